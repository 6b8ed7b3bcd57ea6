"""Tag tables in Kepware's columns, as ``items_from`` reads them and ``pcaccess import`` does too.

One row is one item; dotted prefixes of its name are folders. Columns may come in any order, may be missing
(only name and address are needed) and are known by their old names too; the delimiter is a comma, a semicolon or a
tab. Beyond Kepware's columns there are ``Low``, ``High``, ``Write Limits``, ``Length`` and ``Raw Data Type``,
without which a tag table could not hold what an item can.

Units:    scaling in raw and engineering units.
Errors:   reported with the line and column of the cell; the row is then left out.
Source:   reference notes, Kepware tag CSV and Kepware's S7-200 addresses, which have no type letter: ``V100`` is a
          byte, word or double word by the tag's type, ``V100.3`` a bit, ``V100.32`` of type String 32 characters.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pcaccess.problems import Span, nearest_word
from pcaccess.project.itemtext import ItemText
from pcaccess.project.limits import Where
from pcaccess.project.model import Scaling
from pcaccess.project.problems import Findings
from pcaccess.project.textfile import MAX_SIZE, TextError, decode_table, read_bytes
from pcaccess.s7200.types import DATA_TYPE_NAMES, MAX_STRING

KEPWARE_TYPES: Final = {
    "BOOLEAN": "BOOL",
    "BYTE": "BYTE",
    "CHAR": "CHAR",
    "WORD": "WORD",
    "SHORT": "INT",
    "DWORD": "DWORD",
    "LONG": "DINT",
    "FLOAT": "REAL",
    "STRING": "STRING",
}
_NO_SUCH_TYPE: Final = frozenset({"BCD", "LBCD", "DOUBLE", "QWORD", "LLONG", "DATE"})
_ACCESS: Final = {"": None, "RO": "R", "R": "R", "RW": "RW", "R/W": "RW", "WO": "W", "W": "W"}
_YES: Final = frozenset({"1", "YES", "TRUE", "Y"})
_WIDTHS: Final = {
    "BYTE": "B",
    "CHAR": "B",
    "STRING": "B",
    "WORD": "W",
    "INT": "W",
    "DWORD": "D",
    "DINT": "D",
    "REAL": "D",
}
_AREAS: Final = r"(?P<area>I|Q|V|M|SM|S)"
_BARE: Final = re.compile(
    rf"{_AREAS}(?P<offset>\d{{1,6}})(?:\.(?P<sub>\d{{1,3}}))?\s*(?P<array>\[\d+\])?", re.IGNORECASE
)
_ANALOG: Final = re.compile(r"(A[IQ])(\d{1,6})", re.IGNORECASE)

_COLUMNS: Final = {
    "tagname": "name",
    "name": "name",
    "address": "address",
    "datatype": "type",
    "clientaccess": "access",
    "access": "access",
    "scaling": "scaling",
    "rawlow": "raw_low",
    "rawhigh": "raw_high",
    "scaledlow": "scaled_low",
    "scaledhigh": "scaled_high",
    "clamplow": "clamp_low",
    "clamphigh": "clamp_high",
    "engunits": "unit",
    "units": "unit",
    "description": "description",
    "negatevalue": "negate",
    "low": "low",
    "high": "high",
    "writelimits": "write_limits",
    "length": "length",
    "rawdatatype": "raw_type",
}
_WITHOUT_MEANING: Final = frozenset({"respectdatatype", "scanrate", "scaleddatatype"})
"""Columns of Kepware's that change nothing here: a client's own rate counts, and a scaled item is REAL."""


@dataclass(slots=True)
class TagRow:
    """One row: the folders of its name, the rest, and where it stands."""

    folders: list[str]
    text: ItemText
    span: Span
    where: Where


def read_tags(path: Path, named_at: Span, findings: Findings, max_size: int = MAX_SIZE) -> Iterator[TagRow]:
    """The rows that can be read; ``named_at`` is where the project names the file."""
    try:
        text = decode_table(read_bytes(path, max_size))
    except TextError as error:
        findings.report("PRJ001", named_at, f"{path.name}: {error}")
        return
    yield from read_tag_text(text, str(path), findings)


def has_tag_columns(text: str) -> bool:
    """Whether the text begins as a tag table does."""
    return _Table(text, "", Findings()).read_header()


def read_tag_text(text: str, file: str, findings: Findings) -> Iterator[TagRow]:
    """Rows of a tag table in memory."""
    table = _Table(text, file, findings)
    if not table.read_header():
        return
    yield from table.rows()


class _Table:
    def __init__(self, text: str, file: str, findings: Findings) -> None:
        self.text = text
        self.file = file
        self.findings = findings
        self.delimiter = delimiter_of(text)
        self.columns: dict[str, int] = {}
        self._reader = csv.reader(io.StringIO(text, newline=""), delimiter=self.delimiter)
        self._line = 1  # where the current row begins
        self._lines: list[str] | None = None

    def read_header(self) -> bool:
        header: list[str] = []
        for header in self._records():
            if any(cell.strip() for cell in header):
                break
        for index, cell in enumerate(header):
            plain = re.sub(r"[^a-z]", "", cell.lower())
            if plain in _COLUMNS:
                self.columns.setdefault(_COLUMNS[plain], index)
        missing = [words for key, words in (("name", "Tag Name"), ("address", "Address")) if key not in self.columns]
        for words in missing:
            self.findings.report(
                "PRJ035",
                Span(self.file, self._line, 1),
                f"the tag table has no column {words!r}",
                expected="a header such as Tag Name,Address,Data Type,Client Access,Description",
                nearest=nearest_word(words, header),
            )
        return not missing

    def rows(self) -> Iterator[TagRow]:
        for cells in self._records():
            if any(cells) and (row := _Row(self, self._line, cells).read()) is not None:
                yield row

    def _records(self) -> Iterator[list[str]]:
        """Records with ``_line`` at the line each begins on."""
        while True:
            self._line = self._reader.line_num + 1
            try:
                yield next(self._reader)
            except StopIteration:
                return
            except csv.Error as error:
                self.findings.report("PRJ035", Span(self.file, self._line, 1), f"this is no table: {error}")
                return

    def span(self, line: int, column: int) -> Span:
        """A cell; ``line`` is the one its record begins on."""
        if self._lines is None:
            self._lines = self.text.splitlines()
        start, length = _cell_at(self._lines[line - 1], column, self.delimiter)
        return Span(self.file, line, start, length)


class _Row:
    """The cells of one record."""

    __slots__ = ("_cells", "_line", "_table")

    def __init__(self, table: _Table, line: int, cells: list[str]) -> None:
        self._table, self._line, self._cells = table, line, cells

    def read(self) -> TagRow | None:
        findings = self._table.findings
        before = findings.errors
        full = self._cell("name")
        if not full:
            findings.report("PRJ009", self.where("name"), "the tag has no name")
            return None
        *folders, name = full.split(".")
        data_type = self._type()
        address, length = _own_address(self._cell("address"), data_type)
        text = ItemText(
            name,
            address,
            data_type,
            self._access(),
            self._number("high"),
            self._number("low"),
            self._cell("unit"),
            self._cell("description"),
            self._cell("write_limits") or None,
            self._length() or length,
        )
        self._scale(text)
        if findings.errors > before:
            return None
        return TagRow(folders, text, self.where("name"), self.where)

    def where(self, key: str) -> Span:
        columns = self._table.columns
        return self._table.span(self._line, columns.get(key, columns["address"]))

    def _cell(self, key: str) -> str:
        index = self._table.columns.get(key)
        return self._cells[index].strip() if index is not None and index < len(self._cells) else ""

    def _report(self, code: str, key: str, message: str, expected: str = "") -> None:
        self._table.findings.report(code, self.where(key), message, expected=expected)

    def _type(self) -> str | None:
        word = self._cell("type")
        plain = word.upper().removesuffix("ARRAY").rstrip()
        if plain in ("", "DEFAULT"):
            return None
        if plain in _NO_SUCH_TYPE:
            self._report(
                "PRJ011", "type", f"there is no type {word} in an S7-200", f"one of {', '.join(DATA_TYPE_NAMES)}"
            )
        return KEPWARE_TYPES.get(plain, plain)

    def _access(self) -> str | None:
        word = self._cell("access").upper()
        if word not in _ACCESS:
            self._report("PRJ011", "access", f"there is no access {word!r}", "RO, RW, R/W, R or W")
        return _ACCESS.get(word)

    def _length(self) -> int | None:
        written = self._cell("length")
        if not written:
            return None
        if not re.fullmatch(r"\d{1,3}", written, re.ASCII) or not 1 <= int(written) <= MAX_STRING:
            self._report("PRJ012", "length", f"length: {written!r} is out of range", f"1 to {MAX_STRING}")
            return None
        return int(written)

    def _number(self, key: str) -> float | None:
        written = self._cell(key)
        if not written:
            return None
        try:
            value = float(written.replace(",", ".") if self._table.delimiter == ";" else written)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            self._report("PRJ010", key, f"{written!r}", "a number such as 12.5")
        return value

    def _scale(self, text: ItemText) -> None:
        """Kepware's linear scaling and its sign change, as one straight line."""
        kind = self._cell("scaling").lower()
        negate = self._cell("negate").upper() in _YES
        if kind in ("", "none") and not negate:
            return
        ends = [self._number(key) for key in ("raw_low", "raw_high", "scaled_low", "scaled_high")]
        if kind in ("", "none"):
            ends = [0.0, 1.0, 0.0, 1.0]
        elif kind != "linear":
            self._report("PRJ024", "scaling", f"there is no scaling {kind!r}", "None or Linear")
            return
        raw_low, raw_high, scaled_low, scaled_high = (end for end in ends)
        if raw_low is None or raw_high is None or scaled_low is None or scaled_high is None:
            self._report("PRJ024", "scaling", "an end of the scaling is missing", "four numbers, raw and scaled")
            return
        clamps = {self._cell(key).upper() in _YES for key in ("clamp_low", "clamp_high")}
        if len(clamps) == 2:
            self._report("PRJ036", "clamp_low", "clamped at one end only; an item is clamped at both or at none")
        if negate:
            scaled_low, scaled_high = 0.0 - scaled_low, 0.0 - scaled_high  # no -0.0
        text.scaling = Scaling(raw_low, raw_high, scaled_low, scaled_high, clamps == {True})
        text.raw_type, text.type = self._cell("raw_type") or text.type, None


