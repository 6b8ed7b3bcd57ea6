"""Scenarios: a test of a program as a YAML text (docs/scenarios.md). Reading and checking them.

Units:    times are milliseconds of virtual time.
Errors:   ProblemError with everything that is wrong in the scenario (SCN...) or in its program (STL...).
Not here: running them (``pcaccess.plc.testrun``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Generic, TypeVar

from pcaccess.plc.cpu import Mode
from pcaccess.plc.literals import (
    Expectation,
    LiteralError,
    Target,
    between,
    exactly,
    near,
    parse_target,
    parse_typed,
    parse_value,
)
from pcaccess.plc.problems import SCENARIO
from pcaccess.plc.session import CYCLE
from pcaccess.problems import Problem, ProblemError, Span, nearest_word
from pcaccess.project.durations import EXPECTED as A_DURATION
from pcaccess.project.durations import DurationError, parse_duration
from pcaccess.project.textfile import TextError, read_bytes
from pcaccess.project.yamltext import Mapping, Node, Scalar, Sequence, Tree, YamlError, read_yaml
from pcaccess.s7200.cpu import DEFAULT_CPU, CpuError, CpuModel, cpu_model
from pcaccess.s7200.types import DataType, Value
from pcaccess.stl.checker import load_program
from pcaccess.stl.datablock import parse_data_block
from pcaccess.stl.errors import FatalError, RunTimeError
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import DataBlock, Program, SymbolTable

_FILE_KEYS: Final = ("program", "cpu", "scan", "scan_load", "data", "trace", "steps")
_STEP_KEYS: Final = ("at", "set", "expect", "mode", "error")
_RANGE_KEYS: Final = ("min", "max", "near", "tol")
_CODES: Final = frozenset(str(code) for code in (*RunTimeError, *FatalError))

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Setting:
    target: Target
    type: DataType
    value: Value


@dataclass(frozen=True, slots=True)
class Placed(Generic[T]):
    """Something that is expected, and where the scenario says so."""

    value: T
    span: Span


@dataclass(frozen=True, slots=True)
class Step:
    """What happens at one time; see docs/scenarios.md."""

    at: float
    text: str
    """``at`` as written."""
    span: Span
    settings: tuple[Setting, ...] = ()
    expectations: tuple[Placed[Expectation], ...] = ()
    switch: Mode | None = None
    """The mode switch is turned before the scan."""
    mode: Placed[Mode] | None = None
    """The mode expected after the scan."""
    errors: tuple[Placed[str], ...] = ()
    """Codes that must have happened."""


@dataclass(frozen=True, slots=True)
class Scenario:
    file: str
    model: CpuModel
    program: Program
    cycle: float
    load: float
    data: DataBlock
    """Written into V memory after the program's own."""
    trace: tuple[tuple[Target, DataType], ...]
    steps: tuple[Step, ...]
    """In the order of their times."""


def load_scenario(path: Path) -> Scenario:
    """Read a scenario and its program. Raises ProblemError."""
    name = str(path)
    try:
        text = read_bytes(path).decode("utf-8")
    except TextError as error:
        raise ProblemError([SCENARIO.problem("SCN001", Span(name, error.line, error.column), str(error))]) from None
    except UnicodeDecodeError:
        raise ProblemError([SCENARIO.problem("SCN001", Span(name, 1, 1), "this is no text in UTF-8")]) from None
    return parse_scenario(text, name, path.parent)


def parse_scenario(text: str, file: str, base: Path) -> Scenario:
    """A scenario from its text; the program's path starts at ``base``. Raises ProblemError."""
    try:
        tree = read_yaml(text, file)
    except YamlError as error:
        raise ProblemError(SCENARIO.problem("SCN001", fault.span, fault.message) for fault in error.faults) from None
    reader = _Reader(tree, base)
    for fault in tree.faults:
        reader.problems.append(SCENARIO.problem("SCN001", fault.span, fault.message, related=fault.related))
    scenario = reader.scenario()
    if reader.problems or scenario is None:
        raise ProblemError(reader.problems)
    return scenario


