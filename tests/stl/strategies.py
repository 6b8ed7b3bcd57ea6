"""Hypothesis strategies for whole programs as the reader makes them: any text, any operand, not always sensible."""

from __future__ import annotations

from hypothesis import strategies as st

from pcaccess.problems import Span
from pcaccess.s7200.address import Address, Area, Width, parse_address
from pcaccess.s7200.types import DataType
from pcaccess.stl.constants import spell
from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.lexer import comment_text
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import (
    AddressOf,
    Constant,
    ConstantForm,
    Direct,
    Indirect,
    Instruction,
    Network,
    Operand,
    Pou,
    PouKind,
    PouReference,
    Program,
    Section,
    Symbol,
    SymbolTable,
    Variable,
)
from pcaccess.stl.variables import read_variables

HERE = Span("generated.awl", 1, 1)
LETTERS = st.characters(exclude_categories=("C", "Z"), exclude_characters="\x85")
TEXT = st.text(st.one_of(LETTERS, st.just(" "), st.sampled_from("'\"/;,:$#&*")), max_size=20)
COMMENT = TEXT.map(lambda text: comment_text(f"// {text}"))
TITLE = TEXT.map(str.strip)
NAME = st.from_regex(r"\A[A-Za-zäÖл主][A-Za-z0-9_é序]{2,8}( [A-Za-z0-9_]{1,5}){0,2}\Z").filter(
    lambda name: not _means_something(name)
)


def _means_something(name: str) -> bool:
    try:
        parse_address(name)
    except ValueError:
        return name.upper() in ("TRUE", "FALSE", "OFF", "MAIN") or name.upper().startswith(("SBR", "INT"))
    return True


byte_addresses = st.builds(
    lambda area, offset, width, bit: Address(area, offset, width, bit if width is Width.BIT else 0),
    st.sampled_from([area for area in Area if area.is_byte_addressed]),
    st.integers(0, 12000),
    st.sampled_from(Width),
    st.integers(0, 7),
)
numbered = st.sampled_from(["T0", "T255", "C48", "HC2", "AC0", "AC3", "AIW0", "AQW62"]).map(parse_address)
addresses = st.one_of(byte_addresses, numbered)
pointers = st.sampled_from(["AC1", "AC2", "AC3", "VD0", "VD16", "LD34"]).map(parse_address)
widths = st.sampled_from([None, Width.BYTE, Width.WORD, Width.DWORD])
reals = st.floats(width=32, allow_nan=False, allow_infinity=False)
constants = st.one_of(
    st.builds(lambda v, w: Constant(v, ConstantForm.DECIMAL, "", HERE, w), st.integers(-(2**31), 2**32), widths),
    st.builds(lambda v, w: Constant(v, ConstantForm.HEX, "", HERE, w), st.integers(0, 2**32), widths),
    st.builds(lambda v, w: Constant(v, ConstantForm.BINARY, "", HERE, w), st.integers(0, 255), widths),
    st.builds(
        lambda v: Constant(v, ConstantForm.REAL, "", HERE), st.floats(width=32, allow_nan=False, allow_infinity=False)
    ),
    st.builds(lambda v: Constant(v, ConstantForm.BOOL, "", HERE), st.integers(0, 1)),
    st.builds(lambda v: Constant(v.decode("latin-1"), ConstantForm.STRING, "", HERE), st.binary(max_size=20)),
    st.builds(
        lambda raw: Constant(
            int.from_bytes(raw, "big"),
            ConstantForm.ASCII,
            "",
            HERE,
            {1: Width.BYTE, 2: Width.WORD, 4: Width.DWORD}[len(raw)],
        ),
        st.sampled_from([1, 2, 4]).flatmap(lambda n: st.binary(min_size=n, max_size=n)),
    ),
)


