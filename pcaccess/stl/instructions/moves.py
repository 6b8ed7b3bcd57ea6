"""Moves: single values, blocks, fill, swap, immediate bytes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.memory import AREA_START
from pcaccess.s7200.types import DataType
from pcaccess.stl import ir, layout
from pcaccess.stl.builder import Place
from pcaccess.stl.define import SAME, In, InOut, Out, define
from pcaccess.stl.errors import INDIRECT_ADDRESS, OPERAND_RANGE
from pcaccess.stl.instructions.room import room
from pcaccess.stl.ir_values import IrType, Value
from pcaccess.stl.routine import Routine

_IMAGE_SIZE: Final = 16

BYTE, INT, WORD, DWORD, REAL = DataType.BYTE, DataType.INT, DataType.WORD, DataType.DWORD, DataType.REAL


@define(
    {"MOVB": (BYTE,), "MOVW": (WORD,), "MOVR": (REAL,)},
    group="Move",
    operands=(In("IN", SAME, raw=True), Out("OUT", SAME)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Move",
)
def move(b: Routine, kind: DataType, value: Value, out: Place) -> None:
    """Copy IN to OUT, bit for bit."""
    b.store(out, value)
    b.eno(True)


@define(
    {"MOVD": (DWORD,)},
    group="Move",
    operands=(In("IN", SAME, address_of=True), Out("OUT", SAME)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Move; Indirect addressing",
)
def move_double(b: Routine, kind: DataType, value: Value, out: Place) -> None:
    """Copy IN to OUT; IN may be the address of something (``&VB100``), which makes OUT a pointer to it."""
    b.store(out, value)
    b.eno(True)


@define(
    {"BMB": (BYTE,), "BMW": (WORD,), "BMD": (DWORD,)},
    group="Move",
    operands=(
        In("IN", SAME, constant=False, block=True),
        Out("OUT", SAME, block=True),
        In("N", BYTE, low=1, high=255),
    ),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source="System Manual, Block move",
)
def block_move(b: Routine, kind: DataType, source: Place, out: Place, count: Value) -> None:
    """Copy N values from IN on to OUT on. The two may overlap.

    When some of the values do not exist, or N is 0, nothing happens but error 0091.
    """
    size = b.binary("mul", b.convert(count, IrType.I32), kind.size)
    good = b.and_(b.and_(room(b, source, size), room(b, out, size)), b.gt(size, 0))
    with b.choose(good) as choice:
        b.emit(ir.CopyBytes(b.address(out), b.address(source), size))
        b.eno(True)
        choice.otherwise()
        b.fault(OPERAND_RANGE)
        b.eno(False)


@define(
    {"FILL": ()},
    group="Table",
    operands=(In("IN", INT), Out("OUT", INT, block=True), In("N", BYTE, low=1, high=255)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source="System Manual, Memory fill",
)
def fill(b: Routine, value: Value, out: Place, count: Value) -> None:
    """Write the word IN to N words from OUT on.

    When some of the words do not exist, or N is 0, nothing happens but error 0091.
    """
    number = b.convert(count, IrType.I32)
    good = b.and_(room(b, out, b.binary("mul", number, 2)), b.gt(number, 0))
    with b.choose(good) as choice:
        b.emit(ir.FillWords(b.address(out), value, number))
        b.eno(True)
        choice.otherwise()
        b.fault(OPERAND_RANGE)
        b.eno(False)


@define(
    {"SWAP": ()},
    group="Move",
    operands=(InOut("IN", WORD),),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Swap bytes",
)
def swap(b: Routine, place: Place) -> None:
    """Exchange the two bytes of the word."""
    word = b.load(place)
    b.store(place, b.or_(b.shl(word, 8), b.shr(word, 8)))
    b.eno(True)


@contextmanager
def _physical(b: Routine, place: Place, area: Area, start: int) -> Iterator[int | Value]:
    """Inside: the box, with the terminal's address; a pointer to another area is error 0006."""
    if isinstance(place.at, int):
        yield start + place.offset
        b.eno(True)
        return
    number = b.sub(place.at, AREA_START[area])
    with b.choose(b.and_(b.ge(number, 0), b.lt(number, _IMAGE_SIZE))) as choice:
        yield b.add(number, start)
        b.eno(True)
        choice.otherwise()
        b.bad_pointer()


@define(
    {"BIR": ()},
    group="Move immediate",
    operands=(In("IN", BYTE, constant=False, areas=frozenset({Area.I}), place=True), Out("OUT", BYTE)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Move byte immediate",
)
def read_immediate(b: Routine, source: Place, out: Place) -> None:
    """Copy a byte of physical inputs to OUT; the process image stays as it is."""
    with _physical(b, source, Area.I, layout.PHYSICAL_INPUTS) as at:
        b.store(out, b.load_at(IrType.U8, at))


@define(
    {"BIW": ()},
    group="Move immediate",
    operands=(In("IN", BYTE), Out("OUT", BYTE, areas=frozenset({Area.Q}))),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Move byte immediate",
)
def write_immediate(b: Routine, value: Value, out: Place) -> None:
    """Write IN to a byte of physical outputs and to the process image."""
    with _physical(b, out, Area.Q, layout.PHYSICAL_OUTPUTS) as at:
        b.store(out, value)
        b.store_at(at, value)
