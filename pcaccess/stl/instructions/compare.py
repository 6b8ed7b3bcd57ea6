"""Compare contacts: bytes, words, double words, reals (strings: ``strings``)."""

from __future__ import annotations

from typing import Any, Final

from pcaccess.s7200.types import DataType
from pcaccess.stl.define import SAME, In, Power, StackUse, define
from pcaccess.stl.errors import INDIRECT_ADDRESS, RunTimeError
from pcaccess.stl.ir_values import Value
from pcaccess.stl.routine import Routine

ILLEGAL_NUMBER: Final = RunTimeError.ILLEGAL_NUMBER
_RELATIONS: Final = {"=": "eq", "<>": "ne", ">=": "ge", "<=": "le", ">": "gt", "<": "lt"}
_INTEGERS: Final = {"B": DataType.BYTE, "W": DataType.INT, "D": DataType.DINT}
_OPERANDS: Final = (In("IN1", SAME), In("IN2", SAME))
_SOURCE: Final = "System Manual, Compare; document 004, section 9.16"

Row = tuple[Any, ...]


def _rows(contact: str, letter: str, kind: DataType, *more: str) -> dict[str, Row]:
    return {f"{contact}{letter}{sign}": (*more, kind, relation) for sign, relation in _RELATIONS.items()}


def _integers(contact: str, *more: str) -> dict[str, Row]:
    rows: dict[str, Row] = {}
    for letter, kind in _INTEGERS.items():
        rows |= _rows(contact, letter, kind, *more)
    return rows


@define(
    _integers("LD"),
    group="Compare",
    operands=_OPERANDS,
    power=Power.CONTACT,
    stack=StackUse(0, 1),
    errors=(INDIRECT_ADDRESS,),
    source=_SOURCE,
)
def load_compare(b: Routine, _: DataType, relation: str, in1: Value, in2: Value) -> None:
    """Push the result of comparing IN1 with IN2 to the logic stack: bytes unsigned, the others signed."""
    b.push(b.and_(b.compare(relation, in1, in2), b.valid))


@define(
    _integers("A", "and") | _integers("O", "or"),
    group="Compare",
    operands=_OPERANDS,
    power=Power.CONTACT,
    errors=(INDIRECT_ADDRESS,),
    source=_SOURCE,
)
def combine_compare(b: Routine, op: str, _: DataType, relation: str, in1: Value, in2: Value) -> None:
    """Combine the top of the logic stack with the result of comparing IN1 with IN2."""
    b.set_top(b.binary(op, b.top, b.and_(b.compare(relation, in1, in2), b.valid)))


def _real_relation(b: Routine, relation: str, in1: Value, in2: Value) -> Value:
    """An illegal number compares as 0 and is error 000F."""
    legal = b.and_(b.finite(in1), b.finite(in2))
    with b.when(b.not_(legal)):
        b.fault(ILLEGAL_NUMBER)
    return b.and_(b.and_(b.compare(relation, in1, in2), legal), b.valid)


@define(
    _rows("LD", "R", DataType.REAL),
    group="Compare",
    operands=_OPERANDS,
    power=Power.CONTACT,
    stack=StackUse(0, 1),
    errors=(INDIRECT_ADDRESS, ILLEGAL_NUMBER),
    source=_SOURCE,
)
def load_compare_real(b: Routine, _: DataType, relation: str, in1: Value, in2: Value) -> None:
    """Push the result of comparing two REAL values to the logic stack.

    Infinity and NaN are illegal numbers: the result is 0 for every relation, and error 000F.
    """
    b.push(_real_relation(b, relation, in1, in2))


@define(
    _rows("A", "R", DataType.REAL, "and") | _rows("O", "R", DataType.REAL, "or"),
    group="Compare",
    operands=_OPERANDS,
    power=Power.CONTACT,
    errors=(INDIRECT_ADDRESS, ILLEGAL_NUMBER),
    source=_SOURCE,
)
def combine_compare_real(b: Routine, op: str, _: DataType, relation: str, in1: Value, in2: Value) -> None:
    """Combine the top of the logic stack with the result of comparing two REAL values."""
    top = b.top
    b.set_top(b.binary(op, top, _real_relation(b, relation, in1, in2)))
