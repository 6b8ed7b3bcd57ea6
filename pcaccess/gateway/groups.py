"""Groups of the running gateway: a rate, an active flag, a dead band, and reading and writing all items at once.

Source:   OPC DA 2.05, groups: a cache read of an inactive group is OUT_OF_SERVICE; a percent dead band counts in the
          item's engineering range.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from enum import IntEnum
from typing import TYPE_CHECKING

from pcaccess.items.quality import Quality
from pcaccess.items.sample import ItemValue, Sample
from pcaccess.links.base import Outcome
from pcaccess.project.model import Access, Item
from pcaccess.project.model import Group as Config

if TYPE_CHECKING:
    from pcaccess.gateway.gateway import Gateway


class Source(IntEnum):
    """Where a SyncRead reads (numbers of the Automation interface)."""

    CACHE = 1
    DEVICE = 2


class Group:
    """One group. Clients may change rate, flag and dead band; the project file is not touched by that."""

    def __init__(self, config: Config, gateway: Gateway) -> None:
        self.config = config
        self.update_rate = config.update_rate
        """Seconds."""
        self.active = config.active
        self.dead_band = config.dead_band
        """Percent of the engineering range, 0 to 100."""
        self._gateway = gateway
        self._cache: dict[int, Sample] = {}

    @property
    def name(self) -> str:
        return self.config.name

    @property
    def items(self) -> tuple[str, ...]:
        """Item IDs, in the project's order."""
        return self.config.items

    def rows(self) -> list[int | None]:
        """Row of each item; None for one that the project no longer has."""
        return [self._gateway.find(item_id) for item_id in self.items]

    async def read(self, source: Source) -> list[Sample | None]:
        """A sample per item, in order; None where the item is gone or cannot be read."""
        rows = self.rows()
        known = [row for row in rows if row is not None]
        await self._gateway.read(known, 0.0 if source is Source.DEVICE else self.update_rate)
        return [self._sample(row, source) for row in rows]

    def _sample(self, row: int | None, source: Source) -> Sample | None:
        if row is None:
            return None
        item = self._gateway.item(row)
        if not item.access & Access.R:
            return None
        sample = self._gateway.sample(row)
        if source is Source.DEVICE:
            return sample
        if not self.active:
            return replace(sample, quality=Quality.OUT_OF_SERVICE)
        before = self._cache.get(row)
        if before is not None and self._within_dead_band(item, before, sample):
            return replace(before, time=sample.time)
        self._cache[row] = sample
        return sample

    def _within_dead_band(self, item: Item, before: Sample, now: Sample) -> bool:
        if not self.dead_band or item.low is None or item.high is None or before.code != now.code:
            return False
        if not isinstance(before.value, int | float) or not isinstance(now.value, int | float):
            return False
        return abs(now.value - before.value) <= self.dead_band / 100 * (item.high - item.low)

    async def write(self, values: Sequence[ItemValue | None]) -> list[Outcome]:
        """Write a value to each item, in order; None leaves its item alone and is DONE."""
        rows = self.rows()
        wanted = [
            (n, row, value)
            for n, (row, value) in enumerate(zip(rows, values, strict=True))
            if row is not None and value is not None
        ]
        outcomes = [Outcome.DONE if value is None else Outcome.CONFIG_ERROR for value in values]
        answers = await self._gateway.write([(row, value) for _, row, value in wanted])
        for (n, _, _), answer in zip(wanted, answers, strict=True):
            outcomes[n] = answer
        return outcomes
