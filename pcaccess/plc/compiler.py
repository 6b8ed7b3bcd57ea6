"""The fast executor: IR to machine code through LLVM (``pcaccess.plc.llvm``).

A program is compiled without optimisation first, which takes about 60 microseconds for each instruction. When it has
used as much time as optimising would cost, another process optimises it, and the better code is taken over between
two scans. Both give the same results as the reference interpreter, which runs where LLVM does not.

Units:    seconds.
Errors:   a fault in the program becomes an S7-200 error, as with the interpreter; an exception of a cold instruction
          (our own mistake) comes out of :meth:`Compiled.run`.
Source:   docs/decisions/2026-11-22-compiler.md; docs/performance.md has the figures.
"""

from __future__ import annotations

import ctypes
import logging
from collections.abc import Callable
from typing import Final

from pcaccess.clock import Clock, SystemClock
from pcaccess.plc.executor import Executor
from pcaccess.plc.interpreter import Interpreter
from pcaccess.plc.llvm.bridge import Bridge
from pcaccess.plc.llvm.machine import Loaded, Tier, Unavailable, load, object_code, why_unavailable
from pcaccess.plc.llvm.optimise import Optimiser
from pcaccess.plc.llvm.text import ModuleText, module_text
from pcaccess.stl.ir import Module
from pcaccess.stl.runtime import Runtime

__all__ = ["Compiled", "make_executor", "why_unavailable"]

log: Final = logging.getLogger(__name__)

_START_UP: Final = 0.5
"""Seconds until the optimising process has LLVM."""
_SECONDS_FOR_EACH_LINE: Final = 60e-6
_SAMPLE: Final = 64
"""One scan in so many is timed."""

Entry = Callable[[int, int], bool]
_ENTRY: Final = ctypes.CFUNCTYPE(ctypes.c_bool, ctypes.c_void_p, ctypes.c_void_p)


class Compiled:
    """An ``Executor`` in machine code; it does not hold the GIL while it runs."""

    def __init__(
        self,
        module: Module,
        runtime: Runtime,
        *,
        clock: Clock | None = None,
        tier: Tier = Tier.QUICK,
        optimise: bool = True,
    ) -> None:
        """Compile ``module``. Raises ``Unavailable`` where that is not possible.

        ``tier``: what to begin with; ``optimise``: better code later, where it pays.
        """
        self._clock = clock or SystemClock()
        self._main = module.main
        self._source: ModuleText | None = module_text(module)
        self._bridge = Bridge(runtime, self._source.sites)
        self._buffer = (ctypes.c_char * len(runtime.memory)).from_buffer(runtime.memory)
        self._memory = ctypes.addressof(self._buffer)
        self._environment = self._bridge.address
        self._depth = 0
        self.tier = tier
        self._take(object_code(self._source.text, tier))
        self._optimiser: Optimiser | None = None
        self._scans = 0
        self._worth = float("inf")
        """Seconds of scanning that are still to come before optimising pays."""
        if optimise and tier is Tier.QUICK:
            self._worth = _START_UP + _SECONDS_FOR_EACH_LINE * self._source.text.count("\n")

    @property
    def name(self) -> str:
        return "compiled" if self.tier is Tier.QUICK else "compiled, optimised"

    def run(self, function: int) -> bool:
        if self._depth == 0 and function == self._main:
            return self._scan()
        return self._run(function)

    def _run(self, function: int) -> bool:
        self._depth += 1
        try:
            unwound = self._entries[function](self._memory, self._environment)
        finally:
            self._depth -= 1
        self._bridge.raise_failure()
        return unwound

    def _scan(self) -> bool:
        """A run that nothing else runs around: here the code can be changed."""
        self._scans += 1
        if self._optimiser is not None and not self._optimiser.is_running:
            self._take_optimised()
        if self._scans % _SAMPLE or self._optimiser is not None:
            return self._run(self._main)
        start = self._clock.monotonic()
        unwound = self._run(self._main)
        self._worth -= _SAMPLE * (self._clock.monotonic() - start)
        if self._worth <= 0:
            self.start_optimising()
        return unwound

    def start_optimising(self) -> None:
        """Begin now; the next scan after it is done runs the better code."""
        self._worth = float("inf")
        if self._source is None or self._optimiser is not None:
            return
        try:
            self._optimiser = Optimiser(self._source.text)
        except OSError as error:
            log.warning("the program stays as it is compiled: %s", error)

    def finish_optimising(self) -> None:
        """Wait for the better code and take it; for tests and benchmarks."""
        if self._optimiser is not None:
            self._optimiser.wait()
            self._take_optimised()

    def _take_optimised(self) -> None:
        assert self._optimiser is not None
        assert self._source is not None
        optimiser, self._optimiser = self._optimiser, None
        try:
            self._take(optimiser.result())
        except RuntimeError as error:
            log.warning("the program stays as it is compiled: %s", error)
            return
        self.tier = Tier.OPTIMISED
        self._source = None  # megabytes that are not needed any more

    def _take(self, code: bytes) -> None:
        """Run this object file from now on."""
        assert self._source is not None
        loaded = load(code, [f"f{n}" for n in self._source.entries])
        self._entries: dict[int, Entry] = {n: _ENTRY(loaded.addresses[f"f{n}"]) for n in self._source.entries}
        self._loaded: Loaded = loaded

    def close(self) -> None:
        """Give up the background work."""
        self._worth = float("inf")
        if self._optimiser is not None:
            self._optimiser.cancel()
            self._optimiser = None


def make_executor(module: Module, runtime: Runtime) -> Executor:
    """Compiled code, or the interpreter where there is none; the log says so."""
    try:
        return Compiled(module, runtime)
    except Unavailable as error:
        log.warning("programs run in the interpreter, which is much slower: %s", error)
        return Interpreter(module, runtime)
