"""Strings: length, copy, append, part, find, to a number, compare.

Source:   System Manual, String instructions, String conversion, Compare string. Choices:
          docs/decisions/2026-11-22-strings.md.
"""

from __future__ import annotations

import re
import struct
from typing import Final

from pcaccess.s7200.types import DataType
from pcaccess.stl.builder import Place
from pcaccess.stl.define import OVERFLOW, SAME, In, InOut, Out, Power, StackUse, define
from pcaccess.stl.errors import INDIRECT_ADDRESS, OPERAND_RANGE, RunTimeError
from pcaccess.stl.instructions import texts
from pcaccess.stl.instructions.sm import set_sm_bit
from pcaccess.stl.instructions.texts import BadString, Text, outcome
from pcaccess.stl.ir_values import Effects, IrType, Value
from pcaccess.stl.routine import Routine
from pcaccess.stl.runtime import ENO_OFF, OK, Outcome, Runtime

BYTE, INT, DINT, REAL, STRING = DataType.BYTE, DataType.INT, DataType.DINT, DataType.REAL, DataType.STRING
INDEX: Final = RunTimeError.STRING_INDEX
_SOURCE: Final = "System Manual, String instructions"
_RANGE: Final = Effects(errors=(OPERAND_RANGE,))
_RANGE_OR_INDEX: Final = Effects(errors=(OPERAND_RANGE, INDEX))

Operand = Place | bytes


