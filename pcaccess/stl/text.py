"""Bytes of a program file to text: what kind of file it is, and in which encoding.

Micro/WIN writes the ANSI code page of its PC without saying which, so that code page is judged by plausibility:
ASCII and UTF-8 prove themselves; cp1252, cp1251 and GBK compete with a score over their non-ASCII runs. An
``encoding`` given by the user always wins.

Errors:   :class:`NotText` says what the file is instead (a Micro/WIN project, an archive, bytes of something).
Source:   docs/stl.md, "Files"; magic numbers of Micro/WIN projects as found in real files.
"""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pcaccess.codepage import guess_code_page

MAX_BYTES: Final = 16 * 1024 * 1024
"""Largest program text; a full CPU 226 is about 0.3 MB."""


class NotText(ValueError):
    """The bytes are not a program text; the message says what they are and what to do."""


@dataclass(frozen=True, slots=True)
class Decoded:
    text: str
    encoding: str
    """A Python codec name: ``ascii utf-8 utf-16 cp1252 cp1251 gbk``, or what the user forced."""


_EXPORT: Final = "open it in its editor and export the program as text (File, Export, .awl)"
_MAGIC: Final = (
    (b"GJK\x00", f"this is a STEP 7-Micro/WIN project (.mwp); {_EXPORT}"),
    (b"SH3\x00", f"this is a project of STEP 7-Micro/WIN SMART (.smart); {_EXPORT}"),
    (b"DEM\x00", f"this is a project of STEP 7-Micro/WIN SMART (.smart); {_EXPORT}"),
    (b"\x00\x01\x00\x00Standard Jet DB", "this is a PC Access project (.pca); `pcaccess import` reads it"),
    (b"PK\x03\x04", "this is a zip archive; unpack it and name the program inside"),
    (b"%PDF", "this is a PDF; copy the program out of it as plain text"),
    (b"\xd0\xcf\x11\xe0", "this is a Microsoft Office document; save the program as plain text"),
    (b"\x1f\x8b", "this is a gzip archive; unpack it first"),
    (b"\x89PNG", "this is a picture"),
    (b"\xff\xd8\xff", "this is a picture"),
)
_NULS: Final = "the file holds NUL bytes, which no program text has; it is damaged or of another kind"
_MARKUP: Final = re.compile(r"\s*<(\?xml|!doctype|html|[a-z]\w*[\s>])", re.IGNORECASE)
_BOMS: Final = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
# Control characters that no text has; tab, line ends, form feed and the DOS end-of-file mark are fine.
_CONTROL: Final = re.compile(r"[\x00-\x08\x0b\x0e-\x19\x1b-\x1f\x7f]")


def read(path: Path) -> bytes:
    """The file, as far as :func:`decode` would take it: a device may have no end. Raises OSError."""
    with path.open("rb") as file:
        return file.read(MAX_BYTES + 1)


def decode(data: bytes, encoding: str | None = None) -> Decoded:
    """The text with line ends as ``\\n``. Raises NotText; LookupError when there is no such encoding."""
    if len(data) > MAX_BYTES:
        raise NotText(f"the file has more than {MAX_BYTES:,} bytes; no program is so large")
    for magic, what in _MAGIC:
        if data.startswith(magic):
            raise NotText(what)
    decoded = _forced(data, encoding) if encoding else _detected(data)
    text = decoded.text.removesuffix("\x1a")
    if "\x00" in text:
        raise NotText(_NULS)
    controls = len(_CONTROL.findall(text))
    if controls and controls * 200 > len(text):
        raise NotText("these are not the characters of a text; the file is damaged or of another kind")
    if _MARKUP.match(text):
        raise NotText("this is XML or HTML, not STL; export the program as .awl text")
    return Decoded(text.replace("\r\n", "\n").replace("\r", "\n"), decoded.encoding)


def _forced(data: bytes, encoding: str) -> Decoded:
    name = codecs.lookup(encoding).name
    for bom, own in _BOMS:
        if data.startswith(bom) and name.replace("_", "-").startswith(own):
            name, data = own, data.removeprefix(bom) if own == "utf-8" else data
    try:
        return Decoded(data.decode(name), name)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise NotText(
            f"line {line}: byte {error.start + 1} is not {name}; leave the encoding out or name another"
        ) from None
    except LookupError:
        raise LookupError(f"{encoding} is not a text encoding") from None


def _detected(data: bytes) -> Decoded:
    for bom, name in _BOMS:
        if data.startswith(bom):
            return _forced(data, name)
    if b"\x00" in data:
        return _utf16_without_mark(data)
    for name in ("ascii", "utf-8"):
        try:
            return Decoded(data.decode(name), name)
        except UnicodeDecodeError:
            continue
    best = guess_code_page(data)
    return Decoded(data.decode(best, errors="replace"), best)


def _utf16_without_mark(data: bytes) -> Decoded:
    for name, high in (("utf-16-le", 1), ("utf-16-be", 0)):
        if len(data) % 2 == 0 and data[high::2].count(0) * 2 > len(data) // 2 and data[1 - high :: 2].count(0) == 0:
            return Decoded(data.decode(name, errors="replace"), name)
    raise NotText(_NULS)
