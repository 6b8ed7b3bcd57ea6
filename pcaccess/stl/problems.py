"""Everything that can be wrong with an STL program, a symbol table or a data block: one row per code.

001-019 the file and its blocks · 020-039 instructions and operands · 040-049 symbols and data block ·
050-069 structure · 070-079 timers, counters, coils · 080-089 calls and interrupts.

See:      ``docs/problems/STLnnn.md`` for each.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from pcaccess.problems import Kind, Problem, Register, Severity, Span, nearest_word

STL: Final = Register(
    {
        "STL001": Kind("there is no program in the file"),
        "STL002": Kind("the file is not an STL text"),
        "STL003": Kind("a program for another kind of PLC"),
        "STL004": Kind("the file is cut off or a block is not closed"),
        "STL005": Kind("wrong block header"),
        "STL006": Kind("two blocks with the same number or name"),
        "STL007": Kind("text outside of every block"),
        "STL008": Kind("wrong network header"),
        "STL009": Kind("network numbers do not ascend", Severity.WARNING),
        "STL010": Kind("block headers are missing; a comment was taken for one", Severity.WARNING),
        "STL011": Kind("wrong variable declaration"),
        "STL012": Kind("a local variable is declared twice"),
        "STL013": Kind("too many local variables"),
        "STL014": Kind("wrong kind of variable for this block"),
        "STL015": Kind("instructions behind the end of the block"),
        "STL020": Kind("unknown instruction"),
        "STL021": Kind("wrong operand type"),
        "STL022": Kind("wrong memory area"),
        "STL023": Kind("wrong number of operands"),
        "STL024": Kind("the address does not exist on this CPU"),
        "STL025": Kind("the constant does not fit"),
        "STL026": Kind("a constant cannot stand here"),
        "STL027": Kind("wrong use of a pointer"),
        "STL028": Kind("German mnemonic"),
        "STL029": Kind("instruction of the S7-200 SMART"),
        "STL030": Kind("instruction of the S7-300"),
        "STL031": Kind("operand not understood"),
        "STL032": Kind("unknown symbol"),
        "STL033": Kind("unknown local variable"),
        "STL034": Kind("wrong text constant"),
        "STL035": Kind("text behind the instruction was taken for a comment", Severity.WARNING),
        "STL036": Kind("the CPU does not have this"),
        "STL037": Kind("two instructions on one line"),
        "STL040": Kind("wrong row in the symbol table"),
        "STL041": Kind("a symbol is defined twice"),
        "STL042": Kind("the name cannot be used for a symbol"),
        "STL045": Kind("wrong row in the data block"),
        "STL046": Kind("the value does not fit into its place in the data block"),
        "STL047": Kind("the data block writes a byte twice", Severity.WARNING),
        "STL048": Kind("the data block goes beyond V memory"),
        "STL050": Kind("the logic stack holds too few values"),
        "STL051": Kind("the logic stack holds too many values"),
        "STL052": Kind("the network starts without a load", Severity.WARNING),
        "STL053": Kind("LPS, LRD and LPP do not match"),
        "STL054": Kind("FOR and NEXT do not match"),
        "STL055": Kind("FOR loops are nested too deeply"),
        "STL056": Kind("the jump has no label"),
        "STL057": Kind("a label is used twice"),
        "STL058": Kind("a jump into or out of an SCR segment"),
        "STL059": Kind("LSCR and SCRE do not match"),
        "STL060": Kind("the instruction cannot stand in this block"),
        "STL061": Kind("the network has no output", Severity.WARNING),
        "STL062": Kind("too many edge instructions"),
        "STL070": Kind("different timer instructions on one timer"),
        "STL071": Kind("a timer or counter is used twice", Severity.WARNING),
        "STL072": Kind("a coil is used twice", Severity.WARNING),
        "STL073": Kind("the timer number does not fit the instruction"),
        "STL080": Kind("unknown subroutine or interrupt routine"),
        "STL081": Kind("wrong number of call parameters"),
        "STL082": Kind("wrong type of a call parameter"),
        "STL083": Kind("a subroutine calls itself", Severity.WARNING),
        "STL084": Kind("calls are nested too deeply"),
        "STL085": Kind("the main program is missing"),
    }
)

MAX_PROBLEMS: Final = 1000
"""Of each severity. A file with more is hardly a program; the rest is counted, not kept."""
_NEAREST_BUDGET: Final = 200
"""Looking for a similar word takes a millisecond or so; a hopeless file must not take minutes."""


class Collector:
    """Gathers the problems of one file while it is read.

    ``where`` is the place in the user's terms that the next problems get: ``MAIN (OB1), network 3``.
    """

    def __init__(self, file: str) -> None:
        self.file = file
        self.where = ""
        self.problems: list[Problem] = []
        self.left_out = 0
        self._room = {Severity.ERROR: MAX_PROBLEMS, Severity.WARNING: MAX_PROBLEMS}
        self._budget = _NEAREST_BUDGET

    def span(self, line: int, column: int, length: int = 1) -> Span:
        return Span(self.file, line, column, max(1, length))

    def add(
        self,
        code: str,
        span: Span,
        message: str,
        *,
        expected: str = "",
        nearest: str | None = None,
        related: tuple[tuple[Span, str], ...] = (),
        where: str | None = None,
    ) -> None:
        severity = STL[code].severity
        if self._room[severity] <= 0:  # warnings must not crowd out errors
            self.left_out += 1
            return
        self._room[severity] -= 1
        place = self.where if where is None else where
        self.problems.append(
            STL.problem(code, span, message, expected=expected, nearest=nearest, related=related, where=place)
        )

    def nearest(self, word: str, words: Iterable[str]) -> str | None:
        """The most similar word, for the first problems of a file."""
        if self._budget <= 0 or len(word) > 40:
            return None
        self._budget -= 1
        return nearest_word(word, words)
