"""Addresses of simulated items: ``SINE(10s, 0, 100)`` to a typed wave. Computing it is the sim link's business.

Units:    periods in seconds, low and high in the item's own unit.
Errors:   :class:`WaveError`, whose message says what was expected.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from enum import Enum
from typing import Final

from pcaccess.project.durations import DurationError, parse_duration
from pcaccess.s7200.types import DataType, Value


class WaveError(ValueError):
    """The text is not a simulated value."""


class WaveKind(Enum):
    """What a simulated value does; the value is its form as a user writes it."""

    RAMP = "RAMP(period, low, high)"
    SINE = "SINE(period, low, high)"
    RANDOM = "RANDOM(period, low, high)"
    TOGGLE = "TOGGLE(period)"
    COUNTER = "COUNTER(period)"
    CONST = "CONST(value)"
    QUALITY = "QUALITY(code, value)"

    @property
    def is_writable(self) -> bool:
        """Clients may change what stands still; what moves by itself is read-only."""
        return self is WaveKind.CONST


@dataclass(frozen=True, slots=True)
class Wave:
    """One simulated value over time.

    RAMP rises from low to high in each period; SINE swings between them once a period; RANDOM takes a new value
    between them each period; TOGGLE changes between false and true each period; COUNTER counts periods.
    """

    kind: WaveKind
    period: float = 0.0
    low: float = 0.0
    high: float = 0.0
    value: Value = 0
    quality: int = 192
    """OPC DA code, limit bits included."""

    @property
    def default_type(self) -> DataType:
        """Type of an item that does not say one."""
        if self.kind is WaveKind.TOGGLE:
            return DataType.BOOL
        if self.kind is WaveKind.COUNTER:
            return DataType.DINT
        if self.kind in (WaveKind.CONST, WaveKind.QUALITY):
            if isinstance(self.value, bool):
                return DataType.BOOL
            if isinstance(self.value, str):
                return DataType.STRING
            return DataType.DINT if isinstance(self.value, int) else DataType.REAL
        return DataType.REAL

    def check(self, data_type: DataType) -> None:
        """Raise ValueError or TypeError with a message when ``data_type`` cannot hold what the wave gives."""
        if self.kind in (WaveKind.CONST, WaveKind.QUALITY):
            data_type.encode(self.value)
        elif data_type is DataType.STRING:
            raise WaveError(f"{self.kind.name} gives numbers, not a STRING")
        elif self.kind not in (WaveKind.TOGGLE, WaveKind.COUNTER):
            for end in (self.low, self.high):
                data_type.encode(float(round(end)) if data_type.is_integer else end)


_CALL: Final = re.compile(r"\s*([A-Za-z]+)\s*\((.*)\)\s*", re.DOTALL)
_ARGUMENT: Final = re.compile(r"""\s*('(?:[^']|'')*'|[^,'()]*)\s*(?:,|$)""")


def parse_wave(text: str) -> Wave:
    """Read one simulated value; names in any case, a text in single quotes."""
    match = _CALL.fullmatch(text)
    kind = WaveKind.__members__.get(match[1].upper()) if match else None
    if match is None or kind is None:
        forms = ", ".join(k.value for k in WaveKind)
        raise WaveError(f"{text!r} is not a simulated value; expected one of {forms}")
    arguments = _split(match[2], text)
    expected = kind.value.count(",") + 1
    if len(arguments) != expected:
        raise WaveError(f"{text}: {len(arguments)} values in brackets; expected {kind.value}")
    if kind is WaveKind.CONST:
        return Wave(kind, value=_value(arguments[0], text))
    if kind is WaveKind.QUALITY:
        return Wave(kind, quality=_quality(arguments[0], text), value=_value(arguments[1], text))
    try:
        period = parse_duration(arguments[0])
    except DurationError as error:
        raise WaveError(f"{text}: {error}") from None
    if period <= 0:
        raise WaveError(f"{text}: the period must be longer than nothing")
    if expected == 1:
        return Wave(kind, period)
    low, high = _number(arguments[1], text), _number(arguments[2], text)
    if low >= high:
        raise WaveError(f"{text}: low must be below high; expected {kind.value}")
    return Wave(kind, period, low, high)


def _split(inside: str, text: str) -> list[str]:
    if "'" not in inside and "(" not in inside:
        return [argument.strip() for argument in inside.split(",")] if inside.strip() else []
    arguments, at = [], 0
    while True:
        match = _ARGUMENT.match(inside, at)
        if match is None:
            raise WaveError(f"{text}: cannot be read from {inside[at:].strip()!r} on")
        arguments.append(match[1].strip())
        if match.end() == len(inside) and not match[0].endswith(","):
            return arguments if inside.strip() else []
        at = match.end()


def _number(argument: str, text: str) -> float:
    try:
        value = float(argument)
    except ValueError:
        raise WaveError(f"{text}: {argument!r} is not a number") from None
    if not math.isfinite(value):
        raise WaveError(f"{text}: {argument} is not a number a PLC could have")
    return value


def _value(argument: str, text: str) -> Value:
    if argument.startswith("'"):
        return argument[1:-1].replace("''", "'")
    if argument.lower() in ("true", "false"):
        return argument.lower() == "true"
    try:
        return int(argument)
    except ValueError:
        return _number(argument, text)


def _quality(argument: str, text: str) -> int:
    if not re.fullmatch(r"\d{1,3}", argument, re.ASCII) or int(argument) > 255:
        raise WaveError(f"{text}: {argument!r} is not a quality code; expected 0 to 255, for example 24 (COMM_FAILURE)")
    return int(argument)
