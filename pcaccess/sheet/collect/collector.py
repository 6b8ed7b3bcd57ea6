"""Collecting: a row of samples at every tick into the journal, the journal into the workbook now and then.

Saving costs time in proportion to the workbook, so it is done seldom: at least ``SAVE_EVERY`` apart, and at most a
twentieth of the time. A gateway that goes away is not the end: its rows have the last values and COMM_FAILURE, as
everywhere in pcaccess, until it answers again.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any, Final, Protocol

from pcaccess.clock import Clock
from pcaccess.counting import counted
from pcaccess.items.quality import Quality
from pcaccess.sheet.client import Gone
from pcaccess.sheet.collect.records import CellValue, EventRecord, RowRecord, Sample
from pcaccess.sheet.collect.store import BookIsOpen, Store
from pcaccess.sheet.entries import Entry, SheetError

SAVE_EVERY: Final = 30.0
"""Seconds between two savings, at least."""
SHARE: Final = 20
"""Saving takes at most one part in so many of the time."""
LOOK_AGAIN: Final = 5.0
"""Seconds between looks whether a workbook that is open elsewhere was closed."""


class Reader(Protocol):
    """What :class:`GatewayClient` does here."""

    def read(self, item_ids: Sequence[str]) -> list[dict[str, Any]]: ...


@dataclass(slots=True)
class Collector:
    """``tell`` hears what happens, in words."""

    reader: Reader
    entries: Sequence[Entry]
    store: Store
    clock: Clock
    tell: Callable[[str], None]
    rows: int = 0
    missed: int = 0
    """Ticks that passed before the row of the last one was there."""
    failure: str | None = None
    """Why it ended before its time."""
    _last: list[Sample] = field(default_factory=list)
    _lost_at: datetime | None = None
    _next_save: float = 0.0
    _waiting_for: str | None = None

    async def run(self, every: float, duration: float | None, stop: asyncio.Event) -> None:
        """Collect until the time is over or ``stop`` is set; then save. Raises SheetError when it cannot even begin."""
        self._last = [Sample(None, Quality.WAITING_FOR_INITIAL_DATA.code, None)] * len(self.entries)
        first = await self._samples()
        self._note(f"began: {counted({'items': len(self.entries)}, 'items') or 'no items'} every {every:g} s")
        self._next_save = self.clock.monotonic() + min(SAVE_EVERY, 5.0)
        async with asyncio.TaskGroup() as tasks:
            ticking = tasks.create_task(self._tick(first, every, duration, tasks))
            stopping = tasks.create_task(stop.wait())
            await asyncio.wait((ticking, stopping), return_when=asyncio.FIRST_COMPLETED)
            interrupted = not ticking.done()
            ticking.cancel()
            stopping.cancel()
        rows = counted({"rows": self.rows}, "rows") or "no rows"
        self._note(f"ended{' (interrupted)' if interrupted else ''}: {rows} in this run")
        await self._save(last=True)

    async def _tick(
        self, samples: Sequence[Sample], every: float, duration: float | None, tasks: asyncio.TaskGroup
    ) -> None:
        begin = self.clock.monotonic()
        count = None if duration is None else max(1, math.ceil(duration / every - 1e-9))
        tick = 0
        while self._keep(RowRecord(self.clock.now(), samples)):
            if self.clock.monotonic() >= self._next_save and self.store.pending:
                self._next_save = math.inf  # until this one is done
                tasks.create_task(self._save())
            due = max(tick + 1, math.ceil((self.clock.monotonic() - begin) / every - 1e-9))
            self.missed += due - tick - 1
            tick = due
            if count is not None and tick >= count:
                return
            await self.clock.sleep(max(0.0, begin + tick * every - self.clock.monotonic()))
            samples = await self._sampled()

    # ------------------------------------------------------------------ samples

    async def _samples(self) -> list[Sample]:
        ids = [entry.item_id for entry in self.entries]
        answers = await asyncio.to_thread(self.reader.read, ids)
        self._last = [
            _sample(entry, answer, last) for entry, answer, last in zip(self.entries, answers, self._last, strict=True)
        ]
        return self._last

    async def _sampled(self) -> list[Sample]:
        """As above, and what to write while the gateway does not answer."""
        try:
            samples = await self._samples()
        except SheetError as error:
            if self._lost_at is None:
                self._lost_at = self.clock.now()
                rest = "is asked again" if isinstance(error, Gone) else "refuses; it is asked again"
                self._note(f"{error}; the gateway {rest} at every tick, rows have quality 24 (COMM_FAILURE) meanwhile")
            code = Quality.COMM_FAILURE.code
            return [Sample(sample.value, code, sample.time) for sample in self._last]
        if self._lost_at is not None:
            away = (self.clock.now() - self._lost_at).total_seconds()
            self._lost_at = None
            self._note(f"the gateway answers again after {away:.0f} s")
        return samples

    # ------------------------------------------------------------------ the workbook

    def _keep(self, record: RowRecord) -> bool:
        try:
            self.store.append(record)
        except OSError as error:
            self.failure = f"{self.store.journal.path} cannot be written: {error.strerror}; collecting ended"
            return False
        self.rows += 1
        return True

    def _note(self, text: str) -> None:
        """For people now, and in the workbook."""
        self.tell(text)
        try:
            self.store.append(EventRecord(self.clock.now(), text))
        except OSError as error:
            self.failure = f"{self.store.journal.path} cannot be written: {error.strerror}"

    async def _save(self, *, last: bool = False) -> None:
        began = self.clock.monotonic()
        try:
            await asyncio.to_thread(self.store.save)
        except SheetError as error:
            wait = LOOK_AGAIN if isinstance(error, BookIsOpen) else SAVE_EVERY
            self._next_save = self.clock.monotonic() + wait
            if last:
                self.failure = (
                    f"{error}\nthe rows are safe in {self.store.journal.path}; put them into the workbook later with: "
                    f"pcaccess sheet merge {self.store.journal.path.with_suffix('')}"
                )
            elif str(error) != self._waiting_for:
                self._waiting_for = str(error)
                self.tell(f"{error}; rows wait in {self.store.journal.path}")
            return
        if self._waiting_for is not None:
            self._waiting_for = None
            self.tell(f"{self.store.book} is saved again")
        took = self.clock.monotonic() - began
        self._next_save = self.clock.monotonic() + max(SAVE_EVERY, SHARE * took)


def _sample(entry: Entry, answer: dict[str, Any], last: Sample) -> Sample:
    """A sample as the gateway tells it; an item that is gone keeps its last value with CONFIG_ERROR."""
    if "error" in answer:
        return Sample(last.value, Quality.CONFIG_ERROR.code, last.time)
    return Sample(
        _cell(answer["value"]),
        answer["quality"],
        datetime.fromisoformat(answer["source_timestamp"]) if answer["source_timestamp"] else None,
    )


def _cell(value: Any) -> CellValue:
    """What a cell can hold of a JSON value."""
    if isinstance(value, bool):
        return int(value)
    if isinstance(value, list):
        return " ".join(str(_cell(one)) for one in value)
    if value is None or isinstance(value, int | float | str):
        return value
    return str(value)
