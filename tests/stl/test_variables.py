"""Variable sections and the L addresses that follow from their order."""

from __future__ import annotations

from pcaccess.stl.problems import Collector
from pcaccess.stl.program import PouKind, Section, Variable
from pcaccess.stl.variables import read_variables

IN, IN_OUT, OUT, TEMP = Section.IN, Section.IN_OUT, Section.OUT, Section.TEMP


def read(*declarations: tuple[Section, str], kind: PouKind = PouKind.SBR) -> tuple[tuple[Variable, ...], list[str]]:
    problems = Collector("p.awl")
    rows = [(section, number, line) for number, (section, line) in enumerate(declarations, 1)]
    variables = read_variables(kind, rows, problems)
    return variables, [f"{p.span.line}:{p.span.column} {p.code}" for p in problems.problems]


def addresses(*declarations: tuple[Section, str]) -> dict[str, str]:
    variables, problems = read(*declarations)
    assert problems == []
    return {variable.name: str(variable.address) for variable in variables}


def test_bits_share_a_byte_and_everything_else_takes_the_next_one() -> None:
    assert addresses(
        (IN, "First:BOOL;"),
        (IN, "Second : BOOL"),
        (IN, "Slave:BYTE;"),
        (IN, "Count:INT; // how many"),
        (IN, "Where:DWORD;"),
        (OUT, "Done:BOOL;"),
        (OUT, "Error:REAL;"),
    ) == {
        "First": "L0.0",
        "Second": "L0.1",
        "Slave": "LB1",
        "Count": "LW2",
        "Where": "LD4",
        "Done": "L8.0",
        "Error": "LD9",
    }


def test_a_ninth_bit_goes_to_the_next_byte() -> None:
    rows = [(IN, f"b{n}:BOOL;") for n in range(9)]
    assert addresses(*rows)["b8"] == "L1.0"


def test_sections_are_laid_out_in_their_order_whatever_the_text() -> None:
    found = addresses((TEMP, "t:BYTE;"), (OUT, "o:BYTE;"), (IN_OUT, "x:BYTE;"), (IN, "i:BYTE;"))
    assert found == {"i": "LB0", "x": "LB1", "o": "LB2", "t": "LB3"}


def test_a_string_takes_the_double_word_of_its_pointer() -> None:
    assert addresses((IN, "Text:STRING;"), (IN, "n:BYTE;")) == {"Text": "LD0", "n": "LB4"}


def test_comments_are_kept_and_comment_lines_skipped() -> None:
    variables, problems = read((IN, "// remark"), (IN, "a:INT; // why"))
    assert problems == []
    assert [(v.name, v.comment) for v in variables] == [("a", "why")]


def test_sixty_four_bytes_fit_and_the_next_does_not() -> None:
    rows = [(TEMP, f"v{n}:REAL;") for n in range(16)]
    assert read(*rows)[1] == []
    assert read(*rows, (TEMP, "  more:BOOL;"))[1] == ["17:3 STL013"]


def test_wrong_declarations_are_reported_and_left_out() -> None:
    variables, problems = read(
        (IN, "Speed INT;"),
        (IN, "Level:INTEGER;"),
        (IN, "a:INT;"),
        (IN, "A:REAL;"),
        (OUT, "Text:STRING;"),
    )
    assert problems == ["1:1 STL011", "2:7 STL011", "4:1 STL012", "5:1 STL014"]
    assert [v.name for v in variables] == ["a"]


def test_only_subroutines_have_parameters() -> None:
    assert read((IN, "a:INT;"), kind=PouKind.MAIN)[1] == ["1:1 STL014"]
    assert read((OUT, "a:INT;"), kind=PouKind.INT)[1] == ["1:1 STL014"]
    assert read((TEMP, "a:INT;"), kind=PouKind.INT)[1] == []
