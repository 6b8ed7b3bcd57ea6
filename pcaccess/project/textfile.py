"""Files of users as text: size, encoding and what else a file may turn out to be.

Errors:   :class:`TextError` says what the file is instead and what to do.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

from pcaccess.codepage import guess_code_page

MAX_SIZE: Final = 50_000_000
"""Bytes. Beyond this a project is a mistake, unless somebody says otherwise."""

_SIGNATURES: Final = (
    (b"\x00\x01\x00\x00Standard Jet DB", "a PC Access project; turn it into YAML with: pcaccess import"),
    (b"GJK\x00", "a Micro/WIN project; export its symbol table as text and import that"),
    (b"SH3\x00", "a Micro/WIN SMART project; export its symbol table as text and import that"),
    (b"PK\x03\x04", "an archive or a workbook"),
    (b"\xd0\xcf\x11\xe0", "an old Office file"),
    (b"%PDF", "a PDF"),
)


class TextError(ValueError):
    """The file cannot be used; line and column are where, from 1."""

    def __init__(self, message: str, line: int = 1, column: int = 1) -> None:
        super().__init__(message)
        self.line, self.column = line, column


def read_bytes(path: Path, max_size: int = MAX_SIZE) -> bytes:
    """The whole file, unless it is missing, no file or too large."""
    try:
        size = path.stat().st_size
        if path.is_dir():
            raise TextError("this is a directory, not a file")
        if size > max_size:
            raise TextError(
                f"the file has {size:,} bytes; files over {max_size:,} are refused, unless --max-size allows them"
            )
        if not path.is_file():
            raise TextError("this is a device, not a file")
        return path.read_bytes()
    except FileNotFoundError:
        raise TextError("there is no such file") from None
    except OSError as error:
        raise TextError(f"the file cannot be read: {error.strerror or error}") from None


def what_is(data: bytes) -> str | None:
    """In words what a file is that is not text; None when it may be text."""
    for signature, words in _SIGNATURES:
        if data.startswith(signature):
            return words
    if b"\x00" in data[:4096] and not data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "not a text file"
    return None


def decode_utf8(data: bytes) -> str:
    """Text of a file that must be UTF-8, with or without its mark."""
    if words := what_is(data):
        raise TextError(f"this is {words}")
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise TextError("this is UTF-16; save the file as UTF-8")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line = before.count(b"\n") + 1
        column = len(before[before.rfind(b"\n") + 1 :].decode("utf-8-sig")) + 1
        shown = data[error.start : error.start + 1]
        guess = shown.decode("cp1252", "replace")
        raise TextError(
            f"the byte {shown.hex().upper()} is not UTF-8 (is it {guess!r}?); save the file as UTF-8", line, column
        ) from None


def decode_table(data: bytes, encoding: str | None = None) -> str:
    """Text of a table as spreadsheets and engineering tools save it.

    UTF-8, UTF-16 with its mark, else the likeliest code page. ``encoding`` ends the guessing.
    """
    if encoding is not None:
        return _decode_as(data, encoding)
    if words := what_is(data):
        raise TextError(f"this is {words}")
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return _decode_as(data, "utf-16")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode(guess_code_page(data), "replace")


def _decode_as(data: bytes, encoding: str) -> str:
    try:
        return data.decode(encoding)
    except LookupError:
        raise TextError(f"there is no encoding {encoding!r}; expected utf-8, cp1252, cp1251, gbk or the like") from None
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise TextError(f"the byte {data[error.start]:02X} is not {encoding}; name another encoding", line) from None
