"""What is said of a word that is no instruction of the S7-200: where it comes from, and what to write here."""

from __future__ import annotations

from typing import Final

from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.foreign import GERMAN, LADDER, S7_300, SMART
from pcaccess.stl.habits import BITS_ELSEWHERE, advice
from pcaccess.stl.lexer import Statement
from pcaccess.stl.problems import Collector

_OLD_WORDS: Final = {
    "RET": "a subroutine returns at its end by itself; CRET returns while the top of the stack is 1",
    "RETI": "an interrupt routine returns at its end by itself; CRETI returns while the top of the stack is 1",
}
EXPLAINED: Final = frozenset({*GERMAN, *SMART, *S7_300, *LADDER, *_OLD_WORDS})
"""Words of other languages of PLCs: a file that has them is a program, if not one for an S7-200."""
_LONGEST_SHOWN: Final = 40


def report_unknown(statement: Statement, problems: Collector) -> None:
    mnemonic = statement.mnemonic
    span = problems.span(statement.line, statement.column, len(statement.written))
    if mnemonic in GERMAN:
        right = GERMAN[mnemonic]
        message = f"{statement.written} is the German mnemonic of {right}"
        expected = "international mnemonics (in Micro/WIN: Tools, Options, General) when the program is exported"
        problems.add("STL028", span, message, expected=expected, nearest=right)
    elif mnemonic in SMART:
        right_smart = SMART[mnemonic]
        message = f"{mnemonic} is an instruction of the S7-200 SMART; the S7-200 has "
        problems.add("STL029", span, message + (right_smart or "nothing like it"), nearest=right_smart)
    elif mnemonic in LADDER:
        message = f"{mnemonic} is the name of a box in ladder diagrams"
        problems.add("STL020", span, message, expected="the STL instruction", nearest=LADDER[mnemonic])
    elif mnemonic in S7_300 and not (mnemonic in BITS_ELSEWHERE and statement.pieces):
        message = f"{statement.written} is an instruction of the S7-300"
        problems.add("STL030", span, message, expected=f"an instruction of the S7-200: {S7_300[mnemonic]}")
    elif mnemonic in _OLD_WORDS:
        problems.add("STL020", span, f"{mnemonic} is not written here: {_OLD_WORDS[mnemonic]}")
    else:
        _report_unheard_of(statement, problems)


def _report_unheard_of(statement: Statement, problems: Collector) -> None:
    mnemonic, written = statement.mnemonic, statement.written
    words = [word for piece in statement.pieces for word in piece]
    if words and words[0].column == statement.column + len(written):
        written += words[0].text
    span = problems.span(statement.line, statement.column, len(written))
    shown = written if len(written) <= _LONGEST_SHOWN else f"{written[: _LONGEST_SHOWN - 3]}..."
    message = f"there is no instruction {shown!r}"
    known = advice(mnemonic, written, [word.text for word in words])
    if known is not None:
        problems.add("STL020", span, message, expected=known.expected, nearest=known.nearest)
        return
    expected = "an S7-200 mnemonic; a comment starts with //"
    similar = problems.nearest(mnemonic, DEFINITIONS)
    nearest = similar if similar and similar[0] == mnemonic[0] else None  # "the" is not meant as ATH
    problems.add("STL020", span, message, expected=expected, nearest=nearest)
