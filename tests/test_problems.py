"""What a user sees of a mistake."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pcaccess.problems import Kind, ProblemError, Register, Severity, Span, nearest_word, render

CODES = Register({"X001": Kind("a mistake"), "X002": Kind("a doubt", Severity.WARNING)})
SPAN = Span("items.yaml", 2, 5, 3)


def test_a_problem_is_one_line_with_place_code_expectation_and_nearest_word() -> None:
    problem = CODES.problem("X001", SPAN, "no type 'IMT'", expected="INT or WORD", nearest="INT", where="MAIN (OB1)")
    assert str(problem) == "items.yaml:2:5: X001 MAIN (OB1): no type 'IMT'; expected INT or WORD; did you mean 'INT'?"


def test_a_warning_says_that_it_is_one() -> None:
    problem = CODES.problem("X002", SPAN, "swapped")
    assert str(problem) == "items.yaml:2:5: warning X002 swapped"
    assert not problem.is_error


def test_a_code_that_is_not_registered_is_our_own_mistake() -> None:
    with pytest.raises(KeyError):
        CODES.problem("X999", SPAN, "?")


def test_all_problems_of_a_text_come_in_file_order() -> None:
    places = [Span("b", 1, 1), Span("a", 10, 1), Span("a", 2, 7), Span("a", 2, 3)]
    error = ProblemError(CODES.problem("X001", span, "x") for span in places)
    assert [str(problem.span) for problem in error.problems] == ["a:2:3", "a:2:7", "a:10:1", "b:1:1"]
    assert str(error).splitlines()[0] == "a:2:3: X001 x"


def test_people_see_the_line_and_the_place_in_it() -> None:
    problem = CODES.problem("X001", SPAN, "wrong", related=((Span("items.yaml", 1, 1), "first used here"),))
    assert render(problem, "one\ntwo three\n").splitlines() == [
        "items.yaml:2:5: X001 wrong",
        "     2 | two three",
        "       |     ^^^",
        "    items.yaml:1:1: first used here",
    ]


def test_a_tab_before_the_place_does_not_move_the_carets() -> None:
    assert render(CODES.problem("X001", Span("f", 1, 3, 1), "x"), "\tab").splitlines()[1:] == [
        "     1 |  ab",
        "       |   ^",
    ]


def test_control_characters_of_a_file_never_reach_the_terminal() -> None:
    shown = render(CODES.problem("X001", Span("f", 1, 6, 1), "no \x1b[2J"), "\x1b[31m\x00\x9bx")
    assert shown.splitlines() == ["f:1:6: X001 no ␛[2J", "     1 | ␛[31m␀\ufffdx", "       |      ^"]


def test_of_a_very_long_line_the_part_around_the_place_is_shown() -> None:
    line = "a" * 60_000 + "xyz" + "b" * 60_000
    _, source, carets = render(CODES.problem("X001", Span("f", 1, 60_001, 3), "wrong"), line).splitlines()
    assert len(source) < 500
    at = carets.index("^")
    assert (source[at : at + 3], carets.count("^")) == ("xyz", 3)


def test_a_file_of_one_endless_line_is_cut_at_its_beginning_too() -> None:
    _, source, carets = render(CODES.problem("X001", Span("f", 1, 1, 1), "too large"), "a" * 60_000).splitlines()
    assert (len(source) < 500, carets) == (True, "       | ^")


def test_the_line_is_read_from_the_file_when_nobody_has_its_text(tmp_path: Path) -> None:
    path = tmp_path / "items.yaml"
    path.write_text("a\nbcd\n")
    assert "     2 | bcd" in render(CODES.problem("X001", Span(str(path), 2, 1), "x"))


@pytest.mark.parametrize(("name", "line"), [("missing.yaml", 1), ("items.yaml", 99)])
def test_a_line_that_is_not_there_is_left_out(tmp_path: Path, name: str, line: int) -> None:
    (tmp_path / "items.yaml").write_text("a\n")
    problem = CODES.problem("X001", Span(str(tmp_path / name), line, 1), "x")
    assert render(problem) == str(problem)


def test_programs_get_everything_as_json() -> None:
    problem = CODES.problem("X002", SPAN, "m", expected="e", nearest="n", related=((SPAN, "r"),), where="w")
    assert json.loads(json.dumps(problem.as_json())) == {
        "code": "X002",
        "severity": "warning",
        "file": "items.yaml",
        "span": {"line": 2, "column": 5, "length": 3},
        "message": "m",
        "expected": "e",
        "nearest": "n",
        "related": [{"at": "items.yaml:2:5", "message": "r"}],
        "where": "w",
    }


@pytest.mark.parametrize(
    ("word", "nearest"),
    [("adress", "address"), ("ADRESS", "address"), ("tpye", "type"), ("addr", "address"), ("xyz", None), ("", None)],
)
def test_the_nearest_word_is_close_or_none(word: str, nearest: str | None) -> None:
    assert nearest_word(word, ["address", "type", "name"]) == nearest
