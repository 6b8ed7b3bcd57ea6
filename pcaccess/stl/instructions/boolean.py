"""Bit logic: contacts, logic stack, edges, coils, set and reset."""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.types import DataType
from pcaccess.stl import layout
from pcaccess.stl.builder import Place
from pcaccess.stl.define import In, Number, Out, Power, StackUse, define
from pcaccess.stl.errors import INDIRECT_ADDRESS, OPERAND_RANGE
from pcaccess.stl.instructions.bit_ranges import RANGE_ERROR, bit_number, change, set_bits, set_outputs
from pcaccess.stl.ir_values import IrType, Value
from pcaccess.stl.routine import Routine

BOOL, BYTE = DataType.BOOL, DataType.BYTE
_INPUT: Final = frozenset({Area.I})
_OUTPUT: Final = frozenset({Area.Q})


def _physical_input(b: Routine, place: Place) -> Value:
    return b.load_bit(layout.PHYSICAL_INPUTS + place.offset, place.bit)


def _write_output(b: Routine, place: Place, value: Value) -> None:
    b.store(place, value)
    b.store_bit(layout.PHYSICAL_OUTPUTS + place.offset, place.bit, value)


@define(
    {"LD": (False,), "LDN": (True,)},
    group="Boolean",
    operands=(In("BIT", BOOL),),
    power=Power.CONTACT,
    stack=StackUse(0, 1),
    source="System Manual, Standard contacts",
)
def load(b: Routine, inverted: bool, bit: Value) -> None:
    """Push the bit (LDN, its opposite) to the logic stack."""
    b.push(b.not_(bit) if inverted else bit)


@define(
    {"A": ("and", False), "AN": ("and", True), "O": ("or", False), "ON": ("or", True)},
    group="Boolean",
    operands=(In("BIT", BOOL),),
    power=Power.CONTACT,
    source="System Manual, Standard contacts",
)
def combine(b: Routine, op: str, inverted: bool, bit: Value) -> None:
    """Combine the top of the logic stack with the bit (AN, ON: with its opposite)."""
    b.set_top(b.binary(op, b.top, b.not_(bit) if inverted else bit))


@define(
    {"LDI": (False,), "LDNI": (True,)},
    group="Boolean immediate",
    operands=(In("BIT", BOOL, areas=_INPUT, place=True),),
    power=Power.CONTACT,
    stack=StackUse(0, 1),
    source="System Manual, Immediate contacts",
)
def load_immediate(b: Routine, inverted: bool, bit: Place) -> None:
    """Push the physical input (LDNI: its opposite) to the logic stack; the process image stays as it is."""
    value = _physical_input(b, bit)
    b.push(b.not_(value) if inverted else value)


@define(
    {"AI": ("and", False), "ANI": ("and", True), "OI": ("or", False), "ONI": ("or", True)},
    group="Boolean immediate",
    operands=(In("BIT", BOOL, areas=_INPUT, place=True),),
    power=Power.CONTACT,
    source="System Manual, Immediate contacts",
)
def combine_immediate(b: Routine, op: str, inverted: bool, bit: Place) -> None:
    """Combine the top of the logic stack with the physical input (ANI, ONI: with its opposite)."""
    value = _physical_input(b, bit)
    b.set_top(b.binary(op, b.top, b.not_(value) if inverted else value))


@define(
    {"NOT": ()},
    group="Boolean",
    power=Power.CONTACT,
    source="System Manual, NOT",
)
def invert(b: Routine) -> None:
    """Invert the top of the logic stack."""
    b.set_top(b.not_(b.top))


@define(
    {"EU": (True,), "ED": (False,)},
    group="Boolean",
    power=Power.CONTACT,
    source="System Manual, Positive and negative transition",
)
def edge(b: Routine, rising: bool) -> None:
    """Let power through for one scan when the top of the logic stack rises (ED: falls).

    Each EU and ED in the program has a memory of its own. In the first scan there is no edge: the memory only
    takes over the state, as the manual says.
    """
    before = b.new_edge()
    now, was = b.top, b.ne(b.load_at(IrType.U8, before), 0)
    changed = b.and_(now, b.not_(was)) if rising else b.and_(b.not_(now), was)
    running = b.eq(b.load_at(IrType.U8, layout.FIRST_SCAN), 0)
    b.store_at(before, b.convert(now, IrType.U8))
    b.set_top(b.and_(changed, running))
    b.when_idle(lambda: b.store_at(before, b.const(IrType.U8, 0)))


