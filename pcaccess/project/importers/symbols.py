"""Symbol tables of STEP 7-Micro/WIN: what its table copies (name, address and comment with tabs between them), or
the same saved as CSV, or STEP 7's four columns with the data type before the comment.

The table's name is a folder, as PC Access made it. Symbols that are no address (constants, names of program blocks)
are no items; they are counted and told.

Source:   reference notes, Micro/WIN file formats, symbol tables; PC Access facts, symbol import and default types.
"""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path
from typing import Final

from pcaccess.problems import Span
from pcaccess.project.importers.draft import Draft, DraftItem, DraftPlc
from pcaccess.project.itemtext import ItemText
from pcaccess.project.tagtable import delimiter_of
from pcaccess.project.textfile import TextError
from pcaccess.s7200.address import AddressError, parse_address
from pcaccess.s7200.types import DATA_TYPE_NAMES

_HEADERS: Final = frozenset({"symbol", "name", "symbole", "símbolo", "simbolo", "символ", "符号", "sym"})
_OTHER: Final = re.compile(r"(OB|SBR|INT|FB|FC|DB)\s?\d+|[+-]?\d+(\.\d+)?|(2|16)#[0-9A-F_]+|'.*'|\".*\"", re.IGNORECASE)
"""What a symbol may stand for that is no address: a block or a constant."""


def read_symbols(path: Path, text: str, *, link: str, plc: str, folder: str) -> Draft:
    """One PLC with the table's symbols in ``folder``; an empty ``folder`` puts them into the PLC itself."""
    draft = Draft(str(path), f"the symbol table {path.name}")
    found = DraftPlc(link, plc)
    delimiter = "\t" if "\t" in text else delimiter_of(text)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    rows = others = 0
    line = 1
    try:
        for cells in reader:
            begins, line = line, reader.line_num + 1
            row = [cell.strip() for cell in cells]
            if not any(row) or (rows == 0 and row[0].casefold() in _HEADERS):
                continue
            rows += 1
            item = _item(row, Span(str(path), begins, 1, max(1, len(row[0]))), (folder,) if folder else ())
            if item is not None:
                found.items.append(item)
            elif any(_OTHER.fullmatch(cell) for cell in row[1:]):
                others += 1
            else:
                shown = " ".join(cell for cell in row if cell)
                draft.leave_out("PRJ017", Span(str(path), begins, 1), f"no address in {shown[:60]!r}")
    except csv.Error as error:
        raise TextError(f"this is no table: {error}", line) from None
    draft.left_out += others
    if not found.items:
        raise TextError("no symbol with an S7-200 address is in it; expected lines of name, address and comment")
    if others:
        what = f"{others} symbols are constants or program blocks; items are addresses, so they are left out"
        draft.warn("PRJ036", Span(str(path), 1, 1), what)
    draft.plcs.append(found)
    return draft


def _item(row: list[str], span: Span, folders: tuple[str, ...]) -> DraftItem | None:
    """The first cell that is an address; the name stands before it, type and comment behind it.

    Micro/WIN's table has columns of marks before the name, which some ways of copying take along.
    """
    for index, cell in enumerate(row[1:], 1):
        try:
            address = parse_address(cell.replace(" ", ""))  # STEP 7 writes "Q     0.0"
        except AddressError:
            continue
        name = next((before for before in reversed(row[:index]) if before), "")
        behind = row[index + 1 :]
        data_type = behind.pop(0) if len(behind) > 1 and behind[0].upper() in DATA_TYPE_NAMES else None
        description = " ".join(part for part in behind if part)
        text = ItemText(name, str(address), data_type, description=description)
        return DraftItem(folders, text, span)
    return None
