"""A CPU from the inside: what its running program asks for (``pcaccess.stl.runtime.Runtime``).

Time inside a scan goes on only where the program polls (``scan_load`` spread over the networks of OB1); 1 ms
timers advance, timed events happen, and interrupt routines run there and nowhere else.

Units:    milliseconds.
"""

from __future__ import annotations

import math
from typing import Final

from pcaccess.plc.errorlog import ErrorLog
from pcaccess.plc.executor import Executor
from pcaccess.plc.frames import push_frame, unwind_to
from pcaccess.plc.interrupts import T32_EVENT, T96_EVENT, TIMED_0, TIMED_1, InterruptTable
from pcaccess.plc.timers import advance_1_ms
from pcaccess.plc.watchdog import CountedWatchdog, Watchdog
from pcaccess.s7200.address import Area
from pcaccess.s7200.cpu import CpuModel
from pcaccess.s7200.memory import AREA_START
from pcaccess.stl import layout
from pcaccess.stl.define import SmBit
from pcaccess.stl.errors import RUN_TIME_ERRORS, FatalError, RunTimeError
from pcaccess.stl.ir import Module, Place
from pcaccess.stl.runtime import OK, Outcome, Peripherals

_SM: Final = AREA_START[Area.SM]
_ACCUMULATORS: Final = slice(AREA_START[Area.AC], AREA_START[Area.AC] + 16)
_FLAGS: Final = _SM + 1
RUN_TIME_PROBLEM: Final = SmBit(4, 3)
INTERRUPTS_ENABLED: Final = SmBit(4, 4)
_INTERVALS: Final = {TIMED_0: _SM + 34, TIMED_1: _SM + 35}
_TIMER_EVENTS: Final = {32: T32_EVENT, 96: T96_EVENT}
INTERRUPT_CALL_DEPTH: Final = 1
"""Subroutines an interrupt routine can nest (System Manual, Interrupts)."""


def whole(milliseconds: float) -> int:
    """Full milliseconds; a hair below the next one counts as the next one."""
    return math.floor(milliseconds + 1e-6)


