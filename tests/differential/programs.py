"""Well-formed programs for Hypothesis: everything the checker lets pass, and what happens to the CPU meanwhile.

Which instructions there are, what they accept and what they do to the logic stack comes from the definitions: a new
instruction takes part by itself. Only program control is written out here.
"""

from __future__ import annotations

import itertools
import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Final

from hypothesis import strategies as st

from pcaccess.s7200.address import Area, parse_address
from pcaccess.s7200.memory import AREA_START, locate
from pcaccess.s7200.pointers import pointer_to
from pcaccess.s7200.types import DataType
from pcaccess.stl.define import Definition, In, InOut, OperandSpec, Out, Power, Special
from pcaccess.stl.definitions import DEFINITIONS
from tests.differential.operands import FIRST_REAL, POINTED, operand

_CONTROL: Final = ("CALL", "FOR", "NEXT", "JMP", "LBL", "END", "MEND", "STOP", "CRET", "RET", "LDS", "NOP")
_SEQUENCE: Final = ("LSCR", "SCRT", "SCRE", "CSCRE")
_INTERRUPTS: Final = ("ATCH", "DTCH", "ENI", "DISI", "CRETI", "RETI", "HDEF")
RUNNABLE: Final = {name: d for name, d in DEFINITIONS.items() if d.body is not None}
GENERIC: Final = {name: d for name, d in RUNNABLE.items() if name not in _CONTROL + _SEQUENCE + _INTERRUPTS}
LOADS: Final = [d for d in GENERIC.values() if d.power is Power.CONTACT and d.stack.delta == 1]
CONTACTS: Final = [d for d in GENERIC.values() if d.power is Power.CONTACT and d.stack.delta == 0]
BOXES: Final = [d for d in GENERIC.values() if d.power is Power.BOX]
COILS: Final = [d for d in GENERIC.values() if d.power is Power.COIL]
COMMON: Final = [GENERIC[name] for name in ("LD", "LDN", "LDW>=", "LDI")]
EVENTS: Final = (0, 1, 2, 7, 10, 11, 21)
TYPES: Final = (DataType.BOOL, DataType.BYTE, DataType.INT, DataType.WORD, DataType.DINT, DataType.REAL)
_SECTIONS: Final = (("VAR_INPUT", In), ("VAR_IN_OUT", InOut), ("VAR_OUTPUT", Out))

Draw = Callable[..., object]


@dataclass(frozen=True)
class Tick:
    """What happens before one scan."""

    inputs: bytes
    elapsed: float
    """Milliseconds since the start of the scan before."""
    load: float


@dataclass(frozen=True)
class Run:
    """A program, what V memory and the accumulators hold at the beginning, and some scans."""

    text: str
    patches: tuple[tuple[int, bytes], ...]
    """Flat address, bytes."""
    ticks: tuple[Tick, ...]
    junk: int | None = None
    """Memory is full of random bytes of this seed before."""

    def __str__(self) -> str:
        return self.text


@dataclass
class _Pou:
    """A POU being written."""

    kind: str
    """``main``, ``sbr``, ``int``."""
    callable: tuple[int, ...] = ()
    """Subroutines it may call."""
    signatures: tuple[tuple[OperandSpec, ...], ...] = ()
    networks: list[list[str]] = field(default_factory=list)
    labels: Iterable[int] = field(default_factory=itertools.count)
    in_segment: bool = False


