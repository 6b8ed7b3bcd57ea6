"""What holds for every instruction follows from its definition: power flow, pointers, constants.

Each variant is made from the first plain case of an instruction: the same operands behind pointers, as
constants, behind a pointer that names nothing, and without power.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from conformance import EXECUTORS, Case, Scan, compile_case, load_cases, run_case

from pcaccess.s7200.address import parse_address
from pcaccess.s7200.memory import MEMORY_SIZE
from pcaccess.stl.define import OperandSpec, Power
from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.program import Direct, Instruction

POINTER = "VD10000"


def instruction_of(case: Case) -> Instruction:
    """The instruction under test (MEND is none: the reader takes it for the end of the block)."""
    program = compile_case(case)
    found = [i for pou in program.pous for _, i in pou.instructions() if i.mnemonic == case.mnemonic]
    return next(i for i in found if len(i.operands) == len(words(case)))


def words(case: Case) -> list[str]:
    """The operands as the case writes them."""
    rest = case.do.splitlines()[0].partition(" ")[2]
    return [word.strip() for word in rest.split(",")] if rest else []


def plain_cases() -> dict[str, Case]:
    """The first case of each instruction that neither fails nor stops."""
    chosen: dict[str, Case] = {}
    for case in load_cases():
        if case.mnemonic in DEFINITIONS and not (case.fault or case.stop or case.problem):
            chosen.setdefault(case.mnemonic, case)
    return chosen


PLAIN = plain_cases()


def operands(case: Case) -> Iterator[tuple[int, OperandSpec, str]]:
    """Value operands of the case that are direct addresses: place, specification, text."""
    definition = DEFINITIONS[case.mnemonic]
    if definition.is_variadic or not definition.operands:
        return
    found = instruction_of(case).operands
    for number, (spec, operand, word) in enumerate(zip(definition.operands, found, words(case), strict=True)):
        if spec.is_value and isinstance(operand, Direct):
            yield number, spec, word


def with_operand(case: Case, number: int, text: str, given: dict[str, str]) -> Case:
    texts = words(case)
    texts[number] = text
    first = case.scans[0]
    scans = [Scan(first.at, {**first.given, **given}, first.expect, first.same), *case.scans[1:]]
    return case.instead(f"{case.mnemonic} {', '.join(texts)}", scans)


def behind_pointers() -> Iterator[tuple[Case, int]]:
    for case in PLAIN.values():
        for number, spec, word in operands(case):
            if spec.pointer and parse_address(word).area.value not in ("L", "AC", "HC"):
                yield with_operand(case, number, f"*{POINTER}", {POINTER: f"&{word}"}), number


def as_constants() -> Iterator[tuple[Case, int]]:
    for case in PLAIN.values():
        for number, spec, word in operands(case):
            text = case.scans[0].given.get(word)
            if spec.constant and text is not None:
                yield with_operand(case, number, text, {}), number


def label(variant: tuple[Case, int]) -> str:
    case, number = variant
    return f"{case.mnemonic}-{DEFINITIONS[case.mnemonic].operands[number].name}"


ON_EVERY_EXECUTION = pytest.mark.parametrize("executor", EXECUTORS)


@ON_EVERY_EXECUTION
@pytest.mark.parametrize("variant", list(behind_pointers()), ids=label)
def test_an_operand_behind_a_pointer_means_the_same(variant: tuple[Case, int], executor: str) -> None:
    seen = run_case(variant[0], EXECUTORS[executor])
    assert (seen.differences, seen.faults) == ([], [])


@ON_EVERY_EXECUTION
@pytest.mark.parametrize("variant", list(as_constants()), ids=label)
def test_a_constant_operand_means_the_same(variant: tuple[Case, int], executor: str) -> None:
    seen = run_case(variant[0], EXECUTORS[executor])
    assert (seen.differences, seen.faults) == ([], [])


@ON_EVERY_EXECUTION
@pytest.mark.parametrize("variant", list(behind_pointers()), ids=label)
def test_a_pointer_that_names_nothing_is_error_0006_and_changes_nothing(
    variant: tuple[Case, int], executor: str
) -> None:
    case, _ = variant
    definition = DEFINITIONS[case.mnemonic]
    only = Scan(0.0, {**case.scans[0].given, POINTER: "0", "Q1.7": "1", "IB0": "255"}, {})
    seen = run_case(case.instead(case.do, [only]), EXECUTORS[executor])
    assert seen.faults == ["0006"]
    if definition.power is Power.BOX:
        other = run_case(case.instead(f"MOVB *{POINTER}, VB10039", [only]), EXECUTORS[executor])
        assert seen.memory[0][:MEMORY_SIZE] == other.memory[0][:MEMORY_SIZE]


def is_box(case: Case) -> bool:
    return DEFINITIONS[case.mnemonic].power is Power.BOX and f"LD SM0.0\n{case.do}" in case.program


BOXES = [case for case in PLAIN.values() if is_box(case)]


@ON_EVERY_EXECUTION
@pytest.mark.parametrize("case", BOXES, ids=lambda case: case.mnemonic)
def test_a_box_without_power_changes_nothing(case: Case, executor: str) -> None:
    off = case.program.replace("LD SM0.0", "LD M31.7", 1)
    only = Scan(0.0, case.scans[0].given, {})
    seen = run_case(case.instead(case.do, [only], program=off), EXECUTORS[executor])
    without = off.replace(case.do, "NOP 0", 1)
    other = run_case(case.instead(case.do, [only], program=without), EXECUTORS[executor])
    assert seen.faults == []
    assert seen.memory[0][:MEMORY_SIZE] == other.memory[0][:MEMORY_SIZE]
