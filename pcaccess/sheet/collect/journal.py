"""The journal beside a workbook: every row is on the disk before the next one is asked for.

JSON, one record on a line, so that a line that a crash cut off is seen to be none. The workbook remembers up to where
it has the journal (its name and a number of bytes), so a crash between saving the workbook and removing the journal
puts no row in twice.

Errors:   SheetError for a journal of other items or one that somebody else writes; OSError when the disk is full.
"""

from __future__ import annotations

import json
import os
import secrets
import sys
from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import BinaryIO, Final

from pcaccess.sheet.collect.records import EventRecord, Record, RowRecord, Sample
from pcaccess.sheet.entries import SheetError

_KIND: Final = "pcaccess journal 1"


def journal_of(book: Path) -> Path:
    return book.with_name(f"{book.name}.journal")


class Journal:
    """Open for one run; nobody else can open it meanwhile."""

    def __init__(self, path: Path, file: BinaryIO, name: str, items: Sequence[str], begin: int) -> None:
        self.path = path
        self.name = name
        self.items = items
        self.begin = begin
        """Where its first record stands."""
        self._file = file
        self._end = file.tell()

    @property
    def end(self) -> int:
        """Behind the last complete record."""
        return self._end

    def append(self, record: Record) -> None:
        """On the disk when this returns."""
        self._file.seek(self._end)
        self._file.write(_line(record))
        self._file.flush()
        os.fsync(self._file.fileno())
        self._end = self._file.tell()

    def records(self, start: int, end: int) -> Iterator[Record]:
        """Those between two places, read from the file, which others may be appending to."""
        with self.path.open("rb") as file:
            file.seek(start)
            while file.tell() < end:
                yield _record(file.readline())

    def close(self, *, remove: bool) -> None:
        """``remove``: everything is in the workbook."""
        if remove and sys.platform != "win32":  # still locked, so that nobody begins to write it
            self.path.unlink(missing_ok=True)
        self._file.close()
        if remove:
            self.path.unlink(missing_ok=True)


def open_journal(path: Path, items: Sequence[str] | None) -> Journal:
    """A new one for these items, or the one that a run left behind. ``items`` None takes whatever is there.

    What a crash cut off at its end is dropped.
    """
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666)
    except OSError as error:
        raise SheetError(f"{path} cannot be written: {error.strerror}") from None
    file = os.fdopen(handle, "r+b")
    try:
        _lock(file, path)
        head = file.readline()
        if not head.endswith(b"\n"):
            if items is None:
                raise SheetError(f"{path} has no rows")
            return _begin(path, file, items)
        name, had = _head(head, path)
        if items is not None and list(items) != had:
            raise SheetError(
                f"{path} still holds rows of other items ({', '.join(had[:5])}{' …' if len(had) > 5 else ''}); put "
                f"them into their workbook first: pcaccess sheet merge {path.name.removesuffix('.journal')}"
            )
        begin = file.tell()
        _skip_complete(file)
        file.truncate()
        return Journal(path, file, name, had, begin)
    except BaseException:
        file.close()
        raise


def _begin(path: Path, file: BinaryIO, items: Sequence[str]) -> Journal:
    name = secrets.token_hex(8)
    file.seek(0)
    file.truncate()
    file.write(json.dumps([_KIND, name, list(items)], ensure_ascii=False).encode() + b"\n")
    file.flush()
    os.fsync(file.fileno())
    return Journal(path, file, name, items, file.tell())


def _head(line: bytes, path: Path) -> tuple[str, list[str]]:
    try:
        kind, name, items = json.loads(line)
    except ValueError:
        kind, name, items = "", "", []
    if kind != _KIND:
        raise SheetError(f"{path} is not a journal of pcaccess; rename or remove it")
    return name, items


def _skip_complete(file: BinaryIO) -> None:
    """To the end of the last line that is a record."""
    while True:
        at = file.tell()
        line = file.readline()
        try:
            if line.endswith(b"\n"):
                _record(line)
                continue
        except (ValueError, TypeError, KeyError):
            pass
        file.seek(at)
        return


def _line(record: Record) -> bytes:
    stamp = record.time.isoformat()
    content: list[object] = [stamp]
    if isinstance(record, EventRecord):
        content.append(record.text)
    else:
        content.append([[s.value, s.quality, None if s.time is None else s.time.isoformat()] for s in record.samples])
    return json.dumps(content, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "replace") + b"\n"


def _record(line: bytes) -> Record:
    stamp, content = json.loads(line)
    time = datetime.fromisoformat(stamp)
    if isinstance(content, str):
        return EventRecord(time, content)
    samples = [
        Sample(value, quality, None if at is None else datetime.fromisoformat(at)) for value, quality, at in content
    ]
    return RowRecord(time, samples)


def _lock(file: BinaryIO, path: Path) -> None:
    """One collector per journal; the operating system lets go of it when the process ends, however it ends."""
    try:
        if sys.platform == "win32":
            import msvcrt

            file.seek(1 << 40)  # far behind the end, because Windows locks bytes against reading too
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
            file.seek(0)
        else:
            import fcntl

            fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise SheetError(f"another pcaccess is collecting into {path.name.removesuffix('.journal')}") from None
