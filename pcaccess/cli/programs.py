"""Program files as commands take them: checking and listing."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import typer

from pcaccess.counting import counted
from pcaccess.problems import Problem, Span
from pcaccess.s7200.cpu import CpuError, CpuModel, cpu_model
from pcaccess.stl.checker import check_program
from pcaccess.stl.problems import STL
from pcaccess.stl.program import Program
from pcaccess.stl.reader import ReadResult, read_program


def model_of(name: str) -> CpuModel:
    """The CPU that ``--cpu`` names; wrong usage when there is none."""
    try:
        return cpu_model(name)
    except CpuError as error:
        raise typer.BadParameter(str(error)) from None


def read(path: Path, encoding: str | None) -> ReadResult:
    """The program in a file, as far as it can be read; of one that cannot be opened, why."""
    try:
        return read_program(path, encoding=encoding)
    except OSError as error:
        message = f"the file cannot be opened: {error.strerror}"
        span = Span(str(error.filename or path), 1, 1)  # it may be the symbol table beside it
        return ReadResult(None, (STL.problem("STL001", span, message),))


@dataclass(frozen=True, slots=True)
class CheckedProgram:
    """What is wrong with one program, and how large it is."""

    file: str
    problems: tuple[Problem, ...]
    text: str
    program: Program | None
    left_out: int

    @property
    def is_good(self) -> bool:
        return self.program is not None and not any(problem.is_error for problem in self.problems)

    @property
    def content(self) -> dict[str, int]:
        if self.program is None:
            return {}
        networks = [network for pou in self.program.pous for network in pou.networks]
        return {
            "blocks": len(self.program.pous),
            "networks": len(networks),
            "instructions": sum(len(network.instructions) for network in networks),
        }

    @property
    def summary(self) -> str:
        warnings = sum(not problem.is_error for problem in self.problems)
        found = {"errors": len(self.problems) - warnings, "warnings": warnings}
        words = counted(found, "errors", "warnings") or "no problems"
        more = f", {self.left_out:,} more not shown" if self.left_out else ""
        held = counted(self.content, "blocks", "networks", "instructions")
        return f"{self.file}: {'; '.join(filter(None, (held, words + more)))}"

    def as_json(self) -> dict[str, Any]:
        encoding = None if self.program is None else self.program.encoding
        problems = [problem.as_json() for problem in self.problems]
        return {"file": self.file, "ok": self.is_good, "encoding": encoding, **self.content, "problems": problems}


def check(path: Path, cpu: CpuModel, encoding: str | None) -> CheckedProgram:
    """Everything that is wrong with a program, for one CPU."""
    result = read(path, encoding)
    found = [] if result.program is None else check_program(result.program, cpu)
    problems = sorted((*result.problems, *found), key=lambda problem: (problem.span, problem.code))
    return CheckedProgram(str(path), tuple(problems), result.text, result.program, result.left_out)
