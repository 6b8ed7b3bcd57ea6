"""A CPU in virtual time: scans follow each other at fixed distances, as fast as the machine can.

Scan n starts at n times ``cycle``. Scans take no time unless ``load`` spreads that much over the networks.

Units:    milliseconds from the moment the CPU was switched on and put to RUN.
"""

from __future__ import annotations

import math
from typing import Final

from pcaccess.plc.cpu import Cpu
from pcaccess.plc.executor import MakeExecutor
from pcaccess.plc.interpreter import Interpreter
from pcaccess.s7200.cpu import CpuModel
from pcaccess.stl.program import Program

CYCLE: Final = 10.0


class Session:
    """One program under test."""

    def __init__(
        self,
        model: CpuModel,
        program: Program,
        *,
        cycle: float = CYCLE,
        load: float = 0.0,
        make_executor: MakeExecutor = Interpreter,
    ) -> None:
        self.cpu = Cpu(model, program, make_executor=make_executor)
        self.cpu.run(0.0)
        self.cycle = cycle
        self.load = load
        self.scans = 0
        """Scans begun so far; in STOP they count too."""

    @property
    def next_start(self) -> float:
        """When the next scan starts."""
        return self.scans * self.cycle

    def scan(self) -> None:
        """The next scan."""
        self.cpu.scan(self.next_start, load=self.load)
        self.scans += 1

    def first_scan(self, time: float) -> int:
        """Number of the first scan that starts at ``time`` or later."""
        return math.ceil(time / self.cycle - 1e-6)

    def run_to(self, time: float) -> None:
        """All scans that start before ``time``."""
        while self.scans < self.first_scan(time):
            self.scan()
