"""Values as people write and read them, for every type an item can have.

Written:  ``true`` or ``1``; ``-12``, ``16#FF``, ``2#1010``, ``8#17``; ``3.5``, ``1e-3``; a text as it stands; an array
          as ``1,2,3``. ``16#`` and its like are bit patterns, as in STL: ``16#FFFF`` is -1 for an INT.
Errors:   :class:`ValueTextError` says what the type takes.
"""

from __future__ import annotations

import csv
import json
import math
import re
import struct
from dataclasses import dataclass
from datetime import UTC, datetime
from types import MappingProxyType
from typing import Any, Final

from pcaccess.items.varianttypes import VARIANT_TYPES
from pcaccess.s7200.types import DataType


class ValueTextError(ValueError):
    """The text is no value of the type; the message says what would be."""


@dataclass(frozen=True, slots=True)
class ValueType:
    """A type as the command shows it: S7-200 names where there is one, else the OPC UA name."""

    name: str
    number: int
    """OPC UA built-in type (Part 6, table of built-in types)."""
    low: int = 0
    high: int = 0
    """Bounds of an integer type, both 0 for others."""


BOOLEAN: Final = VARIANT_TYPES[DataType.BOOL]
FLOAT: Final = VARIANT_TYPES[DataType.REAL]
DOUBLE: Final = 11
STRING: Final = VARIANT_TYPES[DataType.STRING]

TYPES: Final = MappingProxyType(
    {
        **{
            number: ValueType(t.name, number, *((t.low, t.high) if t.is_integer else (0, 0)))
            for t, number in VARIANT_TYPES.items()
        },
        8: ValueType("Int64", 8, -(1 << 63), (1 << 63) - 1),
        9: ValueType("UInt64", 9, 0, (1 << 64) - 1),
        DOUBLE: ValueType("Double", DOUBLE),
        13: ValueType("DateTime", 13),
        14: ValueType("Guid", 14),
        15: ValueType("ByteString", 15),
        17: ValueType("NodeId", 17),
        20: ValueType("QualifiedName", 20),
        21: ValueType("LocalizedText", 21),
        22: ValueType("Structure", 22),
    }
)
"""By OPC UA built-in type number. Those of an S7-200 come first; the rest is met on foreign servers."""

_TRUTH: Final = MappingProxyType({"true": True, "1": True, "on": True, "false": False, "0": False, "off": False})
_RADIX: Final = re.compile(r"(2|8|16)#([0-9A-F_]+)", re.IGNORECASE)
_DECIMAL: Final = re.compile(r"[+-]?\d+")


# ---------------------------------------------------------------------- text to value


def parse_value(text: str, kind: ValueType, *, is_array: bool = False) -> Any:
    """The value a text means for a type; a list for an array."""
    if not is_array:
        return _parse_one(text, kind)
    return [_parse_one(part, kind) for part in _split(text, kind)]


def _split(text: str, kind: ValueType) -> list[str]:
    if kind.number == STRING:  # "a, b","c" as in CSV
        return next(csv.reader([text], skipinitialspace=True), [])
    return text.split(",")


def _parse_one(text: str, kind: ValueType) -> Any:
    if kind.number == STRING:
        return text
    word = text.strip()
    if kind.number == BOOLEAN:
        value = _TRUTH.get(word.lower())
        if value is None:
            raise ValueTextError(f"{text!r} is not a {kind.name}: write true or false, 1 or 0")
        return value
    if kind.number in (FLOAT, DOUBLE):
        return _parse_real(word, kind)
    if kind.low < kind.high:
        return _parse_integer(word, kind)
    raise ValueTextError(f"a value of type {kind.name} cannot be written from the command line")


def _parse_integer(word: str, kind: ValueType) -> int:
    radix = _RADIX.fullmatch(word)
    if radix is not None:
        pattern = _digits(radix[2], int(radix[1]), word)
        bits = (kind.high - kind.low).bit_length()
        if pattern >> bits:
            raise ValueTextError(f"{word} has more than the {bits} bits of {kind.name}")
        return pattern - (1 << bits) if pattern > kind.high else pattern
    if not _DECIMAL.fullmatch(word):
        raise ValueTextError(
            f"{word!r} is not a whole number: {kind.name} takes {kind.low} to {kind.high}, or bits such as 16#FF"
        )
    value = int(word)
    if not kind.low <= value <= kind.high:
        raise ValueTextError(f"{word} does not fit {kind.name}, which takes {kind.low} to {kind.high}")
    return value


def _digits(text: str, base: int, word: str) -> int:
    try:
        return int(text, base)
    except ValueError:
        raise ValueTextError(f"{word!r} is not a number to the base {base}") from None


def _parse_real(word: str, kind: ValueType) -> float:
    if "_" in word:
        raise ValueTextError(f"{word!r} is not a number")
    try:
        value = float(word)
    except ValueError:
        hint = "; the decimal sign is a point" if re.fullmatch(r"[+-]?\d+,\d+", word) else ""
        raise ValueTextError(f"{word!r} is not a number{hint}") from None
    if kind.number == FLOAT and math.isfinite(value):
        try:
            struct.pack("<f", value)
        except OverflowError:
            raise ValueTextError(f"{word} does not fit {kind.name}, which ends at 3.4e38") from None
    return value


# ---------------------------------------------------------------------- value to text


def value_text(value: Any, number: int) -> str:
    """For people; :func:`parse_value` takes it back. ``number``: OPC UA built-in type. No value is no text."""
    if value is None:
        return ""
    if isinstance(value, list):
        return ",".join(value_text(element, number) for element in value)
    plain = json_value(value, number)
    if isinstance(plain, bool):
        return "true" if plain else "false"
    if number == STRING:
        return json.dumps(plain, ensure_ascii=False)
    return str(plain)


def json_value(value: Any, number: int) -> Any:
    """For programs. What JSON cannot hold is a text (``"NaN"``, ``"Infinity"``: OPC UA Part 6, JSON encoding)."""
    if isinstance(value, list):
        return [json_value(element, number) for element in value]
    if isinstance(value, float):
        if math.isnan(value):
            return "NaN"
        if math.isinf(value):
            return "Infinity" if value > 0 else "-Infinity"
        return shortest_real(value) if number == FLOAT else value
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, bytes):
        return value.hex()
    return time_json(value) if isinstance(value, datetime) else str(value)


def shortest_real(value: float) -> float:
    """The number with the fewest digits that is the same 32-bit REAL: 0.1, not 0.10000000149011612."""
    exact = struct.pack("<f", value)
    for digits in range(6, 9):
        candidate = float(f"{value:.{digits}g}")
        try:
            if struct.pack("<f", candidate) == exact:
                return candidate
        except OverflowError:  # rounded up beyond the largest REAL
            continue
    return float(f"{value:.9g}")


def time_json(moment: datetime | None) -> str | None:
    """``2026-11-22T17:00:00.123456Z``."""
    return None if moment is None else f"{moment.astimezone(UTC):%Y-%m-%dT%H:%M:%S.%fZ}"


def time_text(moment: datetime | None) -> str:
    """``2026-11-22 18:00:00.123`` in local time, for people."""
    if moment is None:
        return ""
    local = moment.astimezone()
    return f"{local:%Y-%m-%d %H:%M:%S}.{local.microsecond // 1000:03d}"
