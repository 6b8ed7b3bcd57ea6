"""Workbooks as files: whether somebody has one open, and putting a new one in its place, whole or not at all."""

from __future__ import annotations

import contextlib
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from pcaccess.sheet.entries import SheetError


def lock_files(book: Path) -> list[Path]:
    """What Excel and LibreOffice put beside a workbook while they have it open.

    Excel writes ``~$`` before the name; of a name with more than 8 letters older versions drop the first two.
    """
    return [book.with_name(f"~${book.name}"), book.with_name(f".~lock.{book.name}#")]


def opened_by(book: Path) -> str | None:
    """Who has the workbook open, for people; None when nobody seems to."""
    for lock in lock_files(book):
        with contextlib.suppress(OSError):
            content = lock.read_bytes()
            if lock.name.startswith("~$"):
                # A length, then the user's name in one byte a letter, padded.
                who = content[1 : 1 + content[0]].decode("latin-1", "replace").strip("\0 ") if content else ""
                return f"Excel ({who or 'somebody'}); its mark is {lock.name}"
            fields = [field for field in content.decode("utf-8", "replace").strip().rstrip(";").split(",") if field]
            return f"LibreOffice ({fields[0] if fields else 'somebody'}); its mark is {lock.name}"
    return None


@contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """A file that takes the place of ``path`` when the block ends well; otherwise everything stays as it was.

    Raises SheetError, which says what to do.
    """
    fresh = path.with_name(f".{path.name}.{secrets.token_hex(4)}.new")
    try:
        if path.exists() and not path.stat().st_mode & stat.S_IWUSR:
            raise SheetError(f"{path} is read-only; make it writable, or name another file")
        handle = os.open(fresh, os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
        with os.fdopen(handle, "w+b") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        with contextlib.suppress(FileNotFoundError):
            fresh.chmod(path.stat().st_mode & 0o7777)
        fresh.replace(path)
    except PermissionError as error:
        raise SheetError(
            f"{path} cannot be written ({error.strerror}); is it open in another program, or the folder read-only?"
        ) from None
    except OSError as error:
        raise SheetError(f"{path} cannot be written: {error.strerror}") from None
    finally:
        with contextlib.suppress(OSError):
            fresh.unlink(missing_ok=True)
