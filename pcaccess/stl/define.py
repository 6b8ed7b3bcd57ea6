"""One definition per STL instruction: what it takes, what it touches, what it does.

An instruction module writes ``@define({mnemonic: arguments, ...}, operands=..., ...)`` above a function that
emits IR (``pcaccess.stl.builder``); a family of instructions shares one function. ``declare`` is the same
without a function: known to the checker, not executable. ``pcaccess.stl.definitions`` collects all of them in
``DEFINITIONS``.

Source:   System Manual, instruction set; each definition names its section.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.types import DataType
from pcaccess.stl.errors import RunTimeError


class Direction(Enum):
    IN = "IN"
    OUT = "OUT"
    INOUT = "INOUT"

    @property
    def reads(self) -> bool:
        return self is not Direction.OUT

    @property
    def writes(self) -> bool:
        return self is not Direction.IN


class Special(Enum):
    """Operands that are no value of a data type."""

    LABEL = "label"
    """Number of a LBL, ``low`` to ``high``."""
    TIMER = "timer"
    """``T37``; which numbers an instruction accepts says ``OperandSpec.timers``."""
    COUNTER = "counter"
    SBR = "subroutine"
    INT = "interrupt routine"
    NUMBER = "number"
    """A constant ``low`` to ``high`` that is part of the instruction."""
    PARAMETERS = "parameters"
    """What CALL passes: as many operands as the subroutine declares."""


OperandType = DataType | Special

SAME: Final = "same"
"""In a family: the data type that stands first in the row."""


@dataclass(frozen=True, slots=True)
class OperandSpec:
    """What one operand may be."""

    name: str
    direction: Direction
    type: OperandType
    areas: frozenset[Area] = frozenset()
    """Areas a direct address may lie in. SM0..SM29 are read-only whatever stands here."""
    constant: bool = False
    pointer: bool = False
    """``*AC1`` may stand here."""
    address_of: bool = False
    """``&VB100`` may stand here."""
    low: int | None = None
    """Range of a constant, where it is narrower than the type's."""
    high: int | None = None
    timers: str = ""
    """For a TIMER: ``TONR`` or ``TON`` (TON and TOF share their numbers)."""
    block: bool = False
    """The first of several values in a row: it has an address of its own, so it is no accumulator."""
    extent: int = 0
    """Bytes used from the address on, where it is more than one value and known beforehand."""
    place: bool = False
    """The body wants to know where it lies; it loads the value itself."""
    raw: bool = False
    """The body wants the bits, as an unsigned integer of the type's width."""
    template: str | None = None
    """``SAME``, before a row has said its type."""

    @property
    def is_value(self) -> bool:
        return isinstance(self.type, DataType)


class Power(Enum):
    """How an instruction deals with the logic stack."""

    CONTACT = "contact"
    """Pushes to the stack or changes its top."""
    STACK = "stack"
    """Rearranges the stack."""
    COIL = "coil"
    """Acts on every execution, with S0 (and below) as its input: ``=``, timers, counters."""
    BOX = "box"
    """Runs only while S0 is 1; leaves the stack alone; sets ENO."""
    CONTROL = "control"
    """Directs the program."""
    MARK = "mark"
    """A place in the program, whatever the stack says: LBL, NEXT, LSCR, SCRE."""


@dataclass(frozen=True, slots=True)
class StackUse:
    """Levels an instruction needs in the running network, and by how many it changes their number."""

    needs: int = 1
    delta: int = 0


@dataclass(frozen=True, slots=True)
class SmBit:
    """One bit of SM memory that instructions set."""

    byte: int
    bit: int

    def __str__(self) -> str:
        return f"SM{self.byte}.{self.bit}"


ZERO: Final = SmBit(1, 0)
OVERFLOW: Final = SmBit(1, 1)
NEGATIVE: Final = SmBit(1, 2)
DIVIDE_BY_ZERO: Final = SmBit(1, 3)
TABLE_FULL: Final = SmBit(1, 4)
TABLE_EMPTY: Final = SmBit(1, 5)
NOT_BCD: Final = SmBit(1, 6)
NOT_HEX: Final = SmBit(1, 7)

EnoCause = SmBit | RunTimeError

Body = Callable[..., None]


@dataclass(frozen=True, slots=True)
class Definition:
    """One instruction."""

    mnemonic: str
    group: str
    operands: tuple[OperandSpec, ...]
    power: Power
    stack: StackUse
    sm: tuple[SmBit, ...]
    """SM bits it can change."""
    eno_off: tuple[EnoCause, ...]
    """What makes ENO 0."""
    errors: tuple[RunTimeError, ...]
    """Run-time errors it can cause without touching ENO."""
    source: str
    summary: str
    description: str
    body: Body | None = field(default=None, repr=False)
    """Emits the IR; None: known, not executable."""
    arguments: tuple[Any, ...] = ()
    """What the row gives the body before the operands."""

    @property
    def is_variadic(self) -> bool:
        return any(o.type is Special.PARAMETERS for o in self.operands)


@dataclass(frozen=True, slots=True)
class Family:
    """Definitions that share a body, in the order of their rows."""

    rows: tuple[Definition, ...]
    body: Body | None = field(default=None, repr=False)


Row = tuple[Any, ...]

