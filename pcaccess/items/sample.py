"""A sample: value, quality and source time of one item, always together."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from pcaccess.items.quality import Limit, Quality
from pcaccess.s7200.types import Value

ItemValue = Value | list[Value]


@dataclass(frozen=True, slots=True)
class Sample:
    """What an item was when its PLC was last heard: ``time`` is the last successful read, UTC.

    A bad quality keeps the last value and its time.
    """

    value: ItemValue
    quality: Quality
    time: datetime
    limit: Limit = Limit.NONE

    @property
    def code(self) -> int:
        """DA quality code with limit bits."""
        return self.quality.code | self.limit

    @property
    def status(self) -> int:
        """UA StatusCode with limit bits."""
        return self.quality.status(self.limit)
