"""Project files as commands take them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pcaccess.cli.output import working

if TYPE_CHECKING:
    from pcaccess.gateway.programs import Programs
    from pcaccess.project.load import Loaded
    from pcaccess.project.model import Project


def load(path: Path, max_size: int | None) -> Loaded:
    """The project; raises ProblemError. ``max_size`` in megabytes, None for the usual limit."""
    from pcaccess.project.load import load_project

    with working(f"reading {path}"):
        return load_project(path) if max_size is None else load_project(path, max_size=max_size * 1_000_000)


def load_all(path: Path, max_size: int | None) -> tuple[Loaded, Programs]:
    """The project and the programs it names; raises ProblemError."""
    from pcaccess.gateway.programs import load_programs

    loaded = load(path, max_size)
    return loaded, load_programs(loaded.project)


def content_of(project: Project) -> dict[str, int]:
    """How much a project holds."""
    return {
        "links": len(project.links),
        "plcs": sum(1 for _ in project.all_plcs()),
        "items": sum(1 for _ in project.all_items()),
        "groups": len(project.groups),
    }
