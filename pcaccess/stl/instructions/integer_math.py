"""Integer mathematics."""

from __future__ import annotations

from pcaccess.s7200.types import DataType
from pcaccess.stl.define import DIVIDE_BY_ZERO, NEGATIVE, OVERFLOW, SAME, ZERO, In, InOut, declare
from pcaccess.stl.errors import INDIRECT_ADDRESS

BYTE, INT, DINT = DataType.BYTE, DataType.INT, DataType.DINT
_SOURCE = "System Manual, Integer math; document 004, section 9.18"

add_subtract_multiply = declare(
    {
        "+I": (INT, "add"),
        "-I": (INT, "sub"),
        "*I": (INT, "mul"),
        "+D": (DINT, "add"),
        "-D": (DINT, "sub"),
        "*D": (DINT, "mul"),
    },
    group="Math int",
    operands=(In("IN1", SAME), InOut("OUT", SAME)),
    sm=(ZERO, OVERFLOW, NEGATIVE),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
    doc="""Add IN1 to OUT, subtract it from OUT, or multiply OUT by it.""",
)
divide = declare(
    {"/I": (INT,), "/D": (DINT,)},
    group="Math int",
    operands=(In("IN1", SAME), InOut("OUT", SAME)),
    sm=(ZERO, OVERFLOW, NEGATIVE, DIVIDE_BY_ZERO),
    eno_off=(OVERFLOW, DIVIDE_BY_ZERO, INDIRECT_ADDRESS),
    source=_SOURCE,
    doc="""Divide OUT by IN1; no remainder is kept.""",
)
multiply_wide = declare(
    {"MUL": ()},
    group="Math int",
    operands=(In("IN1", INT), InOut("OUT", DINT)),
    sm=(ZERO, OVERFLOW, NEGATIVE),
    eno_off=(INDIRECT_ADDRESS,),
    source=_SOURCE,
    doc="""Multiply the low word of OUT by IN1; the product fills OUT.""",
)
divide_wide = declare(
    {"DIV": ()},
    group="Math int",
    operands=(In("IN1", INT), InOut("OUT", DINT)),
    sm=(ZERO, OVERFLOW, NEGATIVE, DIVIDE_BY_ZERO),
    eno_off=(OVERFLOW, DIVIDE_BY_ZERO, INDIRECT_ADDRESS),
    source=_SOURCE,
    doc="""Divide the low word of OUT by IN1: quotient to the low word of OUT, remainder to the high word.""",
)
increment_byte = declare(
    {"INCB": ("add",), "DECB": ("sub",)},
    group="Math int",
    operands=(InOut("OUT", BYTE),),
    sm=(ZERO, OVERFLOW),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
    doc="""Add 1 to the byte (DECB: subtract 1).""",
)
increment = declare(
    {"INCW": (INT, "add"), "DECW": (INT, "sub"), "INCD": (DINT, "add"), "DECD": (DINT, "sub")},
    group="Math int",
    operands=(InOut("OUT", SAME),),
    sm=(ZERO, OVERFLOW, NEGATIVE),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
    doc="""Add 1 to OUT (DECW, DECD: subtract 1).""",
)
