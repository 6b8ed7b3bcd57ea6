"""A sample as the command shows it: value, quality and time of an item, for people and for programs."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Any, Final

from pcaccess.cli.output import Cell, Column, Row
from pcaccess.cli.values import TYPES, json_value, time_json, time_text, value_text
from pcaccess.items.quality import BY_CODE, Quality, from_status, quality_text

COLUMNS: Final = (Column("Item ID"), Column("Value"), Column("Time Stamp"), Column("Quality"))
"""Those of PC Access's Test Client."""


@dataclass(frozen=True, slots=True)
class Shown:
    """What a server said of one item."""

    item_id: str
    value: Any
    type: int
    """OPC UA built-in type, 0 where it is not known."""
    quality: int
    """OPC DA code, without limit bits."""
    status: int
    """OPC UA StatusCode."""
    status_name: str
    source_time: datetime | None

    @property
    def type_name(self) -> str | None:
        known = TYPES.get(self.type)
        return known.name if known else None

    @property
    def quality_name(self) -> str:
        """With the limit the value is stuck at, if any."""
        _, limit = from_status(self.status)
        return quality_text(self.quality | limit)

    def as_json(self) -> dict[str, Any]:
        return {
            "id": self.item_id,
            "value": json_value(self.value, self.type),
            "type": self.type_name,
            "quality": self.quality,
            "quality_name": quality_text(self.quality),
            "status": self.status_name,
            "source_timestamp": time_json(self.source_time),
        }

    def as_row(self) -> Row:
        """Cells of ``COLUMNS``."""
        meaning = quality_meaning(self.quality)
        return (
            self.item_id,
            Cell(value_text(self.value, self.type), "" if meaning == "good" else "dim"),
            time_text(self.source_time),
            Cell(f"{self.quality:>3} {self.quality_name}", meaning),
        )


def quality_meaning(code: int) -> str:
    """How a quality looks: ``good``, ``uncertain`` or ``bad``."""
    return ("bad", "uncertain", "bad", "good")[code >> 6 & 3]


def derived_quality(status: int) -> int:
    """The DA code that a StatusCode stands for; several may share one (see :data:`SHARED`)."""
    return from_status(status)[0].code


SHARED: Final = frozenset(
    q.status() for q in Quality if sum(other.status() == q.status() for other in BY_CODE.values()) > 1
)
"""StatusCodes of more than one quality: the item's ``Quality`` says which it is."""
