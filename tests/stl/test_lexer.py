"""One line of STL to mnemonic, operand words and comment."""

from __future__ import annotations

import pytest

from pcaccess.stl.lexer import Statement, comment_text, statement_of


def parse(line: str) -> Statement:
    statement, _ = statement_of(line, 1, ())
    assert statement is not None
    return statement


def words(line: str) -> list[list[str]]:
    return [[word.text for word in piece] for piece in parse(line).pieces]


@pytest.mark.parametrize(
    ("line", "mnemonic"),
    [
        ("LDW>=  VW0, 5", "LDW>="),
        ("LDW >= VW0, 5", "LDW>="),
        ("ldw == VW0, 5", "LDW="),
        ("OB=VB0,1", "OB="),
        ("AR<> VD0, 1.0", "AR<>"),
        ("LDW=>VW0,1", "LDW>="),
        ("AS= VB0, VB10", "AS="),
        ("FND <> VW0, 1, VW2", "FND<>"),
        ("=Q0.0", "="),
        ("= Q0.0", "="),
        ("=I Q0.0", "=I"),
        ("=I0.0", "="),
        ("+I VW0, VW2", "+I"),
        ("-D +2, AC0", "-D"),
        ("/R 64000.0, AC0", "/R"),
        ("*r VD0, VD4", "*R"),
        ("\tnot", "NOT"),
        ("LDS 3", "LDS"),
        ("A I0.0", "A"),
        ("AI I0.0", "AI"),
    ],
)
def test_a_mnemonic_is_capitals_without_blanks(line: str, mnemonic: str) -> None:
    assert parse(line).mnemonic == mnemonic


@pytest.mark.parametrize(
    ("line", "pieces"),
    [
        ("MOVB 3, VB500", [["3"], ["VB500"]]),
        ("MOVB 3 VB500", [["3", "VB500"]]),
        ("MOVB 3,VB500", [["3"], ["VB500"]]),
        ("LD Pump motor", [["Pump", "motor"]]),
        ("CALL Mix, , VB0", [["Mix"], [], ["VB0"]]),
        ("MOVB ',', VB0", [["','"], ["VB0"]]),
        ('SCPY "a, b // c; d", VB0 // e', [['"a, b // c; d"'], ["VB0"]]),
        ('SCPY "say $"hi$"", VB0', [['"say $"hi$""'], ["VB0"]]),
        ("MOVB '@, VB21", [["'@, VB21"]]),
        ("NOT // nothing", []),
        ("LDW=SMW68 +500", [["SMW68", "+500"]]),
        ("LD\tI0.0\t", [["I0.0"]]),
    ],
)
def test_operands_are_words_between_commas(line: str, pieces: list[list[str]]) -> None:
    assert words(line) == pieces


@pytest.mark.parametrize("line", ["  LD  I0.0 // start", "LD I0.0; // start", "LD I0.0//start"])
def test_a_comment_follows_on_the_same_line(line: str) -> None:
    statement, behind = statement_of(line, 1, ())
    assert statement is not None
    assert (statement.comment or comment_text(behind.strip())) == "start"
    assert statement.pieces[0][0].text == "I0.0"


def test_columns_count_from_one() -> None:
    statement = parse("  MOVW   VW0, VW2")
    assert (statement.column, [piece[0].column for piece in statement.pieces]) == (3, [10, 15])


def test_a_line_that_ends_with_a_comma_goes_on() -> None:
    assert parse("CALL Mix, VB0,").open_end
    assert not parse("CALL Mix, VB0").open_end


@pytest.mark.parametrize("line", ["", "+500", "// comment", "100*100 msec", "`"])
def test_a_line_without_a_mnemonic_is_no_statement(line: str) -> None:
    assert statement_of(line, 1, ())[0] is None
