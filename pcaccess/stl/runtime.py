"""What a running program may ask of its CPU: the one interface between IR and the soft-PLC.

Both executions and every cold instruction (a Python function called from the IR) work on this. The soft-PLC
implements it in ``pcaccess.plc.runtime``.

Units:    times in milliseconds; addresses are flat byte offsets in ``memory``.
Errors:   results are ``Outcome`` numbers, nothing raises.
"""

from __future__ import annotations

from typing import Final, Protocol

OK: Final = 0
"""Outcome of a cold box: ENO stays 1."""
ENO_OFF: Final = -1
"""Outcome of a cold box that sets ENO to 0 without a run-time error. Any other outcome is a ``RunTimeError``."""

Outcome = int


class Peripherals(Protocol):
    """Everything around the CPU that an instruction can reach. Each method answers an ``Outcome``.

    ``table`` and ``buffer`` are flat addresses of V memory or another area, already checked for one byte.
    """

    def read_clock(self, buffer: int, size: int) -> Outcome: ...
    def set_clock(self, buffer: int, size: int) -> Outcome: ...
    def transmit(self, table: int, port: int) -> Outcome: ...
    def receive(self, table: int, port: int) -> Outcome: ...
    def net_read(self, table: int, port: int) -> Outcome: ...
    def net_write(self, table: int, port: int) -> Outcome: ...
    def port_address(self, port: int) -> int:
        """The station address of the port, or a negative ``RunTimeError``."""
        ...

    def set_port_address(self, address: int, port: int) -> Outcome: ...
    def define_counter(self, counter: int, mode: int) -> Outcome: ...
    def run_counter(self, counter: int) -> Outcome: ...
    def pulse(self, output: int) -> Outcome: ...
    def pid(self, table: int, loop: int) -> Outcome: ...

    def diagnosis_led(self, on: bool) -> None: ...


class Runtime(Protocol):
    """One CPU while it executes."""

    @property
    def memory(self) -> bytearray | memoryview:
        """The whole buffer, ``pcaccess.stl.layout.BUFFER_SIZE`` bytes."""
        ...

    @property
    def peripherals(self) -> Peripherals: ...

    def fault(self, code: int, place: int) -> None:
        """Record a run-time error (see ``pcaccess.stl.ir.Fault``)."""
        ...

    def poll(self, network: int) -> bool:
        """Time goes on and interrupts run; True: unwind."""
        ...

    def out_of_budget(self, place: int) -> bool:
        """The loop budget is used up at ``place`` (see ``pcaccess.stl.ir.Budget``); True: the watchdog ends the
        scan, unwind."""
        ...

    def request_stop(self) -> None:
        """STOP was executed; the CPU changes to STOP when the scan ends."""
        ...

    def reset_watchdog(self) -> None: ...
    def attach(self, event: int, routine: int) -> Outcome: ...
    def detach(self, event: int) -> Outcome: ...
    def enable_interrupts(self, on: bool) -> Outcome: ...
    def room(self, address: int) -> int:
        """Bytes from the flat ``address`` on to the end of its area on this CPU model."""
        ...
