"""Shift, rotate and the shift register bit."""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.types import DataType
from pcaccess.stl.builder import Place
from pcaccess.stl.define import OVERFLOW, SAME, ZERO, In, InOut, define
from pcaccess.stl.errors import COUNT_RANGE, INDIRECT_ADDRESS, OPERAND_RANGE
from pcaccess.stl.instructions.bit_ranges import area_start, bit_number
from pcaccess.stl.ir_values import TYPE_OF, Effects, IrType, Value
from pcaccess.stl.routine import Routine
from pcaccess.stl.runtime import OK, Outcome, Runtime

BOOL, BYTE, WORD, DWORD = DataType.BOOL, DataType.BYTE, DataType.WORD, DataType.DWORD
_TYPES: Final = (("B", BYTE), ("W", WORD), ("D", DWORD))
MAX_REGISTER: Final = 64


@define(
    {f"{name}{letter}": (kind, name == "SL") for name in ("SL", "SR") for letter, kind in _TYPES},
    group="Shift",
    operands=(InOut("OUT", SAME), In("N", BYTE)),
    sm=(ZERO, OVERFLOW),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Shift",
)
def shift(b: Routine, kind: DataType, left: bool, out: Place, count: Value) -> None:
    """Shift OUT by N bits to the left (SR: right), filling with zeros.

    N counts up to the width of OUT, more is as much. With N > 0, SM1.1 is the bit that left last and SM1.0 says
    whether the result is 0; with N = 0 nothing changes. Words and double words shift as unsigned numbers too:
    "the sign bit is shifted when you use signed data types" is read as shifted like any other bit.
    """
    bits = TYPE_OF[kind].bits
    wide = b.convert(b.load(out), IrType.U64)
    number = b.convert(b.minimum(count, bits), IrType.U64)
    with b.when(b.ne(number, 0)):
        # One bit more to the right, so that the bit that leaves last is still there.
        moved = b.shl(wide, number) if left else b.shr(b.shl(wide, 1), number)
        last = b.and_(b.shr(moved, bits), 1) if left else b.and_(moved, 1)
        result = b.convert(moved if left else b.shr(moved, 1), TYPE_OF[kind])
        b.store(out, result)
        b.set_sm({ZERO: b.eq(result, 0), OVERFLOW: b.ne(last, 0)})
    b.eno(True)


@define(
    {f"{name}{letter}": (kind, name == "RL") for name in ("RL", "RR") for letter, kind in _TYPES},
    group="Shift",
    operands=(InOut("OUT", SAME), In("N", BYTE)),
    sm=(ZERO, OVERFLOW),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Rotate",
)
def rotate(b: Routine, kind: DataType, left: bool, out: Place, count: Value) -> None:
    """Rotate OUT by N bits to the left (RR: right).

    N counts modulo the width of OUT. SM1.0 says whether OUT is 0; SM1.1 is the bit that went round last, and
    stays as it was when nothing rotates.
    """
    native = TYPE_OF[kind]
    value = b.load(out)
    number = b.and_(b.convert(count, native), native.bits - 1)
    with b.choose(b.ne(number, 0)) as choice:
        back = b.and_(b.sub(b.const(native, native.bits), number), native.bits - 1)
        first, second = (number, back) if left else (back, number)
        result = b.or_(b.shl(value, first), b.shr(value, second))
        b.store(out, result)
        last = result if left else b.shr(result, native.bits - 1)
        b.set_sm({ZERO: b.eq(result, 0), OVERFLOW: b.ne(b.and_(last, 1), 0)})
        choice.otherwise()
        b.set_sm({ZERO: b.eq(value, 0)})
    b.eno(True)


@define(
    {"SHRB": ()},
    group="Shift",
    operands=(In("DATA", BOOL), InOut("S_BIT", BOOL), In("N", BYTE, low=-64, high=64)),
    sm=(OVERFLOW,),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE, COUNT_RANGE),
    source="System Manual, Shift register bit; document 004, section 9.21",
)
def shift_register(b: Routine, data: Value, first: Place, count: Value) -> None:
    """Shift DATA into the register of |N| bits from S_BIT on; the bit that leaves goes to SM1.1.

    N > 0: DATA comes in at S_BIT. N < 0: it comes in at the other end. N is a signed byte of -64 to 64; beyond,
    or 0, nothing happens but error 0092. A register that does not wholly exist is error 0091.
    """
    assert first.area is not None
    limit = b.model.sizes[first.area] * (1 if first.area.is_numbered else 8)
    b.cold(
        shift_bits,
        data,
        b.bitcast(count, IrType.I8),
        static=(first.area, bit_number(first), limit),
        effects=Effects(sm=(OVERFLOW,), errors=(OPERAND_RANGE, COUNT_RANGE)),
    )


def shift_bits(runtime: Runtime, area: Area, first: int, limit: int, data: int, count: int) -> Outcome:
    """SHRB: see :func:`shift_register`."""
    length = abs(count)
    if not 0 < length <= MAX_REGISTER:
        return COUNT_RANGE
    if first + length > limit:
        return OPERAND_RANGE
    memory = runtime.memory
    start, end = area_start(area) + first // 8, area_start(area) + (first + length + 7) // 8
    everything = int.from_bytes(memory[start:end], "little")
    mask, shift = (1 << length) - 1, first % 8
    register = everything >> shift & mask
    if count > 0:
        leaving = register >> length - 1
        moved = register << 1 & mask | data
    else:
        leaving = register & 1
        moved = register >> 1 | data << length - 1
    everything = everything & ~(mask << shift) | moved << shift
    memory[start:end] = everything.to_bytes(end - start, "little")
    at = area_start(Area.SM) + OVERFLOW.byte
    memory[at] = memory[at] & ~(1 << OVERFLOW.bit) | leaving << OVERFLOW.bit
    return OK
