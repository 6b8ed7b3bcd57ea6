"""What each operation on values computes: plain functions on Python numbers.

The builder folds constants with them and the reference interpreter runs them; the compiler is tested against
them.

Units:    an integer is in the range of its type; an F32 is a Python float that a REAL can hold exactly.
Source:   ``pcaccess.stl.ir_values`` and ``ir`` (which say what each operation means).
"""

from __future__ import annotations

import math
import operator
import struct
from collections.abc import Callable
from typing import Any, Final

from pcaccess.stl.ir_values import BinaryOp, IrType, Relation, UnaryOp

_SINGLE: Final = struct.Struct("<f")


def round_to_single(number: float) -> float:
    """The nearest number an F32 can hold (ties to even); beyond the largest: infinity."""
    try:
        return float(_SINGLE.unpack(_SINGLE.pack(number))[0])
    except OverflowError:
        return math.copysign(math.inf, number)


def divide_real(a: float, b: float) -> float:
    """IEEE 754 division: by zero gives infinity, 0/0 a NaN."""
    if b:
        return a / b
    if a == 0 or math.isnan(a) or math.isnan(b):
        return math.nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def divide(a: int, b: int) -> int:
    """Quotient cut towards zero."""
    quotient = abs(a) // abs(b)
    return quotient if (a < 0) == (b < 0) else -quotient


def remainder(a: int, b: int) -> int:
    """What :func:`divide` leaves; it has the sign of ``a``."""
    return a - b * divide(a, b)


_INTEGER: Final[dict[BinaryOp, Callable[[int, int], int]]] = {
    BinaryOp.ADD: operator.add,
    BinaryOp.SUB: operator.sub,
    BinaryOp.MUL: operator.mul,
    BinaryOp.DIV: divide,
    BinaryOp.REM: remainder,
    BinaryOp.AND: operator.and_,
    BinaryOp.OR: operator.or_,
    BinaryOp.XOR: operator.xor,
    BinaryOp.SHL: operator.lshift,
    BinaryOp.SHR: operator.rshift,  # Python keeps the sign of a negative number, as SHR of a signed type does
}
_REAL: Final[dict[BinaryOp, Callable[[float, float], float]]] = {
    BinaryOp.ADD: operator.add,
    BinaryOp.SUB: operator.sub,
    BinaryOp.MUL: operator.mul,
    BinaryOp.DIV: divide_real,
}
_CLOSED: Final = frozenset({BinaryOp.AND, BinaryOp.OR, BinaryOp.XOR, BinaryOp.SHR, BinaryOp.REM})
"""The result of these is in the range of the type by itself."""


def binary(op: BinaryOp, kind: IrType) -> Callable[[Any, Any], Any]:
    """The function that computes ``op`` on two values of type ``kind``."""
    if kind.real:
        real = _REAL[op]
        return real if kind is IrType.F64 else lambda a, b: round_to_single(real(a, b))
    integer = _INTEGER[op]
    if op in _CLOSED:
        return integer
    mask, high, span = (1 << kind.bits) - 1, kind.high, 1 << kind.bits
    if not kind.signed:
        return lambda a, b: integer(a, b) & mask

    def signed(a: int, b: int) -> int:
        number = integer(a, b) & mask
        return number - span if number > high else number

    return signed


def _square_root(a: float) -> float:
    return math.sqrt(a) if a >= 0 else math.nan


def _whole(function: Callable[[float], int]) -> Callable[[float], float]:
    """As IEEE 754 does it: -0.5 without its fraction is -0."""
    return lambda a: math.copysign(float(function(a)), a) if math.isfinite(a) else a


_UNARY_REAL: Final[dict[UnaryOp, Callable[[float], float]]] = {
    UnaryOp.NEG: operator.neg,
    UnaryOp.ABS: abs,
    UnaryOp.SQRT: _square_root,
    UnaryOp.FLOOR: _whole(math.floor),
    UnaryOp.TRUNC: _whole(math.trunc),
}


def unary(op: UnaryOp, kind: IrType) -> Callable[[Any], Any]:
    """The function that computes ``op`` on a value of type ``kind``."""
    if kind.real:
        real = _UNARY_REAL[op]
        return real if kind is IrType.F64 else lambda a: round_to_single(real(a))
    if op is UnaryOp.NOT:
        if kind.signed:
            return operator.invert
        return lambda a: a ^ kind.high
    if op is UnaryOp.NEG:
        return lambda a: kind.wrap(-a)
    if op is UnaryOp.TRAILING_ZEROS:
        return lambda a: (a & -a).bit_length() - 1
    raise ValueError(f"{op.value} of {kind.name}")


_RELATIONS: Final[dict[Relation, Callable[[Any, Any], bool]]] = {
    Relation.EQ: operator.eq,
    Relation.NE: operator.ne,
    Relation.LT: operator.lt,
    Relation.LE: operator.le,
    Relation.GT: operator.gt,
    Relation.GE: operator.ge,
}


def compare(relation: Relation) -> Callable[[Any, Any], bool]:
    """The function that compares two values of one type."""
    return _RELATIONS[relation]


def convert(source: IrType, target: IrType) -> Callable[[Any], Any]:
    """The function that converts a value; a real must fit an integer target (``ir.Fits``)."""
    if target.real:
        return round_to_single if target is IrType.F32 else float
    if source.real:
        return math.trunc
    if target.low <= source.low and source.high <= target.high:
        return int
    return target.wrap


_FORMATS: Final = {
    IrType.U8: "<B",
    IrType.I8: "<b",
    IrType.U16: "<H",
    IrType.I16: "<h",
    IrType.U32: "<I",
    IrType.I32: "<i",
    IrType.F32: "<f",
}


def bitcast(source: IrType, target: IrType) -> Callable[[Any], Any]:
    """The function that reads the bits of a value as another type of the same width."""
    if not source.real and not target.real:
        return target.wrap
    pack, unpack = struct.Struct(_FORMATS[source]).pack, struct.Struct(_FORMATS[target]).unpack
    return lambda a: unpack(pack(a))[0]


def fits(source: IrType, target: IrType) -> Callable[[Any], bool]:
    """The function that says whether the integer type ``target`` can hold a value."""
    low, high = target.low, target.high
    if source.real:
        return lambda a: math.isfinite(a) and low <= math.trunc(a) <= high
    return lambda a: low <= a <= high
