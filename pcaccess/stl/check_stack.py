"""The logic stack, network by network: too few values, values pushed out at the bottom, LPS without LPP.

Each level is followed as it moves. A value that a later rung leaves behind on the stack hurts nobody; only a level
that an instruction needs and that is not there is reported: never loaded in this network (STL050, STL053), or
pushed out because more than nine values were on the stack (STL051).

Source:   System Manual, "Logic stack instructions"; document 003, logic stack of nine levels.
"""

from __future__ import annotations

from typing import Final

from pcaccess.problems import Span
from pcaccess.stl.define import Definition, Power
from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import Constant, Instruction, Network

LEVELS: Final = 9
_PAIRED: Final = ("LRD", "LPP")


def check_stack(network: Network, problems: Collector) -> None:
    """One network. Stops silently at an instruction it does not know."""
    levels = 0
    lost: Span | None = None
    """Where a value was pushed out."""
    pushes: list[Span] = []
    started = False
    for instruction in network.instructions:
        definition = DEFINITIONS.get(instruction.mnemonic)
        if definition is None:
            return
        needs = _needs(instruction, definition)
        if needs > levels:
            if needs == 1 and not started and definition.power not in (Power.STACK,):
                _report_no_load(instruction, problems)
            elif lost is not None:
                _report_lost(instruction, lost, problems)
            elif instruction.mnemonic not in _PAIRED:
                _report_too_few(instruction, needs, levels, problems)
            levels = needs
            lost = None
        started = started or needs > 0 or definition.stack.delta > 0
        if instruction.mnemonic == "LPS":
            pushes.append(instruction.span)
        elif instruction.mnemonic in _PAIRED:
            if not pushes:
                message = f"{instruction.mnemonic} without LPS"
                problems.add("STL053", instruction.span, message, expected="an LPS before it in this network")
            elif instruction.mnemonic == "LPP":
                pushes.pop()
        levels += definition.stack.delta
        if levels > LEVELS:
            levels = LEVELS
            lost = instruction.span
    for span in pushes:
        problems.add("STL053", span, "LPS without LPP", expected="an LPP before the network ends")


def _needs(instruction: Instruction, definition: Definition) -> int:
    if instruction.mnemonic == "LDS" and instruction.operands:
        operand = instruction.operands[0]
        if isinstance(operand, Constant) and isinstance(operand.value, int) and 0 <= operand.value < LEVELS:
            return operand.value + 1
    return definition.stack.needs


def _report_no_load(instruction: Instruction, problems: Collector) -> None:
    message = f"nothing is loaded before {instruction.mnemonic}: it takes what the network before has left"
    problems.add("STL052", instruction.span, message, expected="LD or another load first; LD SM0.0 is always 1")


def _report_too_few(instruction: Instruction, needs: int, levels: int, problems: Collector) -> None:
    have = {0: "none", 1: "one"}.get(levels, str(levels))
    message = f"{instruction.mnemonic} needs {needs} values on the logic stack; this network has loaded {have}"
    problems.add("STL050", instruction.span, message, expected=f"{needs - levels} more LD before it")


def _report_lost(instruction: Instruction, lost: Span, problems: Collector) -> None:
    message = f"{instruction.mnemonic} needs a value that was pushed out: the logic stack has {LEVELS} levels"
    related = ((lost, "this pushed the value out"),)
    expected = "fewer branches in one network, or an intermediate result in a bit of M or L"
    problems.add("STL051", instruction.span, message, expected=expected, related=related)
