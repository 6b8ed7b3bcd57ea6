"""How long a scan may take: the loop budget, the clock, WDR."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from conformance import EXECUTORS

from pcaccess.plc.cpu import Mode
from pcaccess.plc.executor import MakeExecutor
from pcaccess.plc.watchdog import RESETS, TimedWatchdog
from tests.clocks import HandClock
from tests.plc.conftest import Bench

MakeBench = Callable[..., Bench]
LOOP = "LD SM0.0\nFOR VW0, 1, {rounds}\nNEXT\n"
ENDLESS = "LBL 1\nLD SM0.0\nJMP 1\n"
PATIENT = "LBL 1\nLD SM0.0\nWDR\nLD SM0.0\nJMP 1\n"
"""An endless loop that says it needs more time."""


@pytest.fixture(params=EXECUTORS)
def make(request: pytest.FixtureRequest) -> MakeExecutor:
    return EXECUTORS[request.param]


class Ticking(HandClock):
    """A millisecond passes whenever somebody looks."""

    def monotonic(self) -> float:
        self.move(0.001)
        return super().monotonic()


def test_a_scan_goes_on_while_there_is_time(bench: MakeBench, make: MakeExecutor) -> None:
    plc = bench(LOOP.format(rounds=250), loop_budget=10, watchdog=TimedWatchdog(Ticking()), make_executor=make)
    plc.scan()
    assert (plc.word("VW0"), plc.cpu.mode) == (251, Mode.RUN)


def test_a_scan_ends_when_its_time_is_over(bench: MakeBench, make: MakeExecutor) -> None:
    plc = bench(LOOP.format(rounds=20_000), loop_budget=10, watchdog=TimedWatchdog(Ticking()), make_executor=make)
    plc.scan()
    assert (plc.word("VW0"), plc.cpu.mode) == (1 + 11 * 500, Mode.STOP)
    assert str(plc.cpu.fatal).startswith("test.awl:3:1: 0003 ")


def test_every_scan_has_its_full_time(bench: MakeBench) -> None:
    plc = bench(LOOP.format(rounds=3_000), loop_budget=10, watchdog=TimedWatchdog(Ticking()))
    for _ in range(3):
        plc.scan(after=10)
    assert plc.cpu.mode is Mode.RUN


def test_wdr_gives_the_full_time_again(bench: MakeBench, make: MakeExecutor) -> None:
    text = LOOP.format(rounds=3_000)
    clock = Ticking()
    plc = bench(f"{text}LD SM0.0\nWDR\n{text}", loop_budget=10, watchdog=TimedWatchdog(clock), make_executor=make)
    plc.scan()
    assert plc.cpu.mode is Mode.RUN
    assert clock.monotonic() > 0.5


def test_wdr_without_end_is_no_way_around_the_clock(bench: MakeBench, make: MakeExecutor) -> None:
    clock = Ticking()
    plc = bench(PATIENT, loop_budget=10, watchdog=TimedWatchdog(clock), make_executor=make)
    plc.scan()
    assert (plc.cpu.mode, str(plc.cpu.fatal)[:20]) == (Mode.STOP, "test.awl:5:1: 0003 s")
    assert clock.monotonic() == pytest.approx(0.5 * (RESETS + 1), abs=0.1)


def test_wdr_without_end_is_no_way_around_the_budget(bench: MakeBench, make: MakeExecutor) -> None:
    plc = bench(PATIENT.replace("WDR", "INCW VW0\nWDR"), loop_budget=100, make_executor=make)
    plc.scan()
    assert (plc.cpu.mode, str(plc.cpu.fatal)[:20]) == (Mode.STOP, "test.awl:6:1: 0003 s")
    assert plc.word("VW0") == 100 * (RESETS + 1)


def test_calls_count_like_jumps(bench: MakeBench, make: MakeExecutor) -> None:
    text = (
        "ORGANIZATION_BLOCK MAIN:OB1\nTITLE=\nBEGIN\nNETWORK 1\nLD SM0.0\n"
        + "CALL SBR_0\n" * 7
        + "END_ORGANIZATION_BLOCK\nSUBROUTINE_BLOCK SBR_0:SBR0\nTITLE=\nBEGIN\nNETWORK 1\nLD SM0.0\nINCW VW0\n"
        "END_SUBROUTINE_BLOCK\n"
    )
    plc = bench(text, loop_budget=5, make_executor=make)
    plc.scan()
    assert (plc.word("VW0"), plc.cpu.mode) == (5, Mode.STOP)
    assert str(plc.cpu.fatal).startswith("test.awl:11:1: 0003 ")
