"""Data types: their bytes, their ranges and what they refuse."""

from __future__ import annotations

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.s7200.types import MAX_STRING, DataType, Value, ValueRangeError, ValueTypeError

INTEGERS = [t for t in DataType if t.is_integer]


@pytest.mark.parametrize(
    ("data_type", "value", "wire"),
    [
        (DataType.BOOL, True, "01"),
        (DataType.BOOL, False, "00"),
        (DataType.BYTE, 255, "ff"),
        (DataType.CHAR, -1, "ff"),
        (DataType.WORD, 0x1234, "1234"),
        (DataType.INT, -2, "fffe"),
        (DataType.DWORD, 0x1234_5678, "12345678"),
        (DataType.DINT, -2, "fffffffe"),
        (DataType.REAL, 1.0, "3f800000"),
        (DataType.REAL, -0.5, "bf000000"),
        (DataType.STRING, "Öl", "02d66c"),
        (DataType.STRING, "", "00"),
    ],
)
def test_the_high_byte_comes_first(data_type: DataType, value: Value, wire: str) -> None:
    assert data_type.encode(value).hex() == wire
    assert data_type.decode(bytes.fromhex(wire)) == value


@given(st.sampled_from(INTEGERS), st.data())
def test_an_integer_comes_back_from_its_bytes(data_type: DataType, data: st.DataObject) -> None:
    value = data.draw(st.integers(data_type.low, data_type.high))
    raw = data_type.encode(value)
    assert len(raw) == data_type.size
    assert data_type.decode(b"\xaa" + raw + b"\xaa", 1) == value


@given(st.sampled_from(INTEGERS), st.binary(min_size=4, max_size=4))
def test_every_pattern_of_bits_is_an_integer(data_type: DataType, raw: bytes) -> None:
    assert data_type.encode(data_type.decode(raw)) == raw[: data_type.size]


@given(st.floats(width=32))
def test_a_real_comes_back_from_its_bytes(value: float) -> None:
    back = DataType.REAL.decode(DataType.REAL.encode(value))
    assert back == value or (math.isnan(value) and isinstance(back, float) and math.isnan(back))


@given(st.text(st.characters(max_codepoint=255), max_size=MAX_STRING))
def test_a_string_comes_back_from_its_bytes(value: str) -> None:
    raw = DataType.STRING.encode(value)
    assert raw[0] == len(value) == len(raw) - 1
    assert DataType.STRING.decode(raw + b"rest") == value


@given(st.binary(min_size=1, max_size=300))
def test_a_string_whose_length_byte_lies_ends_where_the_bytes_end(raw: bytes) -> None:
    value = DataType.STRING.decode(raw)
    assert isinstance(value, str)
    assert len(value) == min(raw[0], MAX_STRING, len(raw) - 1)


@pytest.mark.parametrize("data_type", INTEGERS)
def test_one_more_than_the_largest_and_one_less_than_the_smallest_are_refused(data_type: DataType) -> None:
    for value in (data_type.low - 1, data_type.high + 1):
        with pytest.raises(ValueRangeError, match=f"{value} does not fit {data_type.name}"):
            data_type.encode(value)


@pytest.mark.parametrize(
    ("data_type", "value"),
    [
        (DataType.INT, "5"),
        (DataType.REAL, "5"),
        (DataType.BOOL, "true"),
        (DataType.STRING, 5),
        (DataType.STRING, True),
        (DataType.INT, 1.5),
        (DataType.INT, math.nan),
        (DataType.DINT, math.inf),
        (DataType.BOOL, 0.5),
    ],
)
def test_a_value_of_another_kind_is_refused(data_type: DataType, value: Value) -> None:
    with pytest.raises(ValueTypeError):
        data_type.encode(value)


@pytest.mark.parametrize(
    ("data_type", "value"),
    [
        (DataType.BOOL, 2),
        (DataType.REAL, 1e39),
        pytest.param(DataType.REAL, 10**400, id="REAL-beyond every float"),
        (DataType.STRING, "€"),
    ],
)
def test_a_value_that_does_not_fit_is_refused(data_type: DataType, value: Value) -> None:
    with pytest.raises(ValueRangeError):
        data_type.encode(value)


def test_a_string_has_the_room_it_is_given() -> None:
    assert DataType.STRING.encode("abc", length=3) == b"\x03abc"
    with pytest.raises(ValueRangeError, match="4 characters do not fit into a STRING of 3"):
        DataType.STRING.encode("abcd", length=3)


def test_a_whole_float_and_a_truth_value_are_numbers() -> None:
    assert DataType.INT.encode(5.0) == DataType.INT.encode(5)
    assert DataType.BYTE.encode(True) == b"\x01"
    assert DataType.BOOL.encode(1) == b"\x01"


def test_the_struct_format_says_what_the_codec_does() -> None:
    for data_type in (*INTEGERS, DataType.REAL):
        assert struct.calcsize(data_type.struct_format) == data_type.size
