"""Conversions between numbers, BCD, seven segments, encode and decode.

A number that does not fit sets SM1.1 and leaves OUT as it was; a conversion that succeeds clears SM1.1.
"""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.types import DataType
from pcaccess.stl.builder import Place
from pcaccess.stl.define import NOT_BCD, OVERFLOW, In, InOut, Out, define
from pcaccess.stl.errors import INDIRECT_ADDRESS
from pcaccess.stl.ir_values import BinaryOp, IrType, UnaryOp, Value
from pcaccess.stl.routine import Routine

BYTE, INT, WORD, DINT, REAL = DataType.BYTE, DataType.INT, DataType.WORD, DataType.DINT, DataType.REAL
_GROUP: Final = "Conversion"
_SOURCE: Final = "System Manual, Standard conversion; document 004, section 9.20"


@define(
    {"BTI": (IrType.I16,)},
    group=_GROUP,
    operands=(In("IN", BYTE), Out("OUT", INT)),
    eno_off=(INDIRECT_ADDRESS,),
    source=_SOURCE,
)
def byte_to_int(b: Routine, kind: IrType, value: Value, out: Place) -> None:
    """Convert an unsigned byte to an integer."""
    b.store(out, b.convert(value, kind))
    b.eno(True)


@define(
    {"ITD": (IrType.I32,)},
    group=_GROUP,
    operands=(In("IN", INT), Out("OUT", DINT)),
    eno_off=(INDIRECT_ADDRESS,),
    source=_SOURCE,
)
def int_to_double(b: Routine, kind: IrType, value: Value, out: Place) -> None:
    """Convert an integer to a double integer; the sign is extended."""
    b.store(out, b.convert(value, kind))
    b.eno(True)


@define(
    {"DTR": ()},
    group=_GROUP,
    operands=(In("IN", DINT), Out("OUT", REAL)),
    eno_off=(INDIRECT_ADDRESS,),
    source=_SOURCE,
)
def double_to_real(b: Routine, value: Value, out: Place) -> None:
    """Convert a double integer to the nearest REAL (beyond 16777216 not every integer has one)."""
    b.store(out, b.convert(value, IrType.F32))
    b.eno(True)


def _narrow(b: Routine, value: Value, kind: IrType, out: Place) -> None:
    fits = b.fits(value, kind)
    with b.when(fits):
        b.store(out, b.convert(value, kind))
    b.set_sm({OVERFLOW: b.not_(fits)})
    b.eno(fits)


@define(
    {"ITB": ()},
    group=_GROUP,
    operands=(In("IN", INT), Out("OUT", BYTE)),
    sm=(OVERFLOW,),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def int_to_byte(b: Routine, value: Value, out: Place) -> None:
    """Convert an integer of 0 to 255 to a byte."""
    _narrow(b, value, IrType.U8, out)


@define(
    {"DTI": ()},
    group=_GROUP,
    operands=(In("IN", DINT), Out("OUT", INT)),
    sm=(OVERFLOW,),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def double_to_int(b: Routine, value: Value, out: Place) -> None:
    """Convert a double integer to an integer."""
    _narrow(b, value, IrType.I16, out)


@define(
    {"ROUND": (True,), "TRUNC": (False,)},
    group=_GROUP,
    operands=(In("IN", REAL), Out("OUT", DINT)),
    sm=(OVERFLOW,),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def real_to_double(b: Routine, rounded: bool, value: Value, out: Place) -> None:
    """Convert a REAL to a double integer: rounded (.5 upwards), or without its fraction (TRUNC).

    "Upwards" is taken at its word for negative numbers too: -2.5 becomes -2.
    """
    wide = b.convert(value, IrType.F64)
    whole = b.unary(UnaryOp.FLOOR, b.add(wide, 0.5)) if rounded else b.unary(UnaryOp.TRUNC, wide)
    _narrow(b, whole, IrType.I32, out)


@define(
    {"BCDI": ()},
    group=_GROUP,
    operands=(InOut("OUT", WORD),),
    sm=(NOT_BCD,),
    eno_off=(NOT_BCD, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def bcd_to_int(b: Routine, out: Place) -> None:
    """Convert four BCD digits to an integer. A digit above 9 sets SM1.6 and leaves OUT as it was."""
    word = b.convert(b.load(out), IrType.U32)
    good, number = b.bit(True), b.const(IrType.U32, 0)
    for position in (12, 8, 4, 0):
        digit = b.and_(b.shr(word, position), 0xF)
        good = b.and_(good, b.le(digit, 9))
        number = b.add(b.binary(BinaryOp.MUL, number, 10), digit)
    _bcd(b, good, number, out)


@define(
    {"IBCD": ()},
    group=_GROUP,
    operands=(InOut("OUT", WORD),),
    sm=(NOT_BCD,),
    eno_off=(NOT_BCD, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def int_to_bcd(b: Routine, out: Place) -> None:
    """Convert an integer of 0 to 9999 to four BCD digits. Any other sets SM1.6 and leaves OUT as it was."""
    number = b.convert(b.load(out), IrType.U32)
    good, word, rest = b.le(number, 9999), b.const(IrType.U32, 0), number
    for position in (0, 4, 8, 12):
        word = b.or_(word, b.shl(b.binary(BinaryOp.REM, rest, 10), position))
        rest = b.binary(BinaryOp.DIV, rest, 10)
    _bcd(b, good, word, out)


def _bcd(b: Routine, good: Value, result: Value, out: Place) -> None:
    with b.when(good):
        b.store(out, b.convert(result, IrType.U16))
    b.set_sm({NOT_BCD: b.not_(good)})
    b.eno(good)


SEGMENTS: Final = (
    0b0011_1111,
    0b0000_0110,
    0b0101_1011,
    0b0100_1111,
    0b0110_0110,
    0b0110_1101,
    0b0111_1101,
    0b0000_0111,
    0b0111_1111,
    0b0110_0111,
    0b0111_0111,
    0b0111_1100,
    0b0011_1001,
    0b0101_1110,
    0b0111_1001,
    0b0111_0001,
)
"""Segments -gfedcba of the digits 0 to F (document 004, section 9.20)."""


@define(
    {"SEG": ()},
    group=_GROUP,
    operands=(In("IN", BYTE), Out("OUT", BYTE)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Segment; document 004, section 9.20",
)
def segment(b: Routine, value: Value, out: Place) -> None:
    """Light the segments of a seven-segment display for the low digit of IN."""
    b.store(out, b.lookup(b.and_(value, 0xF), SEGMENTS, IrType.U8))
    b.eno(True)


@define(
    {"DECO": ()},
    group=_GROUP,
    operands=(In("IN", BYTE), Out("OUT", WORD)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Encode and decode",
)
def decode(b: Routine, value: Value, out: Place) -> None:
    """Set only the bit of OUT whose number stands in the low four bits of IN."""
    b.store(out, b.shl(b.const(IrType.U16, 1), b.convert(b.and_(value, 0xF), IrType.U16)))
    b.eno(True)


@define(
    {"ENCO": ()},
    group=_GROUP,
    operands=(In("IN", WORD), Out("OUT", BYTE)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Encode and decode",
)
def encode(b: Routine, value: Value, out: Place) -> None:
    """Write the number of the lowest bit of IN that is 1 to OUT. When there is none, OUT becomes 0: our choice."""
    lowest = b.unary(UnaryOp.TRAILING_ZEROS, b.or_(b.convert(value, IrType.U32), 1 << 16))
    b.store(out, b.convert(b.and_(lowest, 0xF), IrType.U8))
    b.eno(True)
