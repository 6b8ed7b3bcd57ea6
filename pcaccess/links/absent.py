"""Links of a type that this version checks but cannot drive: their items are NOT_CONNECTED, and say so."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Sequence

from pcaccess.items.quality import Quality
from pcaccess.links.base import Outcome, PlcStatus, RawBlock, RawWrite, Sink
from pcaccess.project.model import Item, Plc


class AbsentLink:
    """Answers for PLCs that nobody reaches."""

    def __init__(self, sink: Sink) -> None:
        self._stations: tuple[str, ...] = ()
        self._sink = sink

    def configure(self, plcs: Sequence[Plc]) -> None:
        self._stations = tuple(plc.item_id for plc in plcs)

    def add(self, station: str, items: Iterable[tuple[int, Item]]) -> None:
        pass

    def remove(self, rows: Iterable[int]) -> None:
        pass

    def show(self) -> None:
        for station in self._stations:
            self._sink.lost(station, Quality.NOT_CONNECTED)

    def status(self, station: str) -> PlcStatus:
        return PlcStatus("UNKNOWN")

    async def run(self) -> None:
        await asyncio.get_running_loop().create_future()

    async def write(self, station: str, writes: Sequence[RawWrite]) -> list[Outcome]:
        return self.write_now(station, writes)

    def is_prompt(self, station: str) -> bool:
        return True

    def write_now(self, station: str, writes: Sequence[RawWrite]) -> list[Outcome]:
        return [Outcome.NOT_CONNECTED] * len(writes)

    def takes_blocks(self, station: str) -> bool:
        return True

    def write_blocks(self, station: str, blocks: Sequence[RawBlock]) -> Outcome:
        return Outcome.NOT_CONNECTED
