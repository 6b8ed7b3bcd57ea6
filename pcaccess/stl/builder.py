"""Emits IR: what the bodies of instruction definitions are written in.

Constants are folded on the way (an instruction with a constant count costs only what is left), so a body is
written once for all its operands. ``Place`` is an operand that can be written; a value operand arrives as a
``Value``, already loaded.

Not here: the logic stack, labels and calls (``pcaccess.stl.routine``).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.memory import AREA_START
from pcaccess.s7200.types import DataType
from pcaccess.stl import evaluate, ir
from pcaccess.stl.define import SmBit
from pcaccess.stl.errors import RunTimeError
from pcaccess.stl.ir_values import TYPE_OF, BinaryOp, Effects, IrError, IrType, PythonFunction, Relation, UnaryOp, Value

SM_START: Final = AREA_START[Area.SM]
_UNSIGNED: Final = {8: IrType.U8, 16: IrType.U16, 32: IrType.U32, 64: IrType.U64}
_SIGNED_WIDE: Final = {8: IrType.I32, 16: IrType.I32, 32: IrType.I64}


@dataclass(frozen=True, slots=True)
class Place:
    """Where an operand lies: at a flat address known now (int) or at run time (a checked I32 value)."""

    type: DataType
    at: int | Value
    bit: int = 0
    area: Area | None = None
    """None for an operand behind a pointer."""
    offset: int = 0
    """Byte offset or element number in the area."""
    pointer: Value | None = None
    """The pointer it lies behind."""


class Choice:
    """The two sides of ``Builder.choose``; see there."""

    def __init__(self, builder: Builder, otherwise: ir.Block, join: ir.Block) -> None:
        self._builder, self._otherwise, self._join = builder, otherwise, join
        self.turned = False

    def otherwise(self) -> None:
        """What follows runs when the condition is 0."""
        self._builder.jump(self._join)
        self._builder.start(self._otherwise)
        self.turned = True


class Builder:
    """Builds one function, block by block. Every method that computes returns the new value."""

    def __init__(self, name: str) -> None:
        self.function = ir.Function(name)
        self._constants: dict[tuple[IrType, int | float, bool], Value] = {}
        self.place = 0
        """Index of the place (``Module.places``) for errors of what is emitted now."""
        self.nested = 0
        """How many ``when`` and ``choose`` are open."""
        self.block = self.new_block()

    # values

    def new_value(self, kind: IrType) -> Value:
        value = Value(len(self.function.values), kind)
        self.function.values.append(value)
        return value

    def const(self, kind: IrType, number: int | float) -> Value:
        """A constant; an integer wraps to its type, a real is rounded to it."""
        if kind.real:
            number = evaluate.round_to_single(number) if kind is IrType.F32 else float(number)
        else:
            number = kind.wrap(int(number))
        key = (kind, number, str(number)[0] == "-")  # -0.0 equals 0.0, and is not the same constant
        value = self._constants.get(key)
        if value is None:
            value = Value(len(self.function.values), kind, number)
            self.function.values.append(value)
            self._constants[key] = value
        return value

    def bit(self, on: bool) -> Value:
        return self.const(IrType.I1, int(on))

    def _same(self, a: Value, b: Value | int | float) -> Value:
        return b if isinstance(b, Value) else self.const(a.type, b)

    # blocks

    def new_block(self) -> ir.Block:
        """A block in the function; it is filled after :meth:`start`."""
        block = ir.Block(len(self.function.blocks))
        self.function.blocks.append(block)
        return block

    def start(self, block: ir.Block) -> None:
        """What is emitted next goes into ``block``."""
        self.block = block

    def emit(self, operation: ir.Operation) -> None:
        self.block.operations.append(operation)

    def terminate(self, terminator: ir.Terminator) -> None:
        if self.block.terminator is not None:
            raise IrError(f"{self.function.name}: {self.block} ends twice")
        self.block.terminator = terminator

    def jump(self, target: ir.Block) -> None:
        self.terminate(ir.Jump(target))

    def branch(self, condition: Value, then: ir.Block, otherwise: ir.Block) -> None:
        self.terminate(ir.Branch(condition, then, otherwise))

    @contextmanager
    def when(self, condition: Value) -> Iterator[None]:
        """``with b.when(c):`` what is emitted inside runs when ``c`` is 1."""
        if condition.constant == 1:
            yield
            return
        inside, after = self.new_block(), self.new_block()
        self.branch(condition, inside, after)
        self.start(inside)
        self.nested += 1
        yield
        self.nested -= 1
        self.jump(after)
        self.start(after)

    @contextmanager
    def choose(self, condition: Value) -> Iterator[Choice]:
        """``with b.choose(c) as choice:`` one side, ``choice.otherwise()``, the other side."""
        inside, otherwise, after = self.new_block(), self.new_block(), self.new_block()
        if condition.constant is None:
            self.branch(condition, inside, otherwise)
        else:
            self.jump(inside if condition.constant else otherwise)
        self.start(inside)
        choice = Choice(self, otherwise, after)
        self.nested += 1
        yield choice
        self.nested -= 1
        if not choice.turned:
            raise IrError("choose without otherwise: use when")
        self.jump(after)
        self.start(after)

    # arithmetic

    def binary(self, op: BinaryOp | str, a: Value, b: Value | int | float) -> Value:
        """``op`` by name (``"add"``) or value; both of one type."""
        op = BinaryOp(op)
        b = self._same(a, b)
        if a.type is not b.type:
            raise IrError(f"{op.value} of {a} and {b}")
        if a.constant is not None and b.constant is not None and not (op in _DIVISIONS and b.constant == 0):
            return self.const(a.type, evaluate.binary(op, a.type)(a.constant, b.constant))
        if a.type is IrType.I1:
            folded = self._logic(op, a, b)
            if folded is not None:
                return folded
        elif b.constant == 0 and op in _NEUTRAL_ZERO and not a.type.real:
            return a
        out = self.new_value(a.type)
        self.emit(ir.Binary(op, out, a, b))
        return out

    def _logic(self, op: BinaryOp, a: Value, b: Value) -> Value | None:
        if a.constant is not None:
            a, b = b, a
        if op is BinaryOp.AND:
            return {None: None, 0: b, 1: a}[b.constant]  # type: ignore[index]
        if op is BinaryOp.OR:
            return {None: None, 0: a, 1: b}[b.constant]  # type: ignore[index]
        return None

    def add(self, a: Value, b: Value | int | float) -> Value:
        return self.binary(BinaryOp.ADD, a, b)

    def sub(self, a: Value, b: Value | int | float) -> Value:
        return self.binary(BinaryOp.SUB, a, b)

    def and_(self, a: Value, b: Value | int) -> Value:
        return self.binary(BinaryOp.AND, a, b)

    def or_(self, a: Value, b: Value | int) -> Value:
        return self.binary(BinaryOp.OR, a, b)

    def xor(self, a: Value, b: Value | int) -> Value:
        return self.binary(BinaryOp.XOR, a, b)

    def shl(self, a: Value, b: Value | int) -> Value:
        return self.binary(BinaryOp.SHL, a, b)

    def shr(self, a: Value, b: Value | int) -> Value:
        return self.binary(BinaryOp.SHR, a, b)

    def unary(self, op: UnaryOp, a: Value) -> Value:
        if a.constant is not None:
            return self.const(a.type, evaluate.unary(op, a.type)(a.constant))
        out = self.new_value(a.type)
        self.emit(ir.Unary(op, out, a))
        return out

    def not_(self, a: Value) -> Value:
        return self.unary(UnaryOp.NOT, a)

    def compare(self, relation: Relation | str, a: Value, b: Value | int | float) -> Value:
        relation = Relation(relation)
        b = self._same(a, b)
        if a.type is not b.type:
            raise IrError(f"{relation.value} of {a} and {b}")
        if a.constant is not None and b.constant is not None:
            return self.bit(evaluate.compare(relation)(a.constant, b.constant))
        out = self.new_value(IrType.I1)
        self.emit(ir.Compare(relation, out, a, b))
        return out

    def eq(self, a: Value, b: Value | int | float) -> Value:
        return self.compare(Relation.EQ, a, b)

    def ne(self, a: Value, b: Value | int | float) -> Value:
        return self.compare(Relation.NE, a, b)

    def lt(self, a: Value, b: Value | int | float) -> Value:
        return self.compare(Relation.LT, a, b)

    def le(self, a: Value, b: Value | int | float) -> Value:
        return self.compare(Relation.LE, a, b)

    def gt(self, a: Value, b: Value | int | float) -> Value:
        return self.compare(Relation.GT, a, b)

    def ge(self, a: Value, b: Value | int | float) -> Value:
        return self.compare(Relation.GE, a, b)

    def convert(self, a: Value, kind: IrType) -> Value:
        """``a`` as another type; see ``ir.Convert``."""
        if a.type is kind:
            return a
        if a.constant is not None and (kind.real or not a.type.real):
            return self.const(kind, evaluate.convert(a.type, kind)(a.constant))
        out = self.new_value(kind)
        self.emit(ir.Convert(out, a))
        return out

    def widen(self, a: Value) -> Value:
        """A signed integer wide enough for any sum, difference or product of two such values."""
        return self.convert(a, _SIGNED_WIDE[a.type.bits])

    def bitcast(self, a: Value, kind: IrType) -> Value:
        if a.type is kind:
            return a
        out = self.new_value(kind)
        self.emit(ir.Bitcast(out, a))
        return out

    def fits(self, a: Value, kind: IrType) -> Value:
        if a.constant is not None:
            return self.bit(evaluate.fits(a.type, kind)(a.constant))
        out = self.new_value(IrType.I1)
        self.emit(ir.Fits(out, a, kind))
        return out

    def finite(self, a: Value) -> Value:
        if a.constant is not None:
            return self.bit(math.isfinite(a.constant))
        out = self.new_value(IrType.I1)
        self.emit(ir.Finite(out, a))
        return out

    def select(self, condition: Value, a: Value, b: Value | int | float) -> Value:
        b = self._same(a, b)
        if condition.constant is not None:
            return a if condition.constant else b
        out = self.new_value(a.type)
        self.emit(ir.Select(out, condition, a, b))
        return out

    def minimum(self, a: Value, b: Value | int) -> Value:
        b = self._same(a, b)
        return self.select(self.lt(a, b), a, b)

    def lookup(self, index: Value, table: tuple[int, ...], kind: IrType) -> Value:
        out = self.new_value(kind)
        self.emit(ir.Lookup(out, index, table))
        return out

    # memory

    def load_at(self, kind: IrType, at: int | Value) -> Value:
        """A number from a flat address."""
        out = self.new_value(kind)
        self.emit(ir.Load(out, at) if isinstance(at, int) else ir.LoadFrom(out, at))
        return out

    def store_at(self, at: int | Value, value: Value) -> None:
        self.emit(ir.Store(at, value) if isinstance(at, int) else ir.StoreTo(at, value))

    def load_bit(self, at: int, bit: int) -> Value:
        out = self.new_value(IrType.I1)
        self.emit(ir.LoadBit(out, at, bit))
        return out

    def store_bit(self, at: int, bit: int, value: Value) -> None:
        self.store_bits(at, ((bit, value),))

    def store_bits(self, at: int, bits: Sequence[tuple[int, Value]]) -> None:
        """Change several bits of one byte: (number, value)."""
        self.emit(ir.StoreBits(at, tuple(bits)))

    def load(self, place: Place) -> Value:
        """The operand's value, in the IR type of its data type."""
        if place.type is DataType.BOOL:
            return self.load_bit(self._fixed(place), place.bit)
        return self.load_at(TYPE_OF[place.type], place.at)

    def load_raw(self, place: Place) -> Value:
        """The operand's bits as an unsigned integer."""
        return self.load_at(_UNSIGNED[TYPE_OF[place.type].bits], place.at)

    def load_bits(self, place: Place) -> Value:
        """What is only copied, bit for bit: a REAL need not be a number."""
        return self.load(place) if place.type is DataType.BOOL else self.load_raw(place)

    def store(self, place: Place, value: Value) -> None:
        """``value`` has the IR type of the place, or another of the same width."""
        if place.type is DataType.BOOL:
            self.store_bit(self._fixed(place), place.bit, value)
        else:
            self.store_at(place.at, value)

    @staticmethod
    def _fixed(place: Place) -> int:
        if not isinstance(place.at, int):
            raise IrError("a bit has no run-time address")
        return place.at

    def address(self, place: Place) -> Value:
        """The flat address as an I32 value."""
        return place.at if isinstance(place.at, Value) else self.const(IrType.I32, place.at)

    # flags, errors, cold instructions

    def set_sm(self, bits: Mapping[SmBit, Value | bool]) -> None:
        """Change SM bits; those of one byte are changed at once."""
        by_byte: dict[int, list[tuple[int, Value]]] = {}
        for bit, value in bits.items():
            by_byte.setdefault(bit.byte, []).append((bit.bit, value if isinstance(value, Value) else self.bit(value)))
        for byte, changes in by_byte.items():
            self.store_bits(SM_START + byte, changes)

    def fault(self, code: RunTimeError | Value) -> None:
        """Record a run-time error at the current place."""
        value = code if isinstance(code, Value) else self.const(IrType.I32, int(code))
        self.emit(ir.Fault(value, self.place))

    def call(
        self,
        function: PythonFunction,
        *arguments: Value,
        static: tuple[Any, ...] = (),
        effects: Effects | None = None,
        result: IrType | None = None,
    ) -> Value | None:
        """Call a Python function; see ``ir.CallPython``."""
        out = self.new_value(result) if result else None
        self.emit(ir.CallPython(out, function, static, arguments, effects or Effects(), self.place))
        return out

    def compute(self, function: PythonFunction, *arguments: Value, result: IrType) -> Value:
        """Call a Python function for its result alone."""
        out = self.call(function, *arguments, result=result)
        assert out is not None
        return out


_DIVISIONS: Final = (BinaryOp.DIV, BinaryOp.REM)
_NEUTRAL_ZERO: Final = (BinaryOp.ADD, BinaryOp.SUB, BinaryOp.OR, BinaryOp.XOR, BinaryOp.SHL, BinaryOp.SHR)
