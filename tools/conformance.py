"""Conformance cases of STL instructions: YAML tables in tests/conformance, and how one is run.

A file has ``source``, a ``program`` with ``{do}`` in it, and ``cases``. A case has
- ``do``: the instruction under test (or a list of several that must behave the same);
- ``with``: a list of replacements for ``{words}`` in the whole case: one case for each row;
- ``given``: what is put into memory before the scan (``&VB100`` is a pointer; bits of SMB1 that the case
  expects and does not give start with the opposite value);
- ``expect``: what is there afterwards; ``same``: places that must not change;
- ``fault``: the run-time error that happens, the CPU stays in RUN; ``stop``: the fatal one, or "STOP";
  ``problem``: the checker refuses the program with this code;
- ``then``: further scans, each with ``at`` (ms, default 10 more), ``given``, ``expect``, ``same``;
- ``program``, ``cpu``: instead of the file's; ``why``: which rule the case is about.

Errors:   ValueError for a case that does not keep this.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import yaml

from pcaccess.plc.compiler import Compiled
from pcaccess.plc.cpu import Cpu, Mode
from pcaccess.plc.executor import Executor, MakeExecutor
from pcaccess.plc.interpreter import Interpreter
from pcaccess.plc.literals import Target, parse_target, parse_value
from pcaccess.problems import ProblemError
from pcaccess.s7200.address import Area, parse_address
from pcaccess.s7200.cpu import CpuModel, cpu_model
from pcaccess.s7200.memory import write_value
from pcaccess.s7200.pointers import pointer_to
from pcaccess.s7200.types import DataType, Value
from pcaccess.stl import layout
from pcaccess.stl.checker import check_program
from pcaccess.stl.ir import Module
from pcaccess.stl.program import Program, SymbolTable
from pcaccess.stl.reader import read_program
from pcaccess.stl.runtime import Runtime

FOLDER: Final = Path(__file__).parent.parent / "tests" / "conformance"
_CASE_KEYS: Final = {
    "do",
    "with",
    "given",
    "expect",
    "same",
    "fault",
    "stop",
    "problem",
    "then",
    "program",
    "cpu",
    "why",
}
_SCAN_KEYS: Final = {"at", "given", "expect", "same"}
NOWHERE: Final = SymbolTable()


def compiled(module: Module, runtime: Runtime) -> Executor:
    """Machine code, or nothing: not the interpreter instead."""
    return Compiled(module, runtime, optimise=False)


EXECUTORS: Final[dict[str, MakeExecutor]] = {"interpreter": Interpreter, "compiled": compiled}
"""Every execution, by the name that tests show."""


@dataclass(frozen=True, slots=True)
class Scan:
    at: float
    given: Mapping[str, str]
    expect: Mapping[str, str]
    same: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Case:
    file: str
    number: int
    do: str
    program: str
    """With ``do`` in its place."""
    scans: tuple[Scan, ...]
    source: str
    why: str = ""
    fault: str | None = None
    stop: str | None = None
    problem: str | None = None
    cpu: str = "CPU 226"

    def __str__(self) -> str:
        return f"{self.file}-{self.number}-{self.do.splitlines()[0] if self.do else self.why}"

    @property
    def mnemonic(self) -> str:
        """Of the instruction under test: the first of ``do``."""
        return self.do.split()[0].upper() if self.do else ""

    @property
    def model(self) -> CpuModel:
        return cpu_model(self.cpu)

    def instead(self, do: str, scans: Sequence[Scan], **more: Any) -> Case:
        """The same case with another instruction and other values."""
        changes = {"program": self.program.replace(self.do, do, 1), **more}
        return replace(self, do=do, scans=tuple(scans), **changes)


def load_cases(folder: Path = FOLDER) -> list[Case]:
    """All cases of all files, in order."""
    cases: list[Case] = []
    for path in sorted(folder.glob("*.yaml")):
        data = yaml.load(path.read_text(encoding="utf-8"), Loader=yaml.BaseLoader)
        number = 0
        for row in data["cases"]:
            for expanded in _expand(row):
                number += 1
                cases.append(_case(path.stem, number, expanded, data))
    return cases


def _expand(row: dict[str, Any]) -> Iterator[dict[str, Any]]:
    unknown = set(row) - _CASE_KEYS
    if unknown:
        raise ValueError(f"unknown keys {unknown} in {row}")
    for words in row.get("with", [{}]):
        filled = _fill({key: value for key, value in row.items() if key != "with"}, words)
        for do in filled["do"] if isinstance(filled.get("do"), list) else [filled.get("do", "")]:
            yield filled | {"do": do}


def _fill(value: Any, words: dict[str, str]) -> Any:
    if isinstance(value, dict):
        return {_fill(k, words): _fill(v, words) for k, v in value.items()}
    if isinstance(value, list):
        return [_fill(v, words) for v in value]
    return re.sub(r"\{(\w+)\}", lambda m: words.get(m[1], m[0]), value)


def _case(file: str, number: int, row: dict[str, Any], data: dict[str, Any]) -> Case:
    program = row.get("program", data["program"]).replace("{do}", row["do"])
    first = Scan(0.0, row.get("given", {}), row.get("expect", {}), _list(row.get("same", ())))
    scans = [first]
    for more in row.get("then", ()):
        if set(more) - _SCAN_KEYS:
            raise ValueError(f"unknown keys in {more}")
        at = float(more.get("at", scans[-1].at + 10))
        scans.append(Scan(at, more.get("given", {}), more.get("expect", {}), _list(more.get("same", ()))))
    return Case(
        file=file,
        number=number,
        do=row["do"],
        program=program,
        scans=tuple(scans),
        source=data["source"],
        why=row.get("why", ""),
        fault=row.get("fault"),
        stop=row.get("stop"),
        problem=row.get("problem"),
        cpu=row.get("cpu", data.get("cpu", "CPU 226")),
    )


def _list(value: Any) -> tuple[str, ...]:
    return (value,) if isinstance(value, str) else tuple(value)


def compile_case(case: Case) -> Program:
    """The case's program, read and checked. Raises ProblemError."""
    result = read_program(case.program.encode("latin-1"), file=str(case))
    problems = list(result.problems)
    if result.program is not None and result.ok:
        problems += [p for p in check_program(result.program, case.model) if p not in problems]
    if result.program is None or any(p.is_error for p in problems):
        raise ProblemError(problems)
    return result.program


