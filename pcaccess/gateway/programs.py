"""The programs of a project's soft-PLCs, read and checked before anything runs.

Errors:   ProblemError with everything that is wrong in any of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from pcaccess.problems import Problem, ProblemError
from pcaccess.project.model import LinkType, Plc, Project
from pcaccess.stl.checker import load_program
from pcaccess.stl.program import Program
from pcaccess.stl.reader import ReadResult


@dataclass(frozen=True, slots=True)
class Programs:
    """Programs by ``Link.PLC``, and what their authors should know."""

    by_station: Mapping[str, Program] = field(default_factory=dict)
    warnings: tuple[Problem, ...] = ()

    def of(self, plc: Plc) -> Program | None:
        return self.by_station.get(plc.item_id)


def load_programs(project: Project) -> Programs:
    """Read every ``program:`` of the project's soft links; one that several PLCs run, once."""
    found: dict[str, Program] = {}
    results: dict[tuple[Path, str], ReadResult] = {}
    problems: list[Problem] = []
    for link in project.links:
        for plc in link.plcs if link.type is LinkType.SOFT else ():
            if plc.program is None:
                continue
            result = results.get((plc.program, plc.cpu.name))
            if result is None:
                result = results[plc.program, plc.cpu.name] = load_program(plc.program, plc.cpu)
                problems.extend(p for p in result.problems if p not in problems)
            if result.program is not None:
                found[plc.item_id] = result.program
    if any(problem.is_error for problem in problems):
        raise ProblemError(problems)
    return Programs(found, tuple(problems))
