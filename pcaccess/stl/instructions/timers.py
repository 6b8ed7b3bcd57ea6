"""Timers and interval times.

A timer's value and bit change where its resolution says: 100 ms timers here, when their instruction runs, by the
intervals that ended between the starts of the scan before and of this one; 10 ms timers at the start of a scan
and 1 ms timers every millisecond, both in ``pcaccess.plc.timers``. The instruction starts and stops them all.

Source:   System Manual, Timers ("Understanding timer resolution"); document 004, section 9.17; document 003,
          section 3.4.1. Choices: docs/decisions/2026-11-22-timers.md.
"""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.memory import AREA_START, T_BITS
from pcaccess.s7200.timers import resolution
from pcaccess.s7200.types import DataType
from pcaccess.stl import layout
from pcaccess.stl.builder import Place
from pcaccess.stl.define import Direction, In, Out, Power, Special, define, special
from pcaccess.stl.errors import INDIRECT_ADDRESS
from pcaccess.stl.ir_values import IrType, Value
from pcaccess.stl.layout import TimerState
from pcaccess.stl.routine import Routine

INT, DWORD = DataType.INT, DataType.DWORD
LONGEST: Final = 32767
_SOURCE: Final = "System Manual, Timers; document 004, section 9.17"


class _Timer:
    """The cells of one timer, as a body uses them."""

    def __init__(self, b: Routine, number: int) -> None:
        self.b = b
        self.number = number
        self.is_slow = resolution(number) == 100

    def set_value(self, value: Value | int) -> None:
        value = value if isinstance(value, Value) else self.b.const(IrType.I32, value)
        self.b.store_at(AREA_START[Area.T] + 2 * self.number, self.b.convert(value, IrType.I16))

    def set_bit(self, value: Value | bool) -> None:
        value = value if isinstance(value, Value) else self.b.bit(value)
        self.b.store_bit(T_BITS + self.number // 8, self.number % 8, value)

    def set_state(self, state: TimerState) -> None:
        self.b.store_at(layout.TIMER_STATE + self.number, self.b.const(IrType.U8, state))

    def state(self) -> Value:
        return self.b.load_at(IrType.U8, layout.TIMER_STATE + self.number)

    def set_preset(self, preset: Value) -> None:
        self.b.store_at(layout.TIMER_PRESET + 2 * self.number, preset)

    def value(self) -> Value:
        return self.b.convert(self.b.load_at(IrType.I16, AREA_START[Area.T] + 2 * self.number), IrType.I32)

    def advanced(self, longest: Value | int) -> Value:
        """The value with the 100 ms intervals of this scan added, up to ``longest``."""
        ticks = self.b.bitcast(self.b.load_at(IrType.U32, layout.TICKS_100), IrType.I32)
        return self.b.minimum(self.b.add(self.value(), ticks), longest)

    def clear(self) -> None:
        """Off: value and bit 0, not timing."""
        self.set_state(TimerState.IDLE)
        self.set_value(0)
        self.set_bit(False)


@define(
    {"TON": ()},
    group="Timer",
    operands=(special("TXXX", Special.TIMER, Direction.INOUT, timers="TON"), In("PT", INT)),
    power=Power.COIL,
    errors=(INDIRECT_ADDRESS,),
    source=_SOURCE,
)
def on_delay(b: Routine, number: int, preset: Value) -> None:
    """Delay switching on: the timer's bit comes on when S0 has been 1 for PT intervals.

    The value goes on counting up to 32767. When S0 becomes 0, value and bit are cleared.
    """
    timer = _Timer(b, number)
    with b.choose(b.top) as choice:
        running = b.eq(timer.state(), TimerState.ON_DELAY)
        if timer.is_slow:
            value = b.select(running, timer.advanced(LONGEST), 0)
            timer.set_value(value)
            timer.set_bit(b.ge(value, b.convert(preset, IrType.I32)))
        else:
            timer.set_preset(preset)
            with b.when(b.not_(running)):
                timer.set_value(0)
        timer.set_state(TimerState.ON_DELAY)
        choice.otherwise()
        timer.clear()
    b.when_idle(timer.clear)


@define(
    {"TOF": ()},
    group="Timer",
    operands=(special("TXXX", Special.TIMER, Direction.INOUT, timers="TON"), In("PT", INT)),
    power=Power.COIL,
    errors=(INDIRECT_ADDRESS,),
    source=_SOURCE,
)
def off_delay(b: Routine, number: int, preset: Value) -> None:
    """Delay switching off: the timer's bit is on while S0 is 1 and PT intervals longer.

    The value stops at PT. After R, and in the first scan, S0 must become 1 before the timer can run.
    """
    timer = _Timer(b, number)
    with b.choose(b.top) as choice:
        timer.set_bit(True)
        timer.set_value(0)
        timer.set_state(TimerState.OFF_READY)
        choice.otherwise()
        state = timer.state()
        with b.when(b.ge(state, TimerState.OFF_READY)):
            timer.set_preset(preset)
            timer.set_state(TimerState.OFF_DELAY)
            longest = b.convert(preset, IrType.I32)
            falls = b.eq(state, TimerState.OFF_READY)
            value = b.select(falls, b.const(IrType.I32, 0), timer.advanced(longest) if timer.is_slow else timer.value())
            if timer.is_slow:
                timer.set_value(value)
            with b.when(b.ge(value, longest)):
                timer.set_bit(False)
                timer.set_state(TimerState.IDLE)
    b.when_idle(timer.clear)


@define(
    {"TONR": ()},
    group="Timer",
    operands=(special("TXXX", Special.TIMER, Direction.INOUT, timers="TONR"), In("PT", INT)),
    power=Power.COIL,
    errors=(INDIRECT_ADDRESS,),
    source=_SOURCE,
)
def retentive(b: Routine, number: int, preset: Value) -> None:
    """Add up the time while S0 is 1; the bit comes on at PT. Only R clears value and bit."""
    timer = _Timer(b, number)
    with b.choose(b.top) as choice:
        if timer.is_slow:
            value = b.select(b.eq(timer.state(), TimerState.ON_DELAY), timer.advanced(LONGEST), timer.value())
            timer.set_value(value)
            timer.set_bit(b.ge(value, b.convert(preset, IrType.I32)))
        else:
            timer.set_preset(preset)
        timer.set_state(TimerState.ON_DELAY)
        choice.otherwise()
        timer.set_state(TimerState.IDLE)
    b.when_idle(lambda: timer.set_state(TimerState.IDLE))


@define(
    {"BITIM": ()},
    group="Timer",
    operands=(Out("OUT", DWORD),),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Interval timers; document 004, section 9.25",
)
def begin_interval(b: Routine, out: Place) -> None:
    """Store the millisecond counter of the CPU, which starts again at 0 after 2**32 ms."""
    b.store(out, b.load_at(IrType.U32, layout.MILLISECONDS))
    b.eno(True)


@define(
    {"CITIM": ()},
    group="Timer",
    operands=(In("IN", DWORD, constant=False), Out("OUT", DWORD)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Interval timers; document 004, section 9.25",
)
def interval(b: Routine, since: Value, out: Place) -> None:
    """Store how many milliseconds have passed since IN was stored by BITIM (up to 2**32 ms, 49.7 days)."""
    b.store(out, b.sub(b.load_at(IrType.U32, layout.MILLISECONDS), since))
    b.eno(True)
