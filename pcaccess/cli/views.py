"""Changes of items on the way to somebody: a live table, plain lines, JSON lines."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import Final

from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from pcaccess.cli.output import GAP, Row, as_cell, complain, json_line, note, rich_table
from pcaccess.cli.samples import COLUMNS, Shown
from pcaccess.cli.streams import put_now
from pcaccess.counting import counted
from pcaccess.project.durations import format_duration

REFRESH: Final = 10.0
"""Paintings per second of the live table, at most."""
VALUE_WIDTH: Final = 12
"""Columns for a value in plain lines; longer ones move the rest of their line."""


def _tell_left_out(why: str, is_failure: bool) -> None:
    (complain if is_failure else note)(why)


class JsonLines:
    """One JSON object per change."""

    def begin(self, items: Sequence[str], interval: float) -> None:
        """Nothing to prepare."""

    def show(self, samples: Sequence[Shown]) -> None:
        for sample in samples:
            json_line(sample.as_json())

    def remark(self, text: str) -> None:
        if text:
            note(text)

    def left_out(self, why: str, *, is_failure: bool) -> None:
        _tell_left_out(why, is_failure)


class PlainLines:
    """One line per change, for pipes and files."""

    def __init__(self) -> None:
        self._widths: tuple[int, ...] = ()

    def begin(self, items: Sequence[str], interval: float) -> None:
        first = not self._widths
        widest = max(map(len, (COLUMNS[0].title, *items)))
        self._widths = (widest, VALUE_WIDTH, len("2026-01-02 03:04:05.678"), 0)
        if first:
            self._line([column.title for column in COLUMNS])

    def show(self, samples: Sequence[Shown]) -> None:
        for sample in samples:
            self._line([as_cell(cell).text for cell in sample.as_row()])

    def _line(self, cells: Sequence[str]) -> None:
        line = GAP.join(f"{cell:<{width}}" for cell, width in zip(cells, self._widths, strict=True))
        put_now(f"{line.rstrip()}\n")

    def remark(self, text: str) -> None:
        if text:
            note(text)

    def left_out(self, why: str, *, is_failure: bool) -> None:
        _tell_left_out(why, is_failure)


class LiveTable:
    """All items at once, each in its line, painted again while they change. Use it as a context manager."""

    def __init__(self, url: str, console: Console) -> None:
        self._url = url
        self._console = console
        self._items: Sequence[str] = ()
        self._samples: dict[str, Shown] = {}
        self._interval = 0.0
        self._trouble = ""
        self._live = Live(console=console, get_renderable=self._painted, refresh_per_second=REFRESH)

    def __enter__(self) -> LiveTable:
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._live.stop()

    def begin(self, items: Sequence[str], interval: float) -> None:
        self._items, self._interval = list(items), interval

    def show(self, samples: Sequence[Shown]) -> None:
        self._samples.update((sample.item_id, sample) for sample in samples)

    def remark(self, text: str) -> None:
        self._trouble = text

    def left_out(self, why: str, *, is_failure: bool) -> None:
        """Stands above the table."""
        _tell_left_out(why, is_failure)

    def _painted(self) -> Group:
        room = max(1, self._console.height - 4)
        rows = [self._row(item) for item in self._items[:room]]
        hidden = len(self._items) - len(rows)
        more = f"; {hidden} more do not fit, name fewer" if hidden else ""
        items = counted({"items": len(self._items)}, "items") or "no items"
        every = format_duration(self._interval) if self._interval else ""
        foot = Text(f"{self._url}, {items}, every {every}{more}. Ctrl-C ends.", "dim")
        return Group(rich_table(COLUMNS, rows), Text(self._trouble, "bold red") if self._trouble else foot)

    def _row(self, item: str) -> Row:
        sample = self._samples.get(item)
        return sample.as_row() if sample is not None else (item, "", "", "")
