"""Mathematics with REAL values: IEEE 754 single precision, rounded once.

A result that is too large, and an operand or a result that is no number, set SM1.1; OUT is not altered then, and
SM1.0 and SM1.2 keep what they were. A result too small becomes 0 with SM1.0, or a subnormal number.

Source:   System Manual, Floating-point math; document 004, section 9.18.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from pcaccess.s7200.types import DataType
from pcaccess.stl.builder import Place
from pcaccess.stl.define import DIVIDE_BY_ZERO, NEGATIVE, OVERFLOW, ZERO, In, InOut, Out, SmBit, define
from pcaccess.stl.errors import INDIRECT_ADDRESS
from pcaccess.stl.ir_values import BinaryOp, IrType, UnaryOp, Value
from pcaccess.stl.routine import Routine
from pcaccess.stl.runtime import Runtime

REAL: Final = DataType.REAL
_SOURCE: Final = "System Manual, Floating-point math; document 004, section 9.18"


def _finish(b: Routine, out: Place, result: Value, legal: Value, *clear: SmBit) -> None:
    """Store a result that is a number, and set the flags and ENO."""
    good = b.and_(legal, b.finite(result))
    with b.choose(good) as choice:
        b.store(out, result)
        flags: dict[SmBit, Value | bool] = {ZERO: b.eq(result, 0.0), OVERFLOW: False, NEGATIVE: b.lt(result, 0.0)}
        b.set_sm(flags | dict.fromkeys(clear, False))
        b.eno(True)
        choice.otherwise()
        b.set_sm({OVERFLOW: True} | dict.fromkeys(clear, False))
        b.eno(False)


@define(
    {"+R": ("add",), "-R": ("sub",), "*R": ("mul",)},
    group="Math real",
    operands=(In("IN1", REAL), InOut("OUT", REAL)),
    sm=(ZERO, OVERFLOW, NEGATIVE),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def arithmetic(b: Routine, op: str, in1: Value, out: Place) -> None:
    """Add IN1 to OUT, subtract it from OUT, or multiply OUT by it."""
    result = b.binary(op, b.load(out), in1)
    _finish(b, out, result, b.bit(True))  # an infinite or illegal operand makes the result so


@define(
    {"/R": ()},
    group="Math real",
    operands=(In("IN1", REAL), InOut("OUT", REAL)),
    sm=(ZERO, OVERFLOW, NEGATIVE, DIVIDE_BY_ZERO),
    eno_off=(OVERFLOW, DIVIDE_BY_ZERO, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def divide(b: Routine, in1: Value, out: Place) -> None:
    """Divide OUT by IN1."""
    with b.choose(b.ne(in1, 0.0)) as choice:
        _finish(b, out, b.binary(BinaryOp.DIV, b.load(out), in1), b.finite(in1), DIVIDE_BY_ZERO)
        choice.otherwise()
        b.set_sm({DIVIDE_BY_ZERO: True})
        b.eno(False)


@define(
    {"SQRT": ()},
    group="Math real",
    operands=(In("IN", REAL), Out("OUT", REAL)),
    sm=(ZERO, OVERFLOW, NEGATIVE),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def square_root(b: Routine, value: Value, out: Place) -> None:
    """Store the square root of IN. Of a negative number there is none: SM1.1."""
    _finish(b, out, b.unary(UnaryOp.SQRT, value), b.bit(True))


def _safely(function: Callable[[float], float]) -> Callable[[Runtime, float], float]:
    """The function as a cold call: NaN for what it cannot compute."""

    def compute(_: Runtime, number: float) -> float:
        try:
            return function(number)
        except (ValueError, OverflowError):
            return math.nan

    compute.__name__ = function.__name__
    return compute


@define(
    {
        "SIN": (_safely(math.sin),),
        "COS": (_safely(math.cos),),
        "TAN": (_safely(math.tan),),
        "LN": (_safely(math.log),),
        "EXP": (_safely(math.exp),),
    },
    group="Math real",
    operands=(In("IN", REAL), Out("OUT", REAL)),
    sm=(ZERO, OVERFLOW, NEGATIVE),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
)
def functions(b: Routine, function: Callable[[Runtime, float], float], value: Value, out: Place) -> None:
    """Store the function of IN in OUT; angles are in radians. LN of 0 or less: SM1.1.

    Computed in double precision and rounded once.
    """
    exact = b.compute(function, b.convert(value, IrType.F64), result=IrType.F64)
    _finish(b, out, b.convert(exact, IrType.F32), b.bit(True))
