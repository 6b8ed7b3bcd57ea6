"""A CPU with nothing around it: every peripheral answers that it is not present.

Later modules replace the methods of what they bring; the errors are those an S7-200 gives without the hardware
(clock: 000C; a port in PPI mode: 0090; a counter before HDEF: 0001; a PID loop: 0013).
"""

from __future__ import annotations

from pcaccess.stl.errors import RunTimeError
from pcaccess.stl.runtime import ENO_OFF, OK, Outcome


class AbsentPeripherals:
    """Implements ``pcaccess.stl.runtime.Peripherals``."""

    def __init__(self) -> None:
        self.led = False
        """The diagnosis LED."""

    def read_clock(self, buffer: int, size: int) -> Outcome:
        return RunTimeError.NO_CLOCK

    def set_clock(self, buffer: int, size: int) -> Outcome:
        return RunTimeError.NO_CLOCK

    def transmit(self, table: int, port: int) -> Outcome:
        return RunTimeError.NO_FREEPORT

    def receive(self, table: int, port: int) -> Outcome:
        return RunTimeError.NO_FREEPORT

    def net_read(self, table: int, port: int) -> Outcome:
        return ENO_OFF

    def net_write(self, table: int, port: int) -> Outcome:
        return ENO_OFF

    def port_address(self, port: int) -> int:
        return 2

    def set_port_address(self, address: int, port: int) -> Outcome:
        return OK

    def define_counter(self, counter: int, mode: int) -> Outcome:
        return RunTimeError.HSC_INPUT_TAKEN

    def run_counter(self, counter: int) -> Outcome:
        return RunTimeError.HSC_BEFORE_HDEF

    def pulse(self, output: int) -> Outcome:
        return ENO_OFF

    def pid(self, table: int, loop: int) -> Outcome:
        return RunTimeError.PID_TABLE

    def diagnosis_led(self, on: bool) -> None:
        self.led = on
