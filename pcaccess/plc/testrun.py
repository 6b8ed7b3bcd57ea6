"""Runs scenarios in virtual time and says what was not as expected.

At each step ``set`` and the mode switch act before the first scan that starts at or after its time; what is
expected is checked after that scan, Q as outputs were written.

Not here: reading them (``pcaccess.plc.scenario``), the command (``pcaccess.cli.plc``).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from types import MappingProxyType
from typing import Any, Final
from xml.etree import ElementTree as Xml

from pcaccess.plc.cpu import Mode
from pcaccess.plc.errorlog import ErrorRecord
from pcaccess.plc.executor import MakeExecutor
from pcaccess.plc.interpreter import Interpreter
from pcaccess.plc.literals import quote
from pcaccess.plc.scenario import Scenario, Step
from pcaccess.plc.session import Session
from pcaccess.problems import Problem, Span
from pcaccess.s7200.address import Area
from pcaccess.s7200.memory import AREA_START
from pcaccess.s7200.types import Value

_INTERPRETING: Final = 0.3e-6
_COMPILING: Final = 100e-6
"""Seconds for an instruction."""
_LOADING_LLVM: Final = 0.5


@dataclass(frozen=True, slots=True)
class Failure:
    """One expectation that was not met."""

    at: str
    """The step's time, as written."""
    address: str
    """The place; ``mode`` or ``error`` for these."""
    expected: str
    actual: str
    span: Span
    wanted: Any = None
    """``expected`` for programs: a number, a text, or ``{"min": ..., "max": ...}``."""
    found: Any = None

    def __str__(self) -> str:
        """``crossing.yaml:12:5: at 1700ms: Q0.2 is 0, expected 1``"""
        return f"{self.span}: at {self.at}: {self.address} is {self.actual}, expected {self.expected}"

    def as_json(self) -> dict[str, Any]:
        return {
            "at": self.at,
            "address": self.address,
            "expected": self.wanted,
            "actual": self.found,
            "line": self.span.line,
            "column": self.span.column,
        }


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one scenario."""

    file: str
    failures: tuple[Failure, ...] = ()
    trace: tuple[dict[str, Any], ...] = ()
    """After every step, ``{"at": ..., "values": {...}}``; empty without ``trace``."""
    errors: tuple[ErrorRecord, ...] = ()
    """Run-time and fatal errors, expected or not."""
    scans: int = 0
    executor: str = ""
    unexpected: tuple[ErrorRecord, ...] = field(default=())
    """Errors that no step names; a fatal one is a failure too."""

    @property
    def passed(self) -> bool:
        return not self.failures

    def as_json(self) -> dict[str, Any]:
        data: dict[str, Any] = {"file": self.file, "passed": self.passed}
        data["failures"] = [failure.as_json() for failure in self.failures]
        if self.trace:
            data["trace"] = list(self.trace)
        return data


def is_worth_compiling(scenario: Scenario) -> bool:
    """Whether compiled code is done before the interpreter would be, by a rough reckoning."""
    instructions = sum(len(list(pou.instructions())) for pou in scenario.program.pous)
    scans = max((step.at for step in scenario.steps), default=0.0) / scenario.cycle
    return instructions * scans * _INTERPRETING > _LOADING_LLVM + instructions * _COMPILING


def run_scenario(scenario: Scenario, *, make_executor: MakeExecutor = Interpreter) -> Outcome:
    """Run one scenario from beginning to end, whatever fails on the way."""
    return _Run(scenario, make_executor).outcome()


class _Run:
    def __init__(self, scenario: Scenario, make_executor: MakeExecutor) -> None:
        self.scenario = scenario
        self.session = Session(
            scenario.model, scenario.program, cycle=scenario.cycle, load=scenario.load, make_executor=make_executor
        )
        start = AREA_START[Area.V]
        memory = memoryview(self.session.cpu.memory)
        scenario.data.write_to(memory[start : start + scenario.model.sizes[Area.V]])
        self.failures: list[Failure] = []
        self.trace: list[dict[str, Any]] = []

    def outcome(self) -> Outcome:
        for _, steps in groupby(self.scenario.steps, key=lambda step: self.session.first_scan(step.at)):
            together = list(steps)
            self.session.run_to(together[0].at)
            for step in together:
                self._act(step)
            self.session.scan()
            for step in together:
                self._check(step)
                if self.scenario.trace:
                    self.trace.append({"at": step.text, "values": self._values()})
        cpu = self.session.cpu
        cpu.close()
        named = {code.value for step in self.scenario.steps for code in step.errors}
        unexpected = tuple(record for record in cpu.errors if str(record.code) not in named)
        self._unexpected_stop(unexpected)
        return Outcome(
            file=self.scenario.file,
            failures=tuple(self.failures),
            trace=tuple(self.trace),
            errors=tuple(cpu.errors),
            scans=self.session.scans,
            executor=cpu.executor_name,
            unexpected=unexpected,
        )

    def _act(self, step: Step) -> None:
        cpu = self.session.cpu
        for setting in step.settings:
            cpu.write(setting.target.address, setting.type, setting.value)
        if step.switch is Mode.STOP:
            cpu.apply_writes()
            cpu.stop()
        elif step.switch is Mode.RUN:
            cpu.run(self.session.next_start)

    def _check(self, step: Step) -> None:
        cpu = self.session.cpu
        for placed in step.expectations:
            expectation = placed.value
            actual = cpu.read(expectation.target.address, expectation.type)
            if not expectation.holds(actual):
                shown = (expectation.shown, _shown(actual))
                place = expectation.target.text
                self._fail(step, placed.span, place, *shown, expectation.as_json(), _plain(actual))
        if step.mode is not None and cpu.mode is not step.mode.value:
            modes = (step.mode.value.value, cpu.mode.value)
            self._fail(step, step.mode.span, "mode", *modes, *modes)
        happened = [str(record.code) for record in cpu.errors]
        for code in step.errors:
            if code.value not in happened:
                self._fail(step, code.span, "error", code.value, ", ".join(happened) or "none", code.value, happened)

    def _fail(self, step: Step, span: Span, address: str, expected: str, actual: str, wanted: Any, found: Any) -> None:
        self.failures.append(Failure(step.text, address, expected, actual, span, wanted, found))

    def _unexpected_stop(self, unexpected: tuple[ErrorRecord, ...]) -> None:
        for record in unexpected:
            if record.is_fatal:
                last = self.scenario.steps[-1] if self.scenario.steps else None
                span = last.span if last else Span(self.scenario.file, 1, 1)
                self.failures.append(
                    Failure(f"{record.first:g}ms", "error", "none", str(record), span, None, str(record.code))
                )

    def _values(self) -> dict[str, Value]:
        cpu = self.session.cpu
        return {place.text: _plain(cpu.read(place.address, kind)) for place, kind in self.scenario.trace}


def _plain(value: Value) -> Value:
    """For JSON, which has no NaN: a text then, as in OPC UA Part 6, JSON encoding."""
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return int(value) if isinstance(value, bool) else value


def _shown(value: Value) -> str:
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, str):
        return quote(value)
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def junit(outcomes: Iterable[Outcome], unreadable: Mapping[str, Sequence[Problem]] = MappingProxyType({})) -> str:
    """The outcomes as JUnit XML: one test suite, a test case for each scenario.

    ``unreadable``: files that could not be run, with what is wrong with them.
    """
    outcomes = list(outcomes)
    counts = {
        "tests": len(outcomes) + len(unreadable),
        "failures": sum(not outcome.passed for outcome in outcomes),
        "errors": len(unreadable),
    }
    suite = Xml.Element("testsuite", {"name": "pcaccess plc scenario", **{k: str(n) for k, n in counts.items()}})
    for outcome in outcomes:
        case = Xml.SubElement(suite, "testcase", name=outcome.file, classname="scenario")
        if outcome.failures:
            text = "\n".join(str(failure) for failure in outcome.failures)
            message = f"{len(outcome.failures)} not as expected"
            Xml.SubElement(case, "failure", message=message).text = text
    for file, problems in unreadable.items():
        case = Xml.SubElement(suite, "testcase", name=file, classname="scenario")
        text = "\n".join(map(str, problems))
        Xml.SubElement(case, "error", message=f"{len(problems)} problems").text = text
    Xml.indent(suite)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + Xml.tostring(suite, encoding="unicode") + "\n"