class _Reader:
    def __init__(self, tree: Tree, base: Path) -> None:
        self.tree = tree
        self.base = base
        self.problems: list[Problem] = []
        self.model = cpu_model()
        self.program = Program(())

    def report(self, code: str, span: Span, message: str, **more: Any) -> None:
        self.problems.append(SCENARIO.problem(code, span, message, **more))

    def scenario(self) -> Scenario | None:
        root = self.tree.root
        if not isinstance(root, Mapping):
            self.report("SCN004", self.tree.span(root), "a scenario consists of keys", expected="program: and steps:")
            return None
        self._known_keys(root, _FILE_KEYS)
        self.model = self._model(root)
        program = self._program(root)
        if program is None:
            return None
        self.program = program
        return Scenario(
            file=self.tree.file,
            model=self.model,
            program=program,
            cycle=self._duration(root, "scan", CYCLE, least=0.001),
            load=self._duration(root, "scan_load", 0.0),
            data=self._data(root),
            trace=self._trace(root),
            steps=self._steps(root),
        )

    # pieces

    def _known_keys(self, node: Mapping, keys: tuple[str, ...]) -> None:
        for key in node.pairs:
            if key not in keys:
                message, expected = f"there is no key {key!r} here", f"one of {', '.join(keys)}"
                self.report(
                    "SCN002", self.tree.key_span(node, key), message, expected=expected, nearest=nearest_word(key, keys)
                )

    def _text(self, node: Mapping, key: str) -> str | None:
        value = node.get(key)
        if value is None:
            return None
        if not isinstance(value, Scalar) or value.text is None:
            self.report("SCN004", self.tree.value_span(node, key), f"{key} is one value", expected="a text or number")
            return None
        return value.text

    def _duration(self, node: Mapping, key: str, default: float, *, least: float = 0.0) -> float:
        text = self._text(node, key)
        if text is None:
            return default
        try:
            milliseconds = parse_duration(text) * 1000
        except DurationError as error:
            self.report("SCN004", self.tree.value_span(node, key), str(error), expected=A_DURATION)
            return default
        if milliseconds < least:
            self.report("SCN004", self.tree.value_span(node, key), f"{text} is too short", expected="more than 0ms")
            return default
        return round(milliseconds, 6)

    def _model(self, root: Mapping) -> CpuModel:
        text = self._text(root, "cpu") or DEFAULT_CPU
        try:
            return cpu_model(text)
        except CpuError as error:
            self.report("SCN004", self.tree.value_span(root, "cpu"), str(error))
            return cpu_model()

    def _program(self, root: Mapping) -> Program | None:
        text = self._text(root, "program")
        if text is None:
            if "program" not in root.pairs:
                self.report("SCN003", self.tree.span(root), "the program is missing", expected="program: FILE.awl")
            return None
        try:
            return load_program(self.base / text, self.model).unwrap()
        except OSError as error:
            why = error.strerror or str(error)
            self.report("SCN007", self.tree.value_span(root, "program"), f"{text}: {why}", expected="an STL program")
        except ProblemError as error:
            self.problems.extend(error.problems)
        return None

    def _data(self, root: Mapping) -> DataBlock:
        text, value = self._text(root, "data"), root.get("data")
        if text is None or value is None:
            return DataBlock()
        collector = Collector(self.tree.file)
        first = value.line if "\n" not in text.rstrip("\n") else value.line + 1
        lines = [(first + n, 0, line) for n, line in enumerate(text.split("\n"))]
        block = parse_data_block(lines, collector, "utf-8", self.program.symbols)
        self.problems.extend(collector.problems)
        return block

    def _trace(self, root: Mapping) -> tuple[tuple[Target, DataType], ...]:
        node = root.get("trace")
        if node is None:
            return ()
        if not isinstance(node, Sequence):
            self.report("SCN004", self.tree.value_span(root, "trace"), "trace is a list", expected="[Q0.0, VW10]")
            return ()
        targets = []
        for child in node.children:
            text = child.text if isinstance(child, Scalar) else None
            target = None if text is None else self._place(parse_typed, text, self.tree.span(child))
            if target is not None:
                targets.append(target)
        return tuple(targets)

    def _target(self, text: str, span: Span) -> Target | None:
        return self._place(parse_target, text, span)

    def _place(self, parse: Callable[[str, CpuModel, SymbolTable], T], text: str, span: Span) -> T | None:
        try:
            return parse(text, self.model, self.program.symbols)
        except LiteralError as error:
            self.report("SCN005", span, str(error), nearest=nearest_word(text, self.program.symbols.names()))
            return None

    # steps

    def _steps(self, root: Mapping) -> tuple[Step, ...]:
        node = root.get("steps")
        if node is None:
            self.report("SCN003", self.tree.span(root), "the steps are missing", expected="steps: and a list")
            return ()
        if not isinstance(node, Sequence):
            self.report("SCN004", self.tree.value_span(root, "steps"), "steps is a list", expected="- at: 100ms")
            return ()
        steps = [step for child in node.children if (step := self._step(child)) is not None]
        return tuple(sorted(steps, key=lambda step: step.at))

    def _step(self, node: Node) -> Step | None:
        if not isinstance(node, Mapping):
            self.report(
                "SCN004", self.tree.span(node), "a step consists of keys", expected="at: 100ms and what is done"
            )
            return None
        self._known_keys(node, _STEP_KEYS)
        if "at" not in node.pairs:
            self.report("SCN003", self.tree.span(node), "the time is missing", expected="at: 100ms")
            return None
        errors = self._errors(node)
        mode = self._mode(node, "mode")
        expectations, expected_mode = self._expectations(node)
        return Step(
            at=self._duration(node, "at", 0.0),
            text=self._text(node, "at") or "",
            span=self.tree.key_span(node, "at"),
            settings=self._settings(node),
            expectations=expectations,
            # beside an error the mode is what the error leads to, not the hand at the switch
            switch=None if errors or mode is None else mode.value,
            mode=mode if errors else expected_mode,
            errors=errors,
        )

    def _mode(self, node: Mapping, key: str) -> Placed[Mode] | None:
        text = self._text(node, key)
        if text is None:
            return None
        if text.upper() not in Mode.__members__:
            self.report("SCN004", self.tree.value_span(node, key), f"there is no mode {text!r}", expected="RUN or STOP")
            return None
        return Placed(Mode[text.upper()], self.tree.key_span(node, key))

    def _errors(self, node: Mapping) -> tuple[Placed[str], ...]:
        value = node.get("error")
        if value is None:
            return ()
        codes = []
        for child in value.children if isinstance(value, Sequence) else [value]:
            text = child.text or "" if isinstance(child, Scalar) else ""
            code = text.upper().removeprefix("16#").zfill(4)
            if code in _CODES:
                codes.append(Placed(code, self.tree.span(child)))
            else:
                message, expected = f"there is no error {text!r}", 'an error code such as "0006"'
                self.report("SCN004", self.tree.span(child), message, expected=expected)
        return tuple(codes)

    def _places(self, node: Mapping, key: str) -> list[tuple[str, Span, Node]]:
        value = node.get(key)
        if value is None:
            return []
        if not isinstance(value, Mapping):
            self.report("SCN004", self.tree.value_span(node, key), f"{key} says values", expected="{I0.0: 1, VW10: -5}")
            return []
        return [(name, self.tree.key_span(value, name), child) for name, (_, child) in value.pairs.items()]

    def _settings(self, node: Mapping) -> tuple[Setting, ...]:
        settings = []
        for name, span, child in self._places(node, "set"):
            target = self._target(name, span)
            if target is None:
                continue
            if not isinstance(child, Scalar) or child.text is None:
                self.report(
                    "SCN004", self.tree.span(child), f"{name} is set to one value", expected="a number or a text"
                )
                continue
            text, quoted = child.text, child.quoted
            pair = self._fitting(child, lambda t=target, x=text, q=quoted: parse_value(x, q, t))  # type: ignore[misc]
            if pair is not None:
                settings.append(Setting(target, *pair))
        return tuple(settings)

    def _expectations(self, node: Mapping) -> tuple[tuple[Placed[Expectation], ...], Placed[Mode] | None]:
        expectations: list[Placed[Expectation]] = []
        mode = None
        for name, span, child in self._places(node, "expect"):
            if name.lower() == "mode":
                value = node.get("expect")
                assert isinstance(value, Mapping)
                mode = self._mode(value, name)
                continue
            target = self._target(name, span)
            expectation = None if target is None else self._expectation(target, child)
            if expectation is not None:
                expectations.append(Placed(expectation, span))
        return tuple(expectations), mode

    def _expectation(self, target: Target, node: Node) -> Expectation | None:
        if isinstance(node, Scalar) and node.text is not None:
            text, quoted = node.text, node.quoted
            return self._fitting(node, lambda: exactly(target, text, quoted))
        if not isinstance(node, Mapping):
            expected = "a value, {min: 0, max: 1} or {near: 12.5, tol: 0.01}"
            self.report("SCN004", self.tree.span(node), f"{target.text}: nothing to compare with", expected=expected)
            return None
        self._known_keys(node, _RANGE_KEYS)
        middle = self._text(node, "near")
        if middle is not None:
            return self._fitting(node, lambda: near(target, middle, self._text(node, "tol")))
        return self._fitting(node, lambda: between(target, self._text(node, "min"), self._text(node, "max")))

    def _fitting(self, node: Node, make: Callable[[], T]) -> T | None:
        try:
            return make()
        except LiteralError as error:
            self.report("SCN006", self.tree.span(node), str(error))
            return None
