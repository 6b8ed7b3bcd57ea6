"""Data block text to bytes of V memory."""

from __future__ import annotations

import struct

import pytest

from pcaccess.s7200.address import parse_address
from pcaccess.s7200.cpu import cpu_model
from pcaccess.stl.datablock import check_data_block, read_data_block
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import Symbol, SymbolTable

SYMBOLS = SymbolTable([Symbol("Speed", parse_address("VW40"), "VW40", "", Collector("s").span(1, 1))])


def rows(text: str, encoding: str = "utf-8") -> list[tuple[int, bytes]]:
    block, problems = read_data_block(text.encode(encoding), symbols=SYMBOLS)
    assert [str(p) for p in problems] == []
    return [(row.offset, row.data) for row in block.rows]


def problems(text: str) -> list[str]:
    _, found = read_data_block(text.encode(), symbols=SYMBOLS)
    return [f"{p.span.line}:{p.span.column}+{p.span.length} {p.code}" for p in found]


@pytest.mark.parametrize(
    ("text", "row"),
    [
        ("VB0 5", (0, b"\x05")),
        ("VW10 1,2, 3", (10, b"\0\1\0\2\0\3")),
        ("VW10 -1 65535", (10, b"\xff\xff\xff\xff")),
        ("VD20 1.5", (20, struct.pack(">f", 1.5))),
        ("VD20 100000", (20, b"\0\1\x86\xa0")),
        ("VB100 'text'", (100, b"text")),
        ('VB200 "string"', (200, b"\x06string")),
        ("VB0 'TD', 0, 16#0A", (0, b"TD\0\n")),
        ("V0 5", (0, b"\x05")),
        ("V0 300", (0, b"\x01\x2c")),
        ("V0 -1", (0, b"\xff\xff")),
        ("V0 16#000F", (0, b"\0\x0f")),
        ("V0 1.0", (0, struct.pack(">f", 1.0))),
        ("V0 W#5", (0, b"\0\x05")),
        ("DB1.DBW4 7", (4, b"\0\7")),
        ("Speed 7 // rpm", (40, b"\0\7")),
        ("vb3 2#1010_1010", (3, b"\xaa")),
    ],
)
def test_a_row_gives_the_bytes_of_its_values(text: str, row: tuple[int, bytes]) -> None:
    assert rows(text) == [row]


def test_a_row_without_an_address_goes_on_in_the_width_of_the_last() -> None:
    text = "VW10 1\n2, 3\n// comment\n\n4"
    assert rows(text) == [(10, b"\0\1"), (12, b"\0\2\0\3"), (16, b"\0\4")]


def test_texts_keep_the_bytes_of_their_code_page() -> None:
    assert rows("VB0 '温度'", "gbk") == rows("VB0 '温度'") == [(0, "温度".encode("gbk"))]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("MW0 5", "1:1+3 STL045"),
        ("V0.1 1", "1:1+4 STL045"),
        ("VW10", "1:1+4 STL045"),
        ("VB0 abc", "1:5+3 STL045"),
        ("Nix 5", "1:1+3 STL045"),
        ("VB0 256", "1:5+3 STL046"),
        ("VB0 -1", "1:5+2 STL046"),
        ("VW0 1.5", "1:5+3 STL046"),
        ("VW0 'AB'", "1:5+4 STL046"),
        ("VW0 DW#5", "1:5+4 STL046"),
        ("VD0 99999999999", "1:5+11 STL046"),
        ("VD0 1e39", "1:5+4 STL046"),
        ("VB0 'abc", "1:5+4 STL034"),
        ("VB0 2#3", "1:5+3 STL045"),
        ("VW10239 5", "1:1+7 STL048"),
    ],
)
def test_a_wrong_row_is_reported_and_left_out(text: str, problem: str) -> None:
    assert problems(text) == [problem]


def test_rows_over_each_other_are_a_warning_and_the_later_counts() -> None:
    block, found = read_data_block(b"VW0 1, 2\nVB3 9")
    assert [(p.code, p.is_error, p.span.line) for p in found] == [("STL047", False, 2)]
    memory = bytearray(8)
    block.write_to(memory)
    assert memory[:4] == b"\0\1\0\x09"


def test_a_small_cpu_has_less_v_memory() -> None:
    block, _ = read_data_block(b"VB2047 1\nVB2048 1")
    found = Collector("d")
    check_data_block(block, cpu_model("CPU 222"), found)
    assert [(p.span.line, p.code) for p in found.problems] == [(2, "STL048")]