class CpuRuntime:
    """Implements ``Runtime`` for one CPU."""

    def __init__(
        self,
        model: CpuModel,
        memory: bytearray | memoryview,
        peripherals: Peripherals,
        *,
        budget: int,
        watchdog: Watchdog | None = None,
    ) -> None:
        """``budget``: backward jumps and calls until the watchdog is asked."""
        self.memory = memory
        self.peripherals = peripherals
        self.errors = ErrorLog()
        self.interrupts = InterruptTable(communication_depth=4 * model.ports)
        self.stop_requested = False
        self.now = 0.0
        self.budget = budget
        self.watchdog: Watchdog = watchdog or CountedWatchdog(budget)
        self._jumps = 0
        """Of this scan, up to when the budget was filled last."""
        self._areas = [
            *((AREA_START[a], AREA_START[a] + model.sizes[a] * (2 if a in (Area.T, Area.C) else 1)) for a in Area),
            (layout.ZEROS, layout.ZEROS + 8),
        ]
        self._module: Module | None = None
        self._executor: Executor | None = None
        self._counted = 0
        """Milliseconds that timers have seen."""
        self._periods: dict[int, tuple[int, int]] = {}
        """Timed event -> (interval, when it is due next)."""
        self._spread = (0.0, 0.0)
        """Start of the scan and its load, which the networks share."""

    # the program

    def load(self, module: Module, executor: Executor) -> None:
        self._module, self._executor = module, executor

    def restart(self, now: float) -> None:
        """The change to RUN: interrupts are off, errors forgotten."""
        self.interrupts.reset()
        self._periods.clear()
        self.errors.clear()
        self.stop_requested = False
        self.now = now
        self._count(whole(now))
        self._set_sm(RUN_TIME_PROBLEM, False)
        self._set_sm(INTERRUPTS_ENABLED, False)

    def begin_scan(self, now: float, load: float) -> None:
        self._spread = (now, load)
        self._jumps = 0
        self._refill()
        self.watchdog.begin()
        self.advance(now)

    def _refill(self) -> None:
        """The whole loop budget again."""
        self.memory[layout.BUDGET : layout.BUDGET + 4] = self.budget.to_bytes(4, "big")

    def _spent(self) -> int:
        """Backward jumps and calls of this scan up to now."""
        left = int.from_bytes(self.memory[layout.BUDGET : layout.BUDGET + 4], "big")
        return self._jumps + self.budget - left

    # time and interrupts

    def advance(self, now: float) -> None:
        """Time goes on to ``now``: 1 ms timers count, timed events happen in their order."""
        self.now = max(self.now, now)
        passed = whole(self.now) - self._counted
        if passed > 0:
            begin = self._counted
            self._count(begin + passed)
            reached = advance_1_ms(self.memory, passed)
            due = [(begin + after, event) for n, after in reached if (event := _TIMER_EVENTS.get(n)) is not None]
            for _, event in sorted(due + self._timed_events()):
                self.raise_event(event)
        self.update_attention()

    def _count(self, milliseconds: int) -> None:
        self._counted = milliseconds
        counter = milliseconds & 0xFFFF_FFFF
        self.memory[layout.MILLISECONDS : layout.MILLISECONDS + 4] = counter.to_bytes(4, "big")

    def _timed_events(self) -> list[tuple[int, int]]:
        due = []
        for event, (interval, when) in list(self._periods.items()):
            while when <= self._counted:
                due.append((when, event))
                when += interval
            self._periods[event] = (interval, when)
        return due

    def raise_event(self, event: int) -> None:
        """An interrupt event happened (an input changed, a pulse train ended ...)."""
        lost = self.interrupts.raise_event(event)
        if lost is not None:
            self._set_sm(SmBit(4, lost.overflow_bit), True)
        self.update_attention()

    def update_attention(self) -> None:
        """Whether polls have something to do."""
        busy = self.memory[layout.IN_INTERRUPT]
        wanted = self._spread[1] > 0 or (not busy and self.interrupts.has_work)
        self.memory[layout.ATTENTION] = int(wanted)

    def poll(self, network: int) -> bool:
        start, load = self._spread
        if network >= 0 and load > 0 and self._module is not None:
            self.advance(start + load * network / max(1, self._module.networks))
        self.run_interrupts()
        return self.errors.fatal is not None  # an interrupt routine that the watchdog ended ends the scan

    def run_interrupts(self) -> None:
        """Run the routines of all events that wait; one that runs already is not interrupted."""
        memory = self.memory
        if memory[layout.IN_INTERRUPT] or self._executor is None or self._module is None:
            return
        while (routine := self.interrupts.take()) is not None:
            function = self._module.interrupts.get(routine)
            if function is not None:
                self._run_interrupt(function)
            for group in self.interrupts.emptied():
                self._set_sm(SmBit(4, group.overflow_bit), False)
        self.update_attention()

    def _run_interrupt(self, function: int) -> None:
        """Logic stack and ENO belong to the function; accumulators, SMB1 and L memory are saved here."""
        assert self._executor is not None
        memory = self.memory
        depth, limit = memory[layout.CALL_DEPTH], memory[layout.CALL_LIMIT]
        accumulators, flags = bytes(memory[_ACCUMULATORS]), memory[_FLAGS]
        memory[layout.IN_INTERRUPT] = 1
        push_frame(memory)
        memory[layout.CALL_LIMIT] = depth + 1 + INTERRUPT_CALL_DEPTH
        self.update_attention()
        self._executor.run(function)
        unwind_to(memory, depth)
        memory[layout.CALL_LIMIT] = limit
        memory[layout.IN_INTERRUPT] = 0
        memory[_ACCUMULATORS], memory[_FLAGS] = accumulators, flags

    # what instructions ask for

    def fault(self, code: int, place: int) -> None:
        assert self._module is not None
        self.errors.add(RUN_TIME_ERRORS[code], self._module.places[place], self.now)
        self._set_sm(RUN_TIME_PROBLEM, True)

    def out_of_budget(self, place: int) -> bool:
        assert self._module is not None
        if self.watchdog.extend():
            self._jumps = self._spent()
            self._refill()
            return False
        self._fail(FatalError.WATCHDOG, self._module.places[place])
        return True

    def _fail(self, code: FatalError, place: Place) -> None:
        """A fatal error: the CPU goes to STOP when the scan has unwound."""
        self.errors.add(code, place, self.now)
        self.stop_requested = True

    def request_stop(self) -> None:
        self.stop_requested = True
        if self.memory[layout.IN_INTERRUPT]:
            self.interrupts.forget_waiting()

    def reset_watchdog(self) -> None:
        spent = self._spent()
        if self.watchdog.reset(spent):
            self._jumps = spent
            self._refill()

    def attach(self, event: int, routine: int) -> Outcome:
        self.interrupts.attach(event, routine)
        if event in _INTERVALS:
            self._start_period(event)
        return OK

    def _start_period(self, event: int) -> None:
        """The interval is captured when the event is attached (document 000, SMB34 and SMB35)."""
        interval = self.memory[_INTERVALS[event]]
        if interval:
            self._periods[event] = (interval, self._counted + interval)
        else:
            self._periods.pop(event, None)

    def detach(self, event: int) -> Outcome:
        self.interrupts.detach(event)
        self._periods.pop(event, None)
        return OK

    def enable_interrupts(self, on: bool) -> Outcome:
        if self.memory[layout.IN_INTERRUPT]:
            return RunTimeError.NOT_IN_INTERRUPT
        self.interrupts.enabled = on
        self._set_sm(INTERRUPTS_ENABLED, on)
        self.update_attention()
        return OK

    def room(self, address: int) -> int:
        end = next((end for start, end in self._areas if start <= address < end), address)
        return end - address

    def _set_sm(self, bit: SmBit, on: bool) -> None:
        at, mask = _SM + bit.byte, 1 << bit.bit
        self.memory[at] = self.memory[at] | mask if on else self.memory[at] & ~mask
