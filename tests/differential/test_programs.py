"""Generated programs leave the same memory, stack, ENO, SM bits and errors in both executions, scan after scan."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, note, settings

from pcaccess.plc.cpu import Cpu
from pcaccess.plc.executor import MakeExecutor
from pcaccess.plc.interpreter import Interpreter
from pcaccess.s7200.cpu import cpu_model
from pcaccess.s7200.memory import AREA_START, MEMORY_SIZE
from pcaccess.stl import layout
from pcaccess.stl.checker import load_program
from pcaccess.stl.ir_check import verify
from pcaccess.stl.lower import lower
from pcaccess.stl.program import Program
from tests.differential.executions import COMPILED
from tests.differential.programs import Run, runs

MODEL = cpu_model()
BUDGET = 40
"""Backward jumps of a scan; endless loops are part of the game."""


def start(program: Program, run: Run, make_executor: MakeExecutor) -> Cpu:
    cpu = Cpu(MODEL, program, make_executor=make_executor, loop_budget=BUDGET)
    if run.junk is not None:
        cpu.memory[:MEMORY_SIZE] = random.Random(run.junk).randbytes(MEMORY_SIZE)
    for at, data in run.patches:
        cpu.memory[at : at + len(data)] = data
    cpu.run(0.0)
    return cpu


def state(cpu: Cpu) -> dict[str, object]:
    """Everything a program can leave behind, by names that help when two differ."""
    memory = bytes(cpu.memory)
    areas = {area.value: memory[start : start + _SIZE[area]] for area, start in AREA_START.items()}
    return {
        "mode": cpu.mode,
        "errors": [(record.code, record.place, record.count, record.first, record.last) for record in cpu.errors],
        "logic stack": memory[layout.LOGIC_STACK : layout.ENO],
        "ENO": memory[layout.ENO],
        **areas,
        "bits of T and C": memory[max(AREA_START.values()) : MEMORY_SIZE],
        "cells": memory[MEMORY_SIZE:],
    }


_ENDS = sorted([*AREA_START.values(), MEMORY_SIZE])
_SIZE = {area: next(end for end in _ENDS if end > at) - at for area, at in AREA_START.items()}


def read(run: Run) -> Program:
    result = load_program(run.text.encode(), MODEL, file="generated.awl")
    assert [str(problem) for problem in result.problems if problem.is_error] == []
    return result.unwrap()


@pytest.mark.timeout(900)  # Hypothesis takes up to five minutes to make a failure small
@pytest.mark.parametrize("execution", COMPILED)
@settings(max_examples=40)
@given(run=runs())
def test_a_program_does_the_same_in_every_execution(run: Run, execution: str) -> None:
    note(run.text)
    program = read(run)
    for function in lower(program, MODEL).functions:
        verify(function)
    plain, fast = (start(program, run, make) for make in (Interpreter, COMPILED[execution]))
    now = 0.0
    for number, tick in enumerate(run.ticks):
        for cpu in (plain, fast):
            cpu.set_inputs(tick.inputs)
            cpu.scan(now, load=tick.load)
        before, after = state(plain), state(fast)
        assert {name: after[name] for name in after if after[name] != before[name]} == {}, f"scan {number}"
        now += tick.elapsed