@st.composite
def programs(draw: st.DrawFn) -> Program:
    """A program with symbols, local variables and calls, that the reader has no problem with."""
    names = draw(st.lists(NAME, max_size=5, unique_by=str.casefold))
    symbols = [_symbol(name, draw(st.one_of(addresses, constants)), draw(COMMENT)) for name in names]
    keys = [(PouKind.MAIN, 1)]
    keys += [(PouKind.SBR, n) for n in draw(st.lists(st.integers(0, 127), max_size=2, unique=True))]
    keys += [(PouKind.INT, n) for n in draw(st.lists(st.integers(0, 127), max_size=1, unique=True))]
    pou_names = draw(
        st.lists(
            NAME.filter(lambda name: name.casefold() not in {n.casefold() for n in names}),
            min_size=len(keys),
            max_size=len(keys),
            unique_by=str.casefold,
        )
    )
    taken = {name.casefold() for name in (*names, *pou_names)}
    blocks = [PouReference(kind, number, name, HERE) for (kind, number), name in zip(keys, pou_names, strict=True)]
    pous = [_pou(draw, block, blocks, symbols, taken) for block in blocks]
    return Program(tuple(pous), SymbolTable(symbols))


def _symbol(name: str, target: Address | Constant, comment: str) -> Symbol:
    text = str(target) if isinstance(target, Address) else spell(target)
    return Symbol(" ".join(name.split()), target, text, comment.strip(), HERE)


def _pou(
    draw: st.DrawFn, block: PouReference, blocks: list[PouReference], symbols: list[Symbol], taken: set[str]
) -> Pou:
    sections = [Section.TEMP] if block.kind is not PouKind.SBR else [Section.IN, Section.OUT, Section.TEMP]
    names = draw(st.lists(NAME.filter(lambda n: n.casefold() not in taken), max_size=3, unique_by=str.casefold))
    types = [t for t in DataType if t not in (DataType.CHAR, DataType.STRING)]
    rows = [
        (draw(st.sampled_from(sections)), 1, f"{name}:{draw(st.sampled_from(types)).name}; // {draw(COMMENT)}")
        for name in names
    ]
    variables = read_variables(block.kind, rows, Collector("generated.awl"))
    operand = _operands(symbols, variables)
    networks = []
    for number in range(1, draw(st.integers(0, 3)) + 1):
        instructions = draw(st.lists(_instructions(operand, blocks), max_size=5))
        comment, after = draw(st.lists(COMMENT, max_size=2)), draw(st.lists(COMMENT, max_size=2))
        if not instructions:
            comment, after = [*comment, *after], []  # they cannot be told apart
        elif instructions[0].before:
            instructions[0] = _without_before(instructions[0])
        networks.append(Network(number, draw(COMMENT), tuple(comment), tuple(instructions), HERE, tuple(after)))
    comment = draw(st.lists(COMMENT, max_size=2))
    return Pou(block.kind, block.number, block.name, draw(TITLE), tuple(comment), variables, tuple(networks), HERE)


def _without_before(instruction: Instruction) -> Instruction:
    return Instruction(instruction.mnemonic, instruction.operands, HERE, instruction.comment)


def _operands(symbols: list[Symbol], variables: tuple[Variable, ...]) -> st.SearchStrategy[Operand]:
    ways: list[st.SearchStrategy[Operand]] = [
        addresses.map(lambda address: Direct(address, HERE)),
        pointers.map(lambda address: Indirect(address, HERE)),
        addresses.map(lambda address: AddressOf(address, HERE)),
        constants,
        st.just(Direct(parse_address("SM0.0"), HERE, "Always_On")),
    ]
    for symbol in symbols:
        target = symbol.target
        if isinstance(target, Address):
            ways += [st.just(Direct(target, HERE, symbol.name)), st.just(AddressOf(target, HERE, f"&{symbol.name}"))]
        elif isinstance(target, Constant):
            named = Constant(target.value, target.form, "", HERE, target.width, symbol.name)
            ways.append(st.just(named))
    ways += [st.just(Direct(v.address, HERE, f"#{v.name}", v.data_type)) for v in variables]
    return st.one_of(ways)


def _instructions(operand: st.SearchStrategy[Operand], blocks: list[PouReference]) -> st.SearchStrategy[Instruction]:
    plain = st.builds(
        lambda mnemonic, operands, comment, before: Instruction(
            mnemonic, tuple(operands), HERE, comment, tuple(before)
        ),
        st.sampled_from([m for m in DEFINITIONS if m not in ("CALL", "ATCH", "MEND")]),
        st.lists(operand, max_size=4),
        COMMENT,
        st.lists(COMMENT, max_size=2),
    )
    calls = st.builds(
        lambda block, operands: Instruction("ATCH" if block.kind is PouKind.INT else "CALL", (block, *operands), HERE),
        st.sampled_from(blocks),
        st.lists(operand, max_size=3),
    )
    return st.one_of(plain, calls)
