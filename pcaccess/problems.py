"""What is wrong in a user's text: one type for project files and STL programs.

A :class:`Problem` cannot be built without a registered code and a place, so every message says where. All
problems of a text are collected and shown at once, in file order.

Units:    lines, columns and lengths count characters from 1.
Errors:   an unregistered code raises KeyError at once: that is our own mistake, not the user's.
See:      ``docs/problems/CODE.md`` for a wrong and a right example of each code (a test runs both).
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import Enum
from pathlib import Path
from typing import Any, Final

_VISIBLE: Final = {
    **{code: 0x2400 + code for code in range(0x20)},
    **dict.fromkeys(range(128, 160), 65533),
    0x7F: 0x2421,
}
"""Control characters become the symbols that stand for them: what is in a file never steers the terminal."""

_LONGEST_LINE: Final = 400
"""Characters of a source line that are shown."""


class Severity(Enum):
    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, slots=True, order=True)
class Span:
    """A piece of a file: ``length`` characters from ``line``:``column``."""

    file: str
    line: int
    column: int
    length: int = 1

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True, slots=True)
class Kind:
    """A row of the register: what a code means, in one line, and how grave it is."""

    title: str
    severity: Severity = Severity.ERROR


class Register:
    """The codes of one family of problems; a package makes its own and keeps it frozen afterwards."""

    def __init__(self, kinds: Mapping[str, Kind]) -> None:
        self._kinds = dict(kinds)

    def __getitem__(self, code: str) -> Kind:
        return self._kinds[code]

    def items(self) -> Iterable[tuple[str, Kind]]:
        return self._kinds.items()

    def problem(
        self,
        code: str,
        span: Span,
        message: str,
        *,
        expected: str = "",
        nearest: str | None = None,
        related: tuple[tuple[Span, str], ...] = (),
        where: str = "",
    ) -> Problem:
        return Problem(code, self._kinds[code].severity, span, message, expected, nearest, related, where)


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong. Build it with :meth:`Register.problem`."""

    code: str
    severity: Severity
    span: Span
    message: str
    expected: str = ""
    nearest: str | None = None
    related: tuple[tuple[Span, str], ...] = ()
    where: str = ""
    """Where in the user's own terms, for example ``MAIN (OB1), network 3``."""

    @property
    def is_error(self) -> bool:
        return self.severity is Severity.ERROR

    def __str__(self) -> str:
        """``items.yaml:12:18: PRJ004 unknown key 'adress'; expected one of …; did you mean 'address'?``"""
        parts = [self.message]
        if self.expected:
            parts.append(f"expected {self.expected}")
        if self.nearest:
            parts.append(f"did you mean {self.nearest!r}?")
        kind = "warning " if self.severity is Severity.WARNING else ""
        where = f"{self.where}: " if self.where else ""
        return f"{self.span}: {kind}{self.code} {where}{'; '.join(parts)}".translate(_VISIBLE)

    def as_json(self) -> dict[str, Any]:
        data = asdict(self)
        data["severity"] = self.severity.value
        data["span"] = {key: value for key, value in asdict(self.span).items() if key != "file"}
        data["file"] = self.span.file
        data["related"] = [{"at": str(span), "message": text} for span, text in self.related]
        return data


class ProblemError(Exception):
    """A text could not be used; ``problems`` holds everything that is wrong with it, in file order."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = sorted(problems, key=lambda p: (p.span, p.code))
        super().__init__("\n".join(str(p) for p in self.problems))


def nearest_word(word: str, words: Iterable[str]) -> str | None:
    """The word that was probably meant, without regard to case; None when nothing is close."""
    return next(iter(nearest_words(word, words, 1)), None)


def nearest_words(word: str, words: Iterable[str], most: int) -> list[str]:
    """Those of ``words`` that were probably meant, the likeliest first: longer ones, then similar ones."""
    by_folded = {w.casefold(): w for w in words}
    folded = word.casefold()
    longer = sorted((w for w in by_folded if len(folded) > 1 and w.startswith(folded)), key=len)
    close = difflib.get_close_matches(folded, by_folded, most, cutoff=0.6)
    return [by_folded[w] for w in dict.fromkeys((*longer, *close))][:most]


def either(words: Sequence[str]) -> str:
    """``a, b or c``"""
    return " or ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def render(problem: Problem, text: str | None = None) -> str:
    """The problem with its source line and a caret line, for people.

    ``text``: the content of the file; read from disk when not given, left out when it cannot be read.
    """
    if text is None:
        try:
            text = Path(problem.span.file).read_text(encoding="utf-8", errors="replace")
        except OSError:
            return str(problem)
    lines = text.splitlines()
    if not 1 <= problem.span.line <= len(lines):
        return str(problem)
    return render_line(problem, lines[problem.span.line - 1])


def render_line(problem: Problem, line: str) -> str:
    """The problem with ``line``, where it is, and a caret line; of a very long line the part around the place."""
    column, cut = problem.span.column, ""
    if len(line) > _LONGEST_LINE:
        first = max(0, min(column - 1 - _LONGEST_LINE // 2, len(line) - _LONGEST_LINE))
        cut = "…" if first else ""
        line = cut + line[first : first + _LONGEST_LINE]
        column += len(cut) - first
    source = line.replace("\t", " ").translate(_VISIBLE)
    number = f"{problem.span.line:6d} | "
    carets = " " * (column - 1) + "^" * max(1, min(problem.span.length, len(source) - column + 1))
    shown = [str(problem), f"{number}{source}", f"{' ' * (len(number) - 2)}| {carets}"]
    shown += [f"    {span}: {message}" for span, message in problem.related]
    return "\n".join(shown)
