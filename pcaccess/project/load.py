"""Project files to projects: the one door through which ``items.yaml`` comes in.

Errors:   ProblemError with everything that is wrong, each with file, line, column, expectation and nearest word.
Source:   docs/items-yaml.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pcaccess.collector import paused
from pcaccess.problems import Problem, ProblemError, Span
from pcaccess.project.build import build_project
from pcaccess.project.context import Context, children
from pcaccess.project.model import Project
from pcaccess.project.problems import Findings
from pcaccess.project.structure import read_structure
from pcaccess.project.textfile import MAX_SIZE, TextError, decode_utf8, read_bytes
from pcaccess.project.yamltext import Mapping, Node, Scalar, YamlError, read_yaml


@dataclass(frozen=True, slots=True)
class Loaded:
    """A project that can be used, and what its author should know."""

    project: Project
    warnings: tuple[Problem, ...]
    files: tuple[Path, ...]
    """The project file and every file it names: a change in any of them changes the project."""


def load_project(path: Path, *, max_size: int = MAX_SIZE) -> Loaded:
    """Read a project file and the tag tables it names; sizes in bytes."""
    try:
        text = decode_utf8(read_bytes(path, max_size))
    except TextError as error:
        findings = Findings()
        findings.report("PRJ001", Span(str(path), error.line, error.column), str(error))
        raise ProblemError(findings.problems) from None
    return _load(text, str(path), path, path.parent, max_size)


def load_text(text: str, name: str = "items.yaml", base: Path | None = None, *, max_size: int = MAX_SIZE) -> Loaded:
    """Read a project from memory. Files that it names start at ``base``; without one they are not looked at."""
    return _load(text, name, Path(name), base, max_size)


def _load(text: str, name: str, path: Path, base: Path | None, max_size: int) -> Loaded:
    with paused():
        return _build(text, name, path, base, max_size)


def _build(text: str, name: str, path: Path, base: Path | None, max_size: int) -> Loaded:
    findings = Findings()
    try:
        tree = read_yaml(text, name)
    except YamlError as error:
        for fault in error.faults:
            findings.report(fault.code, fault.span, fault.message, related=fault.related)
        raise ProblemError(findings.problems) from None
    for fault in tree.faults:
        findings.report(fault.code, fault.span, fault.message, related=fault.related)
    structure = read_structure(tree, findings)
    if structure is None:
        raise ProblemError(findings.problems)
    declared = _declared_ids(read_yaml(text, name).root) if findings.errors else []
    context = Context(tree, findings, base, max_size, structure.taken_out)
    project = build_project(structure.project, path, context, declared)
    if findings.errors:
        raise ProblemError(findings.problems)
    files = (path, *context.files) if base else ()
    return Loaded(project, tuple(sorted(findings.warnings, key=lambda p: (p.span, p.code))), files)


def _declared_ids(root: Node) -> list[str]:
    """IDs of all items that stand in the file, whatever is wrong with them."""
    ids: list[str] = []

    def collect(node: Node, prefix: str) -> None:
        name = node.get("name") if isinstance(node, Mapping) else None
        if not isinstance(name, Scalar) or not name.text:
            return
        path = f"{prefix}.{name.text}" if prefix else name.text
        below = [child for key in ("plcs", "folders", "items") for child in children(node, key)]
        if not below:
            ids.append(path)
        for child in below:
            collect(child, path)

    for link in children(root, "links"):
        collect(link, "")
    return ids
