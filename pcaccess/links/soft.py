"""Link ``soft``: PLCs that exist in this process, as memory alone or with a CPU that runs a program.

A memory-only PLC has the whole memory of its CPU model: items over the same bytes agree, values written stay, inputs
can be set. It needs no polling; its samples are as old as the question. A PLC with a program scans; clients' writes
are applied between two scans and answered after the second, so that what is read afterwards has them.

Not here: executing programs (``pcaccess.plc``).
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from pcaccess.clock import Clock
from pcaccess.items.quality import Quality
from pcaccess.links.base import Outcome, PlcStatus, RawBlock, RawWrite, Sink
from pcaccess.links.scanning import ScanningPlc
from pcaccess.project.model import Item, Plc
from pcaccess.s7200.memory import MEMORY_SIZE, locate
from pcaccess.s7200.special import power_up
from pcaccess.s7200.types import DataType
from pcaccess.stl.program import Program

log = logging.getLogger(__name__)

ProgramOf = Callable[[Plc], Program | None]


class MemoryPlc:
    """A PLC of memory alone. ``memory`` is the flat buffer of ``pcaccess.s7200.memory``."""

    def __init__(self, plc: Plc) -> None:
        self.plc = plc
        self.memory = bytearray(MEMORY_SIZE)
        power_up(self.memory, plc.cpu)

    def configure(self, plc: Plc) -> None:
        """The PLC's entry changed; its memory stays."""
        self.plc = plc
        power_up(self.memory, plc.cpu)


class SoftLink:
    """All PLCs of one soft link."""

    def __init__(self, sink: Sink, clock: Clock, program_of: ProgramOf) -> None:
        self._plcs: dict[str, MemoryPlc | ScanningPlc] = {}
        self._sink = sink
        self._clock = clock
        self._program_of = program_of
        self._tasks: asyncio.TaskGroup | None = None
        self._scans: dict[str, asyncio.Task[None]] = {}

    def configure(self, plcs: Sequence[Plc]) -> None:
        """A PLC that stays keeps its memory, whatever else of it changed; a new program goes in between two scans."""
        before, self._plcs = self._plcs, {}
        for plc in plcs:
            program = self._program_of(plc)
            known = before.pop(plc.item_id, None)
            if isinstance(known, MemoryPlc) and program is None:
                known.configure(plc)
            elif isinstance(known, ScanningPlc) and program is not None:
                known.configure(plc, program)
            else:
                old = known
                known = MemoryPlc(plc) if program is None else ScanningPlc(plc, program, self._sink, self._clock)
                if old is not None:
                    self._end_scan(plc.item_id)
                    known.memory[:MEMORY_SIZE] = old.memory[:MEMORY_SIZE]
            self._plcs[plc.item_id] = known
            self._begin_scan(plc.item_id)
        for station in before:
            self._end_scan(station)

    def _begin_scan(self, station: str) -> None:
        plc = self._plcs[station]
        if self._tasks is not None and isinstance(plc, ScanningPlc) and station not in self._scans:
            self._scans[station] = self._tasks.create_task(plc.run())

    def _end_scan(self, station: str) -> None:
        task = self._scans.pop(station, None)
        if task is not None:
            task.cancel()

    def add(self, station: str, items: Iterable[tuple[int, Item]]) -> None:
        pass

    def remove(self, rows: Iterable[int]) -> None:
        pass

    def show(self) -> None:
        """Hand over whole memories, or say which PLC is not connected."""
        for station, plc in self._plcs.items():
            if plc.plc.connected:
                self._sink.received(station, memoryview(plc.memory)[:MEMORY_SIZE])
            else:
                self._sink.lost(station, Quality.NOT_CONNECTED)

    def status(self, station: str) -> PlcStatus:
        plc = self._plcs[station]
        return plc.status() if isinstance(plc, ScanningPlc) else PlcStatus("STOP")

    def scanning(self, station: str) -> ScanningPlc | None:
        """The CPU of a PLC that has a program."""
        plc = self._plcs.get(station)
        return plc if isinstance(plc, ScanningPlc) else None

    async def run(self) -> None:
        """Scan what has a program; ends only by cancellation."""
        async with asyncio.TaskGroup() as tasks:
            self._tasks = tasks
            for station in self._plcs:
                self._begin_scan(station)
            await asyncio.get_running_loop().create_future()

    async def write(self, station: str, writes: Sequence[RawWrite]) -> list[Outcome]:
        """Into memory at once, or between two scans."""
        plc = self._plcs[station]
        if plc.plc.connected and isinstance(plc, ScanningPlc):
            return await plc.write(writes)
        return self.write_now(station, writes)

    def is_prompt(self, station: str) -> bool:
        """Memory is, a CPU takes writes between two scans."""
        plc = self._plcs[station]
        return isinstance(plc, MemoryPlc) or not plc.plc.connected

    def write_now(self, station: str, writes: Sequence[RawWrite]) -> list[Outcome]:
        """Into memory."""
        plc = self._plcs[station]
        if not plc.plc.connected:
            return [Outcome.NOT_CONNECTED] * len(writes)
        first, last = MEMORY_SIZE, 0
        for write in writes:
            start, end = store(plc.memory, write)
            first, last = min(first, start), max(last, end)
        if writes:
            self._sink.received(station, memoryview(plc.memory)[first:last], first)
        return [Outcome.DONE] * len(writes)

    def takes_blocks(self, station: str) -> bool:
        return self.is_prompt(station)

    def write_blocks(self, station: str, blocks: Sequence[RawBlock]) -> Outcome:
        """Into memory, column by column."""
        plc = self._plcs[station]
        if not plc.plc.connected:
            return Outcome.NOT_CONNECTED
        memory = np.frombuffer(plc.memory, np.uint8)
        first, last = MEMORY_SIZE, 0
        for block in blocks:
            store_block(memory, block)
            first = min(first, int(block.offsets.min()))
            last = max(last, int(block.offsets.max()) + block.raw_type.size)
        self._sink.received(station, memoryview(plc.memory)[first:last], first)
        return Outcome.DONE


def store_block(memory: NDArray[np.uint8], block: RawBlock) -> None:
    """Put many values of one type into a flat memory."""
    if block.raw_type is DataType.BOOL:
        bit = np.left_shift(np.uint8(1), block.bits)
        np.bitwise_and.at(memory, block.offsets, ~bit)
        np.bitwise_or.at(memory, block.offsets, block.data[:, 0] << block.bits)
    else:
        memory[block.offsets[:, None] + np.arange(block.raw_type.size)] = block.data


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
