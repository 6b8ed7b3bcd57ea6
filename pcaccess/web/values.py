"""Values that clients send, as JSON or as text, to the values of items.

Errors:   :class:`Refusal` (``type-mismatch``) for what no item of that type can take; whether it fits is for the
          gateway to say.
"""

from __future__ import annotations

import math
import re
from types import MappingProxyType
from typing import Any, Final

from pcaccess.items.sample import ItemValue
from pcaccess.project.model import Item
from pcaccess.s7200.types import DataType, Value
from pcaccess.web.refusals import Refusal

_TRUTH: Final = MappingProxyType({"true": True, "1": True, "on": True, "false": False, "0": False, "off": False})
_NOT_FINITE: Final = MappingProxyType({"NaN": math.nan, "Infinity": math.inf, "-Infinity": -math.inf})
"""How JSON says what it has no number for (OPC UA Part 6, JSON encoding)."""
_INTEGER: Final = re.compile(r"[+-]?\d{1,20}")


def from_json(item: Item, value: Any) -> ItemValue:
    """The value a JSON value means for an item."""
    if item.count == 1:
        return _one_from_json(item, value)
    if not isinstance(value, list):
        raise _mismatch(item, f"takes a list of {item.count} values")
    return [_one_from_json(item, one) for one in value]


def _one_from_json(item: Item, value: Any) -> Value:
    data_type = item.data_type
    if data_type is DataType.REAL and isinstance(value, str) and value in _NOT_FINITE:
        return _NOT_FINITE[value]
    if isinstance(value, bool):
        if data_type is DataType.BOOL:
            return value
    elif isinstance(value, str):
        if data_type is DataType.STRING:
            return value
    elif isinstance(value, int | float) and data_type is not DataType.STRING:
        if data_type is not DataType.BOOL:
            return value
        if value in (0, 1):
            return bool(value)
    raise _mismatch(item, f"takes {_wanted(data_type)}, not {_shown(value)}")


def from_text(item: Item, text: str) -> ItemValue:
    """The value a text means for an item; elements of an array are separated by blanks."""
    if item.count == 1:
        return _one_from_text(item, text)
    if item.data_type is DataType.STRING:
        raise _mismatch(item, "is an array of texts, which only JSON can say")
    return [_one_from_text(item, one) for one in text.split()]


def _one_from_text(item: Item, text: str) -> Value:
    data_type = item.data_type
    if data_type is DataType.STRING:
        return text
    word = text.strip()
    if data_type is DataType.BOOL and word.lower() in _TRUTH:
        return _TRUTH[word.lower()]
    if _INTEGER.fullmatch(word):
        return _one_from_json(item, int(word))
    try:
        number = float(word)
    except ValueError:
        hint = "; the decimal sign is a point" if re.fullmatch(r"[+-]?\d+,\d+", word) else ""
        raise _mismatch(item, f"takes {_wanted(data_type)}, not {_shown(text)}{hint}") from None
    if "_" in word or (math.isinf(number) and word[-1].isdigit()):
        raise _mismatch(item, f"takes {_wanted(data_type)}, not {_shown(text)}")
    return _one_from_json(item, number)


def _wanted(data_type: DataType) -> str:
    if data_type is DataType.BOOL:
        return "true or false"
    if data_type is DataType.STRING:
        return "a text"
    return "a number" if data_type is DataType.REAL else f"a whole number from {data_type.low} to {data_type.high}"


def _shown(value: Any) -> str:
    text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 40 else f"{text[:40]}…"


def _mismatch(item: Item, message: str) -> Refusal:
    return Refusal("type-mismatch", f"{item.item_id} {message}", id=item.item_id, opcua_status="BadTypeMismatch")
