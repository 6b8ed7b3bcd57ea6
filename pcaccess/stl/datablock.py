"""Data block text: initial values of V memory.

``VB0 5`` · ``VW10 1,2,3`` · ``VD20 1.5`` · ``VB100 'text'`` (bytes) · ``VB200 "string"`` (length byte first) ·
``V0 5`` (width from the value) · a row without an address goes on where the last one ended, in its width · ``//``
comments.

Units:    offsets in bytes of V memory.
Errors:   collected; a wrong row is left out.
Source:   docs/stl.md, "Data block". A value without a width takes the smallest unsigned place, a negative one a
          word or double word (our choice: the editor's own rule is not documented).
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterable
from pathlib import Path
from typing import Final, NamedTuple

from pcaccess.problems import Problem
from pcaccess.s7200.address import Address, AddressError, Area, Width, parse_address
from pcaccess.s7200.cpu import CpuModel
from pcaccess.s7200.types import MAX_STRING, DataType, ValueRangeError
from pcaccess.stl.constants import ConstantError, Number, parse_number, parse_text
from pcaccess.stl.lexer import Word, first_word, pieces_of, split_code
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import ConstantForm, DataBlock, DataRow, SymbolTable
from pcaccess.stl.rawblocks import NumberedLine
from pcaccess.stl.text import NotText, decode, read

_BARE: Final = re.compile(r"V(\d{1,6})?", re.IGNORECASE | re.ASCII)
_FORMATS: Final = {
    Width.BYTE: (DataType.BYTE,),
    Width.WORD: (DataType.WORD, DataType.INT),
    Width.DWORD: (DataType.DWORD, DataType.DINT),
}
V_BYTES: Final = 10240
"""V memory of the largest CPU; smaller ones are the checker's business."""


class _Place(NamedTuple):
    offset: int
    width: Width | None
    """None: the value decides."""


class _WrongRow(ValueError):
    def __init__(self, code: str, word: Word, message: str, expected: str = "") -> None:
        super().__init__(message)
        self.code, self.word, self.expected = code, word, expected


def read_data_block(
    data: bytes | Path, *, symbols: SymbolTable | None = None, file: str | None = None, encoding: str | None = None
) -> tuple[DataBlock, list[Problem]]:
    """A data block text. Never raises on its content; OSError when it cannot be opened."""
    name = file or (str(data) if isinstance(data, Path) else "data block")
    problems = Collector(name)
    raw = read(data) if isinstance(data, Path) else data
    try:
        decoded = decode(raw, encoding)
    except NotText as error:
        problems.add("STL002", problems.span(1, 1), str(error))
        return DataBlock(), problems.problems
    lines = [(number, 0, line) for number, line in enumerate(decoded.text.split("\n"), 1)]
    block = parse_data_block(lines, problems, decoded.encoding, symbols or SymbolTable())
    return block, problems.problems


def parse_data_block(
    lines: Iterable[NumberedLine], problems: Collector, encoding: str, symbols: SymbolTable
) -> DataBlock:
    """Rows that are already lines, each with its number and the characters cut off before it."""
    rows: list[DataRow] = []
    place = _Place(0, None)
    for number, cut, line in lines:
        padded = " " * cut + line
        code = split_code(padded)[0]
        if not code.strip() or first_word(code).upper() in ("DATA_BLOCK", "BEGIN", "END_DATA_BLOCK", "TITLE"):
            continue
        try:
            place, row = _row(code, number, place, problems, encoding, symbols)
        except _WrongRow as wrong:
            span = problems.span(wrong.word.line, wrong.word.column, len(wrong.word.text))
            problems.add(wrong.code, span, str(wrong), expected=wrong.expected, where="data block")
            continue
        if row is not None:
            rows.append(row)
    _report_overlaps(rows, problems)
    return DataBlock(tuple(rows))


def _row(
    code: str, number: int, place: _Place, problems: Collector, encoding: str, symbols: SymbolTable
) -> tuple[_Place, DataRow | None]:
    pieces, _ = pieces_of(code, number)
    words = [word for piece in pieces for word in piece]
    if not words:
        return place, None
    first = words[0]
    start = _place(first, symbols)
    values = words if start is None else words[1:]
    at = place if start is None else start
    if not values:
        raise _WrongRow("STL045", first, f"no value behind {first.text}", "an address and values: VW10 1,2,3")
    raw = b"".join(_bytes(word, at.width, encoding) for word in values)
    end = at.offset + len(raw)
    if end > V_BYTES:
        raise _WrongRow(
            "STL048", first, f"this goes up to VB{end - 1}", f"at most VB{V_BYTES - 1}, the largest V memory"
        )
    span = problems.span(number, first.column, max(1, len(code.rstrip()) - first.column + 1))
    text = code.strip()
    if start is None:  # say where it lies, so that the row means the same alone
        text = f"V{at.width.letter if at.width else ''}{at.offset} {text}"
    return _Place(end, at.width), DataRow(at.offset, raw, text, span)


