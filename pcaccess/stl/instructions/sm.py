"""SM bits from a cold instruction."""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.memory import AREA_START
from pcaccess.stl.define import SmBit

_SM: Final = AREA_START[Area.SM]


def set_sm_bit(memory: bytearray | memoryview, bit: SmBit, on: bool) -> None:
    at, mask = _SM + bit.byte, 1 << bit.bit
    memory[at] = memory[at] | mask if on else memory[at] & ~mask
