"""Counters."""

from __future__ import annotations

from pcaccess.s7200.types import DataType
from pcaccess.stl.define import Direction, In, Power, Special, StackUse, declare, special
from pcaccess.stl.errors import INDIRECT_ADDRESS

INT = DataType.INT
_OPERANDS = (special("CXXX", Special.COUNTER, Direction.INOUT), In("PV", INT))
_SOURCE = "System Manual, Counters; document 004, section 9.17"

count_up = declare(
    {"CTU": ()},
    group="Counter",
    operands=_OPERANDS,
    power=Power.COIL,
    stack=StackUse(2, 0),
    errors=(INDIRECT_ADDRESS,),
    source=_SOURCE,
    doc="""Count up on each rise of S1; S0 resets.""",
)
count_down = declare(
    {"CTD": ()},
    group="Counter",
    operands=_OPERANDS,
    power=Power.COIL,
    stack=StackUse(2, 0),
    errors=(INDIRECT_ADDRESS,),
    source=_SOURCE,
    doc="""Count down on each rise of S1; S0 loads PV.""",
)
count_up_down = declare(
    {"CTUD": ()},
    group="Counter",
    operands=_OPERANDS,
    power=Power.COIL,
    stack=StackUse(3, 0),
    errors=(INDIRECT_ADDRESS,),
    source=_SOURCE,
    doc="""Count up on each rise of S2 and down on each rise of S1; S0 resets.""",
)