class _Writer:
    """Draws one program. Everything random comes from ``draw``, so that Hypothesis can shrink it."""

    def __init__(self, draw: Callable[[st.SearchStrategy[object]], object]) -> None:
        self._draw = draw
        self._segments = iter(range(8))
        self._counters = itertools.count(300, 2)
        self.interrupts = 0

    def pick(self, choices: Iterable[object]) -> object:
        return self._draw(st.sampled_from(list(choices)))

    def number(self, low: int, high: int) -> int:
        value = self._draw(st.integers(low, high))
        assert isinstance(value, int)
        return value

    def chance(self, one_in: int) -> bool:
        return self.number(1, one_in) == one_in

    # instructions

    def instruction(self, definition: Definition) -> str:
        texts = [str(self._draw(operand(spec, definition.mnemonic))) for spec in definition.operands]
        return f"{definition.mnemonic} {', '.join(texts)}".strip()

    def _one_of(self, definitions: Iterable[Definition]) -> str:
        definition = self.pick(definitions)
        assert isinstance(definition, Definition)
        return self.instruction(definition)

    def condition(self, depth: int = 2) -> list[str]:
        """Instructions that push one value."""
        lines = [self._one_of(COMMON if self.chance(2) else LOADS)]
        for _ in range(self.number(0, 2)):
            if depth and self.chance(4):
                lines += [*self.condition(depth - 1), *self.maybe_box(), str(self.pick(("ALD", "OLD")))]
            else:
                lines.append(self._one_of(CONTACTS))
        return lines

    def outputs(self) -> list[str]:
        """Instructions that use the top of the stack and leave it."""
        lines: list[str] = []
        for _ in range(self.number(1, 3)):
            kind = self.number(0, 5)
            if kind <= 2:
                lines.append(self._one_of(BOXES))
                if self.chance(3):
                    lines.append("AENO")
            elif kind == 3:
                lines.append(self._one_of([c for c in COILS if c.stack.needs == 1]))
            else:
                lines.append(self.instruction(GENERIC["="]))
        return lines

    def maybe_box(self) -> list[str]:
        return [self._one_of(BOXES)] if self.chance(4) else []

    def maybe_contact(self) -> list[str]:
        return [self._one_of(CONTACTS)] if self.chance(2) else []

    def rung(self) -> list[str]:
        """One network without program control."""
        kind = self.number(0, 7)
        if kind == 0:
            lines = [*self.condition(), "LPS", *self.outputs()]
            for _ in range(self.number(0, 2)):
                lines += ["LRD", *self.maybe_contact(), *self.outputs()]
            return [*lines, "LPP", *self.maybe_contact(), *self.outputs()]
        if kind == 1:
            definition = self.pick([c for c in COILS if c.stack.needs > 1])
            assert isinstance(definition, Definition)
            loads = [line for _ in range(definition.stack.needs) for line in self.condition(0)]
            return [*loads, self.instruction(definition)]
        if kind == 2:
            pushed = self.number(1, 4)
            loads = [line for _ in range(pushed) for line in self.condition(0)]
            return [*loads, f"LDS {self.number(0, pushed - 1)}", *self.outputs()]
        if kind == 3 and self.chance(3):
            return [self._one_of(CONTACTS), *self.outputs()]  # what the network before has left
        return [*self.condition(), *self.outputs()]

    # program control

    def body(self, pou: _Pou, depth: int) -> None:
        for _ in range(self.number(1, 4 if depth else 3)):
            self.statement(pou, depth)

    def statement(self, pou: _Pou, depth: int) -> None:
        kind = self.number(0, 14)
        if depth and kind == 9:
            self.loop(pou, depth)
        elif depth and kind == 10:
            self.jump_over(pou, depth)
        elif depth and kind == 11:
            self.jump_back(pou, depth)
        elif depth and kind == 12 and not pou.in_segment and pou.kind != "int":
            self.segment(pou, depth)
        elif kind == 13 and pou.callable:
            self.call(pou)
        elif kind == 14:
            self.rare(pou)
        else:
            pou.networks.append(self.rung())

    def loop(self, pou: _Pou, depth: int) -> None:
        index = f"VW{next(self._counters)}"
        first, last = self.pick(("1", "0", "VW2")), self.pick(("3", "1", "2", "VW4"))
        pou.networks.append([*self.condition(0), f"FOR {index}, {first}, {last}"])
        self.body(pou, depth - 1)
        pou.networks.append(["NEXT"])

    def jump_over(self, pou: _Pou, depth: int) -> None:
        label = next(iter(pou.labels))
        pou.networks.append([*self.condition(0), f"JMP {label}"])
        self.body(pou, depth - 1)
        pou.networks.append([f"LBL {label}"])

    def jump_back(self, pou: _Pou, depth: int) -> None:
        label, counter = next(iter(pou.labels)), f"VW{next(self._counters)}"
        pou.networks.append([f"LBL {label}"])
        self.body(pou, depth - 1)
        again = [f"LDW< {counter}, {self.number(1, 3)}", f"INCW {counter}"]
        pou.networks.append([*again, *([] if self.chance(4) else ["AENO"]), f"JMP {label}"])

    def segment(self, pou: _Pou, depth: int) -> None:
        number = next(self._segments, None)
        if number is None:
            return
        pou.in_segment = True
        pou.networks.append([f"LSCR S0.{number}"])
        self.body(pou, depth - 1)
        if self.chance(2):
            pou.networks.append([*self.condition(0), f"SCRT S0.{self.number(0, 7)}"])
        if self.chance(3):
            pou.networks.append([*self.condition(0), "CSCRE"])
            self.body(pou, depth - 1)
        pou.networks.append(["SCRE"])
        pou.in_segment = False

    def call(self, pou: _Pou) -> None:
        number = self.pick(pou.callable)
        assert isinstance(number, int)
        given = [str(self._draw(operand(spec, "CALL"))) for spec in pou.signatures[number]]
        pou.networks.append([*self.condition(0), f"CALL {', '.join([f'SBR_{number}', *given])}"])

    def rare(self, pou: _Pou) -> None:
        """Ends of all kinds, and interrupts."""
        leave = {"main": "END", "sbr": "CRET", "int": "CRETI"}[pou.kind]
        choices = ["STOP"] if pou.kind == "int" else ["STOP", "HDEF 0, 1"]
        if leave in RUNNABLE and not (leave == "END" and pou.in_segment):
            choices += [leave] * 3
        if "ATCH" in RUNNABLE and self.interrupts:
            choices += [f"ATCH INT_{self.number(0, self.interrupts - 1)}, {self.pick(EVENTS)}"] * 4
            choices.append(f"DTCH {self.pick(EVENTS)}")
            if pou.kind != "int":
                choices += ["ENI", "ENI", "DISI"]
        pou.networks.append([*self.condition(1), str(self.pick(choices))])

    # the whole

    def signature(self) -> tuple[OperandSpec, ...]:
        specs = []
        for section, make in _SECTIONS:
            for n in range(self.number(0, 2)):
                kind = self.pick(TYPES)
                assert isinstance(kind, DataType)
                specs.append(make(f"{section[4:].lower()}{n}", kind))
        return tuple(specs)

    def program(self) -> str:
        count = self.number(0, 2)
        self.interrupts = self.number(0, 2) if "ATCH" in RUNNABLE else 0
        signatures = tuple(self.signature() for _ in range(count))
        main = _Pou("main", tuple(range(count)), signatures)
        if self.interrupts and self.chance(2):
            main.networks.append(["LD SM0.1", f"ATCH INT_0, {self.pick(EVENTS)}", "ENI"])
        self.body(main, 2)
        blocks = [_block("ORGANIZATION_BLOCK MAIN:OB1", main)]
        for n, signature in enumerate(signatures):
            deeper = tuple(range(n if self.chance(4) else n + 1, count))  # now and then it calls itself
            sbr = _Pou("sbr", deeper, signatures)
            self.body(sbr, 1)
            blocks.append(_block(f"SUBROUTINE_BLOCK SBR_{n}:SBR{n}", sbr, signature))
        for n in range(self.interrupts):
            routine = _Pou("int")
            self.body(routine, 1)
            blocks.append(_block(f"INTERRUPT_BLOCK INT_{n}:INT{n}", routine))
        return "\n".join(blocks) + "\n"


