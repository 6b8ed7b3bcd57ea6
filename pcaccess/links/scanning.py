"""A soft-PLC that runs a program in the gateway's own process, one scan after the other.

Units:    the CPU counts milliseconds of the monotonic clock; ``Plc.scan`` is in seconds.
Errors:   run-time errors of the program are logged once each; a fatal one leaves the CPU in STOP.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from pcaccess.clock import Clock
from pcaccess.items.quality import Quality
from pcaccess.links.base import Outcome, PlcStatus, RawWrite, Sink
from pcaccess.plc.compiler import make_executor
from pcaccess.plc.cpu import Cpu, Mode, Prepared
from pcaccess.plc.watchdog import TimedWatchdog
from pcaccess.project.model import Plc
from pcaccess.s7200.memory import MEMORY_SIZE
from pcaccess.stl.program import Program

log = logging.getLogger(__name__)

SHORTEST_PAUSE: Final = 0.001
"""Seconds left to everything else in this process after each scan of a free-running PLC."""
LOOPS: Final = 10_000
"""Backward jumps and calls until the watchdog looks at the time; that often it costs nothing to speak of."""


@dataclass(frozen=True, slots=True)
class _Exchange:
    """A program on its way in."""

    prepared: asyncio.Future[Prepared]
    taken: asyncio.Future[str]
    """Empty once it runs, else why it never will."""

    def settle(self, why: str) -> None:
        """The first call counts."""
        if not self.taken.done():
            self.taken.set_result(why)


class ScanningPlc:
    """One PLC with a program."""

    def __init__(self, plc: Plc, program: Program, sink: Sink, clock: Clock) -> None:
        self.plc = plc
        self._program = program
        self._sink = sink
        self._clock = clock
        self._scan_took = 0.0
        self._told = 0
        self._stopped_by_fault = False
        self._answers: list[asyncio.Future[Outcome]] = []
        self.giving = asyncio.Lock()
        """For who gives it a program, so that of two the later one runs in the end."""
        self._ended = False
        """Nobody scans any more, so nobody would answer."""
        self._failed = False
        """It scans nothing until somebody starts it or gives it another program."""
        self._new: _Exchange | None = None
        """In the first scan of a program."""
        self._exchange: _Exchange | None = None
        self.cpu = Cpu(
            plc.cpu,
            program,
            now=self._milliseconds(),
            make_executor=make_executor,
            loop_budget=LOOPS,
            watchdog=TimedWatchdog(clock),
        )
        self.cpu.run(self._milliseconds())

    @property
    def memory(self) -> bytearray | memoryview:
        return self.cpu.memory

    def _milliseconds(self) -> float:
        return self._clock.monotonic() * 1000

    def configure(self, plc: Plc, program: Program) -> None:
        """Take a changed entry at once, and a changed program as soon as it is compiled."""
        self.plc = plc
        if program != self._program:
            self.exchange(program)

    def exchange(self, program: Program) -> asyncio.Future[str]:
        """Compile a program beside the one that runs, in a thread, and take it between two scans.

        Memory, outputs and mode stay. The future is done when the first scan of the new program is over, or when
        that will never be; then it says why.
        """
        loop = asyncio.get_running_loop()
        if self._exchange is not None:
            self._exchange.settle("another program came before this one was compiled")
        self._program = program
        self._exchange = _Exchange(loop.run_in_executor(None, self.cpu.prepare, program), loop.create_future())
        if self._ended:
            self._exchange.settle("the PLC is gone")
        return self._exchange.taken

    def _take_exchange(self) -> _Exchange | None:
        """Between two scans: the new program, when it is ready."""
        if self._exchange is None or not self._exchange.prepared.done():
            return None
        exchange, self._exchange = self._exchange, None
        error = exchange.prepared.exception()
        if error is not None:  # a checked program that cannot be compiled is our own mistake
            log.error("%s goes on with its old program", self.plc.item_id, exc_info=error)
            exchange.settle("it cannot be compiled; the log of pcaccess run says why")
            return None
        prepared = exchange.prepared.result()
        self.cpu.take(prepared, keep_memory=True)
        log.info("%s: program %s taken over", self.plc.item_id, prepared.program.file)
        self._failed = False
        return exchange

    def status(self) -> PlcStatus:
        return PlcStatus(self.cpu.mode.value, self._scan_took * 1000, len(self.cpu.errors))

    def start(self) -> None:
        """STOP to RUN."""
        self._failed = False
        self.cpu.run(self._milliseconds())
        self._told = 0
        self._stopped_by_fault = False

    def stop(self) -> None:
        """RUN to STOP."""
        self.cpu.stop()

    async def write(self, writes: Sequence[RawWrite]) -> list[Outcome]:
        """Queue the writes; they are taken by the next scan and answered when it is over."""
        if self._ended or self._failed:
            return [Outcome.DEVICE_FAILURE] * len(writes)
        for write in writes:
            if isinstance(write.address, str):
                raise TypeError(f"{write.address!r} is not an S7-200 address")
            self.cpu.write_raw(write.address, write.raw_type, write.data)
        answer: asyncio.Future[Outcome] = asyncio.get_running_loop().create_future()
        self._answers.append(answer)
        return [await answer] * len(writes)

    async def run(self) -> None:
        """Scan until cancelled."""
        due = self._clock.monotonic()
        try:
            while True:
                try:
                    self.scan()
                except Exception:
                    self._fail()
                if self.plc.scan is None:
                    await self._clock.sleep(max(SHORTEST_PAUSE, self._scan_took))
                else:
                    due = max(due + self.plc.scan, self._clock.monotonic())
                    await self._clock.sleep(due - self._clock.monotonic())
        finally:
            self._ended = True
            self._answer(Outcome.DEVICE_FAILURE)
            self.cpu.close()
            if self._exchange is not None:
                self._exchange.settle("the PLC is gone")

    def _fail(self) -> None:
        """In the handler of an exception. Our own fault, not the program's: it must cost this PLC only, until it is
        started again or gets another program."""
        log.exception("%s: the CPU failed; its items are no longer good", self.plc.item_id)
        self._failed = True
        self.cpu.stop()
        self._sink.lost(self.plc.item_id, Quality.DEVICE_FAILURE)
        self._answer(Outcome.DEVICE_FAILURE)
        if self._new is not None:
            self._new.settle("the CPU failed with it; the log of pcaccess run says more")

    def scan(self) -> None:
        """One scan, and everything that follows from it."""
        self._new = self._take_exchange()
        if self._failed:
            return
        began = self._clock.monotonic()
        self.cpu.scan(began * 1000)
        self._scan_took = self._clock.monotonic() - began
        if self.plc.connected:
            self._sink.received(self.plc.item_id, memoryview(self.cpu.memory)[:MEMORY_SIZE])
        self._answer(Outcome.DONE)
        if self._new is not None:
            self._new.settle("")
        self._tell_errors()

    def _answer(self, outcome: Outcome) -> None:
        answers, self._answers = self._answers, []
        for answer in answers:
            if not answer.done():
                answer.set_result(outcome)

    def _tell_errors(self) -> None:
        errors = self.cpu.errors
        for record in errors[self._told :]:
            log.warning("%s: run-time error %s", self.plc.item_id, record)
        self._told = len(errors)
        stopped = self.cpu.mode is Mode.STOP and self.cpu.fatal is not None
        if stopped and not self._stopped_by_fault:
            log.error("%s went to STOP: %s", self.plc.item_id, self.cpu.fatal)
        self._stopped_by_fault = stopped
