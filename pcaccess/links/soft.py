"""Link ``soft``: PLCs that exist in this process, as memory alone or with a CPU that runs a program.

A memory-only PLC has the whole memory of its CPU model: items over the same bytes agree, values written stay, inputs
can be set. It needs no polling; its samples are as old as the question.

Not here: executing programs (``pcaccess.plc``).
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from pcaccess.items.quality import Quality
from pcaccess.links.base import Outcome, RawWrite, Sink
from pcaccess.project.model import Item, Plc
from pcaccess.s7200.memory import MEMORY_SIZE, locate
from pcaccess.s7200.special import power_up
from pcaccess.s7200.types import DataType


@dataclass(slots=True)
class SoftPlc:
    """One PLC of a soft link. ``memory`` is the flat buffer of ``pcaccess.s7200.memory``."""

    plc: Plc
    memory: bytearray = field(default_factory=lambda: bytearray(MEMORY_SIZE))

    def __post_init__(self) -> None:
        power_up(self.memory, self.plc.cpu)


class SoftLink:
    """All PLCs of one soft link."""

    def __init__(self, sink: Sink) -> None:
        self._plcs: dict[str, SoftPlc] = {}
        self._sink = sink

    def configure(self, plcs: Sequence[Plc]) -> None:
        """A PLC that stays keeps its memory, whatever else of it changed."""
        before, self._plcs = self._plcs, {}
        for plc in plcs:
            known = before.get(plc.item_id)
            if known is None:
                self._plcs[plc.item_id] = SoftPlc(plc)
            else:
                known.plc = plc
                power_up(known.memory, plc.cpu)
                self._plcs[plc.item_id] = known

    def add(self, station: str, items: Iterable[tuple[int, Item]]) -> None:
        pass

    def remove(self, rows: Iterable[int]) -> None:
        pass

    def show(self) -> None:
        """Hand over whole memories, or say which PLC is not connected."""
        for station, plc in self._plcs.items():
            if plc.plc.connected:
                self._sink.received(station, plc.memory)
            else:
                self._sink.lost(station, Quality.NOT_CONNECTED)

    async def run(self) -> None:
        """In memory alone nothing changes by itself."""
        await asyncio.get_running_loop().create_future()

    async def write(self, station: str, writes: Sequence[RawWrite]) -> list[Outcome]:
        """Into memory at once, and from there to the sink."""
        plc = self._plcs[station]
        if not plc.plc.connected:
            return [Outcome.NOT_CONNECTED] * len(writes)
        first, last = len(plc.memory), 0
        for write in writes:
            start, end = store(plc.memory, write)
            first, last = min(first, start), max(last, end)
        if writes:
            self._sink.received(station, memoryview(plc.memory)[first:last], first)
        return [Outcome.DONE] * len(writes)


def store(memory: bytearray | memoryview, write: RawWrite) -> tuple[int, int]:
    """Put a write into a flat memory; returns the first byte touched and the one behind the last."""
    if isinstance(write.address, str):
        raise TypeError(f"{write.address!r} is not an S7-200 address")
    offset, bit = locate(write.address)
    if write.raw_type is not DataType.BOOL:
        end = offset + len(write.data)
        memory[offset:end] = write.data
        return offset, end
    at, n = offset, bit
    for value in write.data:
        memory[at] = memory[at] & ~(1 << n) | (value & 1) << n
        at, n = (at, n + 1) if n < 7 else (at + 1, 0)
    return offset, at + (n > 0)
