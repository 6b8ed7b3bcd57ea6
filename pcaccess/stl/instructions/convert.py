"""Conversions between numbers, BCD, seven segments, encode and decode."""

from __future__ import annotations

from pcaccess.s7200.types import DataType
from pcaccess.stl.define import NOT_BCD, OVERFLOW, In, InOut, Out, declare
from pcaccess.stl.errors import INDIRECT_ADDRESS

BYTE, INT, WORD, DINT, REAL = DataType.BYTE, DataType.INT, DataType.WORD, DataType.DINT, DataType.REAL
_GROUP = "Conversion"
_SOURCE = "System Manual, Standard conversion"

byte_to_int = declare(
    {"BTI": ()},
    group=_GROUP,
    operands=(In("IN", BYTE), Out("OUT", INT)),
    eno_off=(INDIRECT_ADDRESS,),
    source=_SOURCE,
    doc="""Convert an unsigned byte to an integer.""",
)
int_to_byte = declare(
    {"ITB": ()},
    group=_GROUP,
    operands=(In("IN", INT), Out("OUT", BYTE)),
    sm=(OVERFLOW,),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
    doc="""Convert an integer of 0 to 255 to a byte.""",
)
int_to_double = declare(
    {"ITD": ()},
    group=_GROUP,
    operands=(In("IN", INT), Out("OUT", DINT)),
    eno_off=(INDIRECT_ADDRESS,),
    source=_SOURCE,
    doc="""Convert an integer to a double integer.""",
)
double_to_int = declare(
    {"DTI": ()},
    group=_GROUP,
    operands=(In("IN", DINT), Out("OUT", INT)),
    sm=(OVERFLOW,),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
    doc="""Convert a double integer to an integer.""",
)
double_to_real = declare(
    {"DTR": ()},
    group=_GROUP,
    operands=(In("IN", DINT), Out("OUT", REAL)),
    eno_off=(INDIRECT_ADDRESS,),
    source=_SOURCE,
    doc="""Convert a double integer to the nearest REAL.""",
)
real_to_double = declare(
    {"ROUND": (), "TRUNC": ()},
    group=_GROUP,
    operands=(In("IN", REAL), Out("OUT", DINT)),
    sm=(OVERFLOW,),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS),
    source=_SOURCE,
    doc="""Convert a REAL to a double integer: rounded, or without its fraction.""",
)
bcd_to_int = declare(
    {"BCDI": ()},
    group=_GROUP,
    operands=(InOut("OUT", WORD),),
    sm=(NOT_BCD,),
    eno_off=(NOT_BCD, INDIRECT_ADDRESS),
    source=_SOURCE,
    doc="""Convert four BCD digits to an integer.""",
)
int_to_bcd = declare(
    {"IBCD": ()},
    group=_GROUP,
    operands=(InOut("OUT", WORD),),
    sm=(NOT_BCD,),
    eno_off=(NOT_BCD, INDIRECT_ADDRESS),
    source=_SOURCE,
    doc="""Convert an integer of 0 to 9999 to four BCD digits.""",
)
segment = declare(
    {"SEG": ()},
    group=_GROUP,
    operands=(In("IN", BYTE), Out("OUT", BYTE)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Segment; document 004, section 9.20",
    doc="""Light the segments of a seven-segment display for the low digit of IN.""",
)
decode = declare(
    {"DECO": ()},
    group=_GROUP,
    operands=(In("IN", BYTE), Out("OUT", WORD)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Encode and decode",
    doc="""Set only the bit of OUT whose number stands in the low four bits of IN.""",
)
encode = declare(
    {"ENCO": ()},
    group=_GROUP,
    operands=(In("IN", WORD), Out("OUT", BYTE)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Encode and decode",
    doc="""Write the number of the lowest bit of IN that is set to OUT.""",
)
