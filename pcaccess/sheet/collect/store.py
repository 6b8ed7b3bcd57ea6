"""A workbook that grows, with its journal: rows are safe at once and come into the workbook when it can be written.

When a workbook is full the next one is begun: ``book-2.xlsx`` after ``book.xlsx``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from pcaccess.s7200.types import DataType
from pcaccess.sheet.collect.append import Cells, NewRows, append_rows, check_book, last_row, mark_of
from pcaccess.sheet.collect.journal import Journal, journal_of, open_journal
from pcaccess.sheet.collect.records import EventRecord, Record, RowRecord
from pcaccess.sheet.collect.workbook import QUALITIES, RUNS, TIMES, VALUES, items_of, write_empty
from pcaccess.sheet.entries import Chosen, Entry, SheetError
from pcaccess.sheet.files import opened_by, replacing


class BookIsOpen(SheetError):
    """Somebody has the workbook open; rows wait in the journal."""


def newest_book(book: Path) -> Path:
    """The last of ``book.xlsx``, ``book-2.xlsx`` … that exists; ``book`` when none does."""
    number, newest = 2, book
    while (following := book.with_name(f"{book.stem}-{number}{book.suffix}")).exists():
        newest, number = following, number + 1
    return newest


def following_book(book: Path) -> Path:
    found = re.fullmatch(r"(.*)-(\d+)", book.stem)
    stem, number = (found[1], int(found[2]) + 1) if found and int(found[2]) >= 2 else (book.stem, 2)
    return book.with_name(f"{stem}-{number}{book.suffix}")


@dataclass(slots=True)
class Store:
    """One workbook (and those that follow it) and its journal."""

    book: Path
    """The one that is written now."""
    journal: Journal
    empty: Callable[[Path], None]
    """Makes a workbook without rows at a path that does not exist."""
    max_rows: int
    """Rows of samples in one workbook."""
    rows: int
    """That this workbook has."""
    merged: int
    """Up to where in the journal it has them."""
    books: list[Path] = field(default_factory=list)
    """Workbooks that were written."""

    @property
    def pending(self) -> bool:
        return self.merged < self.journal.end

    def append(self, record: Record) -> None:
        """To the journal; raises OSError when it cannot be kept."""
        self.journal.append(record)

    def save(self) -> int:
        """Put what waits in the journal into the workbook; the number of rows. Safe to be called in a thread.

        Raises SheetError, BookIsOpen among them; everything is then as before.
        """
        done = 0
        end = self.journal.end
        while self.merged < end:
            if self.rows >= self.max_rows:
                self.book = following_book(self.book)
                self.rows = 0
            stop, rows, events = self._portion(end)
            self._save_portion(stop, rows, events)
            self.rows += rows
            done += rows
            self.merged = stop
            if self.book not in self.books:
                self.books.append(self.book)
        return done

    def close(self) -> None:
        """The journal goes when the workbook has all of it."""
        self.journal.close(remove=not self.pending)

    def _portion(self, end: int) -> tuple[int, int, int]:
        """Up to where the journal's records fit into this workbook, and how many rows and events those are."""
        room, rows, events, place = self.max_rows - self.rows, 0, 0, self.merged
        with self.journal.path.open("rb") as file:
            file.seek(place)
            while file.tell() < end and rows < room:
                if file.readline()[-3:-2] == b"]":  # a row ends with the list of its samples, an event with a text
                    rows += 1
                else:
                    events += 1
            return min(file.tell(), end), rows, events

    def _save_portion(self, stop: int, count: int, events: int) -> None:
        if self.book.exists():
            if who := opened_by(self.book):
                raise BookIsOpen(f"{self.book} is open in {who}")
        else:
            self.empty(self.book)
        rows = {
            VALUES: self._cells(stop, count, lambda row: [row.time, *(sample.value for sample in row.samples)]),
            QUALITIES: self._cells(stop, count, lambda row: [row.time, *(sample.quality for sample in row.samples)]),
            TIMES: self._cells(stop, count, lambda row: [row.time, *(sample.time for sample in row.samples)]),
            RUNS: NewRows(events, self._events(stop)),
        }
        with replacing(self.book) as target:
            append_rows(self.book, target, rows, f"{self.journal.name}:{stop}")

    def _cells(self, stop: int, count: int, cells: Callable[[RowRecord], Cells]) -> NewRows:
        records = self.journal.records(self.merged, stop)
        return NewRows(count, (cells(record) for record in records if isinstance(record, RowRecord)))

    def _events(self, stop: int) -> Iterator[Cells]:
        for record in self.journal.records(self.merged, stop):
            if isinstance(record, EventRecord):
                yield [record.time, record.text]


def open_store(book: Path, chosen: Chosen | None, gateway: str, now: datetime, max_rows: int) -> Store:
    """Begin or go on with a workbook; ``chosen`` None takes the items of the one that exists.

    Without a workbook it takes the items of the journal. Raises SheetError for a damaged or foreign workbook, other
    items, or a second collector.
    """
    newest = newest_book(book)
    exists = newest.exists()
    wanted = None if chosen is None else [entry.item_id for entry in chosen.readable]
    if exists:
        check_book(newest)
        had = items_of(newest)
        if wanted is not None and wanted != had:
            raise SheetError(_other_items(newest, had, wanted))
        wanted = had
    journal = open_journal(journal_of(book), wanted)
    name, _, place = mark_of(newest).partition(":") if exists else ("", "", "")
    merged = journal.begin
    if name == journal.name and place.isdecimal():
        merged = min(max(int(place), journal.begin), journal.end)

    shown = chosen or Chosen([Entry(item_id, DataType.REAL) for item_id in journal.items])

    def empty(path: Path) -> None:
        with replacing(path) as target:
            write_empty(target, shown, gateway, now)

    rows = max(last_row(newest, VALUES) - 1, 0) if exists else 0
    return Store(newest, journal, empty, max_rows, rows, merged)


def _other_items(book: Path, had: list[str], wanted: list[str]) -> str:
    more = [item for item in wanted if item not in had]
    fewer = [item for item in had if item not in wanted]
    parts = [
        f"{word} {', '.join(some[:5])}{' …' if len(some) > 5 else ''}"
        for word, some in (("also", more), ("not", fewer))
        if some
    ]
    return (
        f"{book} collects other items (asked for {'; '.join(parts) or 'another order'}); go on without --items and "
        "--group, or name another file"
    )
