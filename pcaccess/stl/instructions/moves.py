"""Moves: single values, blocks, fill, swap, immediate bytes."""

from __future__ import annotations

from pcaccess.s7200.address import Area
from pcaccess.s7200.types import DataType
from pcaccess.stl.define import SAME, In, InOut, Out, declare
from pcaccess.stl.errors import INDIRECT_ADDRESS, OPERAND_RANGE

BYTE, INT, WORD, DWORD, REAL = DataType.BYTE, DataType.INT, DataType.WORD, DataType.DWORD, DataType.REAL

move = declare(
    {"MOVB": (BYTE,), "MOVW": (WORD,), "MOVR": (REAL,)},
    group="Move",
    operands=(In("IN", SAME), Out("OUT", SAME)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Move",
    doc="""Copy IN to OUT, bit for bit.""",
)
move_double = declare(
    {"MOVD": (DWORD,)},
    group="Move",
    operands=(In("IN", SAME, address_of=True), Out("OUT", SAME)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Move; Indirect addressing",
    doc="""Copy IN to OUT; IN may be the address of something (``&VB100``), which makes OUT a pointer to it.""",
)
block_move = declare(
    {"BMB": (BYTE,), "BMW": (WORD,), "BMD": (DWORD,)},
    group="Move",
    operands=(
        In("IN", SAME, constant=False, block=True),
        Out("OUT", SAME, block=True),
        In("N", BYTE, low=1, high=255),
    ),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source="System Manual, Block move",
    doc="""Copy N values from IN on to OUT on. The two may overlap.""",
)
fill = declare(
    {"FILL": ()},
    group="Table",
    operands=(In("IN", INT), Out("OUT", INT, block=True), In("N", BYTE, low=1, high=255)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source="System Manual, Memory fill",
    doc="""Write the word IN to N words from OUT on.""",
)
swap = declare(
    {"SWAP": ()},
    group="Move",
    operands=(InOut("IN", WORD),),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Swap bytes",
    doc="""Exchange the two bytes of the word.""",
)
read_immediate = declare(
    {"BIR": ()},
    group="Move immediate",
    operands=(In("IN", BYTE, constant=False, areas=frozenset({Area.I})), Out("OUT", BYTE)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Move byte immediate",
    doc="""Copy a byte of physical inputs to OUT; the process image stays as it is.""",
)
write_immediate = declare(
    {"BIW": ()},
    group="Move immediate",
    operands=(In("IN", BYTE), Out("OUT", BYTE, areas=frozenset({Area.Q}))),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Move byte immediate",
    doc="""Write IN to a byte of physical outputs and to the process image.""",
)
