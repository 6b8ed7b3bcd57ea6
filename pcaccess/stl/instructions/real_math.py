"""Mathematics with REAL values."""

from __future__ import annotations

from pcaccess.s7200.types import DataType
from pcaccess.stl.define import DIVIDE_BY_ZERO, NEGATIVE, OVERFLOW, ZERO, In, InOut, Out, declare
from pcaccess.stl.errors import INDIRECT_ADDRESS

REAL = DataType.REAL
_SOURCE = "System Manual, Floating-point math; document 004, section 9.18"

arithmetic = declare(
    {"+R": ("add",), "-R": ("sub",), "*R": ("mul",)},
    group="Math real",
    operands=(In("IN1", REAL), InOut("OUT", REAL)),
    sm=(ZERO, OVERFLOW, NEGATIVE),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
    doc="""Add IN1 to OUT, subtract it from OUT, or multiply OUT by it.""",
)
divide = declare(
    {"/R": ()},
    group="Math real",
    operands=(In("IN1", REAL), InOut("OUT", REAL)),
    sm=(ZERO, OVERFLOW, NEGATIVE, DIVIDE_BY_ZERO),
    eno_off=(OVERFLOW, DIVIDE_BY_ZERO, INDIRECT_ADDRESS),
    source=_SOURCE,
    doc="""Divide OUT by IN1.""",
)
functions = declare(
    {"SQRT": (), "SIN": (), "COS": (), "TAN": (), "LN": (), "EXP": ()},
    group="Math real",
    operands=(In("IN", REAL), Out("OUT", REAL)),
    sm=(ZERO, OVERFLOW, NEGATIVE),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
    doc="""Store the function of IN in OUT; angles are in radians.""",
)
