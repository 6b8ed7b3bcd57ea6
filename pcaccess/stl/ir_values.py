"""The words of the intermediate representation: types, values, arithmetic. What instruction definitions speak.

Types:    integers wrap at their width; I1 is 0 or 1; F32 is rounded once after each operation; comparing a
          NaN gives 0 for all relations but NE. U64 and I64 stay in registers: memory has up to 32 bits.
Source:   docs/decisions/2026-11-22-stl-ir.md.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum

from pcaccess.s7200.types import DataType
from pcaccess.stl.define import SmBit
from pcaccess.stl.errors import RunTimeError


class IrError(Exception):
    """IR that breaks the rules of this module."""


@dataclass(frozen=True, slots=True)
class _Kind:
    bits: int
    signed: bool
    real: bool = False


class IrType(Enum):
    """Type of a value. ``I`` is signed, ``U`` unsigned; I1 is a bit."""

    I1 = _Kind(1, False)
    U8 = _Kind(8, False)
    I8 = _Kind(8, True)
    U16 = _Kind(16, False)
    I16 = _Kind(16, True)
    U32 = _Kind(32, False)
    I32 = _Kind(32, True)
    U64 = _Kind(64, False)
    I64 = _Kind(64, True)
    F32 = _Kind(32, True, True)
    F64 = _Kind(64, True, True)

    def __init__(self, kind: _Kind) -> None:
        self.bits = kind.bits
        self.signed = kind.signed
        self.real = kind.real
        self.size = max(1, kind.bits // 8)
        """Bytes in memory."""
        self.low = -(1 << kind.bits - 1) if kind.signed else 0
        self.high = (1 << kind.bits - 1) - 1 if kind.signed else (1 << kind.bits) - 1

    def wrap(self, number: int) -> int:
        """The value that the low ``bits`` bits of ``number`` are (integers only)."""
        number &= (1 << self.bits) - 1
        return number - (1 << self.bits) if self.signed and number > self.high else number

    def __repr__(self) -> str:
        return self.name


TYPE_OF: Mapping[DataType, IrType] = {
    DataType.BOOL: IrType.I1,
    DataType.BYTE: IrType.U8,
    DataType.CHAR: IrType.I8,
    DataType.WORD: IrType.U16,
    DataType.INT: IrType.I16,
    DataType.DWORD: IrType.U32,
    DataType.DINT: IrType.I32,
    DataType.REAL: IrType.F32,
}
"""IR type of each data type a value can have (a STRING has none: it is bytes in memory)."""


@dataclass(slots=True, eq=False)
class Value:
    """A virtual register, or a constant. ``index`` is unique in the function, for constants too."""

    index: int
    type: IrType
    constant: int | float | None = None

    def __repr__(self) -> str:
        name = f"%{self.index}" if self.constant is None else repr(self.constant)
        return f"{name}:{self.type.name}"


@dataclass(slots=True, eq=False)
class Variable:
    """A place in the running function that can be assigned again and again. It starts with ``initial``."""

    index: int
    type: IrType
    name: str
    initial: int = 0

    def __repr__(self) -> str:
        return f"${self.name}"


class BinaryOp(Enum):
    """Both operands and the result have one type. DIV and REM cut towards zero; the divisor is not 0 and the
    quotient fits (the lowering sees to it). SHR fills with the sign of a signed type; a shift count is below
    the width. Real types know ADD SUB MUL DIV (by IEEE 754, division by zero included)."""

    ADD = "add"
    SUB = "sub"
    MUL = "mul"
    DIV = "div"
    REM = "rem"
    AND = "and"
    OR = "or"
    XOR = "xor"
    SHL = "shl"
    SHR = "shr"


class UnaryOp(Enum):
    """NOT inverts every bit. NEG also for reals. ABS, SQRT, FLOOR, TRUNC for reals only. TRAILING_ZEROS: the
    number of the lowest bit that is 1 (the operand is not 0)."""

    NOT = "not"
    NEG = "neg"
    ABS = "abs"
    SQRT = "sqrt"
    FLOOR = "floor"
    TRUNC = "trunc"
    TRAILING_ZEROS = "trailing_zeros"


class Relation(Enum):
    EQ = "eq"
    NE = "ne"
    LT = "lt"
    LE = "le"
    GT = "gt"
    GE = "ge"


@dataclass(frozen=True, slots=True)
class Effects:
    """What a Python function can change beside its result, for the test that holds definitions to it."""

    sm: tuple[SmBit, ...] = ()
    errors: tuple[RunTimeError, ...] = ()


PythonFunction = Callable[..., int | float | None]
