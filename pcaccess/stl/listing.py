"""A program as clean text: an ``.awl`` that Micro/WIN and this package read again as the same program.

Symbols and data block follow the blocks as comments (``//SYMBOL_TABLE`` … ``//END_SYMBOL_TABLE``), so one file holds
everything and an editor that does not know them loses nothing else. The cross reference is for people; reading
skips it.

Not here: the table of the cross reference itself (``pcaccess.stl.xref``).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from pcaccess.stl.constants import ConstantError, ascii_value, parse_number, parse_text, spell, string_value
from pcaccess.stl.datablock import parse_data_block
from pcaccess.stl.headers import header_text, keyword_of
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import (
    AddressOf,
    Constant,
    ConstantForm,
    DataRow,
    Direct,
    Indirect,
    Instruction,
    Network,
    Operand,
    Pou,
    PouReference,
    Program,
    Section,
    SymbolTable,
)
from pcaccess.stl.xref import Access, Use, cross_reference

ENCODING: Final = "utf-8"
"""Of a listing as a file."""
_SECTION_WORDS: Final = {
    Section.IN: "VAR_INPUT",
    Section.IN_OUT: "VAR_IN_OUT",
    Section.OUT: "VAR_OUTPUT",
    Section.TEMP: "VAR",
}
_MARKS: Final = {
    Access.READ: "",
    Access.WRITE: "=",
    Access.BOTH: "+",
    Access.POINTER: "*",
    Access.ADDRESS: "&",
}


def list_program(program: Program, *, references: bool = True) -> str:
    """The whole listing, lines ending in ``\\n``. ``references``: with the cross reference at the end."""
    return "\n".join((*_lines(program, references), ""))


def _lines(program: Program, references: bool) -> Iterator[str]:
    for pou in program.pous:
        yield from _pou(pou)
    if program.symbols.symbols:
        yield "//SYMBOL_TABLE"
        for symbol in program.symbols.symbols:
            yield f"//{symbol.name}\t" + "\t".join((symbol.text, symbol.comment)).rstrip("\t")
        yield "//END_SYMBOL_TABLE"
    if program.data.rows:
        yield "//DATA_BLOCK"
        for row in program.data.rows:
            yield f"//{_data_row(row, program.symbols)}"
        yield "//END_DATA_BLOCK"
    if references:
        yield "//CROSS_REFERENCE"
        yield from (f"//{line}".rstrip() for line in reference_lines(program))
        yield "//END_CROSS_REFERENCE"


def _data_row(row: DataRow, symbols: SymbolTable) -> str:
    """As written, if that gives the same bytes in a file of this encoding; otherwise byte by byte."""
    again = parse_data_block([(1, 0, row.text)], Collector(""), ENCODING, symbols)
    if again.rows == (row,):
        return row.text
    return f"VB{row.offset} " + ",".join(f"16#{byte:02X}" for byte in row.data)


def _pou(pou: Pou) -> Iterator[str]:
    yield header_text(pou.kind, pou.number, pou.name)
    yield f"TITLE={pou.title}"
    yield from map(_comment, pou.comment)
    for section, word in _SECTION_WORDS.items():
        variables = [variable for variable in pou.variables if variable.section is section]
        if variables:
            yield word
            for variable in variables:
                comment = f" {_comment(variable.comment)}" if variable.comment else ""
                yield f"{variable.name}:{variable.data_type.name};{comment}"
            yield "END_VAR"
    yield "BEGIN"
    for network in pou.networks:
        yield from _network(network)
    yield f"END_{keyword_of(pou.kind)}"


def _network(network: Network) -> Iterator[str]:
    yield f"Network {network.number} {_comment(network.title) if network.title else ''}".rstrip()
    yield from map(_comment, network.comment)
    for instruction in network.instructions:
        yield from map(_comment, instruction.before)
        yield instruction_text(instruction)
    yield from map(_comment, network.after)


def _comment(text: str) -> str:
    return f"// {text}" if text else "//"


def instruction_text(instruction: Instruction) -> str:
    """``LDW>=  T33, +40 // comment``."""
    operands = ", ".join(map(operand_text, instruction.operands))
    code = f"{instruction.mnemonic:<6} {operands}".rstrip()
    return f"{code} {_comment(instruction.comment)}" if instruction.comment else code


def operand_text(operand: Operand) -> str:
    """An operand as it is read again: by its symbol where it has one."""
    if isinstance(operand, Direct):
        return operand.symbol or str(operand.address)
    if isinstance(operand, Indirect):
        return operand.symbol or f"*{operand.pointer}"
    if isinstance(operand, AddressOf):
        return operand.symbol or f"&{operand.address}"
    if isinstance(operand, Constant):
        return operand.symbol or _constant(operand)
    return operand.name if isinstance(operand, PouReference) else operand.text


def _constant(constant: Constant) -> str:
    """As written, if that means the same in a file of this encoding; otherwise spelled with escapes."""
    try:
        return constant.text if _reads_as(constant) else spell(constant)
    except ConstantError:
        return spell(constant)


def _reads_as(constant: Constant) -> bool:
    text = constant.text
    if not text:
        return False
    if constant.form is ConstantForm.STRING:
        return text[0] == '"' and string_value(parse_text(text, ENCODING)) == constant.value
    if constant.form is ConstantForm.ASCII:
        return text[0] == "'" and ascii_value(parse_text(text, ENCODING)) == (constant.value, constant.width)
    return parse_number(text) == (constant.value, constant.form, constant.width)


def reference_lines(program: Program) -> Iterator[str]:
    """One line for each address: the address, its symbol, and ``OB1/3 =`` for each use in block/network.

    Marks: nothing reads, ``=`` writes, ``+`` does both, ``*`` is a pointer, ``&`` has its address taken.
    """
    uses = cross_reference(program)
    names = {use.address: use.symbol for use in reversed(uses) if use.symbol and use.symbol[0] not in "#*&"}
    local: dict[str, list[Use]] = {}
    for use in uses:
        key = f"{use.address} in {use.pou}" if use.address.area.value == "L" else str(use.address)
        local.setdefault(key, []).append(use)
    width = max((len(key) for key in local), default=0)
    for key, group in local.items():
        places = dict.fromkeys(f"{use.pou}/{use.network}{_MARKS[use.access]}" for use in group)
        name = names.get(group[0].address) or program.symbols.name_of(group[0].address) or ""
        label = f" ({name})" if name and not key.endswith(")") else ""
        yield f"{key:<{width}}  {' '.join(places)}{label}"
