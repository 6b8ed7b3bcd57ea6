"""What people and programs see: tables, messages, problems, JSON.

A terminal gets colours and tables that fit its width. Anything else gets plain text as wide as it needs to be, so
that a pipe or a file never holds half an item ID.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from rich.cells import cell_len
from rich.table import Table
from rich.text import Text

from pcaccess.cli.failures import Failed
from pcaccess.cli.streams import best_effort, put, put_now, stderr_console, stdout_console, writing
from pcaccess.problems import Problem, Span, render_line
from pcaccess.project.textfile import TextError, decode_table, read_bytes

GAP: Final = "  "
STYLES: Final = {"good": "green", "uncertain": "yellow", "bad": "red", "dim": "dim"}
"""What a cell means to what it looks like."""


@dataclass(frozen=True, slots=True)
class Column:
    title: str
    right: bool = False
    """Numbers stand at the right."""


@dataclass(frozen=True, slots=True)
class Cell:
    """A text and what it means: a key of ``STYLES``."""

    text: str
    meaning: str = ""


Row = Sequence[str | Cell]


def show(text: str = "", *, meaning: str = "") -> None:
    """A line for people on standard output."""
    with writing():
        stdout_console().print(Text(text, STYLES.get(meaning, meaning)))


def complain(text: str) -> None:
    """A line for people on standard error."""
    with best_effort():
        stderr_console().print(Text.assemble(("pcaccess: ", "bold red"), text))


def note(text: str) -> None:
    """A remark for people on standard error, so that standard output stays what was asked for."""
    with best_effort():
        stderr_console().print(Text(text, "dim"))


@contextmanager
def working(text: str) -> Iterator[None]:
    """Says on a terminal what takes its time, and is gone afterwards."""
    stderr = stderr_console()
    with stderr.status(text) if stderr.is_terminal else nullcontext():
        yield


def show_table(columns: Sequence[Column], rows: Sequence[Row]) -> None:
    """Rows below their titles."""
    out = stdout_console()
    if out.is_terminal:
        with writing():
            out.print(rich_table(columns, rows))
        return
    for line in plain_table(columns, rows):
        put(f"{line}\n")


def rich_table(columns: Sequence[Column], rows: Iterable[Row]) -> Table:
    """For a terminal, or for a live display."""
    table = Table(box=None, pad_edge=False, padding=(0, len(GAP), 0, 0), header_style="bold")
    for column in columns:
        table.add_column(column.title, justify="right" if column.right else "left", overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell.text, STYLES.get(cell.meaning, "")) for cell in map(as_cell, row)))
    return table


def plain_table(columns: Sequence[Column], rows: Iterable[Row]) -> list[str]:
    """Lines without colours, columns as wide as their widest cell, no blanks at the end."""
    texts = [[column.title for column in columns], *([as_cell(cell).text for cell in row] for row in rows)]
    widths = [max(map(cell_len, cells)) for cells in zip(*texts, strict=True)]
    return [
        GAP.join(
            _pad(text, width, column.right) for text, width, column in zip(line, widths, columns, strict=True)
        ).rstrip()
        for line in texts
    ]


def as_cell(cell: str | Cell) -> Cell:
    return cell if isinstance(cell, Cell) else Cell(cell)


def _pad(text: str, width: int, right: bool) -> str:
    blanks = " " * (width - cell_len(text))
    return blanks + text if right else text + blanks


# ---------------------------------------------------------------------- problems


def show_problems(problems: Iterable[Problem], *, stderr: bool, texts: Mapping[str, str] | None = None) -> None:
    """Each with its source line and carets, in colour where there is any.

    ``texts``: files that are known already, decoded.
    """
    out = stderr_console() if stderr else stdout_console()
    sources = _Sources(texts or {})
    with best_effort() if stderr else writing():
        for problem in problems:
            line = sources.line(problem.span)
            head, *rest = (str(problem) if line is None else render_line(problem, line)).splitlines()
            out.print(Text(head, "bold red" if problem.is_error else "bold yellow"))
            for line in rest:
                out.print(Text(line))


class _Sources:
    """Lines of the files that problems are in, each read once; what cannot be read, or is no text, has none."""

    def __init__(self, texts: Mapping[str, str]) -> None:
        self._lines = {file: text.splitlines() for file, text in texts.items()}

    def line(self, span: Span) -> str | None:
        if span.file not in self._lines:
            try:
                self._lines[span.file] = decode_table(read_bytes(Path(span.file))).splitlines()
            except TextError:
                self._lines[span.file] = []
        lines = self._lines[span.file]
        return lines[span.line - 1] if 1 <= span.line <= len(lines) else None


# ---------------------------------------------------------------------- for programs


def json_line(value: object) -> None:
    """One JSON value on one line, at once."""
    put_now(f"{_json(value)}\n")


def json_list(values: Sequence[Mapping[str, Any]]) -> None:
    """A JSON list with one object per line."""
    body = ",\n".join(_json(value) for value in values)
    put(f"[\n{body}\n]\n" if values else "[]\n")


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


# ---------------------------------------------------------------------- files


def write_file(path: Path, text: str) -> None:
    """Put ``text`` in the place of ``path``, whole or not at all. Raises Failed."""
    from pcaccess.project.save import replace_file

    try:
        if path.exists() and not path.is_file():  # a pipe, /dev/null: nothing that could be replaced
            path.write_text(text, encoding="utf-8")
        else:
            replace_file(path, text)
    except OSError as error:
        missing = not path.parent.exists()
        why = f"there is no folder {path.parent}" if missing else error.strerror
        raise Failed(f"{path} cannot be written: {why}") from None
