"""Appending rows to sheets of an .xlsx file, leaving everything else in it as it is, byte for byte.

openpyxl would read and write the whole workbook, in memory, and lose what it does not know (pivot tables, queries,
macros). Here the file is copied part by part, and rows go in before ``</sheetData>`` of the sheets that get some; so
memory does not grow with the workbook, and what a user added stays.

Source:   ISO/IEC 29500-1, 18.3 (worksheets); OPC (part 2) for the package.
Errors:   :class:`DamagedBook` when the file is not what it should be.
"""

from __future__ import annotations

import re
import shutil
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import IO, BinaryIO, Final
from xml.etree import ElementTree
from xml.sax.saxutils import escape

from pcaccess.sheet.collect.records import CellValue
from pcaccess.sheet.entries import SheetError
from pcaccess.sheet.formulas import column_letters

PROPERTY: Final = "pcaccess.journal"
"""Custom property of the workbook: up to where it has which journal."""
_CUSTOM: Final = "docProps/custom.xml"
_CHUNK: Final = 1 << 20
_END: Final = b"</sheetData>"
_EMPTY: Final = re.compile(rb"<sheetData\s*/>")
_ROW: Final = re.compile(rb'<row\b[^>]*?\br="(\d+)"')
_DIMENSION: Final = re.compile(rb'(<dimension ref="[A-Z]+\d+:[A-Z]+)\d+("\s*/>)')
_COLUMN: Final = re.compile(rb"<col\b[^>]*>")
_UNFIT: Final = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]|_x[0-9A-Fa-f]{4}_")
_RELATIONSHIPS: Final = "{http://schemas.openxmlformats.org/officeDocument/2006/relationships}id"
_MAX_TEXT: Final = 32_767
"""Characters in a cell."""

Cells = Iterable[CellValue | datetime]
"""Of a row. A datetime is shown in local time."""


@dataclass(frozen=True, slots=True)
class NewRows:
    """For one sheet; ``count`` is how many there are."""

    count: int
    rows: Iterator[Cells]


class DamagedBook(SheetError):
    """The file is no workbook, or not a whole one."""


def append_rows(book: Path, target: BinaryIO, rows: Mapping[str, NewRows], mark: str) -> None:
    """Copy ``book`` to ``target`` with ``rows`` at the end of the sheets they are for.

    ``mark``: what :func:`mark_of` finds then.
    """
    with _opened(book) as old, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new:
        parts = _sheet_parts(old)
        missing = [sheet for sheet in rows if sheet not in parts]
        if missing:
            raise DamagedBook(
                f"{book} has no sheet {missing[0]}: it is no workbook that `pcaccess sheet collect` made, or the sheet "
                "was renamed; name another file"
            )
        growing = {parts[sheet]: (sheet, some) for sheet, some in rows.items()}
        try:
            for info in old.infolist():
                fresh = zipfile.ZipInfo(info.filename, info.date_time)
                fresh.compress_type, fresh.external_attr = zipfile.ZIP_DEFLATED, info.external_attr
                with old.open(info) as source, new.open(fresh, "w", force_zip64=True) as sink:
                    if info.filename in growing:
                        sheet, some = growing[info.filename]
                        last = _last_of(old, info.filename)
                        _copy_sheet(source, sink, some, last, f"{book}, sheet {sheet}")
                    elif info.filename == _CUSTOM:
                        sink.write(_marked(source.read(), mark))
                    else:
                        shutil.copyfileobj(source, sink, _CHUNK)
        except (zipfile.BadZipFile, zlib.error, EOFError) as error:
            raise _damaged(book, error) from None


def check_book(book: Path) -> None:
    """Raises DamagedBook unless every part can be read and its check sum is right."""
    with _opened(book) as package:
        try:
            broken = package.testzip()
        except (zipfile.BadZipFile, zlib.error, EOFError, OSError) as error:
            raise _damaged(book, error) from None
        if broken is not None:
            raise _damaged(book, f"{broken} is broken")
        _sheet_parts(package)


def mark_of(book: Path) -> str:
    """What was given to :func:`append_rows` last; empty when there is none."""
    with _opened(book) as package:
        if _CUSTOM not in package.namelist():
            return ""
        found = _mark_pattern().search(package.read(_CUSTOM).decode("utf-8", "replace"))
        return found[2] if found else ""


def last_row(book: Path, sheet: str) -> int:
    """Number of the last row of a sheet that has anything; 0 for none."""
    with _opened(book) as package:
        part = _sheet_parts(package).get(sheet)
        return 0 if part is None else _last_of(package, part)


# ---------------------------------------------------------------------- the package


def _opened(book: Path) -> zipfile.ZipFile:
    try:
        return zipfile.ZipFile(book)
    except zipfile.BadZipFile as error:
        raise _damaged(book, error) from None
    except OSError as error:
        raise SheetError(f"{book} cannot be read: {error.strerror}") from None


def _damaged(book: Path, why: object) -> DamagedBook:
    return DamagedBook(
        f"{book} is damaged or no .xlsx workbook ({why}); it stays as it is: rename it, or name another file"
    )


