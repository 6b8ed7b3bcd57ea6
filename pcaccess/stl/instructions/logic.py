"""Logic on bytes, words and double words."""

from __future__ import annotations

from pcaccess.s7200.types import DataType
from pcaccess.stl.define import SAME, ZERO, In, InOut, declare
from pcaccess.stl.errors import INDIRECT_ADDRESS

BYTE, WORD, DWORD = DataType.BYTE, DataType.WORD, DataType.DWORD

invert = declare(
    {"INVB": (BYTE,), "INVW": (WORD,), "INVD": (DWORD,)},
    group="Logical",
    operands=(InOut("OUT", SAME),),
    sm=(ZERO,),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Invert",
    doc="""Invert every bit of OUT.""",
)
combine = declare(
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
    doc="""Combine OUT with IN1 bit by bit.""",
)
