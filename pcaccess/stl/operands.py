"""Words of an operand to what they name: addresses, constants, pointers, symbols, subroutines.

Blanks separate operands (``MOVB 3 VB500``) but may also belong to a name (``Pump motor``). Between two commas the
longest known name wins; words that mean something by themselves are operands; the rest is one unknown name.

Errors:   collected; an operand that cannot be understood is ``Unresolved``.
Source:   Micro/WIN editor grammar for the forms; System Manual, "Indirect addressing", for ``*`` and ``&``.
Not here: which operands an instruction takes (``pcaccess.stl.check_operands``).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Final

from pcaccess.problems import Span
from pcaccess.s7200.address import Address, AddressError, Area, Width, parse_address
from pcaccess.s7200.types import DataType
from pcaccess.stl.constants import ConstantError, Number, ascii_value, parse_number, parse_text, string_value
from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.headers import parse_block_name
from pcaccess.stl.lexer import Piece, Statement, Word, canonical
from pcaccess.stl.predefined import PREDEFINED
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import (
    AddressOf,
    Constant,
    ConstantForm,
    Direct,
    Indirect,
    Operand,
    PouKind,
    PouReference,
    SymbolTable,
    Unresolved,
    Variable,
)

_POU_OPERANDS: Final = {"CALL": PouKind.SBR, "ATCH": PouKind.INT}
"""Instructions whose first operand is a block."""
_LIKE_ADDRESS: Final = re.compile(r"[A-Z]{1,3}\d[\dO.]*", re.IGNORECASE | re.ASCII)
_POINTERS: Final = "AC1, AC2, AC3, a VD or an LD address"
_TYPOGRAPHIC: Final = {
    "，": ",",
    "；": ";",
    "：": ":",
    "‘": "'",
    "’": "'",
    "“": '"',
    "”": '"',
    "＃": "#",
    "＋": "+",
    "＊": "*",
}


@lru_cache(maxsize=20_000)
def _address(text: str) -> Address | None:
    try:
        return parse_address(text)
    except AddressError:
        return None


@lru_cache(maxsize=20_000)
def _number(text: str) -> Number | ConstantError | None:
    try:
        return parse_number(text)
    except ConstantError as error:
        return error


def longest_name(symbols: SymbolTable, pous: Mapping[str, PouReference]) -> int:
    """Words of the longest name of a program: so many may belong together."""
    return max((len(name.split()) for name in (*symbols.names(), *pous)), default=1)


class OperandReader:
    """Reads the operands of one POU."""

    def __init__(
        self,
        problems: Collector,
        encoding: str,
        symbols: SymbolTable,
        pous: Mapping[str, PouReference],
        variables: Iterable[Variable],
        longest: int,
    ) -> None:
        """``pous``: blocks of the program by casefolded name; ``longest``: see :func:`longest_name`."""
        self._problems = problems
        self._encoding = encoding
        self._symbols = symbols
        self._pous = pous
        self._locals = {variable.name.casefold(): variable for variable in variables}
        self._longest = max(longest, max((len(name.split()) for name in self._locals), default=1))

    def read(self, statement: Statement) -> tuple[Operand, ...]:
        operands: list[Operand] = []
        block = _POU_OPERANDS.get(statement.mnemonic)
        for piece in statement.pieces:
            if not piece:
                span = self._problems.span(statement.line, statement.column, len(statement.written))
                message = f"an operand of {statement.mnemonic} is missing between two commas"
                self._problems.add("STL031", span, message, expected="one operand between two commas")
                operands.append(Unresolved("", span))
                continue
            for word in [piece[0]] if len(piece) == 1 else self._words(piece):
                kind = block if not operands else None
                operands.append(self._block(word, kind) if kind else self._operand(word))
        return tuple(operands)

    # -- blanks

    def cut(self, statement: Statement, *, at_once: bool) -> tuple[Statement, Statement | None]:
        """The statement up to where another instruction begins on its line, and that one.

        ``at_once``: the instruction has no operands, so that any word behind it may be the next. A word that is an
        instruction counts as one when it can be nothing else: what stands before it is understood, or what follows.
        """
        understood = True
        for number, piece in enumerate(statement.pieces):
            at = 0
            while at < len(piece):
                size = self._name_at(piece, at)
                word = canonical(piece[at].text)
                may_begin = word in DEFINITIONS and (at_once or number or at) and size < 2
                if may_begin and (size == 0 or (word == "ON" and at and statement.mnemonic != "CALL")):
                    follows = at + 1 < len(piece) and self._name_at(piece, at + 1) > 0
                    if understood or follows:
                        return _cut(statement, number, at)
                understood = understood and size > 0
                at += max(1, size)
        return statement, None

    def _words(self, piece: Piece) -> list[Word]:
        """The operands between two commas, each with its blanks."""
        found: list[Word] = []
        unknown: list[Word] = []
        at = 0
        while at < len(piece):
            size = self._name_at(piece, at)
            if size == 0:
                unknown.append(piece[at])
                at += 1
                continue
            if unknown:
                found.append(_join(unknown))
                unknown = []
            found.append(_join(piece[at : at + size]))
            at += size
        if unknown:
            found.append(_join(unknown))
        return found

    def _name_at(self, piece: Piece, at: int) -> int:
        """How many words from ``at`` on are one operand; 0 when none is known to be one."""
        for size in range(min(self._longest, len(piece) - at), 1, -1):
            if self._is_name(" ".join(word.text for word in piece[at : at + size])):
                return size
        text = piece[at].text
        first = text[0]
        if first in "'\"" or (first in "*&" and _address(text[1:]) is not None) or _number(text) is not None:
            return 1
        return 1 if _address(text) is not None or self._is_name(text) or parse_block_name(text) else 0

    def _is_name(self, text: str) -> bool:
        folded = text.lstrip("*&").casefold()
        if folded.startswith("#"):
            return folded[1:] in self._locals
        known = folded in self._pous or folded in self._locals or folded in PREDEFINED
        return known or self._symbols.find(folded) is not None

    # -- one operand

    def _operand(self, word: Word) -> Operand:
        text = word.text
        span = self._problems.span(word.line, word.column, len(text))
        first = text[0]
        if first.isalpha():
            address = _address(text)
            if address is not None and address.count == 1:
                return Direct(address, span)
        elif first in "'\"":
            return self._text(text, span)
        elif first == "*":
            return self._indirect(text, span)
        elif first == "&":
            return self._address_of(text, span)
        elif first == "#":
            return self._local(text, span)
        number = _number(text)
        if isinstance(number, Number):
            return Constant(number.value, number.form, text, span, number.width)
        if isinstance(number, ConstantError):
            return self._unresolved("STL034", text, span, str(number))
        return self._named(text, span)

    def _named(self, text: str, span: Span) -> Operand:
        folded = text.casefold()
        symbol = self._symbols.find(folded)
        if symbol is not None:
            target = symbol.target
            if isinstance(target, Address):
                return Direct(target, span, symbol.name)
            if isinstance(target, Constant):
                return Constant(target.value, target.form, target.text, span, target.width, symbol.name)
            if isinstance(target, PouReference):
                return PouReference(target.kind, target.number, text, span)
            if symbol.text:  # its row has a problem of its own
                return Unresolved(text, span)
            return self._unresolved("STL032", text, span, f"{symbol.name} has no address in the symbol table")
        if folded in self._locals:
            return _variable(self._locals[folded], span)
        if folded in self._pous:
            known = self._pous[folded]
            return PouReference(known.kind, known.number, known.name, span)
        predefined = PREDEFINED.get(folded)
        if predefined is not None:
            return Direct(predefined.address, span, predefined.name)
        return self._unknown(text, span)

    def _unknown(self, text: str, span: Span) -> Operand:
        odd = next((c for c in text if c in _TYPOGRAPHIC), None)
        if odd is not None:
            return self._unresolved("STL031", text, span, f"{odd!r} in {text}", expected=f"{_TYPOGRAPHIC[odd]!r}")
        if _LIKE_ADDRESS.fullmatch(text):
            try:
                parse_address(text)
                return self._unresolved("STL031", text, span, f"{text} is a row of addresses", expected="one address")
            except AddressError as error:
                return self._unresolved("STL031", text, span, str(error), nearest=_with_digits(text))
        if not text[0].isalpha() and text[0] != "_":
            message = f"{text!r} is no operand"
            return self._unresolved("STL031", text, span, message, expected="an address, a constant or a symbol")
        names = (*self._symbols.names(), *(predefined.name for predefined in PREDEFINED.values()))
        nearest = _with_digits(text) or self._problems.nearest(text, names)
        message = f"there is no symbol {text!r}"
        expected = "a symbol of the symbol table, an address or a constant"
        return self._unresolved("STL032", text, span, message, expected=expected, nearest=nearest)

    def _local(self, text: str, span: Span) -> Operand:
        variable = self._locals.get(text[1:].casefold())
        if variable is not None:
            return _variable(variable, span)
        names = [f"#{v.name}" for v in self._locals.values()]
        expected = ", ".join(names[:8]) if names else "a variable declared at the head of this block; there is none"
        nearest = self._problems.nearest(text, names)
        message = f"there is no local variable {text}"
        return self._unresolved("STL033", text, span, message, expected=expected, nearest=nearest)

    def _text(self, text: str, span: Span) -> Operand:
        try:
            raw = parse_text(text, self._encoding)
            if text[0] == '"':
                return Constant(string_value(raw), ConstantForm.STRING, text, span)
            value, width = ascii_value(raw)
        except ConstantError as error:
            return self._unresolved("STL034", text, span, str(error))
        return Constant(value, ConstantForm.ASCII, text, span, width)

    def _target(self, text: str, span: Span) -> Direct | None:
        """What stands behind ``*`` or ``&``; None when it is no address (then reported)."""
        inner = Span(span.file, span.line, span.column + 1, max(1, len(text) - 1))
        rest = text[1:].strip()
        if not rest:
            self._unresolved("STL031", text, span, f"nothing stands behind {text}", expected=f"{text}VB0 or the like")
            return None
        address = _address(rest)
        if address is not None and address.count == 1:
            return Direct(address, span)
        found = self._local(rest, inner) if rest[0] == "#" else self._named(rest, inner)
        if isinstance(found, Direct):
            return found
        if not isinstance(found, Unresolved):
            self._unresolved("STL027", text, span, f"{rest} has no address", expected="an address behind * and &")
        return None

    def _indirect(self, text: str, span: Span) -> Operand:
        target = self._target(text, span)
        if target is None:
            return Unresolved(text, span)
        pointer = target.address
        is_word = pointer.width is Width.DWORD and pointer.area in (Area.V, Area.L)
        if not is_word and not (pointer.area is Area.AC and 1 <= pointer.offset <= 3):
            message = f"{pointer} cannot be a pointer"
            return self._unresolved("STL027", text, span, message, expected=_POINTERS)
        return Indirect(pointer, span, f"*{target.symbol}" if target.symbol else None)

    def _address_of(self, text: str, span: Span) -> Operand:
        target = self._target(text, span)
        if target is None:
            return Unresolved(text, span)
        return AddressOf(target.address, span, f"&{target.symbol}" if target.symbol else None)

    def _block(self, word: Word, kind: PouKind) -> Operand:
        """The first operand of CALL and ATCH: a block by name or number."""
        text = word.text
        span = self._problems.span(word.line, word.column, len(text))
        known = self._pous.get(text.casefold())
        if known is None:
            block = parse_block_name(text)
            if block is not None:
                return PouReference(*block, text, span)
            if text.isascii() and text.isdigit() and len(text) < 5:
                return PouReference(kind, int(text), f"{kind.value}_{text}", span)
            symbol = self._symbols.find(text)
            if symbol is not None and isinstance(symbol.target, PouReference):
                return PouReference(symbol.target.kind, symbol.target.number, symbol.name, span)
            names = [p.name for p in self._pous.values() if p.kind is kind]
            what = "subroutine" if kind is PouKind.SBR else "interrupt routine"
            message = f"there is no {what} {text!r}"
            expected = ", ".join(names[:8]) if names else "one of this program; it has none"
            nearest = self._problems.nearest(text, names)
            return self._unresolved("STL080", text, span, message, expected=expected, nearest=nearest)
        return PouReference(known.kind, known.number, known.name, span)

    def _unresolved(
        self, code: str, text: str, span: Span, message: str, *, expected: str = "", nearest: str | None = None
    ) -> Unresolved:
        self._problems.add(code, span, message, expected=expected, nearest=nearest)
        return Unresolved(text, span)


def _with_digits(text: str) -> str | None:
    """The address somebody meant who took O for 0 or l for 1, as scanned listings have it."""
    digits = text[0] + text[1:].upper().replace("O", "0").replace("L", "1").replace("I", "1")
    return digits if digits != text and _address(digits) is not None else None


def _cut(statement: Statement, number: int, at: int) -> tuple[Statement, Statement]:
    """Before and from word ``at`` of piece ``number`` on."""
    piece = statement.pieces[number]
    word, rest = piece[at], piece[at + 1 :]
    first = (*statement.pieces[:number], *([piece[:at]] if at else []))
    second = (*([rest] if rest else []), *statement.pieces[number + 1 :])
    return (
        statement._replace(pieces=first, open_end=False),
        Statement(canonical(word.text), word.text, word.line, word.column, second, "", (), statement.open_end),
    )


def _variable(variable: Variable, span: Span) -> Operand:
    if variable.data_type is DataType.STRING:
        return Indirect(variable.address, span, f"#{variable.name}")
    return Direct(variable.address, span, f"#{variable.name}", variable.data_type)


def _join(words: Iterable[Word]) -> Word:
    parts = list(words)
    if len(parts) == 1:
        return parts[0]
    return Word(" ".join(word.text for word in parts), parts[0].column, parts[0].line)
