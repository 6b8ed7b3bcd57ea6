"""A program as the user wrote it: POUs, networks, instructions, operands, each with its place in the text.

The reader makes these objects with all symbols resolved; checker, lowering, listing, cross reference and ladder
view take them. Two programs are equal when they say the same: places (``span``), spellings (``text``), file and
encoding take no part in comparing.

Units:    addresses are ``pcaccess.s7200.address.Address``; a local variable is an L address.
Source:   docs/stl.md; System Manual, "Understanding the basic elements of a program".
Not here: reading (``pcaccess.stl.reader``), what an instruction accepts (``pcaccess.stl.define``).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from types import MappingProxyType

from pcaccess.problems import Span
from pcaccess.s7200.address import Address, Width
from pcaccess.s7200.types import DataType


class ConstantForm(Enum):
    """How a constant is written; the value is the word for messages."""

    DECIMAL = "decimal"
    HEX = "hexadecimal"
    BINARY = "binary"
    REAL = "real"
    ASCII = "ASCII"
    STRING = "string"
    BOOL = "Boolean"


@dataclass(frozen=True, slots=True)
class Constant:
    """A number or a text in the program.

    ``value``: int as written (``-5`` is -5, ``16#FFFF`` is 65535); float for REAL; for ASCII the characters as one
    big-endian number (``'AB'`` is 16#4142); the text without its length byte for STRING; 0 or 1 for BOOL.
    ``width``: fixed by the text only for ``B# W# DW#`` and ASCII; None elsewhere.
    ``symbol``: the name it was written as, when a symbol stands for a constant.
    """

    value: int | float | str
    form: ConstantForm
    text: str = field(compare=False)
    span: Span = field(compare=False, repr=False)
    width: Width | None = None
    symbol: str | None = None


@dataclass(frozen=True, slots=True)
class Direct:
    """A place in memory, ``VW2``. T and C come as ``parse_address`` gives them (their value, width WORD);
    ``address.as_type(BOOL)`` names the bit.

    ``symbol``: the name it was written as (a local one with its ``#``); ``declared``: a local variable's type.
    """

    address: Address
    span: Span = field(compare=False, repr=False)
    symbol: str | None = None
    declared: DataType | None = None


@dataclass(frozen=True, slots=True)
class Indirect:
    """``*AC1 *VD16 *LD34``: the place that ``pointer`` points to.

    A local STRING is one too: its L address holds a pointer to the text. ``symbol``: as written, with its ``*``.
    """

    pointer: Address
    span: Span = field(compare=False, repr=False)
    symbol: str | None = None


@dataclass(frozen=True, slots=True)
class AddressOf:
    """``&VB100``: a pointer to ``address``. ``symbol``: as written, with its ``&``."""

    address: Address
    span: Span = field(compare=False, repr=False)
    symbol: str | None = None


class PouKind(Enum):
    """The value is what stands after the colon of a block header, before its number."""

    MAIN = "OB"
    SBR = "SBR"
    INT = "INT"


@dataclass(frozen=True, slots=True)
class PouReference:
    """A subroutine or an interrupt routine as operand of CALL or ATCH; it may not exist (the checker says so)."""

    kind: PouKind
    number: int
    name: str = field(compare=False)
    span: Span = field(compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Unresolved:
    """An operand that could not be understood; its problem has been reported."""

    text: str
    span: Span = field(compare=False, repr=False)


Operand = Constant | Direct | Indirect | AddressOf | PouReference | Unresolved


@dataclass(frozen=True, slots=True)
class Instruction:
    """``mnemonic`` is the SIMATIC English one in capitals (``LDW>=``); ``span`` is the mnemonic's place."""

    mnemonic: str
    operands: tuple[Operand, ...]
    span: Span = field(compare=False, repr=False)
    comment: str = ""
    """What follows ``//`` on the same line."""
    before: tuple[str, ...] = ()
    """Comment lines between the previous instruction and this one."""


@dataclass(frozen=True, slots=True)
class Network:
    number: int
    title: str
    comment: tuple[str, ...]
    """The comment lines between the header and the first instruction."""
    instructions: tuple[Instruction, ...]
    span: Span = field(compare=False, repr=False)
    after: tuple[str, ...] = ()
    """Comment lines behind the last instruction."""


class Section(Enum):
    """Where a local variable is declared; the value is the word of Micro/WIN's variable table."""

    IN = "IN"
    IN_OUT = "IN_OUT"
    OUT = "OUT"
    TEMP = "TEMP"


@dataclass(frozen=True, slots=True)
class Variable:
    """A local variable; ``address`` is computed from the order of declaration (docs/stl.md)."""

    name: str
    section: Section
    data_type: DataType
    address: Address
    comment: str
    span: Span = field(compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Pou:
    kind: PouKind
    number: int
    """0..63 and up for SBR, 0..127 for INT, 1 for the main program (OB1)."""
    name: str
    title: str
    comment: tuple[str, ...]
    """Comment lines between TITLE and the first network."""
    variables: tuple[Variable, ...]
    networks: tuple[Network, ...]
    span: Span = field(compare=False, repr=False)

    @property
    def block(self) -> str:
        """``OB1``, ``SBR0``, ``INT3``."""
        return f"{self.kind.value}{self.number}"

    @property
    def parameters(self) -> tuple[Variable, ...]:
        """What a CALL passes, in its order: IN, IN_OUT, OUT."""
        return tuple(v for section in _PARAMETERS for v in self.variables if v.section is section)

    def where(self, network: Network | None = None) -> str:
        """For messages: ``MAIN (OB1), network 3``."""
        label = self.block if self.name == self.block else f"{self.name} ({self.block})"
        return label if network is None else f"{label}, network {network.number}"

    def instructions(self) -> Iterator[tuple[Network, Instruction]]:
        """All instructions in the order they are executed, each with its network."""
        for network in self.networks:
            for instruction in network.instructions:
                yield network, instruction


_PARAMETERS = (Section.IN, Section.IN_OUT, Section.OUT)


@dataclass(frozen=True, slots=True)
class Symbol:
    """One row of a symbol table; ``target`` is None when its text could not be understood (reported)."""

    name: str
    target: Address | Constant | PouReference | None
    text: str
    comment: str
    span: Span = field(compare=False, repr=False)


class SymbolTable:
    """Global symbols by name (without regard to case), and names by what they stand for."""

    __slots__ = ("_by_address", "_by_name", "symbols")

    def __init__(self, symbols: Iterable[Symbol] = ()) -> None:
        """Of two symbols with one name the first counts (the reader reports the second)."""
        self.symbols = tuple(symbols)
        self._by_name: dict[str, Symbol] = {}
        self._by_address: dict[Address, Symbol] = {}
        for symbol in self.symbols:
            self._by_name.setdefault(symbol.name.casefold(), symbol)
            if isinstance(symbol.target, Address):
                self._by_address.setdefault(symbol.target, symbol)

    def __len__(self) -> int:
        return len(self.symbols)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, SymbolTable) and self.symbols == other.symbols

    def __hash__(self) -> int:
        return hash(self.symbols)

    def __repr__(self) -> str:
        return f"SymbolTable({len(self.symbols)} symbols)"

    def find(self, name: str) -> Symbol | None:
        return self._by_name.get(name.casefold())

    def name_of(self, address: Address) -> str | None:
        symbol = self._by_address.get(address)
        return symbol.name if symbol else None

    def names(self) -> list[str]:
        return [symbol.name for symbol in self.symbols]


@dataclass(frozen=True, slots=True)
class DataRow:
    """Initial values: ``data`` as it lies in V memory from byte ``offset``; ``text`` is the line as written."""

    offset: int
    data: bytes
    text: str = field(compare=False)
    span: Span = field(compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class DataBlock:
    """What the CPU copies into V memory when the program is downloaded."""

    rows: tuple[DataRow, ...] = ()

    def write_to(self, v_memory: bytearray | memoryview) -> None:
        """Put all rows in, in order; ``v_memory`` is area V alone. Rows beyond its end are left out."""
        for row in self.rows:
            if row.offset + len(row.data) <= len(v_memory):
                v_memory[row.offset : row.offset + len(row.data)] = row.data


@dataclass(frozen=True, slots=True)
class Program:
    """A whole program. POUs stand in the order of the file."""

    pous: tuple[Pou, ...]
    symbols: SymbolTable = field(default_factory=SymbolTable)
    data: DataBlock = field(default_factory=DataBlock)
    file: str = field(default="", compare=False)
    encoding: str = field(default="utf-8", compare=False)
    _index: Mapping[tuple[PouKind, int], Pou] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        index: dict[tuple[PouKind, int], Pou] = {}
        for pou in self.pous:
            index.setdefault((pou.kind, pou.number), pou)
        object.__setattr__(self, "_index", MappingProxyType(index))

    def find(self, kind: PouKind, number: int) -> Pou | None:
        return self._index.get((kind, number))

    @property
    def main(self) -> Pou:
        """OB1; the checker refuses a program without one, so KeyError here is our own mistake."""
        return self._index[PouKind.MAIN, 1]

    def subroutine(self, number: int) -> Pou | None:
        return self.find(PouKind.SBR, number)

    def interrupt(self, number: int) -> Pou | None:
        return self.find(PouKind.INT, number)
