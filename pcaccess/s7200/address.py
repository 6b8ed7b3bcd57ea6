"""S7-200 addresses: one grammar for project files, run-time names and STL.

Accepted: ``I0.0 IB0 IW0 ID0`` and the same for Q V M SM S L; ``VX0.0``; ``T37 C5`` (bit and value share the
name), ``HC0``, ``AC0``, ``AIW4``, ``AQW2``; ``DB1.DBX0.0 DB1.DBB0 DB1.DBW0 DB1.DBD0`` for V; the German areas
``E A Z HZ AEW AAW``; any case; an array as ``VW0[10]``.
Errors:   :class:`AddressError`, whose message says what was expected.
Source:   System Manual, "Accessing data in the S7-200 memory areas"; Micro/WIN editor grammar for the aliases.
Not here: which addresses a CPU model has (``pcaccess.s7200.cpu``).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache
from typing import Final

from pcaccess.s7200.types import DataType


class AddressError(ValueError):
    """The text is not an S7-200 address, or the address does not exist."""


class Area(Enum):
    """Memory areas; the value is the English name as Micro/WIN writes it."""

    I = "I"  # noqa: E741 - the field's own name
    Q = "Q"
    V = "V"
    M = "M"
    SM = "SM"
    S = "S"
    L = "L"
    T = "T"
    C = "C"
    HC = "HC"
    AC = "AC"
    AI = "AI"
    AQ = "AQ"

    @property
    def is_byte_addressed(self) -> bool:
        """Bits, bytes, words and double words can be named: I Q V M SM S L."""
        return self in _BYTE_AREAS

    @property
    def is_analog(self) -> bool:
        """Words at even byte addresses: AI AQ."""
        return self in (Area.AI, Area.AQ)

    @property
    def is_numbered(self) -> bool:
        """Elements counted one by one: T C HC AC."""
        return self in _NUMBERED


_BYTE_AREAS: Final = frozenset({Area.I, Area.Q, Area.V, Area.M, Area.SM, Area.S, Area.L})
_NUMBERED: Final = frozenset({Area.T, Area.C, Area.HC, Area.AC})


class Width(Enum):
    """How much one address names. The value is the size in bits."""

    BIT = 1
    BYTE = 8
    WORD = 16
    DWORD = 32

    @property
    def letter(self) -> str:
        return {1: "", 8: "B", 16: "W", 32: "D"}[self.value]

    @property
    def size(self) -> int:
        """Bytes touched; a bit touches one."""
        return max(1, self.value // 8)


@dataclass(frozen=True, slots=True)
class Address:
    """One place in PLC memory, or ``count`` places in a row.

    ``offset`` is the byte offset in byte-addressed and analog areas and the element number in T, C, HC and AC.
    T and C have width WORD (their value); as a BOOL they name their bit, see :meth:`as_type`.
    """

    area: Area
    offset: int
    width: Width
    bit: int = 0
    count: int = 1

    def __str__(self) -> str:
        """The usual English spelling; parsing it gives the same address."""
        if self.area.is_numbered:
            text = f"{self.area.value}{self.offset}"
        elif self.width is Width.BIT:
            text = f"{self.area.value}{self.offset}.{self.bit}"
        else:
            text = f"{self.area.value}{self.width.letter}{self.offset}"
        return f"{text}[{self.count}]" if self.count != 1 else text

    @property
    def types(self) -> tuple[DataType, ...]:
        """Data types an item at this address can have, the usual one first."""
        if self.area in (Area.T, Area.C):
            return (DataType.INT, DataType.WORD, DataType.BOOL)
        if self.area is Area.AC:
            return (DataType.DINT, DataType.DWORD, DataType.REAL, *_TYPES[Width.WORD], *_TYPES[Width.BYTE][:2])
        if self.area is Area.HC:
            return (DataType.DINT, DataType.DWORD)
        if self.width is Width.BYTE and self.area not in (Area.V, Area.L):
            return _TYPES[Width.BYTE][:2]  # strings live in V and L only
        return _TYPES[self.width]

    def as_type(self, data_type: DataType) -> Address:
        """The same place as ``data_type`` sees it: a T or C as BOOL is its bit, an AC takes the type's width.

        Raises AddressError when the type does not fit, naming the address that would.
        """
        if data_type not in self.types:
            wanted = ", ".join(t.name for t in self.types)
            raise AddressError(f"{self} is {_describe(self)} and cannot be {data_type.name}; it can be {wanted}")
        if self.area in (Area.T, Area.C) and data_type is DataType.BOOL:
            return Address(self.area, self.offset, Width.BIT, 0, self.count)
        if self.area is Area.AC:
            return Address(self.area, self.offset, Width(data_type.size * 8), 0, self.count)
        return self


_TYPES: Final = {
    Width.BIT: (DataType.BOOL,),
    Width.BYTE: (DataType.BYTE, DataType.CHAR, DataType.STRING),
    Width.WORD: (DataType.INT, DataType.WORD),
    Width.DWORD: (DataType.DINT, DataType.DWORD, DataType.REAL),
}


def _describe(address: Address) -> str:
    if address.area is Area.T:
        return "a timer"
    if address.area is Area.C:
        return "a counter"
    return {Width.BIT: "a bit", Width.BYTE: "a byte", Width.WORD: "a word", Width.DWORD: "a double word"}[address.width]


# German names as Micro/WIN accepts them. "A" is Ausgang; "AC" is the accumulator in both languages.
_AREA_NAMES: Final = {
    **{area.value: area for area in Area},
    "E": Area.I,
    "A": Area.Q,
    "AE": Area.AI,
    "AA": Area.AQ,
    "Z": Area.C,
    "HZ": Area.HC,
}
_WIDTH_LETTERS: Final = {"B": Width.BYTE, "W": Width.WORD, "D": Width.DWORD}
_ADDRESS: Final = re.compile(
    r"""(?P<db>DB1\.DB(?P<dbw>[XBWD])(?P<dboff>\d{1,6})(?:\.(?P<dbbit>\d{1,3}))?
        |(?P<area>AIW|AQW|AEW|AAW|HC|HZ|AC|SM|[IQVMSLTCEAZ])(?P<w>[XBWD]?)(?P<off>\d{1,6})(?:\.(?P<bit>\d{1,3}))?)
        (?:\[(?P<count>\d{1,6})\])?""",
    re.VERBOSE | re.ASCII,
)
_EXPECTED: Final = "expected an S7-200 address such as I0.0, VB100, VW2, MD4, T37, C5 or AIW0"


@lru_cache(maxsize=1 << 14)
def parse_address(text: str) -> Address:
    """Read one address in any accepted spelling.

    Remembered, because the same few thousand addresses come again in every PLC of a large project, and items that
    share one need not hold a copy each.
    """
    match = _ADDRESS.fullmatch(text.strip().upper())
    if match is None:
        raise AddressError(_explain(text.strip()))
    count = int(match["count"]) if match["count"] is not None else 1
    if count < 1:
        raise AddressError(f"{text}: an array has at least one element")
    if match["db"] and match["dboff"]:
        return _byte_addressed(text, Area.V, match["dbw"], match["dboff"], match["dbbit"], count)
    name = match["area"]
    if len(name) == 3:  # AIW AQW AEW AAW: the width belongs to the name
        if match["w"] or match["bit"]:
            raise AddressError(f"{text}: analog values are words; {_EXPECTED}")
        offset = int(match["off"])
        if offset % 2:
            raise AddressError(
                f"{text}: analog words have even addresses, for example {name}{offset - 1} or {name}{offset + 1}"
            )
        return Address(_AREA_NAMES[name[:2]], offset, Width.WORD, 0, count)
    area = _AREA_NAMES[name]
    if area.is_numbered:
        if match["w"] or match["bit"]:
            raise AddressError(f"{text}: {area.value} takes only a number, for example {area.value}{match['off']}")
        width = Width.WORD if area in (Area.T, Area.C) else Width.DWORD
        return Address(area, int(match["off"]), width, 0, count)
    return _byte_addressed(text, area, match["w"], match["off"], match["bit"], count)


def _byte_addressed(text: str, area: Area, letter: str, offset: str, bit: str | None, count: int) -> Address:
    if letter in _WIDTH_LETTERS:
        if bit is not None:
            raise AddressError(f"{text}: only a bit has a '.'; for that bit write {area.value}{offset}.{bit}")
        return Address(area, int(offset), _WIDTH_LETTERS[letter], 0, count)
    if bit is None:
        raise AddressError(
            f"{text}: bit or width missing; write {area.value}{offset}.0, {area.value}B{offset}, "
            f"{area.value}W{offset} or {area.value}D{offset}"
        )
    if int(bit) > 7:
        raise AddressError(f"{text}: a byte has bits 0 to 7")
    return Address(area, int(offset), Width.BIT, int(bit), count)


def _explain(text: str) -> str:
    if not text:
        return f"the address is empty; {_EXPECTED}"
    if re.fullmatch(r"DB(?!1\.)\d+\..*", text, re.IGNORECASE):
        return f"{text}: an S7-200 has only data block 1 (DB1 is V memory)"
    if re.fullmatch(r"(AI|AQ|AE|AA)\d+", text, re.IGNORECASE):
        return f"{text}: analog values are words; write {text[:2].upper()}W{text[2:]}"
    return f"{text!r} is not an address; {_EXPECTED}"
