"""Compare contacts: bytes, words, double words, reals, strings."""

from __future__ import annotations

from typing import Any, Final

from pcaccess.s7200.types import DataType
from pcaccess.stl.define import SAME, Family, In, Power, StackUse, declare
from pcaccess.stl.errors import INDIRECT_ADDRESS, RunTimeError

RELATIONS: Final = {"=": "eq", "<>": "ne", ">=": "ge", "<=": "le", ">": "gt", "<": "lt"}
_TYPES: Final = {"B": DataType.BYTE, "W": DataType.INT, "D": DataType.DINT, "R": DataType.REAL}


def _rows(contact: str) -> dict[str, tuple[Any, ...]]:
    return {
        f"{contact}{letter}{sign}": (kind, relation)
        for letter, kind in _TYPES.items()
        for sign, relation in RELATIONS.items()
    }


def _declare(contact: str, doc: str) -> Family:
    return declare(
        _rows(contact),
        group="Compare",
        operands=(In("IN1", SAME), In("IN2", SAME)),
        power=Power.CONTACT,
        stack=StackUse(0, 1) if contact == "LD" else StackUse(),
        errors=(INDIRECT_ADDRESS, RunTimeError.ILLEGAL_NUMBER),
        source="System Manual, Compare",
        doc=doc,
    )


load_compare = _declare("LD", "Push the result of comparing IN1 with IN2 to the logic stack.")
and_compare = _declare("A", "AND the top of the logic stack with the result of comparing IN1 with IN2.")
or_compare = _declare("O", "OR the top of the logic stack with the result of comparing IN1 with IN2.")

_STRING: Final = (In("IN1", DataType.STRING), In("IN2", DataType.STRING, constant=False))

load_string = declare(
    {"LDS=": (True,), "LDS<>": (False,)},
    group="Compare string",
    operands=_STRING,
    power=Power.CONTACT,
    stack=StackUse(0, 1),
    errors=(INDIRECT_ADDRESS, RunTimeError.OPERAND_RANGE),
    source="System Manual, Compare string",
    doc="Push the result of comparing two strings to the logic stack.",
)
combine_string = declare(
    {"AS=": ("and", True), "AS<>": ("and", False), "OS=": ("or", True), "OS<>": ("or", False)},
    group="Compare string",
    operands=_STRING,
    power=Power.CONTACT,
    errors=(INDIRECT_ADDRESS, RunTimeError.OPERAND_RANGE),
    source="System Manual, Compare string",
    doc="Combine the top of the logic stack with the result of comparing two strings.",
)
