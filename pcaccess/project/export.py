"""Items of a PLC as a Kepware tag table; ``pcaccess import`` and ``items_from`` read it back.

Kepware has no column for limits, write limits and lengths of simulated strings. ``ours`` adds such columns
(``pcaccess.project.tagtable`` lists them); without it they are lost, and the result says of how many items.

Source:   reference notes, Kepware tag CSV and S7-200 addresses.
"""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from typing import Final

from pcaccess.project.access import Access
from pcaccess.project.model import Item, Plc, WriteLimits
from pcaccess.project.tagtable import KEPWARE_TYPES
from pcaccess.s7200.address import Address, Area, Width
from pcaccess.s7200.types import DataType

COLUMNS: Final = (
    "Tag Name",
    "Address",
    "Data Type",
    "Respect Data Type",
    "Client Access",
    "Scan Rate",
    "Scaling",
    "Raw Low",
    "Raw High",
    "Scaled Low",
    "Scaled High",
    "Scaled Data Type",
    "Clamp Low",
    "Clamp High",
    "Eng Units",
    "Description",
    "Negate Value",
)
OUR_COLUMNS: Final = ("Low", "High", "Write Limits")
_TYPE_NAMES: Final = {
    ours: {"DWORD": "DWord"}.get(kepware, kepware.capitalize()) for kepware, ours in KEPWARE_TYPES.items()
}
_ACCESS: Final = {Access.R: "RO", Access.W: "WO", Access.RW: "R/W"}
_LETTERLESS: Final = frozenset({Area.I, Area.Q, Area.V, Area.M, Area.SM, Area.S})


@dataclass(frozen=True, slots=True)
class Exported:
    text: str
    items: int
    lost: int
    """Items that have limits the table does not hold."""


def export_tags(plc: Plc, *, ours: bool = False) -> Exported:
    """The tag table of one PLC; Kepware has one per device, too."""
    out = io.StringIO(newline="")
    writer = csv.writer(out)
    writer.writerow(COLUMNS + OUR_COLUMNS if ours else COLUMNS)
    items = lost = 0
    for item in plc.all_items():
        items += 1
        lost += item.low is not None and not ours
        writer.writerow(_row(item, item.item_id[len(plc.item_id) + 1 :], ours=ours))
    return Exported(out.getvalue(), items, lost)


def _row(item: Item, name: str, *, ours: bool) -> list[str]:
    scaling = item.scaling
    row = [name, _address(item), _TYPE_NAMES[item.raw_type.name], "1", _ACCESS[item.access], "100"]
    if scaling is None:
        row += ["None", "", "", "", "", "", "0", "0"]
    else:
        ends = (scaling.raw_low, scaling.raw_high, scaling.scaled_low, scaling.scaled_high)
        clamp = str(int(scaling.clamp))
        row += ["Linear", *(repr(end) for end in ends), "Float", clamp, clamp]
    row += [item.unit, item.description, "0"]
    if ours:
        limits = ["", ""] if item.low is None or item.high is None else [repr(item.low), repr(item.high)]
        row += [*limits, "" if item.write_limits is WriteLimits.NONE else item.write_limits.value]
    return row


def _address(item: Item) -> str:
    """As Kepware writes it where it is known how: without a type letter, a string with its length."""
    address = item.address
    if not isinstance(address, Address) or address.area not in _LETTERLESS or address.width is Width.BIT:
        return str(address)
    if item.raw_type is DataType.STRING:
        return f"{address.area.value}{address.offset}.{item.length}"
    return f"{address.area.value}{address.offset}" + (f"[{address.count}]" if address.count > 1 else "")
