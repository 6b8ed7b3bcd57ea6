"""How long a scan may take: by a clock, or by counting where there is none.

The program counts its backward jumps and calls down by itself (``pcaccess.stl.layout.BUDGET``); only when the budget
is used up, and at WDR, a watchdog is asked.

Units:    seconds.
Source:   System Manual, Watchdog Reset: 500 ms in newer CPUs. WDR again and again would hold a real CPU in its scan
          for ever; here everything else in the process would wait with it, so that ends too
          (docs/decisions/2026-11-22-cpu.md).
"""

from __future__ import annotations

from typing import Final, Protocol

from pcaccess.clock import Clock

LIMIT: Final = 0.5
RESETS: Final = 3
"""WDR comes too late when the scan has lasted so many limits; so clients wait two seconds at most."""


class Watchdog(Protocol):
    """Of one CPU."""

    def begin(self) -> None:
        """A scan begins."""

    def extend(self) -> bool:
        """The loop budget is used up: True when the scan may have another one."""
        ...

    def reset(self, jumps: int) -> bool:
        """WDR, after so many backward jumps and calls in this scan: False when it comes too late."""
        ...


class TimedWatchdog:
    """For scans in real time."""

    def __init__(self, clock: Clock, limit: float = LIMIT) -> None:
        self._clock = clock
        self._limit = limit
        self._began = self._since = clock.monotonic()

    def begin(self) -> None:
        self._began = self._since = self._clock.monotonic()

    def extend(self) -> bool:
        return self._clock.monotonic() - self._since < self._limit

    def reset(self, jumps: int) -> bool:
        now = self._clock.monotonic()
        if now - self._began >= RESETS * self._limit:
            return False
        self._since = now
        return True


class CountedWatchdog:
    """For virtual time, in which scans end in the same place on every machine: one budget, more only by WDR."""

    def __init__(self, budget: int) -> None:
        self._most = RESETS * budget

    def begin(self) -> None:
        pass

    def extend(self) -> bool:
        return False

    def reset(self, jumps: int) -> bool:
        return jumps < self._most
