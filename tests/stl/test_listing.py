"""Listings: clean text that reads as the same program again."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given

from pcaccess.stl.checker import load_program
from pcaccess.stl.listing import list_program
from pcaccess.stl.program import Program
from pcaccess.stl.reader import read_program
from tests.stl.strategies import programs

DATA = Path(__file__).parent.parent / "data" / "stl"
FILES = sorted(DATA.glob("*.awl"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_the_listing_of_a_file_reads_as_the_same_program(path: Path) -> None:
    program = load_program(path).program
    assert program is not None
    again = read_program(list_program(program).encode())
    assert again.program == program


@given(programs())
def test_the_listing_of_any_program_reads_as_the_same_program(program: Program) -> None:
    text = list_program(program)
    again = read_program(text.encode())
    assert again.problems == (), text
    assert again.program == program, text
    assert list_program(again.unwrap()) == text


def test_a_listing_is_the_export_format_with_everything_in_one_file() -> None:
    source = """ network 1 // first
 ld  start // button
 = q0.0;
 ldw == vw0 +5
 movb 'A' vb1
 call pump 3 vb2
"""
    symbols = "//SYMBOL_TABLE\n//Start\tI0.0\tgreen\n//END_SYMBOL_TABLE"
    data = "//DATA_BLOCK\n//VW0 1\n// 2\n//END_DATA_BLOCK"
    text = f"""ORGANIZATION_BLOCK MAIN:OB1
BEGIN
{source}END_ORGANIZATION_BLOCK
SUBROUTINE_BLOCK Pump:SBR3
VAR_OUTPUT
Error:BYTE; // 0 is good
END_VAR
VAR_INPUT
Speed:BYTE;
END_VAR
BEGIN
END_SUBROUTINE_BLOCK
{symbols}
{data}
"""
    listing = """ORGANIZATION_BLOCK MAIN:OB1
TITLE=
BEGIN
Network 1 // first
LD     Start // button
=      Q0.0
LDW=   VW0, +5
MOVB   'A', VB1
CALL   Pump, 3, VB2
END_ORGANIZATION_BLOCK
SUBROUTINE_BLOCK Pump:SBR3
TITLE=
VAR_INPUT
Speed:BYTE;
END_VAR
VAR_OUTPUT
Error:BYTE; // 0 is good
END_VAR
BEGIN
END_SUBROUTINE_BLOCK
//SYMBOL_TABLE
//Start	I0.0	green
//END_SYMBOL_TABLE
//DATA_BLOCK
//VW0 1
//VW2 2
//END_DATA_BLOCK
//CROSS_REFERENCE
//I0.0  OB1/1 (Start)
//Q0.0  OB1/1=
//VW0   OB1/1
//VB1   OB1/1=
//VB2   OB1/1=
//END_CROSS_REFERENCE
"""
    assert list_program(read_program(text.encode()).unwrap()) == listing


def test_texts_of_a_code_page_survive_the_change_to_utf_8() -> None:
    source = "LD SM0.0\nSCPY \"温度 25°C\", VB0\nMOVW '°', VW0".encode("gbk")
    program = read_program(source, encoding="gbk").unwrap()
    text = list_program(program, references=False)
    assert '"温度 25°C"' in text
    assert "'$A1$E3'" in text  # alone, the degree sign of a UTF-8 file would become another byte
    assert read_program(text.encode()).program == program


def test_a_symbol_without_an_address_stays_in_the_table() -> None:
    program = read_program(b"LD I0.0\n= Q0.0\n//SYMBOL_TABLE\n//Later\t\n//Start\tI0.0\n//END_SYMBOL_TABLE\n").unwrap()
    again = read_program(list_program(program).encode())
    assert again.unwrap() == program
    assert [(symbol.name, symbol.text) for symbol in program.symbols.symbols] == [("Later", ""), ("Start", "I0.0")]
