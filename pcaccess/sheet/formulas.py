"""The formulas that show an item, for Calc and for Excel; without the sign of equality.

Calc looks it up in the linked area, whose names (``PCA_LIVE`` ...) every book that ``sheet new`` makes has. Excel asks
the gateway itself; ``Tick`` is the cell that makes it ask again, as it fetches an address once only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from types import MappingProxyType
from typing import Final

from pcaccess.sheet.entries import Entry
from pcaccess.sheet.links import item_path


class Program(StrEnum):
    """Whose formulas."""

    CALC = "calc"
    EXCEL = "excel"


def column_letters(column: int) -> str:
    """Of a column's number, from 1."""
    letters = ""
    while column:
        column, letter = divmod(column - 1, 26)
        letters = chr(65 + letter) + letters
    return letters


def quoted(text: str) -> str:
    """A text in a formula."""
    return '"' + text.replace('"', '""') + '"'


def calc_value(key: str) -> str:
    """``key``: the item ID as a quoted text, or the cell that holds it. The last good value stays."""
    return f'IFNA(VLOOKUP({key};PCA_LIVE;2;0);IFNA(VLOOKUP({key};PCA_LAST;2;0);""))'


def calc_quality(key: str) -> str:
    return f"IFNA(VLOOKUP({key};PCA_LIVE;3;0);PCA_MISSING)"


def calc_quality_name(key: str) -> str:
    return f"IFNA(VLOOKUP({key};PCA_LIVE;4;0);PCA_MISSING_NAME)"


def calc_time(key: str) -> str:
    return f'IFNA(VLOOKUP({key};PCA_LIVE;5;0);IFNA(VLOOKUP({key};PCA_LAST;5;0);""))'


def excel_value(entry: Entry) -> str:
    """A number where the item is one, else the text. NUMBERVALUE reads a point as decimal sign in every language."""
    text = _webservice(entry, "value")
    return f'IFERROR(_xlfn.NUMBERVALUE({text},".",","),"")' if entry.is_number else f'IFERROR({text},"")'


def excel_quality(entry: Entry) -> str:
    """COMM_FAILURE (24) when the gateway does not answer."""
    return f'IFERROR(_xlfn.NUMBERVALUE({_webservice(entry, "quality")},".",","),24)'


def _webservice(entry: Entry, what: str) -> str:
    return f"_xlfn.WEBSERVICE(Gateway&{quoted(item_path(entry.item_id, what) + '?tick=')}&Tick)"


Columns = Mapping[str, Callable[[Entry], str]]
COLUMNS: Final[Mapping[Program, Columns]] = MappingProxyType(
    {
        Program.CALC: {
            "Item": lambda entry: entry.item_id,
            "Value": lambda entry: "=" + calc_value(quoted(entry.item_id)),
            "Unit": lambda entry: entry.unit,
            "Quality": lambda entry: "=" + calc_quality(quoted(entry.item_id)),
            "Time stamp": lambda entry: "=" + calc_time(quoted(entry.item_id)),
        },
        Program.EXCEL: {
            "Item": lambda entry: entry.item_id,
            "Value": lambda entry: "=" + excel_value(entry).replace("_xlfn.", ""),
            "Unit": lambda entry: entry.unit,
            "Quality": lambda entry: "=" + excel_quality(entry).replace("_xlfn.", ""),
        },
    }
)
"""What the Formula wizard of the command prints, column by column, as somebody would type it."""