_BIT: Final = frozenset({Area.I, Area.Q, Area.V, Area.M, Area.SM, Area.S, Area.T, Area.C, Area.L})
_BYTES: Final = frozenset({Area.I, Area.Q, Area.V, Area.M, Area.SM, Area.S, Area.L})
_WORDS: Final = _BYTES | {Area.T, Area.C}

_READ: Final[Mapping[DataType, frozenset[Area]]] = {
    DataType.BOOL: _BIT,
    DataType.BYTE: _BYTES | {Area.AC},
    DataType.INT: _WORDS | {Area.AC, Area.AI},
    DataType.WORD: _WORDS | {Area.AC, Area.AI},
    DataType.DINT: _BYTES | {Area.AC, Area.HC},
    DataType.DWORD: _BYTES | {Area.AC, Area.HC},
    DataType.REAL: _BYTES | {Area.AC},
    DataType.STRING: frozenset({Area.V, Area.L}),
}
_WRITE: Final[Mapping[DataType, frozenset[Area]]] = {
    **_READ,
    DataType.INT: _WORDS | {Area.AC, Area.AQ},
    DataType.WORD: _WORDS | {Area.AC, Area.AQ},
    DataType.DINT: _BYTES | {Area.AC},
    DataType.DWORD: _BYTES | {Area.AC},
}
_CHANGE: Final[Mapping[DataType, frozenset[Area]]] = {
    **_WRITE,
    DataType.INT: _WORDS | {Area.AC},  # an output word cannot be read back
    DataType.WORD: _WORDS | {Area.AC},
}
_AREAS: Final = {Direction.IN: _READ, Direction.OUT: _WRITE, Direction.INOUT: _CHANGE}


def _areas(direction: Direction, kind: DataType, block: bool) -> frozenset[Area]:
    areas = _AREAS[direction][kind]
    return areas - {Area.AC, Area.HC} if block else areas


def _value(name: str, direction: Direction, kind: DataType | str, **more: Any) -> OperandSpec:
    if isinstance(kind, str):
        return OperandSpec(name, direction, DataType.BYTE, pointer=True, template=kind, **more)
    areas = more.pop("areas", None) or _areas(direction, kind, more.get("block", False))
    pointer = more.pop("pointer", kind is not DataType.BOOL)
    return OperandSpec(name, direction, kind, areas, pointer=pointer, **more)


def In(name: str, kind: DataType | str, *, constant: bool = True, **more: Any) -> OperandSpec:  # noqa: N802
    """An operand that is read: any area that has the type, a constant, a pointer (a BOOL: only a bit)."""
    return _value(name, Direction.IN, kind, constant=constant and kind is not DataType.BOOL, **more)


def Out(name: str, kind: DataType | str, **more: Any) -> OperandSpec:  # noqa: N802
    """An operand that is written."""
    return _value(name, Direction.OUT, kind, **more)


def InOut(name: str, kind: DataType | str, **more: Any) -> OperandSpec:  # noqa: N802
    """An operand that is read and written."""
    return _value(name, Direction.INOUT, kind, **more)


def Number(name: str, low: int, high: int) -> OperandSpec:  # noqa: N802
    """A constant that is part of the instruction."""
    return OperandSpec(name, Direction.IN, Special.NUMBER, constant=True, low=low, high=high)


def special(name: str, kind: Special, direction: Direction = Direction.IN, **more: Any) -> OperandSpec:
    return OperandSpec(name, direction, kind, **more)


def _typed(spec: OperandSpec, row: Row) -> OperandSpec:
    if spec.template is None:
        return spec
    kind = next(a for a in row if isinstance(a, DataType))
    areas = spec.areas or _areas(spec.direction, kind, spec.block)
    return replace(spec, type=kind, areas=areas, template=None)


def _sections(doc: str | None) -> tuple[str, str]:
    lines = [line.strip() for line in (doc or "").strip().splitlines()]
    text = "\n".join(lines)
    summary, _, rest = text.partition("\n\n")
    return " ".join(summary.split()), rest.strip()


def declare(
    rows: Mapping[str, Row],
    *,
    group: str,
    operands: Sequence[OperandSpec] = (),
    power: Power = Power.BOX,
    stack: StackUse | None = None,
    sm: Sequence[SmBit] = (),
    eno_off: Sequence[EnoCause] = (),
    errors: Sequence[RunTimeError] = (),
    source: str,
    doc: str,
    body: Body | None = None,
) -> Family:
    """Definitions of one family; without ``body`` they are known but not executable."""
    summary, description = _sections(doc)
    return Family(
        tuple(
            Definition(
                mnemonic=mnemonic,
                group=group,
                operands=tuple(_typed(o, row) for o in operands),
                power=power,
                stack=stack or StackUse(),
                sm=tuple(sm),
                eno_off=tuple(eno_off),
                errors=tuple(errors),
                source=source,
                summary=summary,
                description=description,
                body=body,
                arguments=row,
            )
            for mnemonic, row in rows.items()
        ),
        body,
    )


def define(rows: Mapping[str, Row], **facts: Any) -> Callable[[Body], Family]:
    """Decorator of a body; its docstring is the description, the first paragraph the summary.

    ``facts`` are those of :func:`declare`. The name in the module is the family afterwards.
    """

    def family(body: Body) -> Family:
        return declare(rows, doc=body.__doc__ or "", body=body, **facts)

    return family
