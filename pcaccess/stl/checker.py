"""A whole program against the rules of the S7-200 and of one CPU model.

Every check is a module of its own: ``check_operands``, ``check_stack``, ``check_structure``, ``check_resources``,
``check_calls``. What the reader has reported already is not reported again.

Errors:   collected; nothing raises.
"""

from __future__ import annotations

from pathlib import Path

from pcaccess.problems import Problem
from pcaccess.s7200.cpu import CpuModel, cpu_model
from pcaccess.stl.check_calls import check_calls
from pcaccess.stl.check_operands import OperandChecker
from pcaccess.stl.check_resources import check_resources
from pcaccess.stl.check_stack import check_stack
from pcaccess.stl.check_structure import check_structure
from pcaccess.stl.datablock import check_data_block
from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import DataBlock, Program, SymbolTable
from pcaccess.stl.reader import ReadResult, read_program


def check_program(program: Program, cpu: CpuModel) -> list[Problem]:
    """Errors and warnings in file order."""
    problems = Collector(program.file)
    operands = OperandChecker(cpu, problems)
    for pou in program.pous:
        for network in pou.networks:
            problems.where = pou.where(network)
            for instruction in network.instructions:
                definition = DEFINITIONS.get(instruction.mnemonic)
                if definition is not None:
                    operands.check(instruction, definition)
            check_stack(network, problems)
    problems.where = ""
    check_structure(program, problems)
    check_resources(program, problems)
    check_calls(program, cpu, operands, problems)
    check_data_block(program.data, cpu, problems)
    return sorted(problems.problems, key=lambda problem: (problem.span, problem.code))


def load_program(
    data: bytes | Path,
    cpu: CpuModel | None = None,
    *,
    file: str | None = None,
    encoding: str | None = None,
    symbols: SymbolTable | None = None,
    data_block: DataBlock | None = None,
) -> ReadResult:
    """Read and check: the result has the problems of both. ``cpu``: a CPU 226 unless given.

    Raises as :func:`pcaccess.stl.reader.read_program` does; ``result.unwrap()`` raises for errors.
    """
    result = read_program(data, file=file, encoding=encoding, symbols=symbols, data_block=data_block)
    if result.program is None:
        return result
    found = check_program(result.program, cpu or cpu_model())
    problems = sorted((*result.problems, *found), key=lambda problem: (problem.span, problem.code))
    return ReadResult(result.program, tuple(problems), result.text, result.left_out)