def _place(word: Word, symbols: SymbolTable) -> _Place | None:
    """The address a row starts with; None when it starts with a value."""
    text = word.text
    if text[0] in "'\"" or _as_number(word) is not None:
        return None
    bare = _BARE.fullmatch(text)
    if bare:
        return _Place(int(bare[1] or 0), None)
    symbol = symbols.find(text)
    if symbol is not None and isinstance(symbol.target, Address):
        address = symbol.target
    else:
        try:
            address = parse_address(text)
        except AddressError as error:
            raise _WrongRow("STL045", word, str(error), "an address in V memory, then values: VW10 1,2,3") from None
    if address.area is not Area.V or address.width is Width.BIT or address.count != 1:
        raise _WrongRow(
            "STL045", word, f"{text} cannot have an initial value", "a byte, word or double word of V memory"
        )
    return _Place(address.offset, address.width)


def _as_number(word: Word) -> Number | None:
    try:
        return parse_number(word.text)
    except ConstantError as error:
        raise _WrongRow("STL045", word, str(error)) from None


def _bytes(word: Word, width: Width | None, encoding: str) -> bytes:
    if word.text[0] in "'\"":
        try:
            raw = parse_text(word.text, encoding)
        except ConstantError as error:
            raise _WrongRow("STL034", word, str(error)) from None
        if width not in (None, Width.BYTE):
            raise _WrongRow("STL046", word, "a text stands in bytes", "a VB address before it")
        if word.text[0] == "'":
            return raw
        if len(raw) > MAX_STRING:
            raise _WrongRow("STL046", word, f"a STRING of {len(raw)} characters", f"at most {MAX_STRING}")
        return bytes((len(raw),)) + raw
    number = _as_number(word)
    if number is None:
        raise _WrongRow("STL045", word, f"{word.text} is no value", "a number, 'text' or \"string\"")
    if isinstance(number.value, float):
        return _real(word, number.value, width)
    return _integer(word, number, width)


def _real(word: Word, value: float, width: Width | None) -> bytes:
    if width not in (None, Width.DWORD):
        raise _WrongRow("STL046", word, f"{word.text} is a REAL, which takes a double word", "a VD address before it")
    try:
        return DataType.REAL.encode(value)
    except ValueRangeError as error:
        raise _WrongRow("STL046", word, str(error)) from None


def _integer(word: Word, number: Number, width: Width | None) -> bytes:
    value = int(number.value)
    chosen = number.width or width or _smallest(word, value, number.form)
    if width is not None and chosen is not width:
        raise _WrongRow("STL046", word, f"{word.text} is {chosen.value} bits wide", f"a value of {width.value} bits")
    for data_type in _FORMATS[chosen]:
        if data_type.low <= value <= data_type.high:
            return struct.pack(data_type.struct_format, value)
    low, high = _FORMATS[chosen][-1].low, _FORMATS[chosen][0].high
    raise _WrongRow("STL046", word, f"{word.text} does not fit into {chosen.value} bits", f"{low} to {high}")


def _smallest(word: Word, value: int, form: ConstantForm) -> Width:
    if form is ConstantForm.HEX:  # the number of digits says it: 16#0F a byte, 16#000F a word
        digits = len(word.text.split("#")[-1].replace("_", ""))
        return Width.BYTE if digits <= 2 else Width.WORD if digits <= 4 else Width.DWORD
    if 0 <= value <= 0xFF:
        return Width.BYTE
    return Width.WORD if -0x8000 <= value <= 0xFFFF else Width.DWORD


def _report_overlaps(rows: list[DataRow], problems: Collector) -> None:
    """Each row that writes a byte an earlier one has written; the later one counts."""
    written: dict[int, DataRow] = {}
    for row in rows:
        first = next((written[at] for at in range(row.offset, row.offset + len(row.data)) if at in written), None)
        if first is not None:
            related = ((first.span, "written here first"),)
            message = f"{row.text} writes over {first.text}"
            problems.add("STL047", row.span, message, related=related, where="data block")
        for at in range(row.offset, row.offset + len(row.data)):
            written.setdefault(at, row)


def check_data_block(block: DataBlock, cpu: CpuModel, problems: Collector) -> None:
    """Rows beyond the V memory of this CPU."""
    size = cpu.sizes[Area.V]
    for row in block.rows:
        end = row.offset + len(row.data)
        if end > size:
            message = f"{row.text} goes up to VB{end - 1}"
            expected = f"at most VB{size - 1} on a {cpu.name}"
            problems.add("STL048", row.span, message, expected=expected, where="data block")
