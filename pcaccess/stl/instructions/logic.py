"""Logic on bytes, words and double words."""

from __future__ import annotations

from pcaccess.s7200.types import DataType
from pcaccess.stl.builder import Place
from pcaccess.stl.define import SAME, ZERO, In, InOut, define
from pcaccess.stl.errors import INDIRECT_ADDRESS
from pcaccess.stl.ir_values import Value
from pcaccess.stl.routine import Routine

BYTE, WORD, DWORD = DataType.BYTE, DataType.WORD, DataType.DWORD


def _finish(b: Routine, out: Place, result: Value) -> None:
    b.store(out, result)
    b.set_sm({ZERO: b.eq(result, 0)})
    b.eno(True)


@define(
    {"INVB": (BYTE,), "INVW": (WORD,), "INVD": (DWORD,)},
    group="Logical",
    operands=(InOut("OUT", SAME),),
    sm=(ZERO,),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Invert",
)
def invert(b: Routine, kind: DataType, out: Place) -> None:
    """Invert every bit of OUT."""
    _finish(b, out, b.not_(b.load(out)))


@define(
    {
        f"{name}{letter}": (kind, operator)
        for name, operator in (("AND", "and"), ("OR", "or"), ("XOR", "xor"))
        for letter, kind in (("B", BYTE), ("W", WORD), ("D", DWORD))
    },
    group="Logical",
    operands=(In("IN1", SAME), InOut("OUT", SAME)),
    sm=(ZERO,),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, AND, OR, exclusive OR",
)
def combine(b: Routine, kind: DataType, op: str, in1: Value, out: Place) -> None:
    """Combine OUT with IN1 bit by bit."""
    _finish(b, out, b.binary(op, b.load(out), in1))