def delimiter_of(text: str) -> str:
    """The one that the first line with anything on it has most of."""
    first = next((line for line in text.splitlines() if line.strip()), "")
    return max(",;\t", key=first.count)


def _own_address(written: str, data_type: str | None) -> tuple[str, int | None]:
    """Kepware's spelling to ours, and the length of a string; anything else is left as it is."""
    match = _BARE.fullmatch(written)
    if match is None:
        analog = _ANALOG.fullmatch(written)
        return (f"{analog[1]}W{analog[2]}" if analog else written), None
    area, offset, sub = match["area"].upper(), match["offset"], match["sub"]
    if sub is not None and data_type == "STRING":
        return f"{area}B{offset}", int(sub)
    if sub is not None or data_type == "BOOL":
        return written, None
    return f"{area}{_WIDTHS.get(data_type or '', 'B')}{offset}{match['array'] or ''}", None


def _cell_at(line: str, column: int, delimiter: str) -> tuple[int, int]:
    """Where a cell stands in its line, from 1, and how long it is; quotation marks belong to it."""
    start = 0
    for at in range(column + 1):
        end = _end_of_cell(line, start, delimiter)
        if at == column:
            return start + 1, max(1, end - start)
        if end == len(line):
            break
        start = end + 1
    return 1, max(1, len(line))


def _end_of_cell(line: str, start: int, delimiter: str) -> int:
    at = start
    if line.startswith('"', start):
        at += 1
        while (at := line.find('"', at)) >= 0 and line.startswith('""', at):
            at += 2
    end = line.find(delimiter, at) if at >= 0 else -1
    return len(line) if end < 0 else end
