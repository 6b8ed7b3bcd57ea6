"""Statements on a line: usually one, several with ``;``, or the rest of one that ended with a comma.

Errors:   collected; a line that is no statement adds none.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Final

from pcaccess.stl.headers import parse_block_name
from pcaccess.stl.lexer import Statement, canonical, comment_text, first_word, pieces_of, split_code, statement_of
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import PouKind

MAX_OPERANDS: Final = 64
"""No instruction has more; a statement that would is not continued on the next line."""


class StatementReader:
    def __init__(self, problems: Collector, known: Collection[str]) -> None:
        """``known``: all mnemonics, needed to tell an instruction from other words where a line can be both."""
        self._problems = problems
        self._known = known
        self.called: set[tuple[PouKind, int]] = set()
        """Blocks that a CALL or ATCH has named so far."""

    def read(self, number: int, line: str, before: tuple[str, ...]) -> list[Statement]:
        """The statements of a line; the first one gets the comment lines ``before`` it."""
        found: list[Statement] = []
        offset = 0
        while offset >= 0:
            statement, behind = statement_of(line, number, () if found else before, offset)
            if statement is None:
                self.refuse(number, line, offset)
                break
            offset = -1
            text = behind.strip()
            if text.startswith("//"):
                statement = statement._replace(comment=comment_text(text))
            elif canonical(first_word(behind)) in self._known:
                offset = len(line) - len(behind)
            elif text:
                span = self._problems.span(number, len(line) - len(behind.lstrip()) + 1, len(text))
                self._problems.add("STL035", span, "text behind ';'", expected="// before a comment")
                statement = statement._replace(comment=text)
            self._note_call(statement)
            found.append(statement)
        return found

    def _note_call(self, statement: Statement) -> None:
        if statement.mnemonic in ("CALL", "ATCH") and statement.pieces and statement.pieces[0]:
            called = parse_block_name(statement.pieces[0][0].text)
            if called is not None:
                self.called.add(called)

    def goes_on(self, last: Statement, line: str) -> bool:
        """``last`` ends with a comma, and this line is no instruction of its own."""
        if not last.open_end or len(last.pieces) >= MAX_OPERANDS:
            return False
        word = first_word(line)
        follows = line.strip()[len(word) :].strip()
        return canonical(word) not in self._known or not follows or follows.startswith(",")

    def continued(self, last: Statement, number: int, line: str) -> Statement:
        """``last`` with the operands and the comment of this line."""
        code, _, comment = split_code(line)
        pieces, open_end = pieces_of(code, number)
        text = " ".join(part for part in (last.comment, comment) if part)
        return last._replace(pieces=last.pieces + pieces, comment=text, open_end=open_end)

    def refuse(self, number: int, line: str, offset: int = 0) -> None:
        """Report that what stands at ``offset`` is no instruction."""
        text = line[offset:].strip()
        span = self._problems.span(number, line.index(text, offset) + 1, len(text))
        message = f"{shortened(text)} is not an instruction"
        self._problems.add("STL020", span, message, expected="a mnemonic; a comment starts with //")


def shortened(text: str) -> str:
    """A line quoted in a message."""
    plain = text.strip()
    return repr(plain if len(plain) <= 40 else plain[:37] + "...")
