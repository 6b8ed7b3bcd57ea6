"""Durations as a project file writes them: ``250ms``, ``1s``, ``2min``, ``1.5h``."""

from __future__ import annotations

import re
from typing import Final

UNITS: Final = {"ms": 0.001, "s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
PATTERN: Final = r"\d+(?:\.\d+)? ?(?:ms|s|min|h|d)"
EXPECTED: Final = "a duration such as 250ms, 1s or 2min"
_DURATION: Final = re.compile(r"(\d+(?:\.\d+)?)\s*([a-zµ]+)", re.IGNORECASE | re.ASCII)


class DurationError(ValueError):
    """The text is not a duration; the message says why."""


def parse_duration(text: str) -> float:
    """Seconds. A bare number is refused, because nobody can tell whether it means seconds or milliseconds."""
    plain = text.strip()
    match = _DURATION.fullmatch(plain)
    if match and match[2].lower() in UNITS:
        return float(match[1]) * UNITS[match[2].lower()]
    if match:
        raise DurationError(f"{match[2]!r} is not a unit of time; the units are {', '.join(UNITS)}")
    if re.fullmatch(r"\d+(?:\.\d+)?", plain):
        raise DurationError(f"{plain} has no unit; write {plain}ms or {plain}s")
    raise DurationError(f"{text!r} is not a duration")


def format_duration(seconds: float) -> str:
    """The shortest text that :func:`parse_duration` gives back as ``seconds``."""
    for unit in reversed(UNITS):
        number = round(seconds / UNITS[unit], 9)
        if number >= 1 and number == int(number):
            return f"{int(number)}{unit}"
    return f"{seconds * 1000:g}ms" if seconds < 1 else f"{seconds:g}s"
