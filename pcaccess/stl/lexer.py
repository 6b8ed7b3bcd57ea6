"""One line of STL to its parts: mnemonic, operand words, comment. Knows no instruction and no symbol.

``LDW >= T33, +40 // start`` gives the statement ``LDW>=`` with the pieces ``T33`` and ``+40``. What stands between
commas is one piece of one or more words, because blanks separate operands too (``MOVB 3 VB500``) but may also
belong to a symbol (``Pump motor``); ``pcaccess.stl.operands`` decides.

Units:    columns count characters from 1.
Errors:   nothing raises; a line that does not start with a mnemonic has none.
Source:   Micro/WIN editor grammar: comma or blanks between operands, optional ``;``, ``//`` comments, any case.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Final, NamedTuple


class Word(NamedTuple):
    text: str
    column: int
    line: int


Piece = tuple[Word, ...]
"""Words between two commas; empty when nothing stands there."""


class Statement(NamedTuple):
    """An instruction before its operands are understood."""

    mnemonic: str
    """Canonical: capitals, no blanks, ``==`` as ``=``."""
    written: str
    line: int
    column: int
    pieces: tuple[Piece, ...]
    comment: str
    before: tuple[str, ...]
    open_end: bool
    """The operands end with a comma: the next line goes on."""


_MNEMONIC: Final = re.compile(
    r"""\s*(
        (?:LD|[AO])[BWDRSI]\s*(?:==|<>|><|>=|=>|<=|=<|=|<|>)
      | (?:LD|[AOU])N?(?:DI|DW|[BWDRSI])\s*(?:==|<>|>=|<=|!=|=|<|>)   # other words for compares, explained later
      | FND\s*(?:==|<>|>=|<=|=|<|>)
      | =I(?=\s) | =(?!=)
      | [-+*/][IDR](?=\s|$) | [<>=]+[IDR](?=\s|$)               # the second: S7-300 compares, explained later
      | [-+*/](?:DINT|DI|DWORD|DW|INT|WORD|W|REAL|F)(?=\s)
      | [^\W\d]\w*\(? | \)(?:MCR)?
    )\s*""",
    re.VERBOSE | re.IGNORECASE,
)
_WORD: Final = re.compile(r""",|'(?:\$.|[^'$])*'|"(?:\$.|[^"$])*"|['"].*|[^\s,'"]+""")
# Code up to a comment or a ';', skipping quoted texts; an unclosed quote runs to the end of the line.
_CODE: Final = re.compile(r"""(?:[^'"/;]+|/(?!/)|'(?:\$.|[^'$])*(?:'|$)|"(?:\$.|[^"$])*(?:"|$)|['"].*)*""")
_SPELLINGS: Final = {"==": "=", "=>": ">=", "=<": "<=", "><": "<>"}


@lru_cache(maxsize=4096)
def canonical(mnemonic: str) -> str:
    """Capitals, without blanks, with the usual comparison sign."""
    plain = "".join(mnemonic.split()).upper()
    head, sign = plain[:-2], plain[-2:]
    return head + _SPELLINGS[sign] if head and sign in _SPELLINGS else plain


def first_word(line: str) -> str:
    """The mnemonic or keyword a line starts with, as written; empty when there is none."""
    match = _MNEMONIC.match(line)
    return match[1] if match else ""


def split_code(line: str) -> tuple[str, str, str]:
    """(code, what follows a ``;``, comment behind ``//``)."""
    if "'" in line or '"' in line:
        match = _CODE.match(line)
        end = match.end() if match else 0
    else:
        slashes, semicolon = line.find("//"), line.find(";")
        ends = [at for at in (slashes, semicolon) if at >= 0]
        end = min(ends) if ends else len(line)
    code, rest = line[:end], line[end:]
    if rest.startswith(";"):
        return code, rest[1:], ""
    return code, "", comment_text(rest)


def comment_text(text: str) -> str:
    """A comment without its slashes and the one blank that usually follows them."""
    return text.removeprefix("//").removeprefix(" ").rstrip()


def pieces_of(code: str, line: int, start: int = 0) -> tuple[tuple[Piece, ...], bool]:
    """The operand pieces of ``code`` from index ``start`` on, and whether they end with a comma."""
    if "," not in code and "'" not in code and '"' not in code:  # the usual short way
        words = code[start:].split()
        if len(words) == 1:
            return ((Word(words[0], code.index(words[0], start) + 1, line),),), False
        if not words:
            return (), False
    pieces: list[Piece] = []
    piece: list[Word] = []
    open_end = False
    for match in _WORD.finditer(code, start):
        text = match[0]
        if text == ",":
            pieces.append(tuple(piece))
            piece = []
            open_end = True
        else:
            piece.append(Word(text, match.start() + 1, line))
            open_end = False
    if piece:
        pieces.append(tuple(piece))
    return tuple(pieces), open_end


def statement_of(line: str, number: int, before: tuple[str, ...], offset: int = 0) -> tuple[Statement | None, str]:
    """The statement in ``line`` from index ``offset`` on, and what follows its ``;`` (if anything).

    None when there is no mnemonic.
    """
    code, behind, comment = split_code(line[offset:])
    if offset:
        code = " " * offset + code
    match = _MNEMONIC.match(code)
    if match is None:
        return None, behind
    pieces, open_end = pieces_of(code, number, match.end())
    written = match[1]
    return (
        Statement(canonical(written), written, number, match.start(1) + 1, pieces, comment, before, open_end),
        behind,
    )
