"""Integer mathematics.

When the result does not fit (SM1.1), OUT is not altered. SM1.0 and SM1.2, which the manual then calls not valid,
keep what they were: our choice. After a division by zero (SM1.3) the other flags are left unchanged.
"""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.types import DataType
from pcaccess.stl.builder import Place
from pcaccess.stl.define import DIVIDE_BY_ZERO, NEGATIVE, OVERFLOW, SAME, ZERO, In, InOut, SmBit, define
from pcaccess.stl.errors import INDIRECT_ADDRESS
from pcaccess.stl.ir_values import TYPE_OF, BinaryOp, IrType, Value
from pcaccess.stl.routine import Routine

BYTE, INT, DINT = DataType.BYTE, DataType.INT, DataType.DINT
_SOURCE: Final = "System Manual, Integer math; document 004, section 9.18"


def _finish(b: Routine, out: Place, exact: Value, kind: IrType, *clear: SmBit) -> None:
    """Store an exact result if it fits, and set the flags and ENO; ``clear``: further flags that become 0."""
    fits = b.fits(exact, kind)
    with b.choose(fits) as choice:
        b.store(out, b.convert(exact, kind))
        flags: dict[SmBit, Value | bool] = {ZERO: b.eq(exact, 0), OVERFLOW: False}
        if kind.signed:
            flags[NEGATIVE] = b.lt(exact, 0)
        b.set_sm(flags | dict.fromkeys(clear, False))
        b.eno(True)
        choice.otherwise()
        b.set_sm({OVERFLOW: True} | dict.fromkeys(clear, False))
        b.eno(False)


def _zero_divisor(b: Routine) -> None:
    b.set_sm({DIVIDE_BY_ZERO: True})
    b.eno(False)


@define(
    {
        "+I": (INT, "add"),
        "-I": (INT, "sub"),
        "*I": (INT, "mul"),
        "+D": (DINT, "add"),
        "-D": (DINT, "sub"),
        "*D": (DINT, "mul"),
    },
    group="Math int",
    operands=(In("IN1", SAME), InOut("OUT", SAME)),
    sm=(ZERO, OVERFLOW, NEGATIVE),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def add_subtract_multiply(b: Routine, kind: DataType, op: str, in1: Value, out: Place) -> None:
    """Add IN1 to OUT, subtract it from OUT, or multiply OUT by it."""
    exact = b.binary(op, b.widen(b.load(out)), b.widen(in1))  # twice as wide: cannot overflow
    _finish(b, out, exact, TYPE_OF[kind])


@define(
    {"/I": (INT,), "/D": (DINT,)},
    group="Math int",
    operands=(In("IN1", SAME), InOut("OUT", SAME)),
    sm=(ZERO, OVERFLOW, NEGATIVE, DIVIDE_BY_ZERO),
    eno_off=(OVERFLOW, DIVIDE_BY_ZERO, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def divide(b: Routine, kind: DataType, in1: Value, out: Place) -> None:
    """Divide OUT by IN1; no remainder is kept. The lowest number divided by -1 overflows."""
    with b.choose(b.ne(in1, 0)) as choice:
        exact = b.binary(BinaryOp.DIV, b.widen(b.load(out)), b.widen(in1))
        _finish(b, out, exact, TYPE_OF[kind], DIVIDE_BY_ZERO)
        choice.otherwise()
        _zero_divisor(b)


@define(
    {"MUL": ()},
    group="Math int",
    operands=(In("IN1", INT), InOut("OUT", DINT)),
    sm=(ZERO, OVERFLOW, NEGATIVE),
    eno_off=(INDIRECT_ADDRESS,),
    source=_SOURCE,
)
def multiply_wide(b: Routine, in1: Value, out: Place) -> None:
    """Multiply the low word of OUT by IN1; the product fills OUT. It always fits: SM1.1 becomes 0."""
    low = b.convert(b.load(out), IrType.I16)
    product = b.binary(BinaryOp.MUL, b.widen(low), b.widen(in1))
    b.store(out, product)
    b.set_sm({ZERO: b.eq(product, 0), OVERFLOW: False, NEGATIVE: b.lt(product, 0)})
    b.eno(True)


@define(
    {"DIV": ()},
    group="Math int",
    operands=(In("IN1", INT), InOut("OUT", DINT)),
    sm=(ZERO, OVERFLOW, NEGATIVE, DIVIDE_BY_ZERO),
    eno_off=(OVERFLOW, DIVIDE_BY_ZERO, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def divide_wide(b: Routine, in1: Value, out: Place) -> None:
    """Divide the low word of OUT by IN1: quotient to the low word of OUT, remainder to the high word.

    The remainder has the sign of what was divided. The flags tell of the quotient. -32768 divided by -1
    overflows.
    """
    with b.choose(b.ne(in1, 0)) as choice:
        dividend, divisor = b.widen(b.convert(b.load(out), IrType.I16)), b.widen(in1)
        quotient = b.binary(BinaryOp.DIV, dividend, divisor)
        rest = b.binary(BinaryOp.REM, dividend, divisor)
        fits = b.fits(quotient, IrType.I16)
        with b.choose(fits) as inner:
            b.store(out, b.or_(b.shl(rest, 16), b.and_(quotient, 0xFFFF)))
            flags: dict[SmBit, Value | bool] = {ZERO: b.eq(quotient, 0), NEGATIVE: b.lt(quotient, 0)}
            b.set_sm(flags | {OVERFLOW: False, DIVIDE_BY_ZERO: False})
            b.eno(True)
            inner.otherwise()
            b.set_sm({OVERFLOW: True, DIVIDE_BY_ZERO: False})
            b.eno(False)
        choice.otherwise()
        _zero_divisor(b)


@define(
    {"INCB": ("add",), "DECB": ("sub",)},
    group="Math int",
    operands=(InOut("OUT", BYTE),),
    sm=(ZERO, OVERFLOW),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def increment_byte(b: Routine, op: str, out: Place) -> None:
    """Add 1 to the byte (DECB: subtract 1); bytes have no sign."""
    _finish(b, out, b.binary(op, b.widen(b.load(out)), 1), IrType.U8)


@define(
    {"INCW": (INT, "add"), "DECW": (INT, "sub"), "INCD": (DINT, "add"), "DECD": (DINT, "sub")},
    group="Math int",
    operands=(InOut("OUT", SAME),),
    sm=(ZERO, OVERFLOW, NEGATIVE),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def increment(b: Routine, kind: DataType, op: str, out: Place) -> None:
    """Add 1 to OUT (DECW, DECD: subtract 1)."""
    _finish(b, out, b.binary(op, b.widen(b.load(out)), 1), TYPE_OF[kind])
