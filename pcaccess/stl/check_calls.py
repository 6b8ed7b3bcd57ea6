"""Calls and interrupts over the whole program: targets, parameters, nesting; numbers that a CPU model lacks.

Source:   System Manual, "Subroutines" (nesting 8; a subroutine that an interrupt routine calls calls no other;
          recursion is not forbidden), "Interrupts" (events per CPU), CPU specifications (ports, counters).
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from pcaccess.problems import Span
from pcaccess.s7200.address import Area
from pcaccess.s7200.cpu import CpuModel
from pcaccess.s7200.types import DataType
from pcaccess.stl.check_operands import OperandChecker
from pcaccess.stl.define import In, InOut, OperandSpec, Out
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import (
    Constant,
    Instruction,
    Pou,
    PouKind,
    PouReference,
    Program,
    Section,
    Unresolved,
    Variable,
)

NESTING: Final = 8
"""Calls inside each other from the main program."""
INTERRUPT_NESTING: Final = 1
MAX_NUMBER: Final = 127
"""Of a subroutine or interrupt routine on the largest CPU."""
_SMALL: Final = frozenset({"CPU 221", "CPU 222"})
_SMALL_EVENTS: Final = frozenset({*range(13), *range(19, 24), *range(27, 34)})
_ONE_PORT_EVENTS: Final = frozenset({*range(24), *range(27, 34)})
_SMALL_COUNTERS: Final = frozenset({0, 3, 4, 5})
_MAX_SBR: Final = MappingProxyType({"CPU 226XM": MAX_NUMBER})
_MAKERS: Final = MappingProxyType({Section.IN: In, Section.IN_OUT: InOut, Section.OUT: Out})

_Block = tuple[PouKind, int]
_Call = tuple[Pou, Instruction, str]
"""Called block, the CALL, where it stands."""
_Calls = Mapping[_Block, list[_Call]]


def check_calls(program: Program, cpu: CpuModel, operands: OperandChecker, problems: Collector) -> None:
    _check_blocks(program, cpu, problems)
    specs: dict[_Block, tuple[OperandSpec, ...]] = {}
    calls: dict[_Block, list[_Call]] = {}
    for pou in program.pous:
        own = calls.setdefault((pou.kind, pou.number), [])
        for network in pou.networks:
            problems.where = pou.where(network)
            for instruction in network.instructions:
                if instruction.mnemonic == "CALL":
                    target = _target(instruction, program, problems)
                    if target is not None:
                        own.append((target, instruction, problems.where))
                        wanted = specs.setdefault((target.kind, target.number), _specs(target))
                        _check_parameters(instruction, target, wanted, operands, problems)
                elif instruction.mnemonic == "ATCH":
                    _target(instruction, program, problems)
                    _check_event(instruction, 1, cpu, problems)
                else:
                    check = _MODEL_CHECKS.get(instruction.mnemonic)
                    if check is not None:
                        check(instruction, cpu, problems)
    problems.where = ""
    _check_recursion(program, calls, problems)
    _check_nesting(program, calls, problems)


def _check_blocks(program: Program, cpu: CpuModel, problems: Collector) -> None:
    if program.find(PouKind.MAIN, 1) is None:
        span = program.pous[0].span if program.pous else problems.span(1, 1)
        message = "this program has no main program, so nothing is ever executed"
        problems.add("STL085", span, message, expected="ORGANIZATION_BLOCK MAIN:OB1")
    for pou in program.pous:
        last = MAX_NUMBER if pou.kind is PouKind.INT else _MAX_SBR.get(cpu.name, 63)
        if pou.kind is not PouKind.MAIN and pou.number > last:
            message = f"a {cpu.name} has no {pou.block}"
            problems.add("STL036", pou.span, message, expected=f"{pou.kind.value}0 to {pou.kind.value}{last}")


def _target(instruction: Instruction, program: Program, problems: Collector) -> Pou | None:
    reference = instruction.operands[0] if instruction.operands else None
    wanted = PouKind.SBR if instruction.mnemonic == "CALL" else PouKind.INT
    if not isinstance(reference, PouReference) or reference.kind is not wanted:
        return None  # reported with the operands
    found = program.find(reference.kind, reference.number)
    if found is None:
        what = "subroutine" if wanted is PouKind.SBR else "interrupt routine"
        names = [pou.name for pou in program.pous if pou.kind is wanted]
        message = f"there is no {what} {reference.name} in this program"
        expected = ", ".join(names[:8]) if names else "one of this program; it has none"
        nearest = problems.nearest(reference.name, names)
        problems.add("STL080", reference.span, message, expected=expected, nearest=nearest)
    return found


def _specs(target: Pou) -> tuple[OperandSpec, ...]:
    return tuple(_spec(variable) for variable in target.parameters)


def _spec(variable: Variable) -> OperandSpec:
    if variable.section is Section.IN and variable.data_type is DataType.DWORD:
        return In(variable.name, variable.data_type, address_of=True)
    if variable.data_type is DataType.STRING:  # passed as a pointer, and a constant has no address
        return In(variable.name, variable.data_type, constant=False, areas=frozenset({Area.V}))
    return _MAKERS[variable.section](variable.name, variable.data_type)


def _check_parameters(
    instruction: Instruction,
    target: Pou,
    specs: tuple[OperandSpec, ...],
    operands: OperandChecker,
    problems: Collector,
) -> None:
    given = instruction.operands[1:]
    if any(isinstance(operand, Unresolved) for operand in given):
        return  # what was not understood may have been several operands
    if len(given) != len(specs):
        wanted = ", ".join(f"{spec.name} ({variable.section.value} {variable.data_type.name})"
                           for spec, variable in zip(specs, target.parameters, strict=True))  # fmt: skip
        message = f"{target.name} is called with {len(given)} parameter{'' if len(given) == 1 else 's'}"
        span = given[len(specs)].span if len(given) > len(specs) else instruction.operands[0].span
        related = ((target.span, f"{target.name} is here"),)
        expected = f"{len(specs)}: {wanted}" if specs else "none"
        problems.add("STL081", span, message, expected=expected, related=related)
        return
    for operand, spec, variable in zip(given, specs, target.parameters, strict=True):
        what = f"parameter {spec.name} ({variable.section.value}) of {target.name}"
        if variable.data_type is DataType.STRING and isinstance(operand, Constant) and isinstance(operand.value, str):
            message = f"{what} is passed as the address of a text, and {operand.symbol or operand.text} has none"
            expected = f"where it lies in V memory: VB0, say, with VB0 {operand.text} in the data block"
            problems.add("STL026", operand.span, message, expected=expected)
            continue
        operands.check_one(operand, spec, what, "STL082")


# -- what a CPU model lacks


def _constant(instruction: Instruction, at: int) -> tuple[int, Span] | None:
    operand = instruction.operands[at] if len(instruction.operands) > at else None
    if isinstance(operand, Constant) and isinstance(operand.value, int):
        return operand.value, operand.span
    return None


def _check_event(instruction: Instruction, at: int, cpu: CpuModel, problems: Collector) -> None:
    found = _constant(instruction, at)
    if found is None or not 0 <= found[0] <= 33:
        return
    if cpu.name in _SMALL:
        missing, expected = found[0] not in _SMALL_EVENTS, "0 to 12, 19 to 23 or 27 to 33"
    else:
        missing, expected = cpu.ports < 2 and found[0] not in _ONE_PORT_EVENTS, "0 to 23 or 27 to 33"
    if missing:
        problems.add("STL036", found[1], f"a {cpu.name} has no interrupt event {found[0]}", expected=expected)


def _check_detach(instruction: Instruction, cpu: CpuModel, problems: Collector) -> None:
    _check_event(instruction, 0, cpu, problems)


def _check_counter(instruction: Instruction, cpu: CpuModel, problems: Collector) -> None:
    found = _constant(instruction, 0)
    if found is not None and cpu.name in _SMALL and 0 <= found[0] <= 5 and found[0] not in _SMALL_COUNTERS:
        message = f"a {cpu.name} has no high-speed counter {found[0]}"
        problems.add("STL036", found[1], message, expected="0, 3, 4 or 5")


def _check_port(instruction: Instruction, cpu: CpuModel, problems: Collector) -> None:
    found = _constant(instruction, 1)
    if found is not None and found[0] == 1 and cpu.ports < 2:
        problems.add("STL036", found[1], f"a {cpu.name} has no port 1", expected="port 0")


_MODEL_CHECKS: Final = MappingProxyType(
    {
        "DTCH": _check_detach,
        "HDEF": _check_counter,
        "HSC": _check_counter,
        **dict.fromkeys(("XMT", "RCV", "NETR", "NETW", "GPA", "SPA"), _check_port),
    }
)


# -- nesting


def _check_recursion(program: Program, calls: _Calls, problems: Collector) -> None:
    """A warning at each CALL that leads back to the block it stands in."""
    callees = {
        block: frozenset((target.kind, target.number) for target, _, _ in of)
        for block, of in calls.items()
        if block[1] <= MAX_NUMBER  # others were reported, and their number would have no end
    }
    reached = {block: _reachable(block, callees) for block in callees}
    for pou in program.pous:
        for target, instruction, where in calls[pou.kind, pou.number]:
            if (pou.kind, pou.number) in reached.get((target.kind, target.number), ()):
                via = "itself" if target is pou else f"itself through {target.name}"
                message = f"{pou.name} calls {via}"
                expected = f"an end to it: at most {NESTING} calls can be nested"
                problems.add("STL083", instruction.span, message, expected=expected, where=where)


def _reachable(start: _Block, callees: Mapping[_Block, frozenset[_Block]]) -> set[_Block]:
    """The blocks that ``start`` calls, directly or not."""
    seen: set[_Block] = set()
    waiting = [start]
    while waiting:
        found = callees.get(waiting.pop(), frozenset()) - seen
        seen |= found
        waiting += found
    return seen


def _check_nesting(program: Program, calls: _Calls, problems: Collector) -> None:
    """The first CALL on each way that goes too deep; recursion is counted once round."""
    reported: set[int] = set()
    for start in program.pous:
        if start.kind is PouKind.SBR:
            continue
        limit = NESTING if start.kind is PouKind.MAIN else INTERRUPT_NESTING
        deepest: dict[_Block, int] = {(start.kind, start.number): 0}
        waiting: list[tuple[Pou, tuple[str, ...]]] = [(start, (start.name,))]
        while waiting:
            pou, way = waiting.pop()
            for target, instruction, where in calls[pou.kind, pou.number]:
                if target.name in way:
                    continue
                if len(way) > limit:
                    if id(instruction) not in reported:
                        reported.add(id(instruction))
                        _report_deep(start, (*way, target.name), instruction, where, limit, problems)
                    continue
                key = (target.kind, target.number)
                if deepest.get(key, -1) < len(way):
                    deepest[key] = len(way)
                    waiting.append((target, (*way, target.name)))


def _report_deep(
    start: Pou, way: tuple[str, ...], instruction: Instruction, where: str, limit: int, problems: Collector
) -> None:
    shown = " > ".join(way if len(way) <= 5 else (*way[:2], "…", *way[-2:]))
    if start.kind is PouKind.MAIN:
        message = f"this call is nested {len(way) - 1} deep: {shown}"
        expected = f"at most {limit}"
    else:
        message = f"a subroutine called by an interrupt routine calls another: {shown}"
        expected = "no CALL in a subroutine that an interrupt routine uses"
    problems.add("STL084", instruction.span, message, expected=expected, where=where)
