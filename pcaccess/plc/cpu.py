"""The CPU of a soft-PLC: memory, scan cycle, RUN and STOP. A plain synchronous object; time is an argument.

A scan: client writes are applied, inputs are read into the process image, the program runs, outputs are written.
In STOP only the first two happen. ``memory`` is one buffer (``pcaccess.s7200.memory``, ``pcaccess.stl.layout``).

Units:    times are milliseconds; fractions are allowed. A clock that goes back stands still for the CPU.
Errors:   what goes wrong in the program is in ``errors``; a fatal one puts the CPU to STOP and is ``fatal``.
Source:   document 000, "The scan cycle" and appendix C (SM memory); document 003, section 2.2; choices in
          docs/decisions/2026-11-22-cpu.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from typing import Final

from pcaccess.collector import paused
from pcaccess.plc.errorlog import ErrorRecord
from pcaccess.plc.executor import Executor, MakeExecutor
from pcaccess.plc.frames import unwind_to
from pcaccess.plc.interpreter import Interpreter
from pcaccess.plc.interrupts import INPUT_EVENTS
from pcaccess.plc.peripherals import AbsentPeripherals
from pcaccess.plc.runtime import CpuRuntime, whole
from pcaccess.plc.timers import advance_10_ms, restart_timers
from pcaccess.plc.watchdog import Watchdog
from pcaccess.s7200.address import Address, Area
from pcaccess.s7200.cpu import CpuModel
from pcaccess.s7200.memory import AREA_START, C_BITS, locate, read_value
from pcaccess.s7200.special import power_up
from pcaccess.s7200.types import DataType, Value
from pcaccess.stl import layout
from pcaccess.stl.ir import Module
from pcaccess.stl.lower import lower
from pcaccess.stl.program import Program
from pcaccess.stl.runtime import Peripherals

LOOP_BUDGET: Final = 100_000
"""Backward jumps and calls of a scan before the watchdog asks. A real CPU needs 500 ms for a tenth of that."""

_I: Final = AREA_START[Area.I]
_Q: Final = AREA_START[Area.Q]
_SM: Final = AREA_START[Area.SM]
_IMAGE: Final = 16
_INPUTS: Final = slice(_I, _I + _IMAGE)
_OUTPUTS: Final = slice(_Q, _Q + _IMAGE)
_PHYSICAL_INPUTS: Final = slice(layout.PHYSICAL_INPUTS, layout.PHYSICAL_INPUTS + _IMAGE)
_PHYSICAL_OUTPUTS: Final = slice(layout.PHYSICAL_OUTPUTS, layout.PHYSICAL_OUTPUTS + _IMAGE)


class Mode(Enum):
    RUN = "RUN"
    STOP = "STOP"


@dataclass(frozen=True, slots=True)
class _Write:
    address: Address
    type: DataType
    raw: bytes


@dataclass(frozen=True, slots=True)
class Prepared:
    """A program that a CPU can take at once."""

    program: Program
    module: Module
    executor: Executor


class Cpu:
    """One soft-PLC."""

    def __init__(
        self,
        model: CpuModel,
        program: Program | None = None,
        *,
        now: float = 0.0,
        make_executor: MakeExecutor = Interpreter,
        memory: bytearray | memoryview | None = None,
        peripherals: Peripherals | None = None,
        stop_outputs: bytes | None = bytes(_IMAGE),
        loop_budget: int = LOOP_BUDGET,
        watchdog: Watchdog | None = None,
    ) -> None:
        """The CPU is switched on at ``now`` and is in STOP.

        ``memory``: a zeroed buffer of ``layout.BUFFER_SIZE`` bytes to live in. ``stop_outputs``: outputs in STOP
        (16 bytes), None freezes them. ``watchdog``: asked after ``loop_budget`` backward jumps and calls whether the
        scan may go on; left out, it may not.
        """
        self.model = model
        self.mode = Mode.STOP
        self.memory = bytearray(layout.BUFFER_SIZE) if memory is None else memory
        self.runtime = CpuRuntime(
            model, self.memory, peripherals or AbsentPeripherals(), budget=loop_budget, watchdog=watchdog
        )
        self.module: Module | None = None
        self.scans = 0
        """Scans since the change to RUN."""
        self._make_executor = make_executor
        self._executor: Executor | None = None
        self._stop_outputs = stop_outputs
        self._writes: list[_Write] = []
        self._switched_on = now
        self._powered_up = True
        self._new_edges = True
        """The next scan only looks at what edges compare with."""
        self._last_start: float | None = None
        self._shortest, self._longest = 0xFFFF, 0
        self._first_values()
        if program is not None:
            self.load(program)

    def _first_values(self) -> None:
        power_up(self.memory, self.model)
        self.memory[_SM + 4] = 0b0110_0000  # no transmitter is busy
        for byte in (66, 76):
            self.memory[_SM + byte] = 0b1000_0000  # no pulse train runs

    # the program

    def load(self, program: Program, *, keep_memory: bool = False) -> None:
        """Take a checked program and put its data block into V memory, unless ``keep_memory``.

        The mode stays as it is: in RUN the next scan runs the new program. Its edges take over the state they
        find, as in a first scan; a program that cannot be lowered or compiled changes nothing.
        """
        self.take(self.prepare(program), keep_memory=keep_memory)

    def prepare(self, program: Program) -> Prepared:
        """Lower and compile a program without touching the one that runs; may be done in another thread."""
        with paused():
            return self._prepare(program)

    def _prepare(self, program: Program) -> Prepared:
        module = lower(program, self.model)
        executor = self._make_executor(module, self.runtime)
        # The executor has what it needs of the functions; a large program's are a hundred thousand objects.
        return Prepared(program, replace(module, functions=()), executor)

    def take(self, prepared: Prepared, *, keep_memory: bool = False) -> None:
        """Run what was prepared from the next scan on; see :meth:`load`."""
        if self._executor is not None:
            self._executor.close()
        self.module, self._executor = prepared.module, prepared.executor
        self.runtime.load(prepared.module, prepared.executor)
        if not keep_memory:
            start = AREA_START[Area.V]
            prepared.program.data.write_to(memoryview(self.memory)[start : start + self.model.sizes[Area.V]])
        self._new_edges = True

    def close(self) -> None:
        """Nothing will be scanned any more."""
        if self._executor is not None:
            self._executor.close()

    @property
    def executor_name(self) -> str:
        """How the program is executed, for people; empty without one."""
        return "" if self._executor is None else self._executor.name

    def run(self, now: float) -> None:
        """STOP to RUN. Without a program the CPU stays in STOP; in RUN nothing happens.

        V, M, S, counter values and TONR values stay; timer and counter bits, values of TON and TOF, edges and
        interrupts start anew, and so do error records.
        """
        if self.mode is Mode.RUN or self.module is None:
            return
        self.mode = Mode.RUN
        self.runtime.restart(now)
        restart_timers(self.memory)
        self.memory[C_BITS : C_BITS + 32] = bytes(32)
        self.memory[layout.EDGES : layout.TIMER_STATE] = bytes(layout.TIMER_STATE - layout.EDGES)
        self.memory[layout.CALL_DEPTH] = 0
        self.memory[layout.CALL_LIMIT] = layout.MAX_CALL_DEPTH
        self.memory[layout.IN_INTERRUPT] = 0
        self.scans = 0
        self._last_start = None
        self._shortest, self._longest = 0xFFFF, 0

    def stop(self) -> None:
        """RUN to STOP: outputs go to their values for STOP."""
        if self.mode is Mode.STOP:
            return
        self.mode = Mode.STOP
        self.runtime.interrupts.reset()
        self.memory[_SM] &= 0b1000_0001
        if self._stop_outputs is not None:
            self.memory[_OUTPUTS] = self._stop_outputs
        self.memory[_PHYSICAL_OUTPUTS] = bytes(self.memory[_OUTPUTS])

    @property
    def errors(self) -> list[ErrorRecord]:
        """Since the change to RUN, each once for each place."""
        return self.runtime.errors.records()

    @property
    def fatal(self) -> ErrorRecord | None:
        return self.runtime.errors.fatal

    # the outside

    def write(self, address: Address, data_type: DataType, value: Value) -> None:
        """A client's write: applied before the next scan. I and AIW are the input terminals.

        Raises what ``DataType.encode`` raises, at once.
        """
        self.write_raw(address.as_type(data_type), data_type, data_type.encode(value))

    def write_raw(self, address: Address, data_type: DataType, raw: bytes) -> None:
        """A client's write as bytes: ``address`` fits the type, an array's elements follow each other (a BOOL is a
        byte each)."""
        self._writes.append(_Write(address, data_type, raw))

    def read(self, address: Address, data_type: DataType) -> Value:
        """A value as the last scan left it."""
        return read_value(self.memory, address.as_type(data_type), data_type)

    @property
    def inputs(self) -> bytes:
        """The input terminals, 16 bytes."""
        return bytes(self.memory[_PHYSICAL_INPUTS])

    @property
    def outputs(self) -> bytes:
        """The output terminals, 16 bytes."""
        return bytes(self.memory[_PHYSICAL_OUTPUTS])

    def set_inputs(self, data: bytes) -> None:
        """Change the input terminals (up to 16 bytes from I0.0 on). Edges of I0.0 to I0.3 are interrupt events."""
        before = self.memory[layout.PHYSICAL_INPUTS]
        self.memory[layout.PHYSICAL_INPUTS : layout.PHYSICAL_INPUTS + len(data)] = data
        self._raise_input_events(before, self.memory[layout.PHYSICAL_INPUTS])

    def _raise_input_events(self, before: int, now: int) -> None:
        if self.mode is not Mode.RUN:
            return
        for event in range(INPUT_EVENTS):
            bit, falling = event // 2, event % 2
            was, is_on = before >> bit & 1, now >> bit & 1
            if was != is_on and is_on != falling:
                self.runtime.raise_event(event)

    def apply_writes(self) -> None:
        """Take over what clients wrote. ``scan`` does it; a caller may do it between scans too."""
        if not self._writes:
            return
        before = self.memory[layout.PHYSICAL_INPUTS]
        for write in self._writes:
            at, bit = locate(write.address)
            if write.address.area is Area.I:
                at += layout.PHYSICAL_INPUTS - _I
            if write.type is DataType.BOOL:
                for n, value in enumerate(write.raw, bit):
                    place, shift = at + n // 8, n % 8
                    self.memory[place] = self.memory[place] & ~(1 << shift) | value << shift
            else:
                self.memory[at : at + len(write.raw)] = write.raw
        self._writes.clear()
        self._raise_input_events(before, self.memory[layout.PHYSICAL_INPUTS])

    # the scan

    def scan(self, now: float, *, load: float = 0.0) -> None:
        """One cycle, begun at ``now`` (or with the one before, if that was later).

        ``load``: how long the program takes, spread over its networks.
        """
        now = now if self._last_start is None else max(now, self._last_start)
        self.apply_writes()
        self.memory[_INPUTS] = bytes(self.memory[_PHYSICAL_INPUTS])
        if self.mode is Mode.STOP or self.module is None or self._executor is None:
            return
        self._begin(now, load)
        self.runtime.run_interrupts()
        if self.fatal is None:  # a STOP in an interrupt routine lets the main program run once more
            self._executor.run(self.module.main)
            unwind_to(self.memory, 0)
        self.runtime.advance(now + load)
        if not self.runtime.stop_requested:
            self.runtime.run_interrupts()
        self.memory[_PHYSICAL_OUTPUTS] = bytes(self.memory[_OUTPUTS])
        self._powered_up = False
        if self.runtime.stop_requested:
            self.stop()

    def _begin(self, now: float, load: float) -> None:
        m = self.memory
        self.scans += 1
        first = self.scans == 1
        last = now if self._last_start is None else self._last_start
        m[layout.FIRST_SCAN] = int(first or self._new_edges)
        self._new_edges = False
        ticks_100 = whole(now) // 100 - whole(last) // 100
        m[layout.TICKS_100 : layout.TICKS_100 + 4] = max(0, ticks_100).to_bytes(4, "big")
        advance_10_ms(m, max(0, whole(now) // 10 - whole(last) // 10))
        self._status_bits(now, first)
        if not first:
            self._scan_times(whole(now - last))
        self._last_start = now
        self.runtime.begin_scan(now, load)

    def _status_bits(self, now: float, first: bool) -> None:
        """SMB0 (document 000, table C-1)."""
        age = whole(now - self._switched_on)
        byte = 0b1000_0001 | first << 1 | (first and self._powered_up) << 3
        byte |= (age % 60_000 < 30_000) << 4 | (age % 1000 < 500) << 5 | (self.scans % 2) << 6
        self.memory[_SM] = byte

    def _scan_times(self, milliseconds: int) -> None:
        """SMW22, SMW24, SMW26: the last, shortest and longest scan (document 000, table C-9)."""
        last = min(milliseconds, 0x7FFF)
        self._shortest, self._longest = min(self._shortest, last), max(self._longest, last)
        for at, value in ((22, last), (24, self._shortest), (26, self._longest)):
            self.memory[_SM + at : _SM + at + 2] = value.to_bytes(2, "big")
