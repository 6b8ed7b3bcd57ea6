"""A client's value to the bytes a PLC takes: access, type, engineering limits, scaling, range.

Errors:   :class:`WriteRefused` carries the outcome; nothing has been written then.
"""

from __future__ import annotations

import math

from pcaccess.items.image import Linear
from pcaccess.items.sample import ItemValue
from pcaccess.links.base import Outcome, RawWrite
from pcaccess.project.model import Access, Item, Scaling, WriteLimits
from pcaccess.s7200.address import Address
from pcaccess.s7200.types import MAX_STRING, DataType, Value, ValueRangeError, ValueTypeError


class WriteRefused(Exception):
    """The value cannot be written; ``outcome`` says why, the message says it in words."""

    def __init__(self, outcome: Outcome, message: str) -> None:
        super().__init__(message)
        self.outcome = outcome


def linear(scaling: Scaling | None) -> Linear | None:
    """The item table's form of a project's scaling."""
    if scaling is None:
        return None
    return Linear(scaling.raw_low, scaling.raw_high, scaling.scaled_low, scaling.scaled_high, scaling.clamp)


def raw_write(item: Item, value: ItemValue) -> RawWrite:
    """What to send to the PLC so that ``item`` reads ``value``; raises WriteRefused."""
    if not item.access & Access.W:
        raise WriteRefused(Outcome.NOT_WRITABLE, f"{item.item_id} is read-only")
    count = item.count
    values = value if isinstance(value, list) else [value]
    if isinstance(value, list) != (count != 1) or len(values) != count:
        raise WriteRefused(Outcome.TYPE_MISMATCH, f"{item.item_id} takes {_shape(count)}")
    try:
        data = b"".join(_encode(item, v) for v in values)
    except ValueTypeError as error:
        raise WriteRefused(Outcome.TYPE_MISMATCH, f"{item.item_id}: {error}") from None
    except ValueRangeError as error:
        raise WriteRefused(Outcome.OUT_OF_RANGE, f"{item.item_id}: {error}") from None
    return RawWrite(item.item_id, item.address, item.raw_type, data)


def is_verbatim(item: Item) -> bool:
    """Whether :func:`raw_write` of every value of the item's type is just that value's bytes.

    That is a writable single number or bit without scaling and without limits to keep: the many that are written
    in bulk need no look at each.
    """
    return (
        bool(item.access & Access.W)
        and isinstance(item.address, Address)
        and item.count == 1
        and item.raw_type is item.data_type
        and item.raw_type is not DataType.STRING
        and item.scaling is None
        and (item.write_limits is WriteLimits.NONE or item.low is None)
    )


def _shape(count: int) -> str:
    return "one value" if count == 1 else f"{count} values"


def _encode(item: Item, value: Value) -> bytes:
    if not isinstance(value, str):
        value = _within_limits(item, value)
        line = linear(item.scaling)
        if line is not None:
            value = _to_raw(item, line, float(value))
    if item.raw_type is not DataType.STRING:
        return item.raw_type.encode(value)
    raw = item.raw_type.encode(value, length=item.length or MAX_STRING)
    return raw.ljust(1 + item.length, b"\x00") if item.count > 1 else raw


def _within_limits(item: Item, value: float) -> float:
    if item.write_limits is WriteLimits.NONE or item.low is None or item.high is None:
        return value
    if item.low <= value <= item.high:
        return value
    if item.write_limits is WriteLimits.CLAMP and not math.isnan(value):
        if isinstance(value, float):
            return min(max(value, item.low), item.high)
        return min(max(value, math.ceil(item.low)), math.floor(item.high))  # 0.5 is no INT: the nearest within
    raise WriteRefused(Outcome.OUT_OF_RANGE, f"{item.item_id} takes {item.low:g} to {item.high:g}, not {value:g}")


def _to_raw(item: Item, line: Linear, value: float) -> float:
    if not math.isfinite(value):
        raise WriteRefused(Outcome.OUT_OF_RANGE, f"{item.item_id}: {value} has no raw value")
    raw = line.raw(value)
    return raw if item.raw_type is DataType.REAL else float(round(raw))