def _sheet_parts(package: zipfile.ZipFile) -> dict[str, str]:
    """Paths of the sheets by name."""
    try:
        workbook = ElementTree.fromstring(package.read("xl/workbook.xml"))
        relations = ElementTree.fromstring(package.read("xl/_rels/workbook.xml.rels"))
    except (KeyError, ElementTree.ParseError, zipfile.BadZipFile, zlib.error, EOFError) as error:
        raise _damaged(Path(package.filename or ""), error) from None
    targets = {relation.get("Id"): relation.get("Target", "") for relation in relations}
    parts = {}
    for sheet in workbook.iter():
        if sheet.tag.endswith("}sheet"):
            target = targets.get(sheet.get(_RELATIONSHIPS), "")
            parts[sheet.get("name", "")] = target.lstrip("/") if target.startswith("/") else f"xl/{target}"
    return parts


def _mark_pattern() -> re.Pattern[str]:
    return re.compile(rf'(name="{re.escape(PROPERTY)}"[^>]*>\s*<(?:\w+:)?lpwstr>)([^<]*)(</)')


def _marked(content: bytes, mark: str) -> bytes:
    text = content.decode("utf-8")
    return _mark_pattern().sub(lambda found: found[1] + escape(mark) + found[3], text).encode()


# ---------------------------------------------------------------------- a sheet


def _tail_safe_chunks(source: IO[bytes]) -> Iterator[bytes]:
    """Pieces that never end within a tag."""
    held = b""
    while data := source.read(_CHUNK):
        held += data
        cut = held.rfind(b">") + 1
        if cut:
            yield held[:cut]
            held = held[cut:]
    if held:
        yield held


def _last_of(package: zipfile.ZipFile, part: str) -> int:
    last = 0
    with package.open(part) as source:
        for chunk in _tail_safe_chunks(source):
            last = _last_row(chunk, last)
    return last


def _last_row(chunk: bytes, last: int) -> int:
    at = chunk.rfind(b"<row ")
    found = _ROW.match(chunk, at) if at >= 0 else None
    return last if found is None else int(found[1])


def _copy_sheet(source: IO[bytes], sink: IO[bytes], new: NewRows, last: int, where: str) -> None:
    """``last``: number of the last row that is there."""
    size = rb"\g<1>%d\g<2>" % (last + new.count)
    styles: dict[int, str] = {}
    done = False
    for chunk in _tail_safe_chunks(source):
        if done:
            sink.write(chunk)
            continue
        if not styles and b"<cols>" in chunk:
            styles = _column_styles(chunk)
        chunk = _EMPTY.sub(b"<sheetData></sheetData>", chunk)
        chunk = _DIMENSION.sub(size, chunk)
        head, found, tail = chunk.partition(_END)
        sink.write(head)
        if found:
            for number, cells in enumerate(new.rows, start=last + 1):
                sink.write(_row_xml(number, cells, styles))
            sink.write(found + tail)
            done = True
    if not done:
        raise DamagedBook(f"{where}: the sheet has no end; it stays as it is: name another file")


def _column_styles(head: bytes) -> dict[int, str]:
    """Style numbers of columns, from 1, that have one: so a new cell looks as its column says."""
    styles: dict[int, str] = {}
    for element in _COLUMN.findall(head):
        found = dict(re.findall(rb'(\w+)="([^"]*)"', element))
        if b"style" in found and b"min" in found:
            first, last = int(found[b"min"]), min(int(found.get(b"max") or found[b"min"]), 16_384)
            styles |= dict.fromkeys(range(first, last + 1), found[b"style"].decode())
    return styles


def _row_xml(number: int, cells: Cells, styles: Mapping[int, str]) -> bytes:
    texts = []
    for column, value in enumerate(cells, start=1):
        if value is None or value == "":
            continue
        style = f' s="{styles[column]}"' if column in styles else ""
        place = f'<c r="{column_letters(column)}{number}"{style}'
        if isinstance(value, datetime):
            texts.append(f"{place}><v>{serial(value)!r}</v></c>")
        elif isinstance(value, str):
            shown = escape(_UNFIT.sub(_escaped, value[:_MAX_TEXT]))
            texts.append(f'{place} t="inlineStr"><is><t xml:space="preserve">{shown}</t></is></c>')
        else:
            texts.append(f"{place}><v>{value!r}</v></c>")
    return f'<row r="{number}">{"".join(texts)}</row>'.encode()


def _escaped(found: re.Match[str]) -> str:
    """A sign that XML cannot hold, or a text that would read as one (ISO/IEC 29500-1, 22.9.2.19)."""
    text = found[0]
    return f"_x005F{text}" if len(text) > 1 else f"_x{ord(text):04X}_" if ord(text) < 0x10000 else "\ufffd"


_EPOCH: Final = datetime(1899, 12, 30)  # noqa: DTZ001 - Excel's days have no time zone


def serial(moment: datetime) -> float:
    """Local time as Excel's days since 1899-12-30, to the millisecond."""
    passed = moment.astimezone().replace(tzinfo=None) - _EPOCH
    return round(passed.days + (passed.seconds + round(passed.microseconds / 1000) / 1000) / 86400, 10)
