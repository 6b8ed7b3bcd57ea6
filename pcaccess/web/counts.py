"""What the web server has done so far, for diagnostics and metrics."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, field
from datetime import datetime


@dataclass(slots=True)
class Counts:
    """Counters since the start; they only grow."""

    started: datetime
    requests: Counter[tuple[str, str, int]] = field(default_factory=Counter)
    """By method, path as the API writes it, and status."""
    seconds: defaultdict[tuple[str, str], float] = field(default_factory=lambda: defaultdict(float))
    """Time until the answer was ready, by method and path."""
    refused: Counter[str] = field(default_factory=Counter)
    """Requests that were turned away at the door, by kind of refusal."""
    written: Counter[str] = field(default_factory=Counter)
    """Values written by clients, by OPC UA status name."""
    messages: int = 0
    """Sent to websockets."""
    bytes_sent: int = 0
    """Of those messages."""
    slow: int = 0
    """Websockets closed because their client did not take its messages."""
