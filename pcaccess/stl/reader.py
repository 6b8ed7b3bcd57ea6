"""A program file to a :class:`Program`: everything that is wrong with the text is collected, nothing raises.

Steps: bytes to text (``text``), lines to blocks and statements (``blocks``), declarations to local variables
(``variables``), words to operands (``operands``). What an instruction accepts is the checker's business.

Files:    ``read_program(path)`` also takes ``NAME.sym`` (symbol table) and ``NAME.db`` (data block) that lie beside
          ``NAME.awl``; both may also stand in the program file itself, as ``plc list`` writes them.
Errors:   problems in the result; OSError when the file cannot be opened, LookupError for an unknown ``encoding``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from pcaccess.problems import Problem, ProblemError, Span
from pcaccess.stl.blocks import read_blocks
from pcaccess.stl.datablock import parse_data_block, read_data_block
from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.foreign import s7_300_lines
from pcaccess.stl.lexer import Statement
from pcaccess.stl.operands import OperandReader, longest_name
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import (
    DataBlock,
    Instruction,
    Network,
    Pou,
    PouKind,
    PouReference,
    Program,
    SymbolTable,
    Unresolved,
    Variable,
)
from pcaccess.stl.rawblocks import RawBlock, RawFile
from pcaccess.stl.symbols import parse_symbols, read_symbols
from pcaccess.stl.text import NotText, decode, read
from pcaccess.stl.unknown import EXPLAINED, report_unknown
from pcaccess.stl.variables import read_variables

SYMBOL_SUFFIXES: Final = (".sym", ".SYM")
DATA_SUFFIXES: Final = (".db", ".DB")
_FOREIGN_SHOWN: Final = 4


@dataclass(frozen=True, slots=True)
class ReadResult:
    """``program`` is None when the file holds none; it may be incomplete when there are errors."""

    program: Program | None
    problems: tuple[Problem, ...]
    """In file order."""
    text: str = field(default="", repr=False)
    """The decoded text, for showing problems."""
    left_out: int = 0
    """Problems beyond the first thousand, which are not kept."""

    @property
    def ok(self) -> bool:
        return self.program is not None and not any(problem.is_error for problem in self.problems)

    def unwrap(self) -> Program:
        """The program; raises ProblemError with everything that is wrong when there is an error."""
        if self.program is None or not self.ok:
            raise ProblemError(self.problems)
        return self.program


def read_program(
    data: bytes | Path,
    *,
    file: str | None = None,
    encoding: str | None = None,
    symbols: SymbolTable | None = None,
    data_block: DataBlock | None = None,
) -> ReadResult:
    """Read a program from a file or from its bytes.

    ``file``: the name for messages. ``encoding``: forces a Python codec instead of detection, also for the
    files beside. ``symbols`` and ``data_block``: instead of those beside or inside the file.
    """
    name = file or (str(data) if isinstance(data, Path) else "program.awl")
    problems = Collector(name)
    raw = read(data) if isinstance(data, Path) else data
    try:
        decoded = decode(raw, encoding)
    except NotText as error:
        problems.add("STL002", problems.span(1, 1), str(error))
        return ReadResult(None, _sorted(problems.problems))
    lines = decoded.text.split("\n")
    if not any(line.strip() for line in lines):
        problems.add("STL001", problems.span(1, 1), "the file is empty", expected="an S7-200 program in STL")
        return ReadResult(None, _sorted(problems.problems), decoded.text)
    foreign = s7_300_lines(lines)
    if foreign:
        _report_s7_300(foreign, lines, problems)
        return ReadResult(None, _sorted(problems.problems), decoded.text)
    raw_file = read_blocks(lines, problems, DEFINITIONS)
    statements = [s.mnemonic for block in raw_file.blocks for network in block.networks for s in network.statements]
    hopeless = bool(statements) and not any(word in DEFINITIONS or word in EXPLAINED for word in statements)
    if hopeless or not raw_file.blocks:
        return ReadResult(None, (_no_program(lines, name, hopeless),), decoded.text)
    further: list[Problem] = []
    if symbols is None:
        symbols = _symbols(data, raw_file, problems, decoded.encoding, encoding, further)
    if data_block is None:
        data_block = _data_block(data, raw_file, problems, decoded.encoding, encoding, symbols, further)
    pous = _pous(raw_file, problems, symbols, decoded.encoding)
    program = Program(pous, symbols, data_block, name, decoded.encoding)
    return ReadResult(program, _sorted([*problems.problems, *further]), decoded.text, problems.left_out)


def _sorted(problems: Iterable[Problem]) -> tuple[Problem, ...]:
    return tuple(sorted(problems, key=lambda p: (p.span, p.code)))


# -- files that hold no S7-200 program


def _report_s7_300(numbers: Sequence[int], lines: Sequence[str], problems: Collector) -> None:
    def span(number: int) -> Span:
        line = lines[number - 1]
        return problems.span(number, len(line) - len(line.lstrip()) + 1, len(line.strip()))

    more = tuple((span(number), "and here") for number in numbers[1:_FOREIGN_SHOWN])
    message = "this is a program for an S7-300 or S7-400; an S7-200 has another statement list"
    expected = "an STL program exported from STEP 7-Micro/WIN"
    problems.add("STL003", span(numbers[0]), message, expected=expected, related=more)


def _no_program(lines: Sequence[str], file: str, has_words: bool) -> Problem:
    """Takes the place of everything that was found line by line."""
    problems = Collector(file)
    first = next(number for number, line in enumerate(lines, 1) if line.strip())
    line = lines[first - 1]
    span = problems.span(first, len(line) - len(line.lstrip()) + 1, len(line.strip()))
    if has_words:
        message = "no line of this file is an instruction of an S7-200"
        problems.add("STL002", span, message, expected="an STL program (.awl text)")
    else:
        problems.add("STL001", span, "there are only comments in this file", expected="an STL program")
    return problems.problems[0]


# -- symbols and data


def files_beside(program: Path) -> tuple[Path, ...]:
    """Where the symbol table and the data block of a program lie, if it has them."""
    return tuple(program.with_suffix(suffix) for suffix in (*SYMBOL_SUFFIXES, *DATA_SUFFIXES))


def _beside(data: bytes | Path, suffixes: Sequence[str]) -> Path | None:
    if not isinstance(data, Path):
        return None
    found = (data.with_suffix(suffix) for suffix in suffixes)
    return next((path for path in found if path != data and path.is_file()), None)


def _symbols(
    data: bytes | Path,
    raw: RawFile,
    problems: Collector,
    encoding: str,
    forced: str | None,
    further: list[Problem],
) -> SymbolTable:
    path = _beside(data, SYMBOL_SUFFIXES)
    inside = parse_symbols(raw.symbols, problems, encoding)
    if path is None or raw.symbols:
        return inside
    table, found = read_symbols(path, encoding=forced)
    further += found
    return table


def _data_block(
    data: bytes | Path,
    raw: RawFile,
    problems: Collector,
    encoding: str,
    forced: str | None,
    symbols: SymbolTable,
    further: list[Problem],
) -> DataBlock:
    path = _beside(data, DATA_SUFFIXES)
    inside = parse_data_block(raw.data, problems, encoding, symbols)
    if path is None or raw.data:
        return inside
    block, found = read_data_block(path, symbols=symbols, encoding=forced)
    further += found
    return block


# -- blocks


def _pous(raw: RawFile, problems: Collector, symbols: SymbolTable, encoding: str) -> tuple[Pou, ...]:
    names: dict[str, PouReference] = {}
    numbers: dict[tuple[PouKind, int], RawBlock] = {}
    kept = []
    for block in raw.blocks:
        first = numbers.setdefault((block.kind, block.number), block)
        if first is not block:
            related = ((first.span, f"{first.name} is here"),)
            message = f"there are two blocks {block.kind.value}{block.number}"
            problems.add("STL006", block.span, message, expected="one block of each number", related=related)
            continue
        same = names.get(block.name.casefold())
        if same is not None:
            message = f"{same.kind.value}{same.number} has the name {block.name} already"
            problems.add("STL006", block.span, message, expected="another name", related=((same.span, "here"),))
        else:
            names[block.name.casefold()] = PouReference(block.kind, block.number, block.name, block.span)
        kept.append(block)
    longest = longest_name(symbols, names)
    pous = []
    for block in kept:
        problems.where = f"{block.name} ({block.kind.value}{block.number})"
        variables = read_variables(block.kind, block.declarations, problems)
        operands = OperandReader(problems, encoding, symbols, names, variables, longest)
        pous.append(_pou(block, problems, variables, operands))
    return tuple(pous)


def _pou(block: RawBlock, problems: Collector, variables: tuple[Variable, ...], operands: OperandReader) -> Pou:
    label = problems.where
    networks = []
    for network in block.networks:
        problems.where = f"{label}, network {network.number}"
        instructions = tuple(
            instruction
            for statement in network.statements
            for instruction in _instructions(statement, operands, problems)
        )
        networks.append(
            Network(
                network.number,
                network.title,
                tuple(network.comment),
                instructions,
                network.span,
                tuple(network.after),
            )
        )
    problems.where = ""
    return Pou(
        block.kind,
        block.number,
        block.name,
        block.title,
        tuple(block.comment),
        variables,
        tuple(networks),
        block.span,
    )


def _instructions(statement: Statement, operands: OperandReader, problems: Collector) -> Iterator[Instruction]:
    """One, as a rule; where somebody wrote several on a line, each of them, so that nothing follows from it."""
    rest: Statement | None = statement
    while rest is not None:
        statement, rest = rest, None
        definition = DEFINITIONS.get(statement.mnemonic)
        if definition is not None and (any(len(piece) > 1 for piece in statement.pieces) or not definition.operands):
            statement, rest = operands.cut(statement, at_once=not definition.operands)
        if rest is not None:
            span = problems.span(rest.line, rest.column, len(rest.written))
            message = f"another instruction, {rest.written}, begins here"
            problems.add("STL037", span, message, expected="one instruction on a line")
        yield _instruction(statement, operands, problems)


def _instruction(statement: Statement, operands: OperandReader, problems: Collector) -> Instruction:
    mnemonic = statement.mnemonic
    span = problems.span(statement.line, statement.column, len(statement.written))
    if mnemonic not in DEFINITIONS:
        report_unknown(statement, problems)
        words = tuple(
            Unresolved(" ".join(word.text for word in piece), problems.span(piece[0].line, piece[0].column))
            for piece in statement.pieces
            if piece
        )
        return Instruction(mnemonic, words, span, statement.comment, statement.before)
    found = operands.read(statement)
    if statement.open_end:
        message = f"an operand of {mnemonic} is missing behind the last comma"
        problems.add("STL031", span, message, expected="one operand between two commas")
    return Instruction(mnemonic, found, span, statement.comment, statement.before)
