"""Symbol tables: what Micro/WIN's table gives on copying (tab-separated) or as CSV.

A row is ``Symbol<TAB>Address<TAB>Comment``, without a header; in CSV all fields are quoted and a header may come
first. The address may be a constant (``100``, ``16#FF``, ``"abc"``), a block (``SBR0``) or empty.

Errors:   collected; a row that cannot be understood stays in the table without a target.
Source:   docs/stl.md, "Symbol tables".
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

from pcaccess.problems import Problem, Span
from pcaccess.s7200.address import Address, AddressError, parse_address
from pcaccess.s7200.types import DATA_TYPE_NAMES
from pcaccess.stl.constants import ConstantError, ascii_value, parse_number, parse_text, string_value
from pcaccess.stl.headers import parse_block_name
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import Constant, ConstantForm, PouReference, Symbol, SymbolTable
from pcaccess.stl.rawblocks import NumberedLine
from pcaccess.stl.text import NotText, decode, read

_NAME: Final = re.compile(r"[^\W\d](?:[\w ]*\w)?")
_HEADER_WORDS: Final = frozenset({"symbol", "name", "address", "comment", "符号", "地址", "注释"})
_TYPE_WORDS: Final = frozenset({*DATA_TYPE_NAMES, "TIMER", "COUNTER"})


def read_symbols(
    data: bytes | Path, *, file: str | None = None, encoding: str | None = None
) -> tuple[SymbolTable, list[Problem]]:
    """A symbol table file. Never raises on its content; OSError when it cannot be opened."""
    name = file or (str(data) if isinstance(data, Path) else "symbols")
    problems = Collector(name)
    raw = read(data) if isinstance(data, Path) else data
    try:
        decoded = decode(raw, encoding)
    except NotText as error:
        problems.add("STL002", problems.span(1, 1), str(error))
        return SymbolTable(), problems.problems
    lines = [(number, 0, line) for number, line in enumerate(decoded.text.split("\n"), 1)]
    return parse_symbols(lines, problems, decoded.encoding), problems.problems


def parse_symbols(lines: Iterable[NumberedLine], problems: Collector, encoding: str) -> SymbolTable:
    """Rows that are already lines, each with its number and the characters cut off before it."""
    symbols: list[Symbol] = []
    seen: dict[str, Symbol] = {}
    for number, cut, line in lines:
        fields = _fields(line)
        if fields is None or (number == 1 and {f.casefold() for f in fields if f} <= _HEADER_WORDS):
            continue
        symbol = _symbol(fields, number, cut, line, problems, encoding)
        if symbol is None:
            continue
        first = seen.setdefault(symbol.name.casefold(), symbol)
        if first is not symbol:
            related = ((first.span, "defined here first"),)
            problems.add("STL041", symbol.span, f"{symbol.name} is defined already", related=related)
            continue
        symbols.append(symbol)
    return SymbolTable(symbols)


def _fields(line: str) -> list[str] | None:
    """Name, address, comment; None for an empty line or a comment."""
    stripped = line.strip()
    if not stripped or stripped.startswith("//"):
        return None
    if "\t" in line:
        return [field.strip() for field in line.split("\t", 2)]
    if stripped.startswith('"') and len(stripped) < 4000:
        try:
            row = next(csv.reader([stripped], strict=True), [])
        except csv.Error:
            row = []
        if len(row) == 4 and row[2].strip().upper() in _TYPE_WORDS:  # STEP 7: a type before the comment
            row = [row[0], row[1], row[3]]
        if len(row) > 1:
            return [field.strip() for field in row[:3]]
    return [stripped]


def _symbol(
    fields: Sequence[str], number: int, cut: int, line: str, problems: Collector, encoding: str
) -> Symbol | None:
    name = " ".join(fields[0].split())
    span = problems.span(number, cut + max(0, line.find(fields[0])) + 1, len(fields[0]))
    if len(fields) < 2:
        problems.add("STL040", span, "this is no row of a symbol table", expected="Symbol<TAB>Address<TAB>Comment")
        return None
    if not name and not fields[1]:
        return None
    if not _NAME.fullmatch(name):
        expected = "letters, digits, '_' and blanks, a letter first"
        problems.add("STL042", span, f"{name!r} is no name for a symbol", expected=expected)
        return None
    if _is_taken(name):
        problems.add("STL042", span, f"{name} already means something in STL", expected="another name")
        return None
    text = fields[1]
    at = problems.span(number, cut + max(0, line.find(text, len(fields[0]))) + 1, len(text))
    target = _target(text, at, problems, encoding) if text else None
    return Symbol(name, target, text, fields[2] if len(fields) > 2 else "", span)


def _is_taken(name: str) -> bool:
    try:
        parse_address(name)
        return True
    except AddressError:
        return parse_number(name) is not None


def _target(text: str, span: Span, problems: Collector, encoding: str) -> Address | Constant | PouReference | None:
    block = parse_block_name(text)
    if block is not None:
        return PouReference(*block, text, span)
    try:
        if text[0] == '"':
            return Constant(string_value(parse_text(text, encoding)), ConstantForm.STRING, text, span)
        if text[0] == "'":
            value, width = ascii_value(parse_text(text, encoding))
            return Constant(value, ConstantForm.ASCII, text, span, width)
        number = parse_number(text)
        if number is not None:
            return Constant(number.value, number.form, text, span, number.width)
        address = parse_address(text.removeprefix("&").removeprefix("*"))
        if address.count == 1 and text[0] not in "&*":
            return address
        message = f"{text} is not one address"
    except (ConstantError, AddressError) as error:
        message = str(error)
    problems.add("STL040", span, message, expected="an address, a constant, SBRn or INTn")
    return None
