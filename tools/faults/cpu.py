"""Faults in the CPU around the program: scan, timers in time, interrupts, watchdog."""

from __future__ import annotations

from typing import Final

from faults.fault import Fault, table

_CPU: Final = "pcaccess/plc/cpu.py"
_INTERRUPTS: Final = "pcaccess/plc/interrupts.py"
_RUNTIME: Final = "pcaccess/plc/runtime.py"
_TIMERS: Final = "pcaccess/plc/timers.py"
_WATCHDOG: Final = "pcaccess/plc/watchdog.py"
_TESTS: Final = "tests/plc/test_cpu.py tests/plc/test_interrupts.py"

CPU: Final = (
    Fault(
        "ten-ms-timers-too-slow",
        "10 ms timers count every 100 ms",
        _CPU,
        "whole(now) // 10 - whole(last) // 10)",
        "whole(now) // 100 - whole(last) // 100)",
        table("timers"),
    ),
    Fault(
        "timer-bit-one-late",
        "1 ms and 10 ms timers come on one count too late",
        _TIMERS,
        "was_on, is_on = _bit(memory, number), value >= preset",
        "was_on, is_on = _bit(memory, number), value > preset",
        "tests/plc/test_timers.py",
    ),
    Fault(
        "timer-preset-unsigned",
        "1 ms and 10 ms timers take a negative preset for a large one",
        _TIMERS,
        "return number - 0x1_0000 if number & 0x8000 else number",
        "return number",
        table("timers"),
    ),
    Fault(
        "outputs-before-program",
        "output terminals are a scan behind their image",
        _CPU,
        "        self.memory[_PHYSICAL_OUTPUTS] = bytes(self.memory[_OUTPUTS])\n        self._powered_up = False",
        "        self._powered_up = False",
        _TESTS,
    ),
    Fault(
        "edges-of-the-old-program",
        "a new program's edges compare with those of the old one",
        _CPU,
        "        self._new_edges = True\n\n    def",
        "\n    def",
        _TESTS,
    ),
    Fault(
        "interrupt-spoils-accumulators",
        "an interrupt routine leaves its accumulators to the main program",
        _RUNTIME,
        "memory[_ACCUMULATORS], memory[_FLAGS] = accumulators, flags",
        "memory[_FLAGS] = flags",
        table("interrupts"),
    ),
    Fault(
        "interrupt-spoils-flags",
        "an interrupt routine leaves its SM1 flags to the main program",
        _RUNTIME,
        "memory[_ACCUMULATORS], memory[_FLAGS] = accumulators, flags",
        "memory[_ACCUMULATORS] = accumulators",
        table("interrupts"),
    ),
    Fault(
        "interrupt-spoils-local-memory",
        "an interrupt routine works in the L memory of what it interrupted",
        _RUNTIME,
        "        push_frame(memory)\n",
        "",
        table("interrupts"),
    ),
    Fault(
        "interrupt-calls-too-deep",
        "what is called after an interrupt routine ran may nest as deep as one",
        _RUNTIME,
        "        memory[layout.CALL_LIMIT] = limit\n",
        "",
        table("interrupts"),
    ),
    Fault(
        "interrupt-in-an-interrupt",
        "an interrupt routine is interrupted",
        _RUNTIME,
        "        if memory[layout.IN_INTERRUPT] or self._executor is None",
        "        if self._executor is None",
        _TESTS,
    ),
    Fault(
        "interrupts-in-one-queue",
        "timed interrupts come before those of inputs",
        _INTERRUPTS,
        "for queue in self._waiting.values():\n            while queue:",
        "for queue in reversed(self._waiting.values()):\n            while queue:",
        _TESTS,
    ),
    Fault(
        "watchdog-by-the-first-scan",
        "the watchdog counts from the start of the program, not of the scan",
        _WATCHDOG,
        "    def begin(self) -> None:\n        self._began = self._since = self._clock.monotonic()\n",
        "    def begin(self) -> None:\n        pass\n",
        "tests/plc/test_watchdog.py",
    ),
    Fault(
        "wdr-without-end",
        "a loop with WDR in it never ends",
        _WATCHDOG,
        "return jumps < self._most",
        "return jumps < 100 * self._most",
        "tests/plc/test_watchdog.py -k around_the_budget",
    ),
    Fault(
        "wdr-does-nothing",
        "WDR gives no time",
        _RUNTIME,
        "            self._jumps = spent\n            self._refill()\n",
        "            self._jumps = spent\n",
        table("control"),
    ),
    Fault(
        "watchdog-lets-the-scan-end",
        "after an interrupt routine that does not end the main program goes on",
        _RUNTIME,
        "return self.errors.fatal is not None  #",
        "return False  #",
        _TESTS,
    ),
)