@define(
    {"SLEN": ()},
    group="String",
    operands=(In("IN", STRING), Out("OUT", BYTE)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
)
def length(b: Routine, text: Operand, out: Place) -> None:
    """Store the length of the string."""
    constants, addresses = texts.arguments(b, text)
    b.cold(store_length, *addresses, b.address(out), static=constants, effects=_RANGE)


@outcome
def store_length(runtime: Runtime, constant: Text, address: int, out: int) -> Outcome:
    runtime.memory[out] = len(texts.read(runtime, constant, address))
    return OK


@define(
    {"SCPY": ()},
    group="String",
    operands=(In("IN", STRING), Out("OUT", STRING)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
)
def copy(b: Routine, text: Operand, out: Place) -> None:
    """Copy the string, its length and its characters."""
    constants, addresses = texts.arguments(b, text)
    b.cold(copy_text, *addresses, b.address(out), static=constants, effects=_RANGE)


@outcome
def copy_text(runtime: Runtime, constant: Text, address: int, out: int) -> Outcome:
    texts.write(runtime, out, texts.read(runtime, constant, address))
    return OK


@define(
    {"SCAT": ()},
    group="String",
    operands=(In("IN", STRING), InOut("OUT", STRING)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
)
def append(b: Routine, text: Operand, out: Place) -> None:
    """Append IN to the string OUT. More than 254 characters are error 0091, and OUT stays as it was."""
    constants, addresses = texts.arguments(b, text)
    b.cold(append_text, *addresses, b.address(out), static=constants, effects=_RANGE)


@outcome
def append_text(runtime: Runtime, constant: Text, address: int, out: int) -> Outcome:
    texts.write(runtime, out, texts.read(runtime, None, out) + texts.read(runtime, constant, address))
    return OK


@define(
    {"SSCPY": ()},
    group="String",
    operands=(In("IN", STRING), In("INDX", BYTE), In("N", BYTE), Out("OUT", STRING)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE, INDEX),
    source=_SOURCE,
)
def part(b: Routine, text: Operand, first: Value, count: Value, out: Place) -> None:
    """Copy N characters from character INDX on (the first is 1); fewer when the string ends before.

    INDX 0 is error 009B; INDX behind the end of the string is error 0091.
    """
    constants, addresses = texts.arguments(b, text)
    b.cold(copy_part, *addresses, first, count, b.address(out), static=constants, effects=_RANGE_OR_INDEX)


@outcome
def copy_part(runtime: Runtime, constant: Text, address: int, first: int, count: int, out: int) -> Outcome:
    characters = _from(texts.read(runtime, constant, address), first)
    texts.write(runtime, out, characters[:count])
    return OK


def _from(characters: bytes, first: int) -> bytes:
    """What stands from character ``first`` on."""
    if first == 0:
        raise BadString(INDEX)
    if first > len(characters):
        raise BadString(OPERAND_RANGE)
    return characters[first - 1 :]


@define(
    {"SFND": (False,), "CFND": (True,)},
    group="String",
    operands=(In("IN1", STRING, constant=False), In("IN2", STRING), InOut("OUT", BYTE)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE, INDEX),
    source=_SOURCE,
)
def find(b: Routine, any_of: bool, text: Operand, wanted: Operand, out: Place) -> None:
    """Find IN2 (CFND: any character of IN2) in IN1 from character OUT on; OUT becomes its place, or 0.

    OUT 0 before is error 009B. An empty IN2 is never found.
    """
    constants, addresses = texts.arguments(b, text, wanted)
    b.cold(find_text, *addresses, b.address(out), static=(any_of, *constants), effects=_RANGE_OR_INDEX)


@outcome
def find_text(
    runtime: Runtime, any_of: bool, text: Text, wanted: Text, text_at: int, wanted_at: int, out: int
) -> Outcome:
    characters, pattern = texts.read(runtime, text, text_at), texts.read(runtime, wanted, wanted_at)
    first = runtime.memory[out]
    if first == 0:
        raise BadString(INDEX)
    patterns = [bytes((c,)) for c in pattern] if any_of else [pattern] * bool(pattern)
    places = [place for p in patterns if (place := characters.find(p, first - 1)) >= 0]
    runtime.memory[out] = min(places) + 1 if places else 0
    return OK


_INTEGER: Final = re.compile(rb" *([+-]?\d+)")
_REAL: Final = re.compile(rb" *([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+))")


@define(
    {"STI": (INT,), "STD": (DINT,), "STR": (REAL,)},
    group="Conversion string",
    operands=(In("IN", STRING), In("INDX", BYTE), Out("OUT", SAME)),
    sm=(OVERFLOW,),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS, OPERAND_RANGE, INDEX),
    source="System Manual, String conversion",
)
def string_to_number(b: Routine, kind: DataType, text: Operand, first: Value, out: Place) -> None:
    """Convert the text from character INDX on to a number: blanks, a sign, digits (STR: with a point or comma).

    It ends at the first character that does not belong to a number; a text that begins with none is 0. A number
    that does not fit sets SM1.1 and leaves OUT as it was. INDX as for SSCPY.
    """
    constants, addresses = texts.arguments(b, text)
    effects = Effects(sm=(OVERFLOW,), errors=(OPERAND_RANGE, INDEX))
    b.cold(convert_text, *addresses, first, b.address(out), static=(kind, *constants), effects=effects)


@outcome
def convert_text(runtime: Runtime, kind: DataType, constant: Text, address: int, first: int, out: int) -> Outcome:
    characters = _from(texts.read(runtime, constant, address), first)
    raw = _number_bytes(kind, characters)
    set_sm_bit(runtime.memory, OVERFLOW, raw is None)
    if raw is None:
        return ENO_OFF
    runtime.memory[out : out + len(raw)] = raw
    return OK


def _number_bytes(kind: DataType, characters: bytes) -> bytes | None:
    match = (_REAL if kind is REAL else _INTEGER).match(characters)
    number = match[1].replace(b",", b".") if match else b"0"
    try:
        value = float(number) if kind is REAL else int(number)
        return struct.pack(kind.struct_format, value)
    except (OverflowError, struct.error):
        return None


# compare contacts

_OPERANDS: Final = (In("IN1", STRING), In("IN2", STRING, constant=False))
_ERRORS: Final = (INDIRECT_ADDRESS, OPERAND_RANGE)
_COMPARE: Final = "System Manual, Compare string"


@define(
    {"LDS=": (True,), "LDS<>": (False,)},
    group="Compare string",
    operands=_OPERANDS,
    power=Power.CONTACT,
    stack=StackUse(0, 1),
    errors=_ERRORS,
    source=_COMPARE,
)
def load_compare(b: Routine, equal: bool, in1: Operand, in2: Operand) -> None:
    """Push the result of comparing two strings: equal in length and every character, case included."""
    b.push(_relation(b, equal, in1, in2))


@define(
    {"AS=": ("and", True), "AS<>": ("and", False), "OS=": ("or", True), "OS<>": ("or", False)},
    group="Compare string",
    operands=_OPERANDS,
    power=Power.CONTACT,
    errors=_ERRORS,
    source=_COMPARE,
)
def combine_compare(b: Routine, op: str, equal: bool, in1: Operand, in2: Operand) -> None:
    """Combine the top of the logic stack with the result of comparing two strings."""
    top = b.top
    b.set_top(b.binary(op, top, _relation(b, equal, in1, in2)))


def _relation(b: Routine, equal: bool, in1: Operand, in2: Operand) -> Value:
    """A string that is too long for its area lets no power through and is error 0091."""
    constants, addresses = texts.arguments(b, in1, in2)
    answer = b.call(same_texts, *addresses, static=constants, effects=_RANGE, result=IrType.I32)
    assert answer is not None
    with b.when(b.gt(answer, 1)):
        b.fault(answer)
    return b.and_(b.eq(answer, int(equal)), b.valid)


@outcome
def same_texts(runtime: Runtime, text1: Text, text2: Text, at1: int, at2: int) -> Outcome:
    """1 when the strings are the same, 0 when not, a run-time error when one is too long."""
    return int(texts.read(runtime, text1, at1) == texts.read(runtime, text2, at2))
