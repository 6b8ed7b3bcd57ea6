"""Conversions to and from ASCII characters in byte buffers, and of numbers to text.

Numbers as text: no sign but ``-``, no leading zeros but the one before the decimal point, right-justified. A
format that does not exist, and a number that does not fit its buffer, fill the buffer with blanks and set ENO
to 0 without an error code.

Source:   System Manual, ASCII conversion, String conversion; document 004, section 9.20.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Final

from pcaccess.s7200.types import DataType
from pcaccess.stl.builder import Place
from pcaccess.stl.define import NOT_HEX, SAME, In, Out, define
from pcaccess.stl.errors import INDIRECT_ADDRESS, OPERAND_RANGE
from pcaccess.stl.instructions.sm import set_sm_bit
from pcaccess.stl.ir_values import Effects, Value
from pcaccess.stl.routine import Routine
from pcaccess.stl.runtime import ENO_OFF, OK, Outcome, Runtime

BYTE, INT, DINT, REAL = DataType.BYTE, DataType.INT, DataType.DINT, DataType.REAL
_SOURCE: Final = "System Manual, ASCII conversion; document 004, section 9.20"
_HEX: Final = b"0123456789ABCDEF"
MOST_DECIMALS: Final = 5
SHORTEST_REAL: Final = 3
LONGEST_REAL: Final = 15


@define(
    {"ATH": ()},
    group="Conversion ASCII",
    operands=(In("IN", BYTE, constant=False, block=True), Out("OUT", BYTE, block=True), In("LEN", BYTE)),
    sm=(NOT_HEX,),
    eno_off=(NOT_HEX, INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
)
def ascii_to_hex(b: Routine, source: Place, out: Place, length: Value) -> None:
    """Convert LEN hexadecimal characters (0 to 9, A to F) from IN on to digits from OUT on, two in a byte.

    Of an odd number the last digit goes to the upper half of its byte; the lower half stays. Any other character
    ends the conversion and sets SM1.7; the digits before it have been stored.
    """
    effects = Effects(sm=(NOT_HEX,), errors=(OPERAND_RANGE,))
    b.cold(to_hex, b.address(source), b.address(out), length, effects=effects)


def to_hex(runtime: Runtime, source: int, out: int, length: int) -> Outcome:
    if length > runtime.room(source) or (length + 1) // 2 > runtime.room(out):
        return OPERAND_RANGE
    memory = runtime.memory
    good = True
    for number, character in enumerate(bytes(memory[source : source + length])):
        digit = _HEX.find(character)
        if digit < 0:
            good = False
            break
        at = out + number // 2
        memory[at] = memory[at] & 0x0F | digit << 4 if number % 2 == 0 else memory[at] & 0xF0 | digit
    set_sm_bit(memory, NOT_HEX, not good)
    return OK if good else ENO_OFF


@define(
    {"HTA": ()},
    group="Conversion ASCII",
    operands=(In("IN", BYTE, constant=False, block=True), Out("OUT", BYTE, block=True), In("LEN", BYTE)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
)
def hex_to_ascii(b: Routine, source: Place, out: Place, length: Value) -> None:
    """Convert LEN hexadecimal digits from IN on, two in a byte, to characters from OUT on."""
    b.cold(to_ascii, b.address(source), b.address(out), length, effects=Effects(errors=(OPERAND_RANGE,)))


def to_ascii(runtime: Runtime, source: int, out: int, length: int) -> Outcome:
    size = (length + 1) // 2
    if size > runtime.room(source) or length > runtime.room(out):
        return OPERAND_RANGE
    text = bytes(runtime.memory[source : source + size]).hex().upper().encode()
    runtime.memory[out : out + length] = text[:length]
    return OK


def integer_text(number: int, width: int, form: int) -> bytes | None:
    """The text of ITA and DTA; None for a format that does not exist."""
    decimals, comma = form & 7, form & 8
    if form & 0xF0 or decimals > MOST_DECIMALS:
        return None
    digits = str(abs(number)).rjust(decimals + 1, "0")
    return _justified(digits, decimals, number < 0, bool(comma), width)


def real_text(number: float, form: int) -> tuple[int, bytes | None]:
    """The width and the text of RTA; no text when format or number do not fit."""
    width, decimals, comma = form >> 4, form & 7, form & 8
    if not SHORTEST_REAL <= width <= LONGEST_REAL or decimals > MOST_DECIMALS or not math.isfinite(number):
        return width, None
    rounded = int(abs(Fraction(number)) * 10**decimals + Fraction(1, 2))
    digits = str(rounded).rjust(decimals + 1, "0")
    return width, _justified(digits, decimals, number < 0 < rounded, bool(comma), width)


def _justified(digits: str, decimals: int, negative: bool, comma: bool, width: int) -> bytes | None:
    point = "," if comma else "."
    text = digits if decimals == 0 else f"{digits[:-decimals]}{point}{digits[-decimals:]}"
    text = f"-{text}" if negative else text
    return text.rjust(width).encode() if len(text) <= width else None


@define(
    {"ITA": (INT, 8), "DTA": (DINT, 12), "RTA": (REAL, 0)},
    group="Conversion ASCII",
    operands=(In("IN", SAME), Out("OUT", BYTE, block=True), In("FMT", BYTE)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
)
def number_to_ascii(b: Routine, kind: DataType, width: int, number: Value, out: Place, form: Value) -> None:
    """Write the number as text, right-justified, into a buffer: 8 bytes for ITA, 12 for DTA.

    FMT is ``0000cnnn``: nnn digits (0 to 5) stand behind the decimal point, which is a comma when c is 1. For RTA
    it is ``sssscnnn`` with the size of the buffer, 3 to 15; the number is rounded to the digits asked for.
    """
    b.cold(write_number, number, b.address(out), form, static=(width, False), effects=Effects(errors=(OPERAND_RANGE,)))


@define(
    {"ITS": (INT, 8), "DTS": (DINT, 12), "RTS": (REAL, 0)},
    group="Conversion string",
    operands=(In("IN", SAME), Out("OUT", DataType.STRING), In("FMT", BYTE)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source="System Manual, String conversion",
)
def number_to_string(b: Routine, kind: DataType, width: int, number: Value, out: Place, form: Value) -> None:
    """Write the number as a string of 8 (DTS: 12) characters; FMT as for ITA, DTA and RTA."""
    b.cold(write_number, number, b.address(out), form, static=(width, True), effects=Effects(errors=(OPERAND_RANGE,)))


def write_number(runtime: Runtime, width: int, as_string: bool, number: float, out: int, form: int) -> Outcome:
    """ITA, DTA, RTA and ITS, DTS, RTS. ``width``: 0 when the format says it."""
    if width:
        text = integer_text(int(number), width, form)
    else:
        width, text = real_text(number, form)
    stored = bytes((width,)) if as_string else b""
    stored += b" " * width if text is None else text
    if len(stored) > runtime.room(out):
        return OPERAND_RANGE
    runtime.memory[out : out + len(stored)] = stored
    return OK if text is not None else ENO_OFF
