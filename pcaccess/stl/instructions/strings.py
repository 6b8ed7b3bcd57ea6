"""Strings."""

from __future__ import annotations

from pcaccess.s7200.types import DataType
from pcaccess.stl.define import OVERFLOW, SAME, In, InOut, Out, declare
from pcaccess.stl.errors import INDIRECT_ADDRESS, OPERAND_RANGE, RunTimeError

BYTE, INT, DINT, REAL, STRING = DataType.BYTE, DataType.INT, DataType.DINT, DataType.REAL, DataType.STRING
_SOURCE = "System Manual, String instructions"
INDEX = RunTimeError.STRING_INDEX

length = declare(
    {"SLEN": ()},
    group="String",
    operands=(In("IN", STRING), Out("OUT", BYTE)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
    doc="""Store the length of the string.""",
)
copy = declare(
    {"SCPY": ()},
    group="String",
    operands=(In("IN", STRING), Out("OUT", STRING)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
    doc="""Copy the string.""",
)
append = declare(
    {"SCAT": ()},
    group="String",
    operands=(In("IN", STRING), InOut("OUT", STRING)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
    doc="""Append IN to the string OUT.""",
)
part = declare(
    {"SSCPY": ()},
    group="String",
    operands=(In("IN", STRING), In("INDX", BYTE), In("N", BYTE), Out("OUT", STRING)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE, INDEX),
    source=_SOURCE,
    doc="""Copy N characters from character INDX on.""",
)
find = declare(
    {"SFND": (), "CFND": ()},
    group="String",
    operands=(In("IN1", STRING, constant=False), In("IN2", STRING), InOut("OUT", BYTE)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE, INDEX),
    source=_SOURCE,
    doc="""Find IN2 (CFND: any character of IN2) in IN1 from character OUT on; OUT is its place, or 0.""",
)
string_to_number = declare(
    {"STI": (INT,), "STD": (DINT,), "STR": (REAL,)},
    group="Conversion string",
    operands=(In("IN", STRING), In("INDX", BYTE), Out("OUT", SAME)),
    sm=(OVERFLOW,),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS, OPERAND_RANGE, INDEX),
    source="System Manual, String conversion",
    doc="""Convert the text from character INDX on to a number.""",
)
