"""Values as people write and read them."""

from __future__ import annotations

import math
import struct
from decimal import Decimal
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.cli.values import FLOAT, TYPES, ValueTextError, json_value, parse_value, shortest_real, value_text
from pcaccess.items.varianttypes import VARIANT_TYPES
from pcaccess.s7200.types import DataType

S7 = {t: TYPES[number] for t, number in VARIANT_TYPES.items()}


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        (DataType.BOOL, "TRUE", True),
        (DataType.BOOL, "off", False),
        (DataType.BYTE, "255", 255),
        (DataType.BYTE, "2#1010_1010", 0xAA),
        (DataType.CHAR, "16#FF", -1),
        (DataType.INT, "+5", 5),
        (DataType.INT, "16#8000", -32768),
        (DataType.INT, "16#7fff", 32767),
        (DataType.WORD, "16#FFFF", 65535),
        (DataType.DINT, "8#17", 15),
        (DataType.DWORD, "4294967295", 0xFFFFFFFF),
        (DataType.REAL, "-1.5e3", -1500.0),
        (DataType.REAL, "inf", math.inf),
        (DataType.STRING, " 1 ", " 1 "),
    ],
)
def test_a_text_becomes_the_items_type(kind: DataType, text: str, value: Any) -> None:
    parsed = parse_value(text, S7[kind])
    assert (parsed, type(parsed)) == (value, type(value))


@pytest.mark.parametrize(
    ("kind", "text", "words"),
    [
        (DataType.BOOL, "2", "'2' is not a BOOL: write true or false, 1 or 0"),
        (DataType.BYTE, "256", "256 does not fit BYTE, which takes 0 to 255"),
        (DataType.BYTE, "16#100", "16#100 has more than the 8 bits of BYTE"),
        (DataType.BYTE, "2#12", "'2#12' is not a number to the base 2"),
        (DataType.INT, "1.0", "'1.0' is not a whole number: INT takes -32768 to 32767, or bits such as 16#FF"),
        (DataType.INT, "", "'' is not a whole number"),
        (DataType.INT, "1_000", "'1_000' is not a whole number"),
        (DataType.REAL, "1,5", "'1,5' is not a number; the decimal sign is a point"),
        (DataType.REAL, "1e39", "1e39 does not fit REAL, which ends at 3.4e38"),
        (DataType.REAL, "1_0", "'1_0' is not a number"),
    ],
)
def test_a_text_that_is_no_value_says_what_would_be(kind: DataType, text: str, words: str) -> None:
    with pytest.raises(ValueTextError) as caught:
        parse_value(text, S7[kind])
    assert str(caught.value).startswith(words)


def test_types_of_foreign_servers_that_cannot_be_written_say_so() -> None:
    with pytest.raises(ValueTextError, match="a value of type DateTime cannot be written"):
        parse_value("2026-01-01", TYPES[13])


def test_an_array_is_separated_by_commas() -> None:
    assert parse_value("1, 2,16#3", S7[DataType.INT], is_array=True) == [1, 2, 3]
    assert parse_value('"a, b",c', S7[DataType.STRING], is_array=True) == ["a, b", "c"]


@given(st.floats(width=32, allow_nan=False))
def test_a_real_is_shown_with_no_digit_too_many_and_none_too_few(value: float) -> None:
    shown = shortest_real(value) if math.isfinite(value) else value
    assert struct.pack("<f", shown) == struct.pack("<f", value)
    assert digits(shown) <= digits(value)


def digits(value: float) -> int:
    """Significant ones; how many zeros or which exponent is written besides says nothing of the number's length."""
    return len(Decimal(repr(value)).normalize().as_tuple().digits)


@given(st.sampled_from(list(DataType)), st.data())
def test_what_is_shown_can_be_written_again(kind: DataType, data: st.DataObject) -> None:
    if kind is DataType.STRING:
        return  # shown in quotes, written without
    element: Any = {
        DataType.BOOL: st.booleans(),
        DataType.REAL: st.floats(width=32, allow_nan=False),
    }.get(kind, st.integers(kind.low, kind.high))
    value = data.draw(element | st.lists(element, min_size=1))
    again = parse_value(value_text(value, S7[kind].number), S7[kind], is_array=isinstance(value, list))
    assert again == (value if kind is not DataType.REAL else json_numbers(value))


def json_numbers(value: Any) -> Any:
    """REALs as they are shown, infinities as numbers."""
    if isinstance(value, list):
        return [json_numbers(element) for element in value]
    return shortest_real(value) if math.isfinite(value) else value


def test_json_has_no_numbers_that_json_does_not_have() -> None:
    assert json_value([math.nan, math.inf, -math.inf, 0.1], FLOAT) == ["NaN", "Infinity", "-Infinity", 0.1]
    assert json_value(b"\x01\xff", 15) == "01ff"
