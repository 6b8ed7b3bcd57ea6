"""One PLC of the running gateway: its project entry, its link, its rows."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Iterator

from pcaccess.gateway.writing import linear
from pcaccess.items.image import Field, PlcImage
from pcaccess.items.rowset import Rows
from pcaccess.items.table import ItemTable
from pcaccess.links.base import Link, PlcStatus
from pcaccess.project.model import Item, Plc
from pcaccess.s7200.address import Address
from pcaccess.s7200.memory import MEMORY_SIZE, locate
from pcaccess.s7200.special import true_of_memory_alone

FRESH_TICKS = 100_000
"""A sample stamped within the last 10 ms is as good as now."""


class Station:
    """A PLC with its image and rows. PLCs of links without S7-200 memory (sim) have an image nobody fills."""

    def __init__(
        self, plc: Plc, link: Link, table: ItemTable, item_of: Callable[[int], Item], *, live: bool = False
    ) -> None:
        """``item_of`` gives a row's item. ``live``: samples need no polling and are as new as the question."""
        self.plc = plc
        self.link = link
        self.image = PlcImage(table, MEMORY_SIZE)
        self.live = live
        self.reachable = True
        """What the link last said of it."""
        self._table = table
        self._item_of = item_of
        self._numbers = array("q")
        """Its rows: 100,000 of them in a dictionary would cost ten times as much."""
        self._stamped = 0

    @property
    def name(self) -> str:
        """``Link.PLC`` as written."""
        return self.plc.item_id

    @property
    def runs(self) -> bool:
        """A CPU keeps SM, timers and counters true."""
        return self.plc.program is not None

    @property
    def connected(self) -> bool:
        """Whether the PLC answers."""
        return self.plc.connected and self.reachable

    @property
    def polled(self) -> bool:
        """Whether a reader may have to wait for the device: no link of this version makes him wait."""
        return False

    @property
    def status(self) -> PlcStatus:
        """How the PLC is doing; a PLC of memory alone is in STOP, one that does not answer is UNKNOWN."""
        return self.link.status(self.name) if self.connected else PlcStatus("UNKNOWN")

    @property
    def rows(self) -> Rows:
        """Rows that the image keeps."""
        return self.image.rows

    def items(self) -> Iterator[tuple[int, Item]]:
        """Every row of this PLC with its item, dynamic ones too."""
        for row in self._numbers:
            yield row, self._item_of(row)

    def add(self, items: Iterable[tuple[int, Item]]) -> None:
        """Show rows for items of this PLC."""
        members = list(items)
        self._numbers.extend(row for row, _ in members)
        fields, silent = [], []
        for row, item in members:
            if isinstance(item.address, Address):
                fields.append(_field(row, item, item.address))
                if not self.runs and not true_of_memory_alone(item.address, item.raw_type.size):
                    silent.append(row)
        self.image.add(fields, out_of_service=silent)
        self.link.add(self.name, members)

    def remove(self, rows: Iterable[int]) -> None:
        gone = list(rows)
        leaving = set(gone)
        self._numbers = array("q", (row for row in self._numbers if row not in leaving))
        self.image.remove(gone)
        self.link.remove(gone)

    def freshen(self, now: int) -> None:
        """Somebody reads: the samples of a live station are as old as the question."""
        if self.live and self.connected and now - self._stamped > FRESH_TICKS:
            self._stamped = now
            self.image.stamp(now)


def _field(row: int, item: Item, address: Address) -> Field:
    offset, bit = locate(address)
    return Field(row, offset, bit, item.raw_type, address.count, item.length or 254, linear(item.scaling))
