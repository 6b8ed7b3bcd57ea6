"""Link ``sim``: items that move by themselves, computed in bulk.

All items of one kind of wave and one data type are columns; a tick is a few NumPy expressions, whether ten items or
100,000. Time starts when the link starts.

Units:    seconds; ticks every ``TICK``. Waves: ``pcaccess.project.sim``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pcaccess.clock import Clock
from pcaccess.items.quality import Quality, split_code
from pcaccess.items.records import KINDS
from pcaccess.items.rowset import Rows
from pcaccess.items.table import ItemTable, as_rows
from pcaccess.items.ticks import to_ticks
from pcaccess.links.base import Outcome, PlcStatus, RawBlock, RawWrite
from pcaccess.project.model import Item, Plc
from pcaccess.project.sim import Wave, WaveKind, parse_wave
from pcaccess.s7200.types import DataType, Value

TICK: Final = 0.1
_STANDING: Final = (WaveKind.CONST, WaveKind.QUALITY)


class _Waves:
    """Items of one kind of wave and one type, as columns."""

    def __init__(self, kind: WaveKind, data_type: DataType, members: list[tuple[int, Wave]]) -> None:
        self._kind = kind
        self.data_type = data_type
        self.rows: Rows = as_rows(row for row, _ in members)
        self._period = np.array([wave.period for _, wave in members])
        self._low = np.array([wave.low for _, wave in members])
        self._span = np.array([wave.high for _, wave in members]) - self._low

    def values(self, t: float) -> NDArray[Any]:
        """Values at ``t`` seconds in the type's own format."""
        turns = t / self._period
        whole = np.floor(turns)
        if self._kind is WaveKind.TOGGLE:
            return (whole % 2).astype(KINDS[self.data_type].value_format)
        if self._kind is WaveKind.COUNTER:
            return self._counted(whole)
        if self._kind is WaveKind.RAMP:
            part = turns - whole
        elif self._kind is WaveKind.SINE:
            part = 0.5 + 0.5 * np.sin(2 * np.pi * (turns - whole))
        else:
            part = _noise(whole, self.rows)
        return self._typed(self._low + self._span * part)

    def _counted(self, number: NDArray[np.float64]) -> NDArray[Any]:
        """A counter starts again at 0 behind the largest value of its type."""
        if self.data_type is DataType.REAL:
            return number.astype(np.float32)
        return np.mod(number, self.data_type.high + 1.0).astype(KINDS[self.data_type].value_format)

    def _typed(self, value: NDArray[np.float64]) -> NDArray[Any]:
        data_type = self.data_type
        if data_type is DataType.REAL:
            return value.astype(np.float32)
        return np.clip(np.rint(value), data_type.low, data_type.high).astype(KINDS[data_type].value_format)


def _noise(step: NDArray[np.float64], rows: Rows) -> NDArray[np.float64]:
    """Numbers 0 <= x < 1 that depend on nothing but step and row (an integer hash, so that no state is kept)."""
    with np.errstate(over="ignore"):
        x = step.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15) + rows.astype(np.uint64)
        x ^= x >> np.uint64(30)
        x *= np.uint64(0xBF58476D1CE4E5B9)
        x ^= x >> np.uint64(27)
        x *= np.uint64(0x94D049BB133111EB)
        x ^= x >> np.uint64(31)
    fraction: NDArray[np.float64] = (x >> np.uint64(11)).astype(np.float64) / float(1 << 53)
    return fraction


class SimLink:
    """All simulated items of one link."""

    def __init__(self, table: ItemTable, clock: Clock) -> None:
        self._connected: dict[str, bool] = {}
        self._table = table
        self._clock = clock
        self._started = clock.monotonic()
        self._members: dict[int, tuple[str, Item, Wave]] = {}
        self._constants: dict[str, Value] = {}
        self._waves: list[_Waves] | None = None

    def add(self, station: str, items: Iterable[tuple[int, Item]]) -> None:
        """Rows to keep moving."""
        for row, item in items:
            if isinstance(item.address, str):
                self._members[row] = (station, item, parse_wave(item.address))
        self._waves = None

    def remove(self, rows: Iterable[int]) -> None:
        for row in rows:
            self._members.pop(row, None)
        self._waves = None

    def configure(self, plcs: Sequence[Plc]) -> None:
        self._connected = {plc.item_id: plc.connected for plc in plcs}
        self._waves = None

    def show(self) -> None:
        """Show the first values, and those that never change."""
        now = to_ticks(self._clock.now())
        for row, (station, item, wave) in self._members.items():
            if not self._connected[station]:
                self._table.set_quality(as_rows(row), Quality.NOT_CONNECTED, now)
            elif wave.kind in _STANDING:
                self._table.put(row, self._constants.get(item.item_id, wave.value), now)
                quality, limit = split_code(wave.quality)
                if quality is not Quality.GOOD or limit:
                    self._table.set_quality(as_rows(row), quality, now, limit)
        self.tick()

    def status(self, station: str) -> PlcStatus:
        return PlcStatus("RUN")

    async def run(self) -> None:
        due = self._clock.monotonic()
        while True:
            due = max(due + TICK, self._clock.monotonic())
            await self._clock.sleep(due - self._clock.monotonic())
            self.tick()

    def tick(self) -> None:
        """Compute every moving item for the present moment."""
        t = self._clock.monotonic() - self._started
        now = to_ticks(self._clock.now())
        for waves in self._arranged():
            self._table.put_numbers(waves.data_type, waves.rows, waves.values(t), now)

    def _arranged(self) -> list[_Waves]:
        if self._waves is None:
            groups: dict[tuple[WaveKind, DataType], list[tuple[int, Wave]]] = {}
            for row, (station, item, wave) in self._members.items():
                if wave.kind not in _STANDING and self._connected[station]:
                    groups.setdefault((wave.kind, item.data_type), []).append((row, wave))
            self._waves = [_Waves(kind, data_type, members) for (kind, data_type), members in groups.items()]
        return self._waves

    async def write(self, station: str, writes: Sequence[RawWrite]) -> list[Outcome]:
        return self.write_now(station, writes)

    def is_prompt(self, station: str) -> bool:
        return True

    def takes_blocks(self, station: str) -> bool:
        return False

    def write_blocks(self, station: str, blocks: Sequence[RawBlock]) -> Outcome:
        return Outcome.NOT_WRITABLE

    def write_now(self, station: str, writes: Sequence[RawWrite]) -> list[Outcome]:
        """Only constants can be written; they keep the value until the program ends."""
        if not self._connected[station]:
            return [Outcome.NOT_CONNECTED] * len(writes)
        return [self._write(write) for write in writes]

    def _write(self, write: RawWrite) -> Outcome:
        row = self._table.find(write.item_id)
        member = self._members.get(row) if row is not None else None
        if row is None or member is None or member[2].kind is not WaveKind.CONST:
            return Outcome.NOT_WRITABLE
        value = write.raw_type.decode(write.data)
        self._constants[write.item_id] = value
        self._table.put(row, value, to_ticks(self._clock.now()))
        return Outcome.DONE
