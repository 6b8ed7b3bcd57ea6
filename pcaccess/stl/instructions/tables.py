"""Tables of words."""

from __future__ import annotations

from pcaccess.s7200.types import DataType
from pcaccess.stl.define import TABLE_EMPTY, TABLE_FULL, In, InOut, Out, declare
from pcaccess.stl.errors import INDIRECT_ADDRESS, OPERAND_RANGE

INT, WORD = DataType.INT, DataType.WORD
_SOURCE = "System Manual, Table instructions"

add_to_table = declare(
    {"ATT": ()},
    group="Table",
    operands=(In("DATA", INT), InOut("TBL", WORD, block=True)),
    sm=(TABLE_FULL,),
    eno_off=(TABLE_FULL, INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
    doc="""Add DATA at the end of the table.""",
)
take = declare(
    {"LIFO": (True,), "FIFO": (False,)},
    group="Table",
    operands=(InOut("TBL", WORD, block=True), Out("DATA", INT)),
    sm=(TABLE_EMPTY,),
    eno_off=(TABLE_EMPTY, INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
    doc="""Take the newest (FIFO: oldest) entry out of the table.""",
)
find = declare(
    {"FND=": ("eq",), "FND<>": ("ne",), "FND<": ("lt",), "FND>": ("gt",)},
    group="Table",
    operands=(In("TBL", WORD, constant=False, block=True), In("PTN", INT), InOut("INDX", WORD)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
    doc="""Find the next entry that fits, from INDX on; INDX is the entry count when there is none.""",
)
