"""OPC UA time: 100 ns ticks since 1601-01-01 UTC, as the wire and the item table have it.

Source:   OPC UA Part 6, DateTime.
"""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Final

TICKS_PER_SECOND: Final = 10_000_000
_EPOCH: Final = datetime(1601, 1, 1, tzinfo=UTC)
_UNIX_EPOCH_TICKS: Final = 11_644_473_600 * TICKS_PER_SECOND


def to_ticks(moment: datetime) -> int:
    """Ticks of an aware datetime, exact to the microsecond."""
    delta = moment - _EPOCH
    return (delta.days * 86_400 + delta.seconds) * TICKS_PER_SECOND + delta.microseconds * 10


def from_ticks(ticks: int) -> datetime:
    """The datetime (UTC) of ``ticks``, rounded down to the microsecond."""
    return _EPOCH + timedelta(microseconds=int(ticks) // 10)
