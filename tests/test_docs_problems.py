"""The pages of docs/problems hold what they promise: the wrong example gives its code there, the right one nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import pytest
from problem_pages import Example, Mark, read_page, registered

from pcaccess.plc.scenario import load_scenario
from pcaccess.problems import Problem, ProblemError
from pcaccess.project.load import load_project
from pcaccess.stl.checker import load_program

CODES: Final = sorted(registered().items())


def project_problems(path: Path) -> Sequence[Problem]:
    try:
        return load_project(path).warnings
    except ProblemError as error:
        return error.problems


def program_problems(path: Path) -> Sequence[Problem]:
    return load_program(path).problems


def scenario_problems(path: Path) -> Sequence[Problem]:
    try:
        load_scenario(path)
    except ProblemError as error:
        return error.problems
    return ()


FINDERS: Final[dict[str, Callable[[Path], Sequence[Problem]]]] = {
    "yaml": project_problems,
    "awl": program_problems,
    "scenario": scenario_problems,
}
"""What reads the main file of an example, by the example's language."""


def problems_of(example: Example, folder: Path) -> Sequence[Problem]:
    for name, text in example.files:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="")
    return FINDERS[example.language](folder / example.files[0][0])


def as_mark(problem: Problem) -> Mark:
    span = problem.span
    return Mark(Path(span.file).name, span.line, span.column, span.length)


@pytest.mark.parametrize(("code", "kind"), CODES, ids=[code for code, _ in CODES])
def test_the_title_is_that_of_the_register(code: str, kind) -> None:
    assert read_page(code).title == kind.title


@pytest.mark.parametrize("code", [code for code, _ in CODES])
def test_the_wrong_example_gives_exactly_this_code_at_the_marks(code: str, tmp_path: Path) -> None:
    wrong = read_page(code).wrong
    found = problems_of(wrong, tmp_path)
    assert [problem.code for problem in found] == [code] * max(1, len(wrong.marks)), "\n".join(map(str, found))
    assert tuple(map(as_mark, found)) == (wrong.marks or (Mark(wrong.files[0][0], 1, 1, 1),))


@pytest.mark.parametrize("code", [code for code, _ in CODES])
def test_the_right_example_gives_no_problem(code: str, tmp_path: Path) -> None:
    assert [str(problem) for problem in problems_of(read_page(code).right, tmp_path)] == []
