"""Several bits in a row: what S, R, SI and RI do.

Units:    bit numbers count from the first bit of an area (I1.0 is 8; T37 is 37).
"""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.memory import AREA_START, C_BITS, T_BITS
from pcaccess.stl import layout
from pcaccess.stl.builder import Place
from pcaccess.stl.errors import OPERAND_RANGE
from pcaccess.stl.ir_values import Effects, IrType
from pcaccess.stl.routine import Routine
from pcaccess.stl.runtime import OK, Outcome, Runtime

RANGE_ERROR: Final = Effects(errors=(OPERAND_RANGE,))
MAX_IMMEDIATE: Final = 128
_NUMBERED: Final = {Area.T: (T_BITS, AREA_START[Area.T]), Area.C: (C_BITS, AREA_START[Area.C])}
_UNROLLED: Final = 4
"""Resetting more timers or counters than this is one call instead of two or three stores each."""


def bit_number(place: Place) -> int:
    """Number of the bit in its area."""
    return place.offset if place.area in _NUMBERED else place.offset * 8 + place.bit


def area_start(area: Area) -> int:
    """Flat address of the byte with bit 0 of the area (T and C: their bits)."""
    return _NUMBERED[area][0] if area in _NUMBERED else AREA_START[area]


def change(b: Routine, first: Place, count: int, on: bool) -> None:
    """Set or reset ``count`` bits that exist, beginning with ``first``."""
    if first.area in _NUMBERED and not on:
        if count > _UNROLLED:
            b.call(reset_elements, static=(first.area, first.offset, count))
            return
        for number in range(first.offset, first.offset + count):
            _reset_element(b, first.area, number)
    assert isinstance(first.at, int)
    at, bit = first.at, first.bit
    while count > 0:
        number = min(8 - bit, count)
        if number == 8:
            b.store_at(at, b.const(IrType.U8, 0xFF if on else 0))
        else:
            value = b.bit(on)
            b.store_bits(at, [(n, value) for n in range(bit, bit + number)])
        at, bit, count = at + 1, 0, count - number


def _reset_element(b: Routine, area: Area, number: int) -> None:
    b.store_at(_NUMBERED[area][1] + 2 * number, b.const(IrType.I16, 0))
    if area is Area.T:
        b.store_at(layout.TIMER_STATE + number, b.const(IrType.U8, layout.TimerState.IDLE))


def set_bits(runtime: Runtime, area: Area, first: int, limit: int, on: bool, count: int) -> Outcome:
    """Set or reset ``count`` bits of an area that has ``limit`` bits."""
    if not 0 < count <= limit - first:
        return OPERAND_RANGE
    if area in _NUMBERED and not on:
        reset_elements(runtime, area, first, count)
        return OK
    for number in range(first, first + count):
        _change_bit(runtime.memory, area_start(area), number, on)
    return OK


def reset_elements(runtime: Runtime, area: Area, first: int, count: int) -> None:
    """Bit and value of timers or counters := 0; a timer's next rise (TOF: fall) starts it anew."""
    bits, values = _NUMBERED[area]
    memory = runtime.memory
    memory[values + 2 * first : values + 2 * (first + count)] = bytes(2 * count)
    if area is Area.T:
        memory[layout.TIMER_STATE + first : layout.TIMER_STATE + first + count] = bytes(count)
    for number in range(first, first + count):
        _change_bit(memory, bits, number, False)


def set_outputs(runtime: Runtime, first: int, limit: int, on: bool, count: int) -> Outcome:
    """Set or reset physical outputs and their image."""
    if not 0 < count <= min(MAX_IMMEDIATE, limit - first):
        return OPERAND_RANGE
    for number in range(first, first + count):
        _change_bit(runtime.memory, AREA_START[Area.Q], number, on)
        _change_bit(runtime.memory, layout.PHYSICAL_OUTPUTS, number, on)
    return OK


def _change_bit(memory: bytearray | memoryview, start: int, number: int, on: bool) -> None:
    byte, mask = start + number // 8, 1 << number % 8
    memory[byte] = memory[byte] | mask if on else memory[byte] & ~mask
