"""Scenarios as ``pcaccess plc scenario`` runs them: each file by itself, a broken one does not stop the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pcaccess.cli.execution import Executions
from pcaccess.counting import counted
from pcaccess.plc.interpreter import Interpreter
from pcaccess.plc.scenario import load_scenario
from pcaccess.plc.testrun import Outcome, is_worth_compiling, junit, run_scenario
from pcaccess.problems import Problem, ProblemError


@dataclass(frozen=True, slots=True)
class Played:
    """What became of one file: an outcome, or the problems that kept it from running."""

    file: str
    outcome: Outcome | None
    problems: tuple[Problem, ...] = ()

    @property
    def passed(self) -> bool:
        return self.outcome is not None and self.outcome.passed

    @property
    def summary(self) -> str:
        if self.outcome is None:
            return f"{self.file}: cannot be run, {counted({'errors': len(self.problems)}, 'errors')}"
        if self.passed:
            how = "" if self.outcome.executor == Interpreter.name else f" ({self.outcome.executor})"
            return f"{self.file}: passed, {counted({'scans': self.outcome.scans}, 'scans') or 'no scan'}{how}"
        return f"{self.file}: FAILED, {len(self.outcome.failures)} not as expected"

    def as_json(self) -> dict[str, Any]:
        if self.outcome is not None:
            return self.outcome.as_json()
        problems = [problem.as_json() for problem in self.problems]
        return {"file": self.file, "passed": False, "failures": [], "problems": problems}


def play(path: Path, executions: Executions) -> Played:
    """Read and run one scenario."""
    try:
        scenario = load_scenario(path)
        make_executor = executions.choose(worth_compiling=is_worth_compiling(scenario))
        return Played(str(path), run_scenario(scenario, make_executor=make_executor))
    except ProblemError as error:
        return Played(str(path), None, tuple(error.problems))


def as_junit(played: Sequence[Played]) -> str:
    """JUnit XML of all of them."""
    unreadable = {one.file: one.problems for one in played if one.outcome is None}
    return junit([one.outcome for one in played if one.outcome is not None], unreadable)
