"""What a workbook shows of an item, and the group and gateway it follows. From a project file or from a gateway."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from pcaccess.s7200.types import DataType


class SheetError(Exception):
    """A spreadsheet cannot be made or filled; the message is for the user and says what to do."""


@dataclass(frozen=True, slots=True)
class Entry:
    """An item as a spreadsheet sees it."""

    item_id: str
    data_type: DataType
    count: int = 1
    """Elements; more than 1 for an array, which is one text in a cell."""
    readable: bool = True
    writable: bool = True
    low: float | None = None
    high: float | None = None
    unit: str = ""
    description: str = ""

    @property
    def name(self) -> str:
        """The last part of the ID; a run-time name as it is."""
        return self.item_id if "," in self.item_id else self.item_id.rpartition(".")[2]

    @property
    def is_number(self) -> bool:
        """Whether a cell holds its value as a number."""
        return self.count == 1 and self.data_type is not DataType.STRING

    @property
    def range_text(self) -> str:
        """The engineering range for people, empty without one."""
        if self.low is None and self.high is None:
            return ""
        return f"{_limit(self.low)} to {_limit(self.high)}"

    @property
    def decimals(self) -> int | None:
        """Digits behind the point that show a thousandth of the engineering range; None without one."""
        if self.data_type is not DataType.REAL or self.low is None or self.high is None:
            return None
        span = abs(self.high - self.low)
        return next((digits for digits in range(7) if span >= 1000 / 10**digits), None)


@dataclass(frozen=True, slots=True)
class GroupEntry:
    """A group of the project or gateway."""

    name: str
    items: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Chosen:
    """The items of a workbook, in order, and where they come from."""

    entries: Sequence[Entry]
    group: str | None = None
    """The group they are exactly the items of."""

    @property
    def readable(self) -> list[Entry]:
        return [entry for entry in self.entries if entry.readable]

    @property
    def writable(self) -> list[Entry]:
        return [entry for entry in self.entries if entry.writable]

    @property
    def charted(self) -> list[Entry]:
        """Those a line chart can show: numbers, or if there are none bits; at most ``MAX_LINES``."""
        numbers = [entry for entry in self.readable if entry.is_number]
        lines = [entry for entry in numbers if entry.data_type is not DataType.BOOL]
        return (lines or numbers)[:MAX_LINES]


MAX_LINES: Final = 8
"""In one chart; more nobody can tell apart."""


def _limit(value: float | None) -> str:
    return "" if value is None else f"{value:g}"
