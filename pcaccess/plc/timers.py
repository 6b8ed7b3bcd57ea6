"""Timers that the CPU advances itself: 1 ms timers as time goes on, 10 ms timers at the start of a scan.

100 ms timers advance in their instruction (``pcaccess.stl.instructions.timers``).

Source:   System Manual, Timers ("Understanding timer resolution"); docs/decisions/2026-11-22-timers.md.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.memory import AREA_START, T_BITS
from pcaccess.s7200.timers import ONE_MS_TIMERS, TEN_MS_TIMERS, is_retentive
from pcaccess.stl.layout import TIMER_PRESET, TIMER_STATE, TimerState

LONGEST: Final = 32767
_VALUES: Final = AREA_START[Area.T]


def advance_1_ms(memory: bytearray | memoryview, milliseconds: int) -> list[tuple[int, int]]:
    """Let time pass for the 1 ms timers.

    Returns (timer, milliseconds after the beginning) for each that reached its preset, for its interrupt.
    """
    return _advance(memory, ONE_MS_TIMERS, milliseconds)


def advance_10_ms(memory: bytearray | memoryview, ticks: int) -> None:
    """Let ``ticks`` times 10 ms pass for the 10 ms timers."""
    _advance(memory, TEN_MS_TIMERS, ticks)


def _advance(memory: bytearray | memoryview, timers: Iterable[int], ticks: int) -> list[tuple[int, int]]:
    reached = []
    for number in timers:
        state = memory[TIMER_STATE + number]
        if state == TimerState.ON_DELAY:
            after = _on_delay(memory, number, ticks)
        elif state == TimerState.OFF_DELAY:
            after = _off_delay(memory, number, ticks)
        else:
            continue
        if after is not None:
            reached.append((number, after))
    return reached


def _on_delay(memory: bytearray | memoryview, number: int, ticks: int) -> int | None:
    before, preset = _word(memory, _VALUES + 2 * number), _word(memory, TIMER_PRESET + 2 * number)
    value = min(before + ticks, LONGEST)
    _set_word(memory, _VALUES + 2 * number, value)
    was_on, is_on = _bit(memory, number), value >= preset
    _set_bit(memory, number, is_on)
    return max(preset - before, 0) if is_on and not was_on else None


def _off_delay(memory: bytearray | memoryview, number: int, ticks: int) -> int | None:
    before, preset = _word(memory, _VALUES + 2 * number), _word(memory, TIMER_PRESET + 2 * number)
    value = min(before + ticks, max(preset, before))
    _set_word(memory, _VALUES + 2 * number, value)
    if value < preset:
        return None
    _set_bit(memory, number, False)
    memory[TIMER_STATE + number] = TimerState.IDLE
    return max(preset - before, 0)


def restart_timers(memory: bytearray | memoryview) -> None:
    """The change to RUN: every timer stands and its bit is off; TON and TOF lose their values, TONR keep them."""
    memory[TIMER_STATE : TIMER_STATE + 256] = bytes(256)
    memory[T_BITS : T_BITS + 32] = bytes(32)
    for number in range(256):
        if not is_retentive(number):
            _set_word(memory, _VALUES + 2 * number, 0)


def _word(memory: bytearray | memoryview, at: int) -> int:
    number = memory[at] << 8 | memory[at + 1]
    return number - 0x1_0000 if number & 0x8000 else number


def _set_word(memory: bytearray | memoryview, at: int, value: int) -> None:
    memory[at : at + 2] = (value & 0xFFFF).to_bytes(2, "big")


def _bit(memory: bytearray | memoryview, number: int) -> bool:
    return bool(memory[T_BITS + number // 8] >> number % 8 & 1)


def _set_bit(memory: bytearray | memoryview, number: int, on: bool) -> None:
    at, mask = T_BITS + number // 8, 1 << number % 8
    memory[at] = memory[at] | mask if on else memory[at] & ~mask
