"""How values, qualities and times look: as JSON for programs, as CSV for spreadsheets. Pieces, in bulk.

Units:    times are ticks (``pcaccess.items.ticks``); both formats show milliseconds.
Source:   RFC 8259 and OPC UA Part 6 (JSON encoding: "NaN", "Infinity"); RFC 4180. CSV times are local time and BOOL is
          1 or 0, because that is what Excel and Calc take as a time and as a number in every language.
Not here: which rows, and in what order (``rendering``).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Final

import numpy as np
import orjson
from numpy.typing import NDArray

from pcaccess.items.quality import split_code
from pcaccess.items.sample import ItemValue
from pcaccess.items.ticks import TICKS_PER_SECOND, from_ticks
from pcaccess.s7200.types import DataType

Ticks = NDArray[np.int64]
_NUMBERS: Final = orjson.OPT_SERIALIZE_NUMPY
_TICKS_PER_MS: Final = TICKS_PER_SECOND // 1000
_UNIX_EPOCH_MS: Final = 11_644_473_600_000
_FEW: Final = 16
"""So many times are written faster one by one."""
_DANGEROUS: Final = ("=", "+", "-", "@", "\t", "\r")
"""What makes a spreadsheet take a text for a formula when it opens a CSV file."""


@dataclass(frozen=True, slots=True)
class Format:
    """One way to write samples. An entry is head, value, tail and time, one after the other."""

    media_type: str
    opening: bytes
    separator: bytes
    """Between entries."""
    closing: bytes
    true: bytes
    false: bytes
    not_finite: tuple[bytes, bytes, bytes]
    """NaN, infinity, minus infinity."""
    text: Callable[[DataType, ItemValue], bytes]
    """A string or an array."""
    head: Callable[[str], bytes]
    """Of an item ID."""
    tail: Callable[[DataType, int], bytes]
    """Of a type and a quality code with limit bits."""
    times: Callable[[Ticks], list[bytes]]


def numbers(form: Format, data_type: DataType, values: NDArray[Any]) -> list[bytes]:
    """Single values of one type."""
    if data_type is DataType.BOOL:
        return [form.true if value else form.false for value in values.tolist()]
    texts = orjson.dumps(values, option=_NUMBERS)[1:-1].split(b",")
    if data_type is DataType.REAL:
        nan, infinity, minus_infinity = form.not_finite
        for n in np.flatnonzero(~np.isfinite(values)).tolist():
            value = float(values[n])
            texts[n] = nan if math.isnan(value) else infinity if value > 0 else minus_infinity
    return texts


def json_numbers(data_type: DataType, values: NDArray[Any]) -> bytes:
    """Single values of one type, with commas between them; faster than taking them apart and joining them again."""
    if data_type is DataType.BOOL:
        values = values.astype(np.bool_)
    text = orjson.dumps(values, option=_NUMBERS)[1:-1]
    if data_type is DataType.REAL and b"null" in text:  # not a number
        return b",".join(numbers(JSON, data_type, values))
    return text


def value_text(form: Format, data_type: DataType, value: ItemValue) -> bytes:
    """Any one value."""
    if isinstance(value, str | list):
        return form.text(data_type, value)
    return numbers(form, data_type, _array(data_type, [value]))[0]


def _array(data_type: DataType, values: list[Any]) -> NDArray[Any]:
    """Numbers so that a REAL is written with its own few digits: 0.1, not 0.10000000149011612."""
    return np.array(values, np.float32 if data_type is DataType.REAL else np.int64)


def milliseconds(ticks: Ticks) -> NDArray[np.datetime64]:
    """NumPy's times of ticks, rounded down."""
    times: NDArray[np.datetime64] = (ticks // _TICKS_PER_MS - _UNIX_EPOCH_MS).astype("datetime64[ms]")
    return times


def all_equal(column: NDArray[Any], first: NDArray[Any] | None = None) -> bool:
    """Whether every entry of a column of integers that is not empty is the same, or is ``first``."""
    # Bytes, not a comparison of arrays: after half a second of sleep the first use of each NumPy function costs more
    # than a thousand entries do.
    return column.tobytes() == (column[:1] if first is None else first).tobytes() * len(column)


def _each(ticks: Ticks, write: Callable[[Ticks], list[bytes]]) -> list[bytes]:
    """Times as texts; many samples have few different times."""
    if not len(ticks):
        return []
    if all_equal(ticks):
        return write(ticks[:1]) * len(ticks)
    different, which = np.unique(ticks, return_inverse=True)
    texts = write(different)
    return [texts[n] for n in which.tolist()]


# ---------------------------------------------------------------------- JSON


def iso_times(ticks: Ticks) -> list[bytes]:
    """``2026-11-22T17:00:00.123Z``, each."""
    return _each(ticks, lambda some: [text.encode() for text in _iso(some)])


def _iso(ticks: Ticks) -> list[str]:
    if len(ticks) <= _FEW:
        return [iso_time(tick) for tick in ticks.tolist()]
    texts: list[str] = np.datetime_as_string(milliseconds(ticks), unit="ms", timezone="UTC").tolist()
    return texts


def iso_time(ticks: int) -> str:
    """``2026-11-22T17:00:00.123Z``, of one."""
    seconds, ms = divmod(ticks // _TICKS_PER_MS - _UNIX_EPOCH_MS, 1000)
    # A tenth of what strftime costs: this is done for every message.
    t = time.gmtime(seconds)
    date = f"{t.tm_year:04d}-{t.tm_mon:02d}-{t.tm_mday:02d}"
    return f"{date}T{t.tm_hour:02d}:{t.tm_min:02d}:{t.tm_sec:02d}.{ms:03d}Z"


def _json_times(ticks: Ticks) -> list[bytes]:
    return _each(ticks, lambda some: [text.encode() + b'"}' for text in _iso(some)])


def _json_text(data_type: DataType, value: ItemValue) -> bytes:
    if isinstance(value, list) and data_type is not DataType.STRING:
        return b"[" + b",".join(numbers(JSON, data_type, _array(data_type, value))) + b"]" if value else b"[]"
    return orjson.dumps(value)


def _json_tail(data_type: DataType, code: int) -> bytes:
    quality, limit = split_code(code)
    words: dict[str, Any] = {"type": data_type.name, "quality": quality.code, "quality_name": quality.name}
    if limit:
        words["limit"] = limit.name.lower()
    words["status"] = quality.status_name
    return b"," + orjson.dumps(words)[1:-1] + b',"source_timestamp":"'


JSON: Final = Format(
    media_type="application/json",
    opening=b'{"samples":[',
    separator=b",",
    closing=b"]}",
    true=b"true",
    false=b"false",
    not_finite=(b'"NaN"', b'"Infinity"', b'"-Infinity"'),
    text=_json_text,
    head=lambda item_id: b'{"id":' + orjson.dumps(item_id) + b',"value":',
    tail=_json_tail,
    times=_json_times,
)


# ---------------------------------------------------------------------- CSV


def _local_times(ticks: Ticks) -> list[bytes]:
    def write(some: Ticks) -> list[bytes]:
        return [_local(from_ticks(tick)) for tick in some.tolist()]

    return _each(ticks // _TICKS_PER_MS * _TICKS_PER_MS, write)


def _local(moment: datetime) -> bytes:
    here = moment.astimezone()
    return f"{here:%Y-%m-%d %H:%M:%S}.{here.microsecond // 1000:03d}\r\n".encode()


def csv_cell(text: str) -> bytes:
    """A text as a cell that no spreadsheet takes for a formula."""
    if text.startswith(_DANGEROUS):
        text = f"'{text}"
    if any(sign in text for sign in ',"\r\n'):
        text = '"' + text.replace('"', '""') + '"'
    return text.encode()


def _csv_text(data_type: DataType, value: ItemValue) -> bytes:
    if isinstance(value, list) and data_type is not DataType.STRING:
        return b" ".join(numbers(CSV, data_type, _array(data_type, value))) if value else b""
    return csv_cell(" ".join(map(str, value)) if isinstance(value, list) else str(value))


def _csv_tail(data_type: DataType, code: int) -> bytes:
    quality, _ = split_code(code)
    return f",{quality.code},{quality.name},".encode()


CSV: Final = Format(
    media_type="text/csv; charset=utf-8",
    opening=b"Item ID,Value,Quality,Quality Name,Time Stamp\r\n",
    separator=b"",
    closing=b"",
    true=b"1",
    false=b"0",
    not_finite=(b"NaN", b"Infinity", b"-Infinity"),
    text=_csv_text,
    head=lambda item_id: csv_cell(item_id) + b",",
    tail=_csv_tail,
    times=_local_times,
)
