"""Error codes of an S7-200 at run time: which there are and what they mean.

Units:    a code is four hexadecimal digits in every message (``0006``), an int here.
Source:   System Manual, appendix "Error codes" (run-time programming problems, fatal errors).
"""

from __future__ import annotations

from enum import IntEnum
from types import MappingProxyType
from typing import Final


class RunTimeError(IntEnum):
    """Non-fatal: the instruction does nothing, ENO and SM4.3 show it, the CPU stays in RUN."""

    HSC_BEFORE_HDEF = 0x0001, "HSC executed before HDEF"
    INPUT_INTERRUPT_TAKEN = 0x0002, "input interrupt on a point that a high-speed counter uses"
    HSC_INPUT_TAKEN = 0x0003, "high-speed counter on a point that an input interrupt or another counter uses"
    NOT_IN_INTERRUPT = 0x0004, "ENI, DISI, SPA or HDEF in an interrupt routine"
    HSC_PLS_TWICE = 0x0005, "second HSC or PLS with the same number before the first was finished"
    INDIRECT_ADDRESS = 0x0006, "indirect addressing error"
    CLOCK_DATA = 0x0007, "bad date or time for the clock"
    CALL_TOO_DEEP = 0x0008, "subroutines nested too deep"
    PORT_0_BUSY = 0x0009, "XMT and RCV at the same time on port 0"
    HDEF_TWICE = 0x000A, "high-speed counter defined a second time"
    PORT_1_BUSY = 0x000B, "XMT and RCV at the same time on port 1"
    NO_CLOCK = 0x000C, "no clock"
    PULSE_ACTIVE = 0x000D, "pulse output changed while it was active"
    NO_SEGMENTS = 0x000E, "pulse train profile without segments"
    ILLEGAL_NUMBER = 0x000F, "illegal number in a compare"
    PTO_MODE = 0x0010, "command not allowed in this PTO mode"
    PTO_COMMAND = 0x0011, "illegal PTO command"
    PTO_PROFILE = 0x0012, "illegal PTO profile table"
    PID_TABLE = 0x0013, "illegal PID loop table"
    OPERAND_RANGE = 0x0091, "operand out of range"
    COUNT_RANGE = 0x0092, "count out of range"
    NO_FREEPORT = 0x0090, "port is not in Freeport mode"
    STRING_INDEX = 0x009B, "index into a string is 0"

    text: str

    def __new__(cls, code: int, text: str) -> RunTimeError:
        member = int.__new__(cls, code)
        member._value_ = code
        member.text = text
        return member

    def __str__(self) -> str:
        return f"{self.value:04X}"


class FatalError(IntEnum):
    """The CPU goes to STOP."""

    WATCHDOG = 0x0003, "scan watchdog: the program did not end in time"

    text: str

    def __new__(cls, code: int, text: str) -> FatalError:
        member = int.__new__(cls, code)
        member._value_ = code
        member.text = text
        return member

    def __str__(self) -> str:
        return f"{self.value:04X}"


INDIRECT_ADDRESS: Final = RunTimeError.INDIRECT_ADDRESS
OPERAND_RANGE: Final = RunTimeError.OPERAND_RANGE
COUNT_RANGE: Final = RunTimeError.COUNT_RANGE
RUN_TIME_ERRORS: Final = MappingProxyType({int(error): error for error in RunTimeError})
"""By code."""
