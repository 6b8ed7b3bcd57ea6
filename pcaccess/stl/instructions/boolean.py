"""Bit logic: contacts, logic stack, edges, coils, set and reset."""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.types import DataType
from pcaccess.stl.define import In, Number, Out, Power, StackUse, declare
from pcaccess.stl.errors import INDIRECT_ADDRESS, OPERAND_RANGE

BOOL, BYTE = DataType.BOOL, DataType.BYTE
_INPUT: Final = frozenset({Area.I})
_OUTPUT: Final = frozenset({Area.Q})

load = declare(
    {"LD": (False,), "LDN": (True,)},
    group="Boolean",
    operands=(In("BIT", BOOL),),
    power=Power.CONTACT,
    stack=StackUse(0, 1),
    source="System Manual, Standard contacts",
    doc="""Push the bit (LDN: its opposite) to the logic stack.""",
)
combine = declare(
    {"A": ("and", False), "AN": ("and", True), "O": ("or", False), "ON": ("or", True)},
    group="Boolean",
    operands=(In("BIT", BOOL),),
    power=Power.CONTACT,
    source="System Manual, Standard contacts",
    doc="""Combine the top of the logic stack with the bit (AN, ON: with its opposite).""",
)
load_immediate = declare(
    {"LDI": (False,), "LDNI": (True,)},
    group="Boolean immediate",
    operands=(In("BIT", BOOL, areas=_INPUT),),
    power=Power.CONTACT,
    stack=StackUse(0, 1),
    source="System Manual, Immediate contacts",
    doc="""Push the physical input (LDNI: its opposite) to the logic stack; the process image stays as it is.""",
)
combine_immediate = declare(
    {"AI": ("and", False), "ANI": ("and", True), "OI": ("or", False), "ONI": ("or", True)},
    group="Boolean immediate",
    operands=(In("BIT", BOOL, areas=_INPUT),),
    power=Power.CONTACT,
    source="System Manual, Immediate contacts",
    doc="""Combine the top of the logic stack with the physical input (ANI, ONI: with its opposite).""",
)
invert = declare(
    {"NOT": ()},
    group="Boolean",
    power=Power.CONTACT,
    source="System Manual, NOT",
    doc="""Invert the top of the logic stack.""",
)
edge = declare(
    {"EU": (True,), "ED": (False,)},
    group="Boolean",
    power=Power.CONTACT,
    source="System Manual, Positive and negative transition",
    doc="""Let power through for one scan when the top of the logic stack rises (ED: falls).""",
)
both = declare(
    {"ALD": ("and",), "OLD": ("or",)},
    group="Boolean",
    power=Power.STACK,
    stack=StackUse(2, -1),
    source="System Manual, Logic stack",
    doc="""Combine the two top levels of the logic stack into one.""",
)
push = declare(
    {"LPS": ()},
    group="Boolean",
    power=Power.STACK,
    stack=StackUse(1, 1),
    source="System Manual, Logic stack",
    doc="""Push a copy of the top of the logic stack.""",
)
read = declare(
    {"LRD": ()},
    group="Boolean",
    power=Power.STACK,
    stack=StackUse(2, 0),
    source="System Manual, Logic stack",
    doc="""Copy the second level of the logic stack to the top; nothing is pushed or popped.""",
)
pop = declare(
    {"LPP": ()},
    group="Boolean",
    power=Power.STACK,
    stack=StackUse(2, -1),
    source="System Manual, Logic stack",
    doc="""Drop the top of the logic stack; the second level becomes the top.""",
)
load_stack = declare(
    {"LDS": ()},
    group="Boolean",
    operands=(Number("N", 0, 8),),
    power=Power.STACK,
    stack=StackUse(1, 1),
    source="System Manual, Logic stack",
    doc="""Push a copy of level N of the logic stack.""",
)
and_eno = declare(
    {"AENO": ()},
    group="Boolean",
    power=Power.CONTACT,
    source="System Manual, AENO",
    doc="""AND the top of the logic stack with ENO of the box before.""",
)
coil = declare(
    {"=": ()},
    group="Boolean",
    operands=(Out("BIT", BOOL),),
    power=Power.COIL,
    source="System Manual, Output",
    doc="""Copy the top of the logic stack to the bit.""",
)
coil_immediate = declare(
    {"=I": ()},
    group="Boolean immediate",
    operands=(Out("BIT", BOOL, areas=_OUTPUT),),
    power=Power.COIL,
    source="System Manual, Output immediate",
    doc="""Copy the top of the logic stack to the physical output and to the process image.""",
)
set_reset = declare(
    {"S": (True,), "R": (False,)},
    group="Boolean",
    operands=(Out("BIT", BOOL), In("N", BYTE, low=1, high=255)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source="System Manual, Set and reset",
    doc="""Set (R: reset) N bits from BIT on. R on a timer or counter clears its bit and its current value.""",
)
set_reset_immediate = declare(
    {"SI": (True,), "RI": (False,)},
    group="Boolean immediate",
    operands=(Out("BIT", BOOL, areas=_OUTPUT), In("N", BYTE, low=1, high=128)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source="System Manual, Set and reset immediate",
    doc="""Set (RI: reset) N physical outputs and their image bits from BIT on.""",
)
no_operation = declare(
    {"NOP": ()},
    group="Boolean",
    operands=(Number("N", 0, 255),),
    power=Power.MARK,
    stack=StackUse(0, 0),
    source="System Manual, No operation",
    doc="""Do nothing.""",
)
