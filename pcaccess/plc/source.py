"""A program file, ready to be executed: read, checked, all mistakes at once."""

from __future__ import annotations

from pathlib import Path

from pcaccess.problems import ProblemError
from pcaccess.s7200.cpu import CpuModel
from pcaccess.stl.program import Program
from pcaccess.stl.reader import read_program


def load_program(path: Path, model: CpuModel, *, encoding: str | None = None) -> Program:
    """The program in ``path`` for ``model``.

    Raises ProblemError with everything that is wrong, OSError when the file cannot be opened.
    """
    result = read_program(path, encoding=encoding)
    problems = list(result.problems)
    if result.program is None or any(problem.is_error for problem in problems):
        raise ProblemError(problems)
    return result.program
