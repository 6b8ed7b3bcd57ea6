"""A program file sorted by lines: what :mod:`pcaccess.stl.blocks` makes and the reader gives a meaning."""

from __future__ import annotations

from dataclasses import dataclass, field

from pcaccess.problems import Span
from pcaccess.stl.lexer import Statement
from pcaccess.stl.program import PouKind, Section


@dataclass(slots=True)
class RawNetwork:
    number: int
    title: str
    span: Span
    comment: list[str] = field(default_factory=list)
    statements: list[Statement] = field(default_factory=list)
    after: list[str] = field(default_factory=list)


@dataclass(slots=True)
class RawBlock:
    kind: PouKind
    number: int
    name: str
    span: Span
    keyword: str = ""
    """The header's first word; empty when the block has no header."""
    title: str = ""
    comment: list[str] = field(default_factory=list)
    declarations: list[tuple[Section, int, str]] = field(default_factory=list)
    """Section, line number, line."""
    networks: list[RawNetwork] = field(default_factory=list)
    ended: bool = False
    """MEND, RET or RETI was read."""


NumberedLine = tuple[int, int, str]
"""Line number, characters cut off before the text, text."""


@dataclass(slots=True)
class RawFile:
    blocks: list[RawBlock] = field(default_factory=list)
    symbols: list[NumberedLine] = field(default_factory=list)
    data: list[NumberedLine] = field(default_factory=list)
