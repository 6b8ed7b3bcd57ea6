"""Bytes to text: encodings judged by plausibility, and files that are no text."""

from __future__ import annotations

import codecs

import pytest

from pcaccess.stl.text import NotText, decode

RUSSIAN = ["Network 1 // Двигатель", "// ПУСК", "НАСОС", "// Пуск и стоп двигателя, авария", "TITLE=КОММЕНТАРИИ", "№ 5"]
CHINESE = ["ORGANIZATION_BLOCK 主程序:OB1", "// 启动按钮", "SI CPU_输出2, 1", "// 延时10秒，然后停止", "// 灯"]
WESTERN = ["TÍTULO DE SEGMENTO", "// Größe der Säge", "// válvula", "// 50°C", "// Ñandú ¿qué?", "ÜBERFÜLLT"]


@pytest.mark.parametrize("line", RUSSIAN)
def test_a_line_of_russian_is_cp1251(line: str) -> None:
    decoded = decode(line.encode("cp1251"))
    assert (decoded.text, decoded.encoding) == (line, "cp1251")


@pytest.mark.parametrize("line", CHINESE)
def test_a_line_of_chinese_is_gbk(line: str) -> None:
    decoded = decode(line.encode("gbk"))
    assert (decoded.text, decoded.encoding) == (line, "gbk")


@pytest.mark.parametrize("line", WESTERN)
def test_a_line_of_german_or_spanish_is_cp1252(line: str) -> None:
    decoded = decode(line.encode("cp1252"))
    assert (decoded.text, decoded.encoding) == (line, "cp1252")


def test_chinese_that_is_cut_off_in_a_character_is_still_chinese() -> None:
    decoded = decode("// 启动和停止按钮".encode("gbk")[:-1])
    assert decoded.encoding == "gbk"
    assert decoded.text.startswith("// 启动和停止按")


@pytest.mark.parametrize(
    ("data", "encoding"),
    [
        (b"LD I0.0", "ascii"),
        ("// é".encode(), "utf-8"),
        (codecs.BOM_UTF8 + b"LD I0.0", "utf-8"),
        ("LD I0.0 // é".encode("utf-16"), "utf-16"),
        ("LD I0.0 // x".encode("utf-16-le"), "utf-16-le"),
        ("LD I0.0 // x".encode("utf-16-be"), "utf-16-be"),
    ],
)
def test_unicode_and_ascii_prove_themselves(data: bytes, encoding: str) -> None:
    decoded = decode(data)
    assert decoded.encoding == encoding
    assert decoded.text.startswith(("LD", "//"))


def test_a_forced_encoding_wins() -> None:
    assert decode("// Двигатель".encode("cp1251"), "latin-1").text == "// Äâèãàòåëü"


def test_a_mark_at_the_start_does_not_become_a_character() -> None:
    assert decode(codecs.BOM_UTF8 + b"LD", "utf-8").text == "LD"
    assert decode("LD".encode("utf-16"), "utf-16").text == "LD"


def test_bytes_that_are_not_of_the_forced_encoding_say_where() -> None:
    with pytest.raises(NotText, match="line 2: byte 4 is not utf-8"):
        decode(b"LD\n\xff", "utf-8")


def test_an_encoding_that_does_not_exist_is_the_callers_mistake() -> None:
    with pytest.raises(LookupError):
        decode(b"LD", "klingon")


def test_every_kind_of_line_end_becomes_one() -> None:
    assert decode(b"a\r\nb\rc\nd\x1a").text == "a\nb\nc\nd"


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"GJK\x00R04.00\x00\x00", r"Micro/WIN project \(.mwp\)"),
        (b"SH3\x00R02.00", "Micro/WIN SMART"),
        (b"DEM\x00R01.00", "Micro/WIN SMART"),
        (b"\x00\x01\x00\x00Standard Jet DB\x00", "PC Access project"),
        (b"PK\x03\x04....", "zip"),
        (b"%PDF-1.4", "PDF"),
        (b"<?xml version='1.0'?>", "XML"),
        (b"  <!DOCTYPE html>", "HTML"),
        (b"LD I0.0\x00\x01\x02", "NUL bytes"),
        (bytes(range(1, 32)) * 10, "not the characters of a text"),
    ],
)
def test_a_file_of_another_kind_says_what_it_is(data: bytes, what: str) -> None:
    with pytest.raises(NotText, match=what):
        decode(data)


def test_a_file_beyond_all_measure_is_refused() -> None:
    with pytest.raises(NotText, match="more than 16,777,216 bytes"):
        decode(b"x" * (16 * 1024 * 1024 + 1))
