"""What building a project needs beside its text: where things stand, what was found, which files belong to it.

Its methods turn one value into what it means. A wrong one is reported at its place and replaced by something
harmless, so that building goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from pcaccess.problems import nearest_word
from pcaccess.project.durations import EXPECTED, DurationError, parse_duration
from pcaccess.project.limits import Where
from pcaccess.project.network import NetworkError, OpenEndpointError
from pcaccess.project.problems import Findings
from pcaccess.project.yamltext import Mapping, Node, Sequence, Tree

T = TypeVar("T")


@dataclass(slots=True)
class Context:
    tree: Tree
    findings: Findings
    base: Path | None
    """Directory that paths in the file start from; None leaves files alone."""
    max_size: int
    """Of a tag table, in bytes."""
    taken_out: Container[tuple[int, Any]] = frozenset()
    """(id of node, key) that were wrong and are gone."""
    files: list[Path] = field(default_factory=list)
    """Files that the project names."""

    def where(self, node: Node) -> Where:
        """From the keys of ``node`` to where their values stand."""
        return lambda key: self.tree.value_span(node, key)

    def report(self, code: str, node: Node, key: str, message: str, **more: Any) -> None:
        self.findings.report(code, self.tree.value_span(node, key), f"{key}: {message}", **more)

    def duration(self, text: str, node: Node, key: str) -> float:
        """Seconds."""
        try:
            seconds = parse_duration(text)
        except DurationError as error:
            self.report("PRJ013", node, key, str(error), expected=EXPECTED)
            return 1.0
        if seconds <= 0:
            self.report("PRJ013", node, key, "the time must be longer than nothing", expected=EXPECTED)
        return seconds

    def word(self, text: str, words: dict[str, T], node: Node, key: str, default: T) -> T:
        """One of ``words``, in any case."""
        found = words.get(text.strip().lower())
        if found is not None:
            return found
        expected = f"one of {', '.join(words)}"
        self.report("PRJ011", node, key, f"there is no {text!r}", expected=expected, nearest=nearest_word(text, words))
        return default

    def checked(
        self, check: Callable[[str], T], text: str, node: Node, key: str, default: T, code: str = "PRJ028"
    ) -> T:
        """What ``check`` makes of the text."""
        try:
            return check(text)
        except OpenEndpointError as error:
            self.report("PRJ027", node, key, str(error), expected=f"{error.expected} or the like")
        except NetworkError as error:
            self.report(code, node, key, str(error))
        return default

    def file(self, text: str, node: Node, key: str) -> Path:
        """A file that the project names."""
        if not text.strip():
            self.report("PRJ001", node, key, "this names no file", expected="a path from where this file is")
            return Path(text)
        if self.base is None:
            return Path(text)
        path = self.base / text
        self.files.append(path)
        if path.is_dir():
            self.report("PRJ001", node, key, f"{text} is a directory", expected="a file")
        elif not path.is_file():
            self.report("PRJ001", node, key, f"there is no file {text}", expected="a path from where this file is")
        return path


def child(node: Node, key: str) -> Node:
    """The value of ``key``; the node itself where there is none, so that it can still say where it is."""
    found = node.get(key) if isinstance(node, Mapping) else None
    return node if found is None else found


def children(node: Node, key: str) -> Iterable[Node]:
    found = node.get(key) if isinstance(node, Mapping) else None
    return found.children if isinstance(found, Sequence) else ()
