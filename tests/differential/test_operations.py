"""Every IR operation on every type with the borders of their ranges, in both executions."""

from __future__ import annotations

import itertools
import math
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import pytest

from pcaccess.stl.builder import Builder
from pcaccess.stl.ir_values import BinaryOp, IrType, Relation, UnaryOp, Value
from tests.differential.executions import COMPILED
from tests.differential.side_by_side import Pair, function, module

SINGLE_MAX = struct.unpack(">f", b"\x7f\x7f\xff\xff")[0]
REALS = (0.0, -0.0, 1.0, -1.0, 0.5, -2.5, 1.5e-45, -1e-38, 16777217.0, 2147483648.0, -2147483648.0, 1e9, 0.1)
REALS += (3e9, 4294967040.0, 255.9, 32767.5, -32768.9, SINGLE_MAX, -SINGLE_MAX, math.inf, -math.inf, math.nan)
INTEGERS = [kind for kind in IrType if not kind.real]
NUMBERS = [kind for kind in IrType if kind is not IrType.I1]
IN_MEMORY = [kind for kind in NUMBERS if kind.bits <= 32]
SIZE = 8
"""Bytes that one operand has in memory; the results begin behind the three operands."""
RESULT = 3 * SIZE


def borders(kind: IrType) -> list[int | float]:
    if kind.real:
        return list(REALS)
    numbers = {kind.low, kind.low + 1, kind.high, kind.high - 1, 0, 1, 2, 7, 100, -1, -3, kind.high // 2, 0x5A}
    return sorted(n for n in numbers if kind.low <= n <= kind.high)


def operand(b: Builder, kind: IrType, place: int) -> Value:
    """The number at operand ``place``; a double is the sum of two singles, a long number two double words."""
    at = place * SIZE
    if kind is IrType.I1:
        return b.load_bit(at, 0)
    if kind is IrType.F64:
        high, low = (b.convert(b.load_at(IrType.F32, n), IrType.F64) for n in (at, at + 4))
        return b.add(high, low)
    if kind.bits == 64:
        high, low = (b.convert(b.load_at(IrType.U32, n), kind) for n in (at, at + 4))
        return b.or_(b.shl(high, 32), low)
    return b.load_at(kind, at)


def encode(kind: IrType, number: int | float) -> bytes:
    """What ``operand`` reads as this number (a double: as near as two singles come)."""
    if kind is IrType.I1:
        return struct.pack(">Bxxxxxxx", int(number))
    if kind is IrType.F64:
        return struct.pack(">ff", number, 1e-9 * number if abs(number) < 1e3 else 0.0)
    if kind is IrType.F32:
        return struct.pack(">fxxxx", number)
    return (int(number) & (1 << kind.bits) - 1).to_bytes(kind.size, "big").ljust(SIZE, b"\0")


def keep(b: Builder, value: Value) -> None:
    """Store a result of any type so that every bit of it shows."""
    kind = value.type
    if kind is IrType.I1:
        b.store_bit(RESULT, 3, value)
    elif kind is IrType.F64:
        single = b.convert(value, IrType.F32)
        b.store_at(RESULT, single)
        b.store_at(RESULT + 4, b.convert(b.sub(value, b.convert(single, IrType.F64)), IrType.F32))
    elif kind.bits == 64:
        wide = b.convert(value, IrType.U64)
        b.store_at(RESULT, b.convert(b.shr(wide, 32), IrType.U32))
        b.store_at(RESULT + 4, b.convert(wide, IrType.U32))
    else:
        b.store_at(RESULT, value)


def _always(*_: float) -> bool:
    return True


def _allowed(op: BinaryOp, kind: IrType) -> Callable[..., bool]:
    """The operands that ``op`` may get: the lowering sees to it that it gets no others."""
    if op in (BinaryOp.DIV, BinaryOp.REM) and not kind.real:
        return lambda a, b: b != 0 and not (kind.signed and a == kind.low and b == -1)
    if op in (BinaryOp.SHL, BinaryOp.SHR):
        return lambda _, b: 0 <= b < kind.bits
    return _always


def _whole_part_fits(kind: IrType) -> Callable[..., bool]:
    return lambda a: math.isfinite(a) and kind.low <= math.trunc(a) <= kind.high


@dataclass(frozen=True)
class Case:
    name: str
    operands: tuple[IrType, ...]
    compute: Callable[..., Value]
    allowed: Callable[..., bool] = _always
    real_result: bool = False

    def body(self, b: Builder) -> None:
        values = [operand(b, kind, n) for n, kind in enumerate(self.operands)]
        keep(b, self.compute(b, *values))

    def inputs(self) -> Iterator[tuple[float, ...]]:
        return (numbers for numbers in itertools.product(*map(borders, self.operands)) if self.allowed(*numbers))

    def __str__(self) -> str:
        return self.name


def _binary_cases() -> Iterator[Case]:
    for kind in IrType:
        for op in BinaryOp:
            if kind.real and op not in (BinaryOp.ADD, BinaryOp.SUB, BinaryOp.MUL, BinaryOp.DIV):
                continue
            if kind is IrType.I1 and op not in (BinaryOp.AND, BinaryOp.OR, BinaryOp.XOR):
                continue
            yield Case(
                f"{op.value} {kind}",
                (kind, kind),
                lambda b, x, y, op=op: b.binary(op, x, y),
                _allowed(op, kind),
                real_result=kind.real,
            )


def _unary_cases() -> Iterator[Case]:
    for kind in IrType:
        reals = (UnaryOp.NEG, UnaryOp.ABS, UnaryOp.SQRT, UnaryOp.FLOOR, UnaryOp.TRUNC)
        for op in reals if kind.real else (UnaryOp.NOT, UnaryOp.NEG, UnaryOp.TRAILING_ZEROS):
            if kind is IrType.I1 and op is not UnaryOp.NOT:
                continue
            if op is UnaryOp.TRAILING_ZEROS and kind.bits > 32:
                continue
            allowed = bool if op is UnaryOp.TRAILING_ZEROS else _always
            yield Case(
                f"{op.value} {kind}", (kind,), lambda b, x, op=op: b.unary(op, x), allowed, real_result=kind.real
            )


def _conversion_cases() -> Iterator[Case]:
    for source, target in itertools.permutations(IrType, 2):
        if target is IrType.I1 or (source is IrType.I1 and target.real):
            continue
        if target.real and source.bits == 64 and not source.real:
            continue  # no instruction needs it, and Python rounds twice
        yield Case(
            f"convert {source} {target}",
            (source,),
            lambda b, x, kind=target: b.convert(x, kind),
            _whole_part_fits(target) if source.real and not target.real else _always,
            real_result=target.real,
        )
    for source, target in itertools.product(NUMBERS, INTEGERS):
        if target is not IrType.I1 and not (source.real and target.bits > 32):
            yield Case(f"fits {source} {target}", (source,), lambda b, x, kind=target: b.fits(x, kind))
    for kind in (IrType.F32, IrType.F64):
        yield Case(f"finite {kind}", (kind,), lambda b, x: b.finite(x))
    for source, target in itertools.permutations(IN_MEMORY, 2):
        if source.bits == target.bits:
            yield Case(
                f"bitcast {source} {target}",
                (source,),
                lambda b, x, kind=target: b.bitcast(x, kind),
                real_result=IrType.F32 in (source, target),
            )


def _choice_cases() -> Iterator[Case]:
    for kind, relation in itertools.product(NUMBERS, Relation):
        yield Case(
            f"{relation.value} {kind}",
            (kind, kind),
            lambda b, x, y, relation=relation: b.compare(relation, x, y),
        )
    for kind in IrType:
        yield Case(
            f"select {kind}",
            (IrType.I1, kind, kind),
            lambda b, c, x, y: b.select(c, x, y),
            real_result=kind.real,
        )
    table = (5, 0, 255, 17)
    yield Case("lookup", (IrType.U8,), lambda b, x: b.lookup(b.and_(x, 3), table, IrType.U8))


CASES = [*_binary_cases(), *_unary_cases(), *_conversion_cases(), *_choice_cases()]


@pytest.fixture(scope="module", params=["compiled", "optimised"])
def pair(request: pytest.FixtureRequest) -> Pair:
    return Pair(module([function(case.body) for case in CASES]), COMPILED[request.param])


def result(case: Case, memory: bytes) -> object:
    """The bytes of a result; a NaN is as good as any other."""
    data = memory[RESULT : RESULT + SIZE]
    if case.real_result and math.isnan(struct.unpack_from(">f", data)[0]):
        return "NaN"
    return data


@pytest.mark.parametrize(("number", "case"), list(enumerate(CASES)), ids=[case.name for case in CASES])
def test_every_execution_computes_the_same(pair: Pair, number: int, case: Case) -> None:
    for numbers in case.inputs():
        memory = b"".join(encode(kind, n) for kind, n in zip(case.operands, numbers, strict=True))
        plain, fast = pair.run(memory, number)
        assert result(case, fast) == result(case, plain), numbers


def test_every_case_has_inputs() -> None:
    assert [case.name for case in CASES if not any(True for _ in case.inputs())] == []
