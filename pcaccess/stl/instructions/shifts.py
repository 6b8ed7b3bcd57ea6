"""Shift, rotate and the shift register bit."""

from __future__ import annotations

from pcaccess.s7200.types import DataType
from pcaccess.stl.define import OVERFLOW, SAME, ZERO, In, InOut, declare
from pcaccess.stl.errors import COUNT_RANGE, INDIRECT_ADDRESS, OPERAND_RANGE

BOOL, BYTE, WORD, DWORD = DataType.BOOL, DataType.BYTE, DataType.WORD, DataType.DWORD
_TYPES = (("B", BYTE), ("W", WORD), ("D", DWORD))

shift = declare(
    {f"{name}{letter}": (kind, name == "SL") for name in ("SL", "SR") for letter, kind in _TYPES},
    group="Shift",
    operands=(InOut("OUT", SAME), In("N", BYTE)),
    sm=(ZERO, OVERFLOW),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Shift",
    doc="""Shift OUT by N bits to the left (SR: right), filling with zeros.""",
)
rotate = declare(
    {f"{name}{letter}": (kind, name == "RL") for name in ("RL", "RR") for letter, kind in _TYPES},
    group="Shift",
    operands=(InOut("OUT", SAME), In("N", BYTE)),
    sm=(ZERO, OVERFLOW),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Rotate",
    doc="""Rotate OUT by N bits to the left (RR: right).""",
)
shift_register = declare(
    {"SHRB": ()},
    group="Shift",
    operands=(In("DATA", BOOL), InOut("S_BIT", BOOL), In("N", BYTE, low=-64, high=64)),
    sm=(OVERFLOW,),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE, COUNT_RANGE),
    source="System Manual, Shift register bit; document 004, section 9.21",
    doc="""Shift DATA into the register of |N| bits from S_BIT on; the bit that leaves goes to SM1.1.""",
)
