"""Timers that the CPU advances: over long times, and what the change to RUN leaves."""

from __future__ import annotations

import pytest

from pcaccess.plc.timers import advance_1_ms, advance_10_ms, restart_timers
from pcaccess.s7200.address import parse_address
from pcaccess.s7200.memory import read_value, write_value
from pcaccess.s7200.types import DataType
from pcaccess.stl import layout
from pcaccess.stl.layout import TimerState


def memory_with(timer: int, state: TimerState, value: int, preset: int, bit: bool = False) -> bytearray:
    memory = bytearray(layout.BUFFER_SIZE)
    memory[layout.TIMER_STATE + timer] = state
    memory[layout.TIMER_PRESET + 2 * timer : layout.TIMER_PRESET + 2 * timer + 2] = preset.to_bytes(
        2, "big", signed=True
    )
    address = parse_address(f"T{timer}")
    write_value(memory, address, DataType.INT, value)
    write_value(memory, address.as_type(DataType.BOOL), DataType.BOOL, bit)
    return memory


def seen(memory: bytearray, timer: int) -> tuple[object, object]:
    address = parse_address(f"T{timer}")
    bit = read_value(memory, address.as_type(DataType.BOOL), DataType.BOOL)
    return read_value(memory, address, DataType.INT), bit


def test_an_on_delay_says_after_how_long_it_was_reached() -> None:
    memory = memory_with(32, TimerState.ON_DELAY, 3, 10)
    assert advance_1_ms(memory, 20) == [(32, 7)]
    assert seen(memory, 32) == (23, True)
    assert advance_1_ms(memory, 1) == []


def test_an_on_delay_stops_at_32767() -> None:
    memory = memory_with(32, TimerState.ON_DELAY, 32000, 10, bit=True)
    advance_1_ms(memory, 100_000)
    assert seen(memory, 32) == (32767, True)


def test_an_off_delay_stops_at_its_preset_and_is_idle() -> None:
    memory = memory_with(96, TimerState.OFF_DELAY, 3, 10, bit=True)
    assert advance_1_ms(memory, 100) == [(96, 7)]
    assert seen(memory, 96) == (10, False)
    assert memory[layout.TIMER_STATE + 96] == TimerState.IDLE


def test_only_timers_of_the_resolution_advance() -> None:
    memory = memory_with(33, TimerState.ON_DELAY, 0, 10)
    advance_1_ms(memory, 5)
    assert seen(memory, 33) == (0, False)
    advance_10_ms(memory, 5)
    assert seen(memory, 33) == (5, False)


@pytest.mark.parametrize("state", [TimerState.IDLE, TimerState.OFF_READY])
def test_a_timer_that_does_not_run_stays(state: TimerState) -> None:
    memory = memory_with(32, state, 4, 10)
    assert advance_1_ms(memory, 100) == []
    assert seen(memory, 32) == (4, False)


def test_a_restart_keeps_values_of_tonr_only() -> None:
    memory = memory_with(5, TimerState.ON_DELAY, 7, 3, bit=True)
    write_value(memory, parse_address("T37"), DataType.INT, 9)
    restart_timers(memory)
    assert seen(memory, 5) == (7, False)
    assert seen(memory, 37) == (0, False)
    assert memory[layout.TIMER_STATE + 5] == TimerState.IDLE
