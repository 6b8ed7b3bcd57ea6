"""``pcaccess check`` and ``pcaccess schema``: project files before they run."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pcaccess.cli.endpoint import PROJECT_FILE
from pcaccess.cli.options import AsJson, MaxSize
from pcaccess.cli.output import json_list, show, show_problems, write_file
from pcaccess.cli.projects import content_of, load_all
from pcaccess.cli.streams import put
from pcaccess.counting import counted

if TYPE_CHECKING:
    from pcaccess.problems import Problem


@dataclass(frozen=True, slots=True)
class Checked:
    """What is wrong with one file, and how much it holds when it can be used."""

    file: str
    problems: tuple[Problem, ...]
    content: dict[str, int]

    @property
    def is_good(self) -> bool:
        return not any(problem.is_error for problem in self.problems)

    @property
    def summary(self) -> str:
        warnings = sum(not problem.is_error for problem in self.problems)
        errors = len(self.problems) - warnings
        found = counted({"errors": errors, "warnings": warnings}, "errors", "warnings") or "no problems"
        held = counted(self.content, "links", "plcs", "items", "groups")
        return f"{self.file}: {'; '.join(filter(None, (held, found)))}"

    def as_json(self) -> dict[str, Any]:
        return {
            "file": self.file,
            "ok": self.is_good,
            **self.content,
            "problems": [problem.as_json() for problem in self.problems],
        }


def check(
    files: Annotated[list[Path] | None, typer.Argument(help="Project files. Default: items.yaml.")] = None,
    as_json: AsJson = False,
    max_size: MaxSize = None,
) -> None:
    """Say what is wrong with project files: every mistake at once, with line and column.

    Warnings alone leave the exit code at 0.
    """
    results = [check_file(path, max_size) for path in files or [Path(PROJECT_FILE)]]
    if as_json:
        json_list([result.as_json() for result in results])
    else:
        for result in results:
            show_problems(result.problems, stderr=False)
            show(result.summary, meaning="good" if result.is_good else "bad")
    if not all(result.is_good for result in results):
        raise typer.Exit(1)


def check_file(path: Path, max_size: int | None = None) -> Checked:
    """All problems of one project file and the programs it names."""
    from pcaccess.problems import ProblemError

    try:
        loaded, programs = load_all(path, max_size)
    except ProblemError as error:
        return Checked(str(path), tuple(error.problems), {})
    return Checked(str(path), (*loaded.warnings, *programs.warnings), content_of(loaded.project))


def schema(
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write to a file.", metavar="FILE")] = None,
) -> None:
    """Print the JSON Schema of items.yaml, with which editors complete and check while you type."""
    from pcaccess.project.schema import project_schema

    text = json.dumps(project_schema(), indent=2, ensure_ascii=False)
    if output is None:
        put(f"{text}\n")
    else:
        write_file(output, f"{text}\n")
