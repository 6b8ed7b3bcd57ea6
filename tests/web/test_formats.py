"""How values, qualities and times look in JSON and in CSV."""

from __future__ import annotations

import csv
import io
import json
import math
import re
from datetime import UTC, datetime

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.items.quality import Limit, Quality
from pcaccess.items.ticks import to_ticks
from pcaccess.s7200.types import DataType
from pcaccess.web.formats import CSV, JSON, csv_cell, iso_times, json_numbers, numbers, value_text

FIRST, LAST = datetime.fromisoformat("1970-01-01"), datetime.fromisoformat("2100-01-01")


def digits(number: str) -> str:
    """Those that matter, without point and power of ten."""
    return re.sub(r"e.*|[-.]", "", number).strip("0")


@given(st.lists(st.floats(width=32, allow_nan=False, allow_infinity=False), min_size=1))
def test_a_real_has_the_fewest_digits_that_are_the_same_real(values: list[float]) -> None:
    reals = np.array(values, np.float32)
    texts = numbers(JSON, DataType.REAL, reals)
    assert np.array_equal(np.array([json.loads(text) for text in texts], np.float32), reals)
    assert [digits(text.decode()) for text in texts] == [digits(str(value)) for value in reals]
    assert json_numbers(DataType.REAL, reals) == b",".join(texts)


def test_what_json_has_no_number_for_is_a_text() -> None:
    reals = np.array([1.5, math.nan, math.inf, -math.inf, 0.1], np.float32)
    expected = [b"1.5", b'"NaN"', b'"Infinity"', b'"-Infinity"', b"0.1"]
    assert numbers(JSON, DataType.REAL, reals) == expected
    assert json_numbers(DataType.REAL, reals) == b",".join(expected)
    assert numbers(CSV, DataType.REAL, reals) == [b"1.5", b"NaN", b"Infinity", b"-Infinity", b"0.1"]


def test_a_bool_is_a_word_in_json_and_a_number_in_csv() -> None:
    bits = np.array([1, 0], np.uint8)
    assert numbers(JSON, DataType.BOOL, bits) == [b"true", b"false"]
    assert json_numbers(DataType.BOOL, bits) == b"true,false"
    assert numbers(CSV, DataType.BOOL, bits) == [b"1", b"0"]


@pytest.mark.parametrize(
    ("value", "in_json", "in_csv"),
    [
        ([1.5, 0.1, math.nan], b'[1.5,0.1,"NaN"]', b"1.5 0.1 NaN"),
        ([], b"[]", b""),
        ("a, b", b'"a, b"', b'"a, b"'),
        (0.1, b"0.1", b"0.1"),
    ],
)
def test_strings_and_arrays(value, in_json: bytes, in_csv: bytes) -> None:
    data_type = DataType.STRING if isinstance(value, str) else DataType.REAL
    assert value_text(JSON, data_type, value) == in_json
    assert value_text(CSV, data_type, value) == in_csv


@given(st.text())
def test_a_csv_reader_gets_back_every_text(text: str) -> None:
    (row,) = csv.reader(io.StringIO((csv_cell(text) + b",1").decode("utf-8", "surrogatepass"), newline=""))
    assert row[0].removeprefix("'") == text.removeprefix("'")


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@SUM(A1)", "\tx", "=cmd|' /C calc'!A0"])
def test_no_spreadsheet_takes_a_text_for_a_formula(text: str) -> None:
    (row,) = csv.reader(io.StringIO(csv_cell(text).decode(), newline=""))
    assert row == [f"'{text}"]


def test_a_limit_is_told_beside_the_quality() -> None:
    tail = b"{" + JSON.tail(DataType.INT, Quality.DEVICE_FAILURE.code | Limit.LOW)[1:] + b'x"}'
    assert json.loads(tail) == {
        "type": "INT",
        "quality": 12,
        "quality_name": "DEVICE_FAILURE",
        "limit": "low",
        "status": "BadDeviceFailure",
        "source_timestamp": "x",
    }
    assert CSV.tail(DataType.INT, 13) == b",12,DEVICE_FAILURE,"


@given(st.lists(st.datetimes(FIRST, LAST), max_size=40))
def test_times_are_utc_to_the_millisecond_rounded_down(times: list[datetime]) -> None:
    ticks = np.array([to_ticks(time.replace(tzinfo=UTC)) for time in times], np.int64)
    expected = [f"{time:%Y-%m-%dT%H:%M:%S}.{time.microsecond // 1000:03d}Z".encode() for time in times]
    assert iso_times(ticks) == expected


def test_csv_times_are_local_times() -> None:
    time = datetime(2026, 7, 1, 12, 0, 0, 123_999, UTC)
    (text,) = CSV.times(np.array([to_ticks(time)], np.int64))
    assert datetime.fromisoformat(text.decode().strip()).astimezone() == time.replace(microsecond=123_000)
