"""The running whole: links, the item table, writes back to the PLCs.

A value's way in: a link hands memory to :meth:`Gateway.received`, the station's image finds what changed, the table
has the samples. Its way back: :meth:`Gateway.write` turns values into bytes, the station's link takes them and
answers. Clients of any kind (OPC UA, web) hold rows and use nothing else.

Not here: the OPC UA server (``pcaccess.opcua``), reading project files (``pcaccess.project.load``).
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Iterable, Sequence
from itertools import groupby
from types import MappingProxyType

from pcaccess.clock import Clock
from pcaccess.gateway.station import Station, new_image
from pcaccess.gateway.writing import WriteRefused, raw_write
from pcaccess.items.quality import Quality
from pcaccess.items.sample import ItemValue, Sample
from pcaccess.items.table import ItemTable
from pcaccess.items.ticks import to_ticks
from pcaccess.links.base import Link as Driver
from pcaccess.links.base import Outcome, RawWrite
from pcaccess.links.soft import SoftLink, SoftPlc
from pcaccess.project.model import Item, Link, LinkType, Plc, Project

log = logging.getLogger(__name__)


class Gateway:
    """One project, running. Make it, then :meth:`run` it inside a task group."""

    def __init__(self, project: Project, clock: Clock) -> None:
        self.clock = clock
        self.project = project
        self.table = ItemTable(to_ticks(clock.now()))
        self._stations: dict[str, Station] = {}
        self._drivers: list[Driver] = []
        self._items: list[Item | None] = []
        self._station_of: list[Station | None] = []
        self._listeners: list[Callable[[], None]] = []
        for link in project.links:
            self._add_link(link)

    # ------------------------------------------------------------------ building

    def _add_link(self, link: Link) -> None:
        driver = self._driver(link)
        self._drivers.append(driver)
        for plc in link.plcs:
            station = Station(plc, driver, new_image(self.table), live=link.type is LinkType.SOFT)
            self._stations[plc.item_id] = station
            self.add_items(station, list(plc.all_items()))

    def _driver(self, link: Link) -> Driver:
        if link.type is LinkType.SOFT:
            return SoftLink([SoftPlc(plc.item_id, plc.cpu, plc.connected) for plc in link.plcs], self)
        return AbsentLink(link.plcs, self)

    def add_items(self, station: Station, items: Sequence[Item]) -> list[int]:
        """Rows for items of a station."""
        rows: list[int] = self.table.add_many([(i.item_id, i.data_type, _count(i)) for i in items]).tolist()
        grow = max(rows, default=-1) + 1 - len(self._items)
        if grow > 0:
            self._items.extend([None] * grow)
            self._station_of.extend([None] * grow)
        for row, item in zip(rows, items, strict=True):
            self._items[row] = item
            self._station_of[row] = station
        station.add(zip(rows, items, strict=True))
        return rows

    # ------------------------------------------------------------------ looking things up

    @property
    def stations(self) -> MappingProxyType[str, Station]:
        """By ``Link.PLC`` as written."""
        return MappingProxyType(self._stations)

    def find(self, name: str) -> int | None:
        """Row of an item ID, in any case; None when there is no such item."""
        return self.table.find(name)

    def item(self, row: int) -> Item:
        """The project's entry of a row. Raises KeyError for a removed row."""
        item = self._items[row] if 0 <= row < len(self._items) else None
        if item is None:
            raise KeyError(row)
        return item

    def station(self, row: int) -> Station:
        station = self._station_of[row]
        if station is None:
            raise KeyError(row)
        return station

    def on_structure(self, listener: Callable[[], None]) -> None:
        """Call ``listener`` after items or PLCs came, went or changed."""
        self._listeners.append(listener)

    # ------------------------------------------------------------------ values

    async def read(self, rows: Sequence[int], max_age: float = 0.0) -> None:
        """Make the samples of ``rows`` no older than a reader wants (``max_age`` in seconds)."""
        self.freshen(rows)

    def freshen(self, rows: Iterable[int]) -> None:
        """Stamp what needs no polling; enough for a reader that must not wait."""
        now = self.now()
        for station in {id(s): s for s in map(self.station, rows)}.values():
            station.freshen(self.table, now)

    def sample(self, row: int) -> Sample:
        return self.table.sample(row)

    async def write(self, writes: Sequence[tuple[int, ItemValue]]) -> list[Outcome]:
        """Write values to items, in order; returns when every PLC has taken or refused its own.

        Writes to one PLC reach it in one batch; different PLCs are written at the same time.
        """
        outcomes: list[Outcome | None] = [None] * len(writes)
        raw: list[tuple[str, int, RawWrite]] = []
        for n, (row, value) in enumerate(writes):
            try:
                raw.append((self.station(row).name, n, raw_write(self.item(row), value)))
            except WriteRefused as refused:
                log.info("write refused: %s", refused)
                outcomes[n] = refused.outcome
        raw.sort(key=lambda entry: entry[0])
        batches = [(name, list(batch)) for name, batch in groupby(raw, key=lambda entry: entry[0])]
        answers = await asyncio.gather(
            *(self._stations[name].link.write(name, [write for _, _, write in batch]) for name, batch in batches)
        )
        for (_, batch), answer in zip(batches, answers, strict=True):
            for (_, n, _), outcome in zip(batch, answer, strict=True):
                outcomes[n] = outcome
        return [outcome if outcome is not None else Outcome.COMM_FAILURE for outcome in outcomes]

    # ------------------------------------------------------------------ the links' side

    def now(self) -> int:
        """Wall time in ticks."""
        return to_ticks(self.clock.now())

    def received(self, station: str, data: bytes | bytearray | memoryview, start: int = 0) -> None:
        known = self._stations[station]
        known.reachable = True
        known.image.update(data, self.now(), start)

    def lost(self, station: str, quality: Quality) -> None:
        known = self._stations[station]
        known.reachable = False
        known.image.lost(quality, self.now())

    def start(self) -> None:
        """Show at once what needs no waiting."""
        for driver in self._drivers:
            driver.start()

    async def run(self) -> None:
        """Run all links; ends only by cancellation."""
        async with asyncio.TaskGroup() as tasks:
            for driver in self._drivers:
                tasks.create_task(driver.run())


class AbsentLink:
    """A link of a type that this version checks but cannot drive: its items are NOT_CONNECTED, and say so."""

    def __init__(self, plcs: Iterable[Plc], sink: Gateway) -> None:
        self._plcs = tuple(plcs)
        self._sink = sink

    def start(self) -> None:
        for plc in self._plcs:
            self._sink.lost(plc.item_id, Quality.NOT_CONNECTED)

    async def run(self) -> None:
        await asyncio.get_running_loop().create_future()

    async def write(self, station: str, writes: Sequence[RawWrite]) -> list[Outcome]:
        return [Outcome.NOT_CONNECTED] * len(writes)


def _count(item: Item) -> int:
    return 1 if isinstance(item.address, str) else item.address.count
