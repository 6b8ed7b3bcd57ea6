"""Counters.

What the inputs were before is kept for each counter number, not for each instruction; in the first scan an input
that is 1 counts.

Source:   System Manual, Counters; document 004, section 9.17; document 003, section 3.4.2.
"""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.memory import AREA_START, C_BITS
from pcaccess.s7200.types import DataType
from pcaccess.stl import layout
from pcaccess.stl.define import Direction, In, Power, Special, StackUse, define, special
from pcaccess.stl.errors import INDIRECT_ADDRESS
from pcaccess.stl.ir_values import IrType, Value
from pcaccess.stl.routine import Routine

_OPERANDS: Final = (special("CXXX", Special.COUNTER, Direction.INOUT), In("PV", DataType.INT))
_SOURCE: Final = "System Manual, Counters; document 004, section 9.17"
HIGHEST: Final = 32767


def _rises(b: Routine, memory: int, number: int, now: Value) -> Value:
    """1 when the input was 0 before; remembers it. In an SCR segment that is not active it counts as 0."""
    before = b.ne(b.load_at(IrType.U8, memory + number), 0)
    b.store_at(memory + number, b.convert(now, IrType.U8))
    b.when_idle(lambda: b.store_at(memory + number, b.const(IrType.U8, 0)))
    return b.and_(now, b.not_(before))


def _value(b: Routine, number: int) -> Value:
    return b.convert(b.load_at(IrType.I16, AREA_START[Area.C] + 2 * number), IrType.I32)


def _set(b: Routine, number: int, value: Value, bit: Value) -> None:
    b.store_at(AREA_START[Area.C] + 2 * number, b.convert(value, IrType.I16))
    b.store_bit(C_BITS + number // 8, number % 8, bit)


@define(
    {"CTU": ()},
    group="Counter",
    operands=_OPERANDS,
    power=Power.COIL,
    stack=StackUse(2, 0),
    errors=(INDIRECT_ADDRESS,),
    source=_SOURCE,
)
def count_up(b: Routine, number: int, preset: Value) -> None:
    """Count up on each rise of S1, to 32767; the bit is on while the value is PV or more. S0 = 1 resets."""
    reset, up = b.top, b.level(1)
    counted = b.minimum(
        b.add(_value(b, number), b.convert(_rises(b, layout.COUNT_UP, number, up), IrType.I32)), HIGHEST
    )
    value = b.select(reset, b.const(IrType.I32, 0), counted)
    _set(b, number, value, b.and_(b.not_(reset), b.ge(value, b.convert(preset, IrType.I32))))


@define(
    {"CTD": ()},
    group="Counter",
    operands=_OPERANDS,
    power=Power.COIL,
    stack=StackUse(2, 0),
    errors=(INDIRECT_ADDRESS,),
    source=_SOURCE,
)
def count_down(b: Routine, number: int, preset: Value) -> None:
    """Count down on each rise of S1, to 0, where the bit comes on. S0 = 1 loads PV and clears the bit."""
    load, down = b.top, b.level(1)
    before = _value(b, number)
    step = b.and_(_rises(b, layout.COUNT_DOWN, number, down), b.gt(before, 0))
    value = b.select(load, b.convert(preset, IrType.I32), b.sub(before, b.convert(step, IrType.I32)))
    _set(b, number, value, b.and_(b.not_(load), b.le(value, 0)))


@define(
    {"CTUD": ()},
    group="Counter",
    operands=_OPERANDS,
    power=Power.COIL,
    stack=StackUse(3, 0),
    errors=(INDIRECT_ADDRESS,),
    source=_SOURCE,
)
def count_up_down(b: Routine, number: int, preset: Value) -> None:
    """Count up on each rise of S2 and down on each rise of S1; the bit is on while the value is PV or more.

    From 32767 the next step up is -32768, and the other way round. S0 = 1 resets.
    """
    reset, down, up = b.top, b.level(1), b.level(2)
    more = b.convert(_rises(b, layout.COUNT_UP, number, up), IrType.I32)
    less = b.convert(_rises(b, layout.COUNT_DOWN, number, down), IrType.I32)
    counted = b.convert(b.convert(b.sub(b.add(_value(b, number), more), less), IrType.I16), IrType.I32)
    value = b.select(reset, b.const(IrType.I32, 0), counted)
    _set(b, number, value, b.and_(b.not_(reset), b.ge(value, b.convert(preset, IrType.I32))))
