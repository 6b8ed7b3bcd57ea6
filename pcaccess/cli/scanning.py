"""A program that scans in real time, with chosen places of its memory in view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Final, Protocol

import typer
from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from pcaccess.cli.output import GAP, Cell, Column, Row, json_line, note, rich_table
from pcaccess.cli.streams import put_now
from pcaccess.cli.values import json_value, value_text
from pcaccess.clock import Clock
from pcaccess.counting import counted
from pcaccess.items.varianttypes import VARIANT_TYPES
from pcaccess.links.scanning import LOOPS, SHORTEST_PAUSE
from pcaccess.plc.cpu import Cpu
from pcaccess.plc.errorlog import ErrorRecord
from pcaccess.plc.executor import MakeExecutor
from pcaccess.plc.literals import LiteralError, Target, parse_target, parse_typed, parse_value, plain_type
from pcaccess.plc.watchdog import TimedWatchdog
from pcaccess.s7200.address import Address, Area
from pcaccess.s7200.cpu import CpuModel
from pcaccess.s7200.types import DataType, Value
from pcaccess.stl.program import Program
from pcaccess.stl.xref import cross_reference

COLUMNS: Final = (Column("Address"), Column("Symbol"), Column("Value", right=True), Column("Hex", right=True))
REFRESH: Final = 10.0
"""Paintings per second of the live table."""
_HEX: Final = {DataType.BYTE: 2, DataType.WORD: 4, DataType.INT: 4, DataType.DWORD: 8, DataType.DINT: 8}


_NUMBERED: Final = (Area.T, Area.C)
_UNSEEN: Final = frozenset({Area.L, Area.AC, Area.SM})
"""What is over at the end of a scan, or the CPU's own."""


@dataclass(frozen=True, slots=True)
class Place:
    """A place of memory in view."""

    address: Address
    type: DataType
    symbol: str

    @property
    def name(self) -> str:
        """``T37`` is a timer's value, ``T37.bit`` its bit."""
        is_bit = self.address.area in _NUMBERED and self.type is DataType.BOOL
        return f"{self.address}.bit" if is_bit else str(self.address)

    def text(self, value: Value) -> str:
        return str(int(value)) if isinstance(value, bool) else value_text(value, VARIANT_TYPES[self.type])

    def row(self, value: Value) -> Row:
        """Cells of ``COLUMNS``."""
        digits = _HEX.get(self.type)
        pattern = f"16#{int(value) & (1 << digits * 4) - 1:0{digits}X}" if digits else ""
        on = "good" if value is True else ""
        return self.name, Cell(self.symbol, "dim"), Cell(self.text(value), on), Cell(pattern, "dim")

    def as_json(self, at: float, value: Value) -> dict[str, Any]:
        """``at``: milliseconds since the start."""
        shown = json_value(value, VARIANT_TYPES[self.type])
        return {"at": round(at), "address": self.name, "symbol": self.symbol or None, "value": shown}


def parse_place(text: str, program: Program, model: CpuModel) -> Place:
    """``Q0.0``, a symbol, or with a type ``VD20:REAL``. Raises BadParameter."""
    try:
        target, kind = parse_typed(text, model, program.symbols)
    except LiteralError as error:
        raise typer.BadParameter(str(error)) from None
    return Place(target.address, kind, program.symbols.name_of(target.address) or "")


def places_of(program: Program) -> list[Place]:
    """What the program itself names, in the order of a cross reference; of timers and counters value and bit."""
    addresses = dict.fromkeys(use.address for use in cross_reference(program) if use.address.area not in _UNSEEN)
    places: dict[Place, None] = {}
    for address in addresses:
        kinds = [plain_type(Target(str(address), address))]
        if address.area in _NUMBERED:
            kinds = [DataType.INT, DataType.BOOL]
        for kind in kinds:
            places[Place(address.as_type(kind), kind, program.symbols.name_of(address) or "")] = None
    return list(places)


def write_setting(cpu: Cpu, text: str, program: Program, model: CpuModel) -> None:
    """``I0.0=1`` before the first scan. Raises BadParameter."""
    name, equals, value = text.partition("=")
    try:
        if not equals:
            raise LiteralError(f"{text}: write ADDRESS=VALUE")
        target = parse_target(name.strip(), model, program.symbols)
        kind, parsed = parse_value(value.strip().strip("\"'"), value.strip()[:1] in ("'", '"'), target)
        cpu.write(target.address, kind, parsed)
    except LiteralError as error:
        raise typer.BadParameter(str(error)) from None


# ---------------------------------------------------------------------- scanning


@dataclass(slots=True)
class Status:
    """How the CPU is doing."""

    mode: str = "STOP"
    scans: int = 0
    last: float = 0.0
    longest: float = 0.0
    """Milliseconds that scans took."""

    def __str__(self) -> str:
        scans = counted({"scans": self.scans}, "scans") or "no scan"
        return f"{self.mode}, {scans}, last {self.last:.3g} ms, longest {self.longest:.3g} ms"


