"""Cross reference: every address of a program with the places that read or write it.

Source:   the operands' directions in the definitions; a CALL's from the declaration of its parameters.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Final

from pcaccess.problems import Span
from pcaccess.s7200.address import Address, Area, Width
from pcaccess.stl.define import Definition, Direction, Special
from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.program import (
    AddressOf,
    Direct,
    Indirect,
    Instruction,
    Operand,
    PouKind,
    PouReference,
    Program,
    Section,
)


class Access(Enum):
    READ = "read"
    WRITE = "write"
    BOTH = "read and write"
    POINTER = "pointer"
    """The place holds the pointer through which something is read or written."""
    ADDRESS = "address"
    """Its address is taken: it may be read or written through a pointer."""


_ACCESS: Final = {Direction.IN: Access.READ, Direction.OUT: Access.WRITE, Direction.INOUT: Access.BOTH}
_SECTIONS: Final = {Section.IN: Access.READ, Section.OUT: Access.WRITE, Section.IN_OUT: Access.BOTH}


@dataclass(frozen=True, slots=True)
class Use:
    """One place where an address is used."""

    address: Address
    symbol: str | None
    access: Access
    mnemonic: str
    pou: str
    """Its block, ``OB1``."""
    network: int
    span: Span


def cross_reference(program: Program) -> list[Use]:
    """All uses, sorted by area, then address, then place in the program."""
    order = {(pou.kind, pou.number): n for n, pou in enumerate(program.pous)}
    found = list(_uses(program))
    blocks = {pou.block: order[pou.kind, pou.number] for pou in program.pous}
    found.sort(key=lambda use: (*address_order(use.address), blocks[use.pou], use.network, use.span))
    return found


_AREA_ORDER: Final = {area: n for n, area in enumerate(Area)}
_WIDTH_ORDER: Final = {width: n for n, width in enumerate(Width)}


def address_order(address: Address) -> tuple[int, int, int, int]:
    """Sorts addresses as people list them: by area, byte, width, bit."""
    return _AREA_ORDER[address.area], address.offset, _WIDTH_ORDER[address.width], address.bit


def _uses(program: Program) -> Iterator[Use]:
    for pou in program.pous:
        for network, instruction in pou.instructions():
            definition = DEFINITIONS.get(instruction.mnemonic)
            if definition is None:
                continue
            accesses = _accesses(instruction, definition, program)
            for operand, access in zip(instruction.operands, accesses, strict=False):
                yield from _of_operand(operand, access, instruction, pou.block, network.number)


def _accesses(instruction: Instruction, definition: Definition, program: Program) -> Iterator[Access]:
    for spec in definition.operands:
        if spec.type is not Special.PARAMETERS:
            yield _ACCESS[spec.direction]
            continue
        called = instruction.operands[0] if instruction.operands else None
        target = program.find(called.kind, called.number) if isinstance(called, PouReference) else None
        if target is not None and target.kind is PouKind.SBR:
            for variable in target.parameters:
                yield _SECTIONS[variable.section]
        while True:
            yield Access.READ


def _of_operand(operand: Operand, access: Access, instruction: Instruction, block: str, network: int) -> Iterator[Use]:
    if isinstance(operand, Direct):
        address, how = operand.address, access
    elif isinstance(operand, Indirect):
        address, how = operand.pointer, Access.POINTER
    elif isinstance(operand, AddressOf):
        address, how = operand.address, Access.ADDRESS
    else:
        return
    yield Use(address, operand.symbol, how, instruction.mnemonic, block, network, operand.span)