def _block(header: str, pou: _Pou, signature: tuple[OperandSpec, ...] = ()) -> str:
    lines = [header, "TITLE="]
    for section, _ in _SECTIONS:
        declared = [spec for spec in signature if spec.name.startswith(section[4:].lower())]
        if declared:
            lines += [section, *(f"{spec.name}:{_type_name(spec)};" for spec in declared), "END_VAR"]
    lines.append("BEGIN")
    for number, network in enumerate(pou.networks, 1):
        lines += [f"NETWORK {number}", *network]
    return "\n".join([*lines, f"END_{header.split()[0]}"])


def _type_name(spec: OperandSpec) -> str:
    assert not isinstance(spec.type, Special)
    return spec.type.name


_WORDS = st.sampled_from((0, 1, 2, 7, 100, 255, 0x0909, 0x1234, 0x7FFF, 0x8000, 0xFFFF, 0x9999)) | st.integers(
    0, 0xFFFF
)
_REALS = st.sampled_from((0.0, -0.0, 1.0, -2.5, 0.1, 3.4e38, -3.4e38, 1e-45, 2147483520.0, -2147483648.0, 300.5))
_ANY_REAL = st.floats(width=32)


@st.composite
def _patches(draw: st.DrawFn) -> tuple[tuple[int, bytes], ...]:
    v = AREA_START[Area.V]
    words = draw(st.lists(_WORDS, min_size=4, max_size=4))
    reals = draw(st.lists(_REALS | _ANY_REAL, min_size=5, max_size=5))
    pointers = [pointer_to(parse_address(draw(st.sampled_from(POINTED))[1:])) for _ in range(3)]
    accumulators = [pointer_to(parse_address("VB2")), *draw(st.lists(st.integers(0, 0xFFFFFFFF), max_size=1))]
    return (
        (v, b"".join(struct.pack(">H", n) for n in words)),
        (v + FIRST_REAL, b"".join(struct.pack(">f", r) for r in reals)),
        (v + 200, b"".join(struct.pack(">I", p) for p in pointers)),
        (locate(parse_address("AC1"))[0] - 3, b"".join(struct.pack(">I", a) for a in accumulators)),
        (v + 400, draw(st.sampled_from((b"\x03abc", b"\x05-12.5", b"\x00", b"\xff")))),
    )


_TICK = st.builds(
    Tick,
    inputs=st.binary(min_size=2, max_size=2),
    elapsed=st.sampled_from((1.0, 10.0, 37.0, 100.0, 250.0)),
    load=st.sampled_from((0.0, 0.0, 3.0, 20.0)),
)


@st.composite
def runs(draw: st.DrawFn) -> Run:
    """Programs with everything around them."""
    text = _Writer(draw).program()
    ticks = tuple(draw(st.lists(_TICK, min_size=2, max_size=4)))
    return Run(text, draw(_patches()), ticks, draw(st.none() | st.integers(0, 0xFFFF)))
