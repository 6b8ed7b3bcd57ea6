"""Conversions to and from ASCII characters in byte buffers."""

from __future__ import annotations

from pcaccess.s7200.types import DataType
from pcaccess.stl.define import NOT_HEX, SAME, In, Out, declare
from pcaccess.stl.errors import INDIRECT_ADDRESS, OPERAND_RANGE

BYTE, INT, DINT, REAL = DataType.BYTE, DataType.INT, DataType.DINT, DataType.REAL
_SOURCE = "System Manual, ASCII conversion; document 004, section 9.20"

ascii_to_hex = declare(
    {"ATH": ()},
    group="Conversion ASCII",
    operands=(In("IN", BYTE, constant=False, block=True), Out("OUT", BYTE, block=True), In("LEN", BYTE)),
    sm=(NOT_HEX,),
    eno_off=(NOT_HEX, INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
    doc="""Convert LEN hexadecimal characters from IN on to digits from OUT on.""",
)
hex_to_ascii = declare(
    {"HTA": ()},
    group="Conversion ASCII",
    operands=(In("IN", BYTE, constant=False, block=True), Out("OUT", BYTE, block=True), In("LEN", BYTE)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
    doc="""Convert LEN hexadecimal digits from IN on to characters from OUT on.""",
)
number_to_ascii = declare(
    {"ITA": (INT, 8), "DTA": (DINT, 12), "RTA": (REAL, 0)},
    group="Conversion ASCII",
    operands=(In("IN", SAME), Out("OUT", BYTE, block=True), In("FMT", BYTE)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
    doc="""Write the number as text, right-justified in a buffer of fixed length, as FMT says.""",
)
number_to_string = declare(
    {"ITS": (INT, 8), "DTS": (DINT, 12), "RTS": (REAL, 0)},
    group="Conversion string",
    operands=(In("IN", SAME), Out("OUT", DataType.STRING), In("FMT", BYTE)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source="System Manual, String conversion",
    doc="""Write the number as a string, as FMT says.""",
)
