"""What a link is to the gateway: it fetches memory, takes writes, and says how its PLCs are doing.

Failure is data: a dead PLC costs its own items, never an exception. A station is a PLC as a link knows it, by its
``Link.PLC`` name.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pcaccess.items.quality import Quality
from pcaccess.project.model import Item, Plc
from pcaccess.s7200.address import Address
from pcaccess.s7200.types import DataType


class Outcome(Enum):
    """What became of a write. Every write has exactly one."""

    DONE = "done"
    NOT_WRITABLE = "not writable"
    TYPE_MISMATCH = "type does not match"
    OUT_OF_RANGE = "out of range"
    CONFIG_ERROR = "configuration error"
    NOT_CONNECTED = "not connected"
    COMM_FAILURE = "no communication"
    DEVICE_FAILURE = "device failure"


@dataclass(frozen=True, slots=True)
class RawWrite:
    """Bytes for one item, as they stand in PLC memory; for BOOL one byte, 0 or 1, per element.

    ``address`` is a text on links that have their own addresses.
    """

    item_id: str
    address: Address | str
    raw_type: DataType
    data: bytes


@dataclass(frozen=True, slots=True)
class RawBlock:
    """Single values of one type, as they stand in PLC memory, for many places of one PLC."""

    raw_type: DataType
    offsets: NDArray[np.int64]
    """Of the flat memory, ``pcaccess.s7200.memory``."""
    bits: NDArray[np.uint8]
    """Bit in the byte; 0 for anything but BOOL."""
    data: NDArray[np.uint8]
    """One row of ``raw_type.size`` bytes per place; 0 or 1 for BOOL."""


@dataclass(frozen=True, slots=True)
class PlcStatus:
    """How a PLC is doing. ``mode``: RUN, STOP or UNKNOWN; ``scan_time`` in milliseconds, 0 where nothing scans."""

    mode: str
    scan_time: float = 0.0
    errors: int = 0
    """Run-time errors of the program since it went to RUN."""


class Sink(Protocol):
    """Where a link puts what it learns. Both calls are cheap enough for every scan."""

    def received(self, station: str, data: bytes | bytearray | memoryview, start: int = 0) -> None:
        """``data`` was read from the station; it stands at ``start`` of the flat image."""

    def lost(self, station: str, quality: Quality) -> None:
        """The station's items keep value and time and take ``quality``."""


class Link(Protocol):
    """One way to reach PLCs."""

    def configure(self, plcs: Sequence[Plc]) -> None:
        """These are the link's PLCs now; those that stay keep their state."""

    def add(self, station: str, items: Iterable[tuple[int, Item]]) -> None:
        """Rows that somebody may read. Links that hand over whole memories need not know."""

    def remove(self, rows: Iterable[int]) -> None:
        """Rows that are gone."""

    def show(self) -> None:
        """Hand the sink what is known without waiting."""

    def status(self, station: str) -> PlcStatus:
        """How the PLC is doing."""

    async def run(self) -> None:
        """Own ports and tasks; ends only by cancellation."""

    async def write(self, station: str, writes: Sequence[RawWrite]) -> list[Outcome]:
        """Carry writes out, in order; returns when the PLC has taken or refused each."""

    def is_prompt(self, station: str) -> bool:
        """Whether the PLC takes a write without anybody having to wait."""

    def write_now(self, station: str, writes: Sequence[RawWrite]) -> list[Outcome]:
        """As :meth:`write`; only while the PLC is prompt."""

    def takes_blocks(self, station: str) -> bool:
        """Whether the PLC is prompt and takes many values at once."""

    def write_blocks(self, station: str, blocks: Sequence[RawBlock]) -> Outcome:
        """Many single values at once, no bit of them twice; only while :meth:`takes_blocks`."""
