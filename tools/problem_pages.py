"""The pages of docs/problems: which must exist, and the examples in them. As a program: is every page there?

The convention is told in docs/problems/README.md; tests/test_docs_problems.py runs the examples.

Errors:   ValueError when a page does not keep the convention, naming the page.
"""

from __future__ import annotations

import importlib
import pkgutil
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import pcaccess
from pcaccess.problems import Kind, Register

ROOT: Final = Path(__file__).parent.parent
PAGES: Final = ROOT / "docs" / "problems"
SECTIONS: Final = ("Wrong", "Right")
FILE_NAMES: Final = {"yaml": "items.yaml", "awl": "program.awl", "scenario": "scenario.yaml"}
"""Languages an example can be in, and what its file is called."""
_FENCE: Final = re.compile(r"^```(?P<language>\w+)(?: (?P<name>[^\n]+))?\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
_CARETS: Final = re.compile(r" *\^+ *")


@dataclass(frozen=True, slots=True, order=True)
class Mark:
    """A row of carets: ``length`` characters at ``line``:``column``, all from 1, as in a Span."""

    file: str
    line: int
    column: int
    length: int


@dataclass(frozen=True, slots=True)
class Example:
    """One section of a page: the file it is about and the files beside it."""

    language: str
    files: tuple[tuple[str, str], ...]
    """(name, text), the one it is about first."""
    marks: tuple[Mark, ...]


@dataclass(frozen=True, slots=True)
class Page:
    code: str
    title: str
    wrong: Example
    right: Example


def registered() -> dict[str, Kind]:
    """Every problem code of the package: all Registers in modules called ``problems``."""
    kinds: dict[str, Kind] = {}
    for module in pkgutil.walk_packages(pcaccess.__path__, "pcaccess."):
        if not module.name.endswith(".problems"):
            continue
        for value in vars(importlib.import_module(module.name)).values():
            if isinstance(value, Register):
                kinds.update(value.items())
    return kinds


def take_marks(name: str, text: str) -> tuple[str, list[Mark]]:
    """The text without its lines of carets, and what they mark: something in the line above."""
    lines: list[str] = []
    marks = []
    for line in text.splitlines(keepends=True):
        if _CARETS.fullmatch(line.rstrip("\n")):
            marks.append(Mark(name, len(lines), line.index("^") + 1, line.count("^")))
        else:
            lines.append(line)
    return "".join(lines), marks


def read_section(code: str, title: str, text: str) -> Example:
    match = re.search(rf"^## {title}$(?P<body>.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    blocks = list(_FENCE.finditer(match["body"])) if match else []
    if not blocks:
        raise ValueError(f"{code}.md: a section '## {title}' with a fenced example is missing")
    language = blocks[0]["language"]
    if language not in FILE_NAMES:
        raise ValueError(f"{code}.md: the first example of '{title}' is one of {', '.join(FILE_NAMES)}, not {language}")
    files, marks = [], []
    for place, block in enumerate(blocks):
        if (place == 0) != (block["name"] is None):
            raise ValueError(f"{code}.md: in '{title}' the first example has no file name and every further one has")
        name = block["name"] or FILE_NAMES[language]
        shown, found = take_marks(name, block["text"])
        files.append((name, shown))
        marks += found
    return Example(language, tuple(files), tuple(sorted(marks)))


def read_page(code: str) -> Page:
    text = (PAGES / f"{code}.md").read_text(encoding="utf-8")
    title = text.partition("\n")[0]
    if not title.startswith(f"# {code}: "):
        raise ValueError(f"{code}.md: the first line must be '# {code}: ' and the title")
    wrong, right = (read_section(code, section, text) for section in SECTIONS)
    if right.marks:
        raise ValueError(f"{code}.md: nothing is marked in the right example")
    return Page(code, title.removeprefix(f"# {code}: "), wrong, right)


def main() -> int:
    codes = set(registered())
    pages = {path.stem for path in PAGES.glob("*.md")} - {"README"}
    for code in sorted(codes - pages):
        print(f"refused: docs/problems/{code}.md is missing; docs/problems/README.md tells what it holds")
    for code in sorted(pages - codes):
        print(f"refused: docs/problems/{code}.md explains a code that no Register has")
    return 0 if codes == pages else 1


if __name__ == "__main__":
    sys.exit(main())