@dataclass(slots=True)
class Observed:
    """What a case did."""

    differences: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    mode: Mode = Mode.RUN
    memory: list[bytes] = field(default_factory=list)
    """After each scan."""


def run_case(case: Case, make_executor: MakeExecutor, program: Program | None = None) -> Observed:
    """Run the case's scans and compare."""
    cpu = Cpu(case.model, program or compile_case(case), make_executor=make_executor)
    cpu.run(0.0)
    seen = Observed()
    for number, scan in enumerate(case.scans):
        if number == 0:
            _preset(cpu, scan, case)
        for name, text in scan.given.items():
            put(cpu, name, text)
        before = {name: _value(cpu, target(name, case)) for name in scan.same}
        cpu.scan(scan.at)
        seen.memory.append(bytes(cpu.memory))
        for name, text in scan.expect.items():
            _compare(cpu, name, text, case, seen, f"scan {number}")
        for name, was in before.items():
            now = _value(cpu, target(name, case))
            if now != was:
                seen.differences.append(f"scan {number}: {name} changed from {was!r} to {now!r}")
    seen.faults = [str(record.code) for record in cpu.errors]
    seen.mode = cpu.mode
    return seen


def target(name: str, case: Case) -> Target:
    return parse_target(name, case.model, NOWHERE)


def _preset(cpu: Cpu, scan: Scan, case: Case) -> None:
    """SM bits and Q1.7 that are expected and not given start with the opposite value."""
    for name, text in scan.expect.items():
        place = target(name, case)
        flag = (place.address.area is Area.SM and place.address.offset == 1) or name == "Q1.7"
        if flag and name not in scan.given and text in ("0", "1"):
            write_value(cpu.memory, place.address, DataType.BOOL, text == "0")


def put(cpu: Cpu, name: str, text: str) -> None:
    """Store a value as a case writes it; inputs change at once, terminal and image."""
    place = parse_target(name, cpu.model, NOWHERE)
    kind, value = meaning(text, place)
    address = place.address.as_type(kind)
    write_value(cpu.memory, address, kind, value)
    if address.area is Area.I:
        cpu.memory[layout.PHYSICAL_INPUTS : layout.PHYSICAL_INPUTS + 16] = cpu.memory[0:16]


def meaning(text: str, place: Target) -> tuple[DataType, Value]:
    """A value of a case: a number, a pointer, a text in quotes."""
    if text.startswith("&"):
        return DataType.DWORD, pointer_to(parse_address(text[1:]))
    return parse_value(text.strip('"'), text == "" or text.startswith('"'), place)


def _value(cpu: Cpu, place: Target) -> bytes | bool:
    address = place.address
    if address.width.value == 1:
        return bool(cpu.read(address, DataType.BOOL))
    kind = {8: DataType.BYTE, 16: DataType.WORD, 32: DataType.DWORD}[address.width.value]
    return kind.encode(cpu.read(address, kind))


def _compare(cpu: Cpu, name: str, text: str, case: Case, seen: Observed, when: str) -> None:
    place = target(name, case)
    kind, value = meaning(text, place)
    actual = cpu.read(place.address, kind)
    if actual != value:
        seen.differences.append(f"{when}: {name} is {actual!r}, expected {value!r}")
