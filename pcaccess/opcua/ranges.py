"""NumericRange: a part of an array or string (OPC UA Part 4, 7.27).

Only one dimension exists here: ``2`` or ``1:3``, both ends included, counted from 0.
"""

from __future__ import annotations

import dataclasses
import re
from typing import Any, Final

from asyncua import ua
from asyncua.ua.status_codes import StatusCodes

from pcaccess.items.sample import ItemValue

_RANGE: Final = re.compile(r"(\d{1,10})(?::(\d{1,10}))?", re.ASCII)


class RangeError(ValueError):
    """The range cannot be used; ``status`` is what to answer."""

    def __init__(self, status: int) -> None:
        super().__init__(f"index range: status {status:#x}")
        self.status = status


def parse_range(text: str) -> tuple[int, int]:
    """First and last index; raises RangeError BadIndexRangeInvalid."""
    match = _RANGE.fullmatch(text)
    if match is None:
        raise RangeError(StatusCodes.BadIndexRangeInvalid)
    first = int(match[1])
    last = int(match[2]) if match[2] is not None else first
    if match[2] is not None and last <= first:
        raise RangeError(StatusCodes.BadIndexRangeInvalid)
    return first, last


def take_range(value: ua.DataValue, text: str) -> ua.DataValue:
    """The elements a Read asked for; a range may reach beyond the end, but must begin before it."""
    first, last = parse_range(text)
    if value.Value is None:
        return value
    content: Any = value.Value.Value
    if not isinstance(content, list | str | bytes) or first >= len(content):
        raise RangeError(StatusCodes.BadIndexRangeNoData)
    part = ua.Variant(content[first : last + 1], value.Value.VariantType, is_array=isinstance(content, list))
    return dataclasses.replace(value, Value=part)


def put_range(old: ItemValue, text: str, part: Any) -> ItemValue:
    """``old`` with the elements of a Write put in; the part must have just the length of the range."""
    first, last = parse_range(text)
    if isinstance(old, str) and isinstance(part, str):
        if last >= len(old) or len(part) != last - first + 1:
            raise RangeError(StatusCodes.BadIndexRangeNoData)
        return old[:first] + part + old[last + 1 :]
    if not isinstance(old, list) or not isinstance(part, list):
        raise RangeError(StatusCodes.BadIndexRangeInvalid)
    if last >= len(old) or len(part) != last - first + 1:
        raise RangeError(StatusCodes.BadIndexRangeNoData)
    return old[:first] + part + old[last + 1 :]
