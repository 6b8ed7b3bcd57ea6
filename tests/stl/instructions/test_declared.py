"""What a definition declares and what its IR can do are the same: the manual's claim and our code check each other."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import pytest
from conformance import Case, compile_case, load_cases

from pcaccess.s7200.address import Area
from pcaccess.s7200.memory import AREA_START
from pcaccess.stl import ir
from pcaccess.stl.define import Definition, SmBit
from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.errors import INDIRECT_ADDRESS, RUN_TIME_ERRORS, RunTimeError
from pcaccess.stl.lower import lower

STRUCTURE = {"FOR", "NEXT", "JMP", "LBL", "LSCR", "SCRT", "SCRE", "CSCRE", "CALL", "MEND"}
"""These mean nothing alone; the conformance cases look at their errors."""
FLAGS = AREA_START[Area.SM] + 1

CASES: dict[str, list[Case]] = defaultdict(list)
for _case in load_cases():
    if _case.problem is None and _case.mnemonic not in STRUCTURE:
        CASES[_case.mnemonic].append(_case)

TESTED = [d for d in DEFINITIONS.values() if CASES[d.mnemonic]]


def alone(case: Case) -> list[ir.Operation]:
    """The IR of the instruction under test and nothing else."""
    program = compile_case(case)
    everything = (i for pou in program.pous for _, i in pou.instructions())
    chosen = next(i for i in everything if i.mnemonic == case.mnemonic)
    network = replace(program.main.networks[0], instructions=(chosen,))
    others = tuple(pou for pou in program.pous if pou is not program.main)
    module = lower(replace(program, pous=(replace(program.main, networks=(network,)), *others)), case.model)
    return list(module.functions[module.main].operations())


def touched(mnemonic: str) -> tuple[set[SmBit], set[RunTimeError]]:
    """SM bits and errors that the IR of any case can touch."""
    bits: set[SmBit] = set()
    errors: set[RunTimeError] = set()
    for case in CASES[mnemonic]:
        for op in alone(case):
            if isinstance(op, ir.StoreBits) and op.at == FLAGS:
                bits |= {SmBit(1, number) for number, _ in op.bits}
            elif isinstance(op, ir.CallPython):
                bits |= set(op.effects.sm)
                errors |= set(op.effects.errors)
            elif isinstance(op, ir.Fault) and op.code.constant is not None:
                errors.add(RUN_TIME_ERRORS[int(op.code.constant)])
    return bits, errors


@pytest.mark.parametrize("definition", TESTED, ids=lambda d: d.mnemonic)
def test_the_flags_and_errors_declared_are_those_the_ir_can_touch(definition: Definition) -> None:
    bits, errors = touched(definition.mnemonic)
    declared = {c for c in (*definition.eno_off, *definition.errors) if isinstance(c, RunTimeError)}
    assert bits == set(definition.sm)
    assert errors - {INDIRECT_ADDRESS} == declared - {INDIRECT_ADDRESS}


@pytest.mark.parametrize("definition", TESTED, ids=lambda d: d.mnemonic)
def test_error_0006_is_declared_where_a_pointer_can_stand(definition: Definition) -> None:
    has_pointer = any(operand.pointer for operand in definition.operands)
    declared = INDIRECT_ADDRESS in (*definition.eno_off, *definition.errors)
    assert declared is has_pointer