@define(
    {"ALD": ("and",), "OLD": ("or",)},
    group="Boolean",
    power=Power.STACK,
    stack=StackUse(2, -1),
    source="System Manual, Logic stack",
)
def both(b: Routine, op: str) -> None:
    """Combine the two top levels of the logic stack into one."""
    b.close_power()  # LPS, LRD and LPP compute nothing and may stand between boxes; this does
    first = b.pop()
    b.set_top(b.binary(op, b.top, first))


@define(
    {"LPS": ()},
    group="Boolean",
    power=Power.STACK,
    stack=StackUse(1, 1),
    source="System Manual, Logic stack",
)
def push(b: Routine) -> None:
    """Push a copy of the top of the logic stack."""
    b.push(b.top)


@define(
    {"LRD": ()},
    group="Boolean",
    power=Power.STACK,
    stack=StackUse(2, 0),
    source="System Manual, Logic stack",
)
def read(b: Routine) -> None:
    """Copy the second level of the logic stack to the top; nothing is pushed or popped."""
    b.set_top(b.level(1))


@define(
    {"LPP": ()},
    group="Boolean",
    power=Power.STACK,
    stack=StackUse(2, -1),
    source="System Manual, Logic stack",
)
def pop(b: Routine) -> None:
    """Drop the top of the logic stack; the second level becomes the top.

    What comes in at the bottom is 0 (the manual calls it unknown); so with ALD and OLD.
    """
    b.pop()


@define(
    {"LDS": ()},
    group="Boolean",
    operands=(Number("N", 0, 8),),
    power=Power.STACK,
    stack=StackUse(1, 1),
    source="System Manual, Logic stack",
)
def load_stack(b: Routine, level: int) -> None:
    """Push a copy of level N of the logic stack."""
    b.push(b.level(level))


@define(
    {"AENO": ()},
    group="Boolean",
    power=Power.CONTACT,
    source="System Manual, AENO",
)
def and_eno(b: Routine) -> None:
    """AND the top of the logic stack with ENO of the box before.

    A box that did not run leaves ENO as it was; before the first box of a POU it is 1.
    """
    b.set_top(b.and_(b.top, b.get_eno()))


@define(
    {"=": ()},
    group="Boolean",
    operands=(Out("BIT", BOOL),),
    power=Power.COIL,
    source="System Manual, Output",
)
def coil(b: Routine, bit: Place) -> None:
    """Copy the top of the logic stack to the bit."""
    b.store(bit, b.top)
    b.when_idle(lambda: b.store(bit, b.bit(False)))


@define(
    {"=I": ()},
    group="Boolean immediate",
    operands=(Out("BIT", BOOL, areas=_OUTPUT),),
    power=Power.COIL,
    source="System Manual, Output immediate",
)
def coil_immediate(b: Routine, bit: Place) -> None:
    """Copy the top of the logic stack to the physical output and to the process image."""
    _write_output(b, bit, b.top)
    b.when_idle(lambda: _write_output(b, bit, b.bit(False)))


@define(
    {"S": (True,), "R": (False,)},
    group="Boolean",
    operands=(Out("BIT", BOOL), In("N", BYTE, low=1, high=255)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source="System Manual, Set and reset",
)
def set_reset(b: Routine, on: bool, first: Place, count: Value) -> None:
    """Set (R: reset) N bits from BIT on. R on a timer or counter clears its bit and its current value.

    When the bits do not all exist, or N is 0, nothing happens but error 0091.
    """
    assert first.area is not None
    limit = b.model.sizes[first.area] * (1 if first.area.is_numbered else 8)
    if count.constant is None:
        b.cold(set_bits, count, static=(first.area, bit_number(first), limit, on), effects=RANGE_ERROR)
        return
    change(b, first, int(count.constant), on)  # the checker has seen that they exist
    b.eno(True)


@define(
    {"SI": (True,), "RI": (False,)},
    group="Boolean immediate",
    operands=(Out("BIT", BOOL, areas=_OUTPUT), In("N", BYTE, low=1, high=128)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source="System Manual, Set and reset immediate",
)
def set_reset_immediate(b: Routine, on: bool, first: Place, count: Value) -> None:
    """Set (RI: reset) N physical outputs and their image bits from BIT on.

    When the outputs do not all exist, or N is not 1 to 128, nothing happens but error 0091.
    """
    limit = b.model.sizes[Area.Q] * 8
    b.cold(set_outputs, count, static=(bit_number(first), limit, on), effects=RANGE_ERROR)


@define(
    {"NOP": ()},
    group="Boolean",
    operands=(Number("N", 0, 255),),
    power=Power.MARK,
    stack=StackUse(0, 0),
    source="System Manual, No operation",
)
def no_operation(b: Routine, number: int) -> None:
    """Do nothing."""