class View(Protocol):
    """Where values go."""

    def show(self, at: float, changes: Sequence[tuple[Place, Value]], status: Status) -> None:
        """After a scan that began ``at`` milliseconds since the start."""

    def error(self, record: ErrorRecord) -> None:
        """A run-time error, at its first time."""


class Scanner:
    """A CPU in real time."""

    def __init__(self, model: CpuModel, program: Program, clock: Clock, make_executor: MakeExecutor) -> None:
        self._clock = clock
        self._began = clock.monotonic()
        self.cpu = Cpu(
            model,
            program,
            now=self._began * 1000,
            make_executor=make_executor,
            loop_budget=LOOPS,
            watchdog=TimedWatchdog(clock),
        )
        self.status = Status()

    async def run(self, places: Sequence[Place], view: View, period: float | None, duration: float | None) -> None:
        """Scan every ``period`` seconds (None: freely), at least once, until ``duration`` is over.

        A fatal error ends it too.
        """
        clock, cpu = self._clock, self.cpu
        start = due = clock.monotonic()
        first: float | None = None
        cpu.run(start * 1000)
        seen: dict[Place, Value] = {}
        told = 0
        while True:
            self._scan()
            values = {place: cpu.read(place.address, place.type) for place in places}
            changes = [(place, value) for place, value in values.items() if not _same(seen.get(place), value)]
            seen = values
            first = self._began if first is None else first
            view.show((self._began - first) * 1000, changes, self.status)
            for record in cpu.errors[told:]:
                view.error(record)
            told = len(cpu.errors)
            if cpu.fatal is not None:
                return
            due = max(due + (period or 0.0), clock.monotonic() + SHORTEST_PAUSE)
            if duration is not None and due - start >= duration:
                return
            await clock.sleep(due - clock.monotonic())

    def _scan(self) -> None:
        self._began = self._clock.monotonic()
        self.cpu.scan(self._began * 1000)
        took = (self._clock.monotonic() - self._began) * 1000
        longest = max(self.status.longest, took)
        self.status = Status(self.cpu.mode.value, self.cpu.scans, took, longest)


def _same(before: Value | None, value: Value) -> bool:
    """A REAL that is no number stays what it is, although it equals nothing."""
    return before == value or (before != before and value != value)


# ---------------------------------------------------------------------- views


class ScanJson:
    """One JSON object per change."""

    def show(self, at: float, changes: Sequence[tuple[Place, Value]], status: Status) -> None:
        for place, value in changes:
            json_line(place.as_json(at, value))

    def error(self, record: ErrorRecord) -> None:
        note(str(record))


class ScanLines:
    """One line per change: milliseconds since the start, address, symbol, value."""

    def __init__(self, places: Sequence[Place]) -> None:
        self._widths = (8, *(max(map(len, texts), default=0) for texts in _columns(places)))
        self._write("ms", "Address", "Symbol", "Value")

    def _write(self, at: str, address: str, symbol: str, value: str) -> None:
        when, wide, wider = self._widths
        names = f"{address:<{wide}}{GAP}{symbol:<{wider}}{GAP}" if wider > 0 else f"{address:<{wide}}{GAP}"
        put_now(f"{at:>{when}}{GAP}{names}{value}\n")

    def show(self, at: float, changes: Sequence[tuple[Place, Value]], status: Status) -> None:
        for place, value in changes:
            self._write(f"{at:.0f}", place.name, place.symbol, place.text(value))

    def error(self, record: ErrorRecord) -> None:
        note(str(record))


def _columns(places: Sequence[Place]) -> tuple[list[str], list[str]]:
    symbols = [place.symbol for place in places if place.symbol]
    return [place.name for place in places] + ["Address"], [*symbols, "Symbol"] if symbols else []


class ScanTable:
    """All places at once, painted again while they change. Use it as a context manager."""

    def __init__(self, title: str, places: Sequence[Place], console: Console) -> None:
        self._title = title
        self._console = console
        self._values: dict[Place, Value | None] = dict.fromkeys(places)
        self._status = Status()
        self._trouble = ""
        self._live = Live(console=console, get_renderable=self._painted, refresh_per_second=REFRESH)

    def __enter__(self) -> ScanTable:
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._live.stop()

    def show(self, at: float, changes: Sequence[tuple[Place, Value]], status: Status) -> None:
        self._values.update(changes)
        self._status = status

    def error(self, record: ErrorRecord) -> None:
        self._trouble = str(record)

    def _painted(self) -> Group:
        room = max(1, self._console.height - 4)
        rows = [place.row(value) for place, value in list(self._values.items())[:room] if value is not None]
        hidden = len(self._values) - room
        more = f"; {hidden} more do not fit, choose some with --watch" if hidden > 0 else ""
        foot = Text(f"{self._title}: {self._status}{more}. Ctrl-C ends.", "dim")
        return Group(rich_table(COLUMNS, rows), *([Text(self._trouble, "bold red")] if self._trouble else []), foot)
