"""Symbol tables: copied from Micro/WIN (tabs) or exported as CSV."""

from __future__ import annotations

from pathlib import Path

import pytest

from pcaccess.s7200.address import parse_address
from pcaccess.stl.program import Constant, ConstantForm, PouKind, PouReference, SymbolTable
from pcaccess.stl.symbols import read_symbols


def read(text: str) -> tuple[SymbolTable, list[str]]:
    table, problems = read_symbols(text.encode())
    return table, [f"{p.span.line}:{p.span.column}+{p.span.length} {p.code}" for p in problems]


def test_rows_with_tabs_give_addresses_constants_and_blocks() -> None:
    rows = ("Motor\tQ0.0\tmain drive", "Set point\t+1200", "Mask\t16#FF", 'Hello\t"hi"', "Tag\t'AB'", "Mix\tSBR3")
    table, problems = read("\r\n".join(rows))
    assert problems == []
    targets = {symbol.name: symbol.target for symbol in table.symbols}
    assert targets["Motor"] == parse_address("Q0.0")
    assert isinstance(targets["Set point"], Constant)
    assert targets["Set point"].value == 1200
    assert isinstance(targets["Hello"], Constant)
    assert (targets["Hello"].value, targets["Hello"].form) == ("hi", ConstantForm.STRING)
    assert isinstance(targets["Mix"], PouReference)
    assert (targets["Mix"].kind, targets["Mix"].number) == (PouKind.SBR, 3)
    assert table.symbols[0].comment == "main drive"
    assert table.name_of(parse_address("Q0.0")) == "Motor"


def test_csv_with_a_header_and_quotes_is_read_too() -> None:
    table, problems = read('"Symbol","Address","Comment"\n"Motor","Q0.0","main, ""big"" drive"\n"Pump","Q0.1",""\n')
    assert problems == []
    assert [(s.name, s.text, s.comment) for s in table.symbols] == [
        ("Motor", "Q0.0", 'main, "big" drive'),
        ("Pump", "Q0.1", ""),
    ]


def test_the_table_of_step_7_has_a_type_before_the_comment() -> None:
    table, problems = read('"Motor","Q 0.0","BOOL","drive"\n"Speed","VW2","INT","rpm"\n')
    assert problems == ["1:10+5 STL040"]
    assert table.symbols[1].comment == "rpm"


def test_a_row_without_an_address_stays_in_the_table() -> None:
    table, problems = read("Spare\t\tnot wired\n\t\t\n")
    assert problems == []
    assert [(s.name, s.target, s.comment) for s in table.symbols] == [("Spare", None, "not wired")]


@pytest.mark.parametrize(
    ("row", "problem"),
    [
        ("Motor Q0.0", "1:1+10 STL040"),
        ("Motor\tQ0.9", "1:7+4 STL040"),
        ("Motor\tVW0[3]", "1:7+6 STL040"),
        ("Motor\t&VB0", "1:7+4 STL040"),
        ("2nd\tQ0.0", "1:1+3 STL042"),
        ("T37\tQ0.0", "1:1+3 STL042"),
        ("on\tQ0.0", "1:1+2 STL042"),
        ("a,b\tQ0.0", "1:1+3 STL042"),
    ],
)
def test_a_wrong_row_is_reported_at_the_wrong_part(row: str, problem: str) -> None:
    assert read(row)[1] == [problem]


def test_the_second_of_two_equal_names_is_reported_and_the_first_counts() -> None:
    table, problems = read("Motor\tQ0.0\nMOTOR\tQ0.1\n")
    assert problems == ["2:1+5 STL041"]
    found = table.find("motor")
    assert found is not None
    assert found.text == "Q0.0"


def test_the_encoding_is_detected(tmp_path: Path) -> None:
    path = tmp_path / "tags.sym"
    path.write_bytes("电机\tQ0.0\t主电机\n".encode("gbk"))
    table, problems = read_symbols(path)
    assert problems == []
    assert table.symbols[0].comment == "主电机"


def test_a_file_that_is_no_text_is_one_problem() -> None:
    table, problems = read_symbols(b"GJK\x00R04.00", file="x.mwp")
    assert len(table) == 0
    assert [p.code for p in problems] == ["STL002"]
