"""Words for the checker's messages: what an operand is, what it may be, an example of it."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from pcaccess.s7200.address import Address, Area, Width
from pcaccess.s7200.types import DataType
from pcaccess.stl.define import OperandSpec, Special
from pcaccess.stl.program import Constant, ConstantForm

MAX_STRING_CONSTANT: Final = 126
"""Characters of a STRING constant in a program; a string in memory has up to 254 (System Manual, "Strings")."""
INTEGER_RANGES: Final[Mapping[DataType, tuple[int, int]]] = MappingProxyType(
    {
        DataType.BYTE: (0, 0xFF),
        DataType.WORD: (-0x8000, 0xFFFF),
        DataType.INT: (-0x8000, 0xFFFF),
        DataType.DWORD: (-0x8000_0000, 0xFFFF_FFFF),
        DataType.DINT: (-0x8000_0000, 0xFFFF_FFFF),
    }
)
"""Words and double words may be written signed or unsigned: 16#FFFF and -1 are the same INT."""
WIDTH_TEXT: Final = MappingProxyType(
    {Width.BIT: "a bit", Width.BYTE: "a byte", Width.WORD: "a word", Width.DWORD: "a double word"}
)

AREA_TEXT: Final = MappingProxyType(
    {
        Area.I: "the inputs (I)",
        Area.Q: "the outputs (Q)",
        Area.V: "V memory",
        Area.M: "M memory",
        Area.SM: "SM memory",
        Area.S: "S memory",
        Area.L: "L memory",
        Area.T: "the timers (T)",
        Area.C: "the counters (C)",
        Area.HC: "the high-speed counters (HC), which are read-only",
        Area.AC: "the accumulators (AC)",
        Area.AI: "the analog inputs (AI), which are read-only",
        Area.AQ: "the analog outputs (AQ), which are write-only",
    }
)
SPECIAL_TEXT: Final = MappingProxyType(
    {
        Special.LABEL: "the number of a label",
        Special.TIMER: "T0 to T255",
        Special.COUNTER: "C0 to C255",
        Special.SBR: "a subroutine, SBR0 or its name",
        Special.INT: "an interrupt routine, INT0 or its name",
        Special.NUMBER: "a number",
        Special.PARAMETERS: "the parameters of the subroutine",
    }
)
_LETTER: Final = MappingProxyType({1: "B", 2: "W", 4: "D"})


def describe(address: Address) -> str:
    if address.area is Area.T:
        return "a timer"
    if address.area is Area.C:
        return "a counter"
    if address.area is Area.AC:
        return "an accumulator"
    return WIDTH_TEXT[address.width]


def type_text(spec: OperandSpec) -> str:
    if isinstance(spec.type, Special):
        article = "an" if spec.type is Special.INT else "a"
        return f"{article} {spec.type.value}"
    return f"{'an' if spec.type is DataType.INT else 'a'} {spec.type.name}"


def form_text(constant: Constant) -> str:
    article = "an" if constant.form is ConstantForm.ASCII else "a"
    return f"{article} {constant.form.value} constant"


def same_place(address: Address, spec: OperandSpec) -> str | None:
    """The address of the right size at the same byte: VW10 for VB10."""
    if not isinstance(spec.type, DataType) or not address.area.is_byte_addressed or address.area not in spec.areas:
        return None
    if spec.type is DataType.BOOL:
        return f"{address.area.value}{address.offset}.0"
    return f"{address.area.value}{_LETTER.get(spec.type.size, 'B')}{address.offset}"


def example(spec: OperandSpec) -> str:
    """``VW0 or another word``."""
    if not isinstance(spec.type, DataType):
        return SPECIAL_TEXT[spec.type]
    home = Area.V if Area.V in spec.areas else min(spec.areas, key=lambda a: a.value, default=Area.V)
    if spec.type is DataType.BOOL:
        return f"a bit such as {home.value}0.0"
    if home.is_numbered or home.is_analog:
        return areas_text(spec)
    letter = _LETTER.get(spec.type.size, "B")
    word = {"B": "byte", "W": "word", "D": "double word"}[letter]
    return f"a {word} such as {home.value}{letter}0"


def areas_text(spec: OperandSpec) -> str:
    return "one of " + ", ".join(area.value for area in Area if area in spec.areas)


def limits(spec: OperandSpec, data_type: DataType) -> tuple[int, int]:
    low, high = INTEGER_RANGES[data_type]
    return (low if spec.low is None else spec.low, high if spec.high is None else spec.high)


def constant_text(spec: OperandSpec) -> str:
    if spec.type is DataType.STRING:
        return f"a text in double quotes of at most {MAX_STRING_CONSTANT} characters"
    if spec.type is DataType.REAL:
        return "a number with a decimal point between -3.402823E38 and 3.402823E38"
    if isinstance(spec.type, DataType) and spec.type in INTEGER_RANGES:
        low, high = limits(spec, spec.type)
        return f"{low} to {high}"
    return f"{spec.low or 0} to {spec.high or 0}"
