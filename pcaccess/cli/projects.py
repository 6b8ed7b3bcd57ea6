"""Project files as commands take them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from pcaccess.project.load import Loaded
    from pcaccess.project.model import Project

_PLURALS: Final = MappingProxyType({"plcs": "PLCs"})


def load(path: Path, max_size: int | None) -> Loaded:
    """The project; raises ProblemError. ``max_size`` in megabytes, None for the usual limit."""
    from pcaccess.project.load import load_project

    return load_project(path) if max_size is None else load_project(path, max_size=max_size * 1_000_000)


def content_of(project: Project) -> dict[str, int]:
    """How much a project holds."""
    return {
        "links": len(project.links),
        "plcs": sum(1 for _ in project.all_plcs()),
        "items": sum(1 for _ in project.all_items()),
        "groups": len(project.groups),
    }


def counted(counts: Mapping[str, int], *names: str) -> str:
    """``1 link, 2 PLCs, 14 items``; what there is none of is left out."""
    return ", ".join(_number(counts[name], name) for name in names if counts.get(name))


def _number(count: int, name: str) -> str:
    words = _PLURALS.get(name, name)
    return f"{count:,} {words.removesuffix('s') if count == 1 else words}"
