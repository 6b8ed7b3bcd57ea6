"""Loops, jumps, SCR segments and what may stand where, block by block.

Source:   System Manual, "FOR and NEXT" (nesting 8), "Jump" (label in the same block), "Sequence control relay" (no
          jump into or out of a segment, no END in one, no S bit for two), "Interrupts" (no DISI, ENI, HDEF, LSCR,
          END in an interrupt routine); document 003, section 6.2.2, for JMP and LBL.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from pcaccess.problems import Span
from pcaccess.s7200.address import Address
from pcaccess.stl.define import Power
from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import Constant, Direct, Instruction, Network, Pou, PouKind, Program

LOOPS: Final = 8
EDGES: Final = 256
"""EU and ED in one program (System Manual, "Positive and negative transition")."""

_PLACES: Final = MappingProxyType(
    {
        "END": (PouKind.MAIN,),
        "MEND": (PouKind.MAIN,),
        "CRET": (PouKind.SBR,),
        "CRETI": (PouKind.INT,),
        "ENI": (PouKind.MAIN, PouKind.SBR),
        "DISI": (PouKind.MAIN, PouKind.SBR),
        "HDEF": (PouKind.MAIN, PouKind.SBR),
        "LSCR": (PouKind.MAIN, PouKind.SBR),
    }
)
_INSTEAD: Final = MappingProxyType(
    {("END", PouKind.SBR): "CRET", ("END", PouKind.INT): "CRETI", ("CRET", PouKind.MAIN): "END",
     ("CRET", PouKind.INT): "CRETI", ("CRETI", PouKind.MAIN): "END", ("CRETI", PouKind.SBR): "CRET"}
)  # fmt: skip
_KIND_TEXT: Final = MappingProxyType(
    {PouKind.MAIN: "the main program", PouKind.SBR: "a subroutine", PouKind.INT: "an interrupt routine"}
)
_PASSIVE: Final = (Power.CONTACT, Power.STACK)


def check_structure(program: Program, problems: Collector) -> None:
    segments: dict[Address, Span] = {}
    """Where the segment of each S bit begins, over all blocks."""
    edges = 0
    for pou in program.pous:
        _Structure(pou, segments, problems).check()
        for network, instruction in pou.instructions():
            if instruction.mnemonic in ("EU", "ED"):
                edges += 1
                if edges == EDGES + 1:
                    message = f"this is edge instruction {edges}"
                    where = pou.where(network)
                    problems.add(
                        "STL062", instruction.span, message, expected=f"at most {EDGES} EU and ED", where=where
                    )


class _Structure:
    def __init__(self, pou: Pou, segments: dict[Address, Span], problems: Collector) -> None:
        self.pou = pou
        self.all_segments = segments
        self.problems = problems
        self.loops: list[tuple[Instruction, str, Span | None]] = []
        """Open FORs: instruction, where, the segment it stands in."""
        self.segment: Span | None = None
        """Where the open SCR segment begins."""
        self.labels: dict[int, tuple[Span, Span | None]] = {}
        self.jumps: list[tuple[int, Instruction, str, Span | None]] = []

    def check(self) -> None:
        for network in self.pou.networks:
            self.problems.where = self.pou.where(network)
            for instruction in network.instructions:
                self.check_place(instruction)
                handler = _HANDLERS.get(instruction.mnemonic)
                if handler is not None:
                    handler(self, instruction)
            self.check_output(network)
        for instruction, where, _ in self.loops:
            self.problems.add(
                "STL054", instruction.span, "FOR without NEXT", expected="a NEXT in this block", where=where
            )
        if self.segment is not None:
            self.problems.add("STL059", self.segment, "LSCR without SCRE", expected="an SCRE in this block")
        for number, instruction, where, segment in self.jumps:
            self.check_jump(number, instruction, where, segment)
        self.problems.where = ""

    def check_place(self, instruction: Instruction) -> None:
        mnemonic = instruction.mnemonic
        allowed = _PLACES.get(mnemonic)
        if allowed is None:
            return
        if self.pou.kind not in allowed:
            message = f"{mnemonic} cannot stand in {_KIND_TEXT[self.pou.kind]}"
            expected = f"it in {' or '.join(_KIND_TEXT[kind] for kind in allowed)}"
            nearest = _INSTEAD.get((mnemonic, self.pou.kind))
            self.problems.add("STL060", instruction.span, message, expected=expected, nearest=nearest)
        elif mnemonic == "END" and self.segment is not None:
            message = "END cannot stand in an SCR segment"
            related = ((self.segment, "the segment begins here"),)
            self.problems.add("STL060", instruction.span, message, expected="it behind SCRE", related=related)

    def check_output(self, network: Network) -> None:
        instructions = network.instructions
        if not instructions:
            return
        for instruction in instructions:
            definition = DEFINITIONS.get(instruction.mnemonic)
            if definition is None or definition.power not in _PASSIVE:
                return
        last = instructions[-1]
        message = "nothing is done with the result of this network"
        self.problems.add("STL061", last.span, message, expected="an output, a box or a jump at its end")

    # -- FOR and NEXT

    def on_for(self, instruction: Instruction) -> None:
        self.loops.append((instruction, self.problems.where, self.segment))
        if len(self.loops) == LOOPS + 1:
            related = tuple((outer.span, "inside this") for outer, _, _ in self.loops[:1])
            message = f"{len(self.loops)} FOR loops stand inside each other"
            self.problems.add("STL055", instruction.span, message, expected=f"at most {LOOPS}", related=related)

    def on_next(self, instruction: Instruction) -> None:
        if not self.loops:
            self.problems.add("STL054", instruction.span, "NEXT without FOR", expected="a FOR before it in this block")
            return
        start, _, segment = self.loops.pop()
        if segment != self.segment:
            related = ((start.span, "the FOR is here"),)
            message = "FOR and NEXT stand in different SCR segments"
            self.problems.add("STL054", instruction.span, message, expected="both in one segment", related=related)

    # -- JMP and LBL

    def on_jump(self, instruction: Instruction) -> None:
        number = _number(instruction)
        if number is not None:
            self.jumps.append((number, instruction, self.problems.where, self.segment))

    def on_label(self, instruction: Instruction) -> None:
        number = _number(instruction)
        if number is None:
            return
        if number in self.labels:
            related = ((self.labels[number][0], "it is here already"),)
            message = f"there are two LBL {number} in this block"
            free = next(n for n in range(256) if n not in self.labels)
            expected = f"another number, for example {free}"
            self.problems.add("STL057", instruction.span, message, expected=expected, related=related)
        else:
            self.labels[number] = (instruction.span, self.segment)

    def check_jump(self, number: int, instruction: Instruction, where: str, segment: Span | None) -> None:
        label = self.labels.get(number)
        if label is None:
            message = f"there is no LBL {number} in this block"
            numbers = ", ".join(str(n) for n in sorted(self.labels)[:8])
            expected = f"one of {numbers}" if numbers else "a LBL; the block has none"
            self.problems.add("STL056", instruction.operands[0].span, message, expected=expected, where=where)
        elif label[1] != segment:
            related = ((label[0], "the label is here"),)
            message = (
                f"JMP {number} leaves its SCR segment" if segment is not None else f"JMP {number} enters an SCR segment"
            )
            expected = "jump and label in one segment, or both outside"
            self.problems.add("STL058", instruction.span, message, expected=expected, related=related, where=where)

    # -- SCR segments

    def on_segment(self, instruction: Instruction) -> None:
        if self.segment is not None:
            related = ((self.segment, "this segment is still open"),)
            message = "LSCR inside an SCR segment"
            self.problems.add("STL059", instruction.span, message, expected="SCRE before it", related=related)
        self.segment = instruction.span
        operand = instruction.operands[0] if instruction.operands else None
        if isinstance(operand, Direct):
            first = self.all_segments.setdefault(operand.address, instruction.span)
            if first is not instruction.span:
                related = ((first, "its segment begins here"),)
                message = f"{operand.symbol or operand.address} has a segment already"
                self.problems.add(
                    "STL059", operand.span, message, expected="one segment for each S bit", related=related
                )

    def on_segment_end(self, instruction: Instruction) -> None:
        if self.segment is None:
            self.problems.add(
                "STL059", instruction.span, "SCRE without LSCR", expected="an LSCR before it in this block"
            )
        self.segment = None

    def on_segment_leave(self, instruction: Instruction) -> None:
        if self.segment is None:
            message = "CSCRE stands outside of every SCR segment"
            self.problems.add("STL059", instruction.span, message, expected="it between LSCR and SCRE")


_HANDLERS: Final = MappingProxyType(
    {
        "FOR": _Structure.on_for,
        "NEXT": _Structure.on_next,
        "JMP": _Structure.on_jump,
        "LBL": _Structure.on_label,
        "LSCR": _Structure.on_segment,
        "SCRE": _Structure.on_segment_end,
        "CSCRE": _Structure.on_segment_leave,
    }
)


def _number(instruction: Instruction) -> int | None:
    operand = instruction.operands[0] if instruction.operands else None
    return operand.value if isinstance(operand, Constant) and isinstance(operand.value, int) else None
