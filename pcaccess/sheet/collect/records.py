"""What collecting writes down: a row of samples, or an event in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

CellValue = int | float | str | None
"""What a cell holds: BOOL as 1 or 0, an array as a text; None when no value was ever known."""


@dataclass(frozen=True, slots=True)
class Sample:
    value: CellValue
    quality: int
    time: datetime | None
    """When the PLC had the value, UTC."""


@dataclass(frozen=True, slots=True)
class RowRecord:
    """A sample of each item, in the items' order; ``time`` (UTC) is when they were asked for."""

    time: datetime
    samples: Sequence[Sample]


@dataclass(frozen=True, slots=True)
class EventRecord:
    """Begin, end, a gateway that went or came."""

    time: datetime
    text: str


Record = RowRecord | EventRecord
