"""Collecting on a clock that the test moves: ticks, a gateway that goes and comes, savings, the end."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from openpyxl import load_workbook

from pcaccess.s7200.types import DataType
from pcaccess.sheet.client import Gone, Refused
from pcaccess.sheet.collect.collector import Collector
from pcaccess.sheet.collect.journal import journal_of
from pcaccess.sheet.collect.store import open_store
from pcaccess.sheet.entries import Chosen, Entry, SheetError
from tests.clocks import HandClock

ENTRIES = [Entry("L.P.Count", DataType.INT), Entry("L.P.On", DataType.BOOL)]


class Gateway:
    """Answers 1, 2, 3 …; or raises what it is told to."""

    def __init__(self) -> None:
        self.count = 0
        self.fault: SheetError | None = None
        self.gone_item = False

    def read(self, item_ids: Sequence[str]) -> list[dict[str, Any]]:
        if self.fault is not None:
            raise self.fault
        self.count += 1
        time = "2026-01-02T03:04:05.000Z"
        on = {"id": "L.P.On", "value": self.count % 2 == 1, "quality": 192, "source_timestamp": time}
        if self.gone_item:
            on = {"id": "L.P.On", "error": "there is no item L.P.On", "problem": "unknown-item"}
        return [{"id": "L.P.Count", "value": self.count, "quality": 192, "source_timestamp": time}, on]


class One(Gateway):
    """A gateway asked for the first item only."""

    def read(self, item_ids: Sequence[str]) -> list[dict[str, Any]]:
        return super().read(item_ids)[:1]


class Bench:
    """A collector, and a clock that jumps to whoever sleeps."""

    def __init__(self, folder: Path) -> None:
        self.book = folder / "book.xlsx"
        self.gateway = Gateway()
        self.clock = HandClock()
        self.told: list[str] = []
        self.store = open_store(self.book, Chosen(ENTRIES), "http://127.0.0.1:8080", self.clock.now(), 1000)
        self.collector = Collector(self.gateway, ENTRIES, self.store, self.clock, self.told.append)
        self.stop = asyncio.Event()

    async def run(
        self,
        duration: float | None,
        at: dict[int, Callable[[], None]] | None = None,
        every: float = 1.0,
        sleeps: Callable[[float], Awaitable[None]] | None = None,
    ) -> None:
        """``at``: what happens before the tick of that number, from 0."""
        done = 0

        async def sleep(seconds: float) -> None:
            nonlocal done
            done += 1
            if at and done in at:
                at[done]()
            self.clock.move(seconds)
            await asyncio.to_thread(lambda: None)  # let others run

        self.clock.sleep = sleeps or sleep  # type: ignore[method-assign]
        async with asyncio.timeout(30):
            await self.collector.run(every, duration, self.stop)
        self.store.close()

    def rows(self, sheet: str = "Values") -> list[tuple[Any, ...]]:
        return [line[1:] for line in load_workbook(self.book)[sheet].iter_rows(min_row=2, values_only=True)]


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path)


async def test_a_row_at_every_tick_until_the_time_is_over(bench: Bench) -> None:
    await bench.run(5)
    assert bench.rows() == [(1, 1), (2, 0), (3, 1), (4, 0), (5, 1)]
    assert bench.rows("Runs") == [("began: 2 items every 1 s",), ("ended: 5 rows in this run",)]
    assert (bench.collector.missed, bench.collector.failure) == (0, None)
    assert not journal_of(bench.book).exists()


async def test_one_item_and_one_row_are_told_in_the_singular(bench: Bench) -> None:
    bench.collector.entries = ENTRIES[:1]
    bench.collector.reader = One()
    await bench.run(1)
    assert bench.told == ["began: 1 item every 1 s", "ended: 1 row in this run"]


async def test_a_gateway_that_goes_leaves_its_last_values_with_comm_failure(bench: Bench) -> None:
    def go() -> None:
        bench.gateway.fault = Gone("http://127.0.0.1:8080 does not answer")

    def come() -> None:
        bench.gateway.fault = None

    await bench.run(6, {2: go, 4: come})
    assert bench.rows() == [(1, 1), (2, 0), (2, 0), (2, 0), (3, 1), (4, 0)]
    assert [row[0] for row in bench.rows("Qualities")] == [192, 192, 24, 24, 192, 192]
    assert bench.told[1:3] == [
        "http://127.0.0.1:8080 does not answer; the gateway is asked again at every tick, "
        "rows have quality 24 (COMM_FAILURE) meanwhile",
        "the gateway answers again after 2 s",
    ]
    assert [text for (text,) in bench.rows("Runs")] == bench.told


async def test_a_gateway_that_refuses_in_the_middle_is_told_once(bench: Bench) -> None:
    def refuse() -> None:
        bench.gateway.fault = Refused("it wants a password", 401)

    await bench.run(5, {1: refuse})
    assert [row[0] for row in bench.rows("Qualities")] == [192, 24, 24, 24, 24]
    assert sum("it wants a password; the gateway refuses" in text for text in bench.told) == 1


async def test_an_item_that_leaves_the_project_gets_config_error(bench: Bench) -> None:
    def leave() -> None:
        bench.gateway.gone_item = True

    await bench.run(3, {2: leave})
    assert bench.rows("Qualities") == [(192, 192), (192, 192), (192, 4)]
    assert bench.rows()[2] == (3, 0)


async def test_a_gateway_that_is_not_there_at_the_beginning_is_an_error(bench: Bench) -> None:
    bench.gateway.fault = Gone("nobody there")
    with pytest.raises(SheetError, match="nobody there"):
        await bench.run(5)
    bench.store.close()
    assert list(bench.book.parent.iterdir()) == []


async def test_stopping_saves_what_there_is(bench: Bench) -> None:
    await bench.run(None, {3: bench.stop.set})
    assert bench.rows()[:2] == [(1, 1), (2, 0)]
    assert bench.rows("Runs")[-1][0].startswith("ended (interrupted): ")


async def test_ticks_that_passed_while_a_read_took_long_are_missed_not_made_up(bench: Bench) -> None:
    read = bench.gateway.read

    def slow(item_ids: Sequence[str]) -> list[dict[str, Any]]:
        if bench.gateway.count == 2:
            bench.clock.move(3.5)
        return read(item_ids)

    bench.gateway.read = slow  # type: ignore[method-assign]
    await bench.run(8)
    assert bench.collector.missed == 3
    assert len(bench.rows()) == 5


async def test_rows_come_into_the_workbook_while_it_goes_on(bench: Bench) -> None:
    seen: list[int] = []

    def look() -> None:
        seen.append(len(bench.rows()) if bench.book.exists() else 0)

    async def sleep(seconds: float) -> None:
        bench.clock.move(seconds)
        while bench.collector._next_save == float("inf"):  # a saving is under way, in its thread
            await asyncio.to_thread(lambda: None)
        look()

    await bench.run(100, sleeps=sleep)
    # First after 5 s, so that somebody who looks sees it work; then every 30 s, and at the end.
    assert sorted(set(seen)) == [0, 6, 37, 68, 99]
    assert len(bench.rows()) == 100


async def test_a_workbook_that_is_open_gets_its_rows_when_it_is_closed(bench: Bench) -> None:
    lock = bench.book.with_name(".~lock.book.xlsx#")
    await bench.run(2)
    bench = Bench(bench.book.parent)
    lock.write_text(",anna,machine,,;")
    await bench.run(3)
    assert len(bench.rows()) == 2
    assert bench.collector.failure is not None
    assert "is open in LibreOffice (anna)" in bench.collector.failure
    assert "pcaccess sheet merge" in bench.collector.failure
    lock.unlink()
    bench = Bench(bench.book.parent)
    await bench.run(1)
    assert len(bench.rows()) == 6


async def test_a_full_disk_ends_it_and_says_so(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    def full() -> None:
        def fail(record: object) -> None:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(bench.store.journal, "append", fail)

    await bench.run(10, {3: full})
    assert bench.collector.failure is not None
    assert "No space left on device" in bench.collector.failure
    assert len(bench.rows()) == 3
