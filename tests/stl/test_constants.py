"""Constants in every notation, and texts with their escapes."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.problems import Span
from pcaccess.s7200.address import Width
from pcaccess.stl.constants import (
    ConstantError,
    Number,
    ascii_value,
    parse_number,
    parse_text,
    plc_bytes,
    spell,
    spell_text,
    string_value,
)
from pcaccess.stl.program import Constant, ConstantForm

D, H, B, R = ConstantForm.DECIMAL, ConstantForm.HEX, ConstantForm.BINARY, ConstantForm.REAL
HERE = Span("x.awl", 1, 1)


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("100", Number(100, D)),
        ("+100", Number(100, D)),
        ("-5", Number(-5, D)),
        ("16#1F", Number(31, H)),
        ("16#90cda73d", Number(0x90CDA73D, H)),
        ("2#1010_1010", Number(0xAA, B)),
        ("0.75", Number(0.75, R)),
        ("-.5", Number(-0.5, R)),
        ("1.0E-3", Number(0.001, R)),
        ("1e3", Number(1000.0, R)),
        ("5.", Number(5.0, R)),
        ("TRUE", Number(1, ConstantForm.BOOL)),
        ("off", Number(0, ConstantForm.BOOL)),
        ("B#16#0F", Number(15, H, Width.BYTE)),
        ("WORD#100", Number(100, D, Width.WORD)),
        ("dw#2#11", Number(3, B, Width.DWORD)),
    ],
)
def test_numbers_in_every_notation(text: str, number: Number) -> None:
    assert parse_number(text) == number


@pytest.mark.parametrize("text", ["VB0", "Motor", "1.2.3", "--5", "16#", "E5", "1_000", ""])
def test_other_words_are_no_numbers(text: str) -> None:
    assert parse_number(text) is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("2#12", "digits 0 and 1"),
        ("8#17", "not a notation"),
        ("B#1.5", "whole number"),
        ("W#B#1", "whole number"),
        ("1e999", "does not fit a REAL"),
        ("9" * 70, "fits nothing"),
    ],
)
def test_what_looks_like_a_number_and_is_none_says_why(text: str, message: str) -> None:
    with pytest.raises(ConstantError, match=message):
        parse_number(text)


@pytest.mark.parametrize(
    ("text", "raw"),
    [
        ("'AB'", b"AB"),
        ("''", b""),
        ("'$'$$'", b"'$"),
        ('"say $"hi$""', b'say "hi"'),
        ("'$0D$l$N$p$r$t'", b"\r\n\r\n\x0c\r\t"),
        ("'a\"b'", b'a"b'),
    ],
)
def test_escapes_stand_for_their_characters(text: str, raw: bytes) -> None:
    assert parse_text(text, "ascii") == raw


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("'abc", "closing '"),
        ('"', 'closing "'),
        ("'abc$'", "closing '"),
        ("'$z'", "no escape"),
        ("'€漢Ж'", "one code page"),
    ],
)
def test_a_wrong_text_says_what_is_wrong(text: str, message: str) -> None:
    with pytest.raises(ConstantError, match=message):
        parse_text(text, "utf-8")


def test_characters_become_bytes_of_the_files_own_code_page() -> None:
    assert plc_bytes("温度", "gbk") == plc_bytes("温度", "utf-8") == "温度".encode("gbk")
    assert plc_bytes("é", "cp1252") == plc_bytes("é", "utf-16") == b"\xe9"
    assert plc_bytes("°", "gbk") == "°".encode("gbk")
    assert plc_bytes("Ж", "utf-8") == "Ж".encode("cp1251")


def test_ascii_constants_are_one_two_or_four_characters() -> None:
    assert ascii_value(b"A") == (0x41, Width.BYTE)
    assert ascii_value(b"AB") == (0x4142, Width.WORD)
    assert ascii_value(b"ABCD") == (0x41424344, Width.DWORD)
    with pytest.raises(ConstantError, match="not 3"):
        ascii_value(b"ABC")


def test_a_string_has_one_character_for_each_byte() -> None:
    assert string_value(b"\xc4\xe3") == "Äã"
    with pytest.raises(ConstantError, match="at most 254"):
        string_value(bytes(255))


@given(st.binary(max_size=40), st.sampled_from("'\""))
def test_a_spelled_text_reads_as_the_same_bytes_in_any_encoding(raw: bytes, quote: str) -> None:
    written = spell_text(raw, quote)
    assert written.isascii()
    assert all(parse_text(written, encoding) == raw for encoding in ("ascii", "gbk", "cp1251", "utf-8"))


@given(st.integers(-(2**31), 2**32 - 1), st.sampled_from([None, Width.BYTE, Width.WORD, Width.DWORD]))
def test_a_spelled_integer_reads_as_the_same_number(value: int, width: Width | None) -> None:
    forms = [D] if value < 0 else [D, H, B]
    for form in forms:
        assert parse_number(spell(Constant(value, form, "", HERE, width))) == (value, form, width)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_spelled_real_reads_as_the_same_number(value: float) -> None:
    assert parse_number(spell(Constant(value, R, "", HERE))) == Number(value, R)
