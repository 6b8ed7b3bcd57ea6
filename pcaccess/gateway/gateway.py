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
from types import MappingProxyType

from pcaccess.clock import Clock
from pcaccess.collector import paused
from pcaccess.gateway.dynamic import DynamicNames
from pcaccess.gateway.groups import Group
from pcaccess.gateway.programs import Programs, load_programs
from pcaccess.gateway.station import Station
from pcaccess.gateway.writing import WriteRefused, raw_write
from pcaccess.items.quality import Quality
from pcaccess.items.sample import ItemValue, Sample
from pcaccess.items.table import ItemTable
from pcaccess.items.ticks import to_ticks
from pcaccess.links.absent import AbsentLink
from pcaccess.links.base import Link as Driver
from pcaccess.links.base import Outcome, RawWrite
from pcaccess.links.sim import SimLink
from pcaccess.links.soft import SoftLink
from pcaccess.project.model import Item, Link, LinkType, Plc, Project

log = logging.getLogger(__name__)

_Batches = dict[str, dict[int, RawWrite]]
"""By PLC: writes by their place in the request."""


class Gateway:
    """One project, running. Make it, :meth:`show` what is known, then :meth:`run` it inside a task group."""

    def __init__(self, project: Project, clock: Clock, programs: Programs | None = None) -> None:
        """``programs``: those of the soft-PLCs, loaded (``load_programs``); read here when not given."""
        self.clock = clock
        self.project = project
        self.programs = load_programs(project) if programs is None else programs
        self.table = ItemTable(to_ticks(clock.now()))
        self.dynamic = DynamicNames(self)
        self._stations: dict[str, Station] = {}
        self._drivers: dict[str, Driver] = {}
        self._items: list[Item | None] = []
        self._station_of: list[Station | None] = []
        self._groups: dict[str, Group] = {}
        self._listeners: list[Callable[[], None]] = []
        self._tasks: asyncio.TaskGroup | None = None
        self._driver_tasks: dict[str, asyncio.Task[None]] = {}
        with paused():
            self.table.reserve((item.data_type, item.count) for item in project.all_items())
            for link in project.links:
                self.add_link(link)
        self.set_groups()

    # ------------------------------------------------------------------ structure

    def add_link(self, link: Link) -> None:
        """Start to drive a link of the project."""
        driver = self._drivers[link.name] = self._driver(link)
        driver.configure(link.plcs)
        for plc in link.plcs:
            self.add_station(link, plc)
        if self._tasks is not None:
            self._driver_tasks[link.name] = self._tasks.create_task(driver.run())

    def remove_link(self, name: str) -> None:
        """Stop driving a link; its items are gone."""
        for station in [s for s in self._stations.values() if s.plc.link == name]:
            self.remove_station(station.name)
        del self._drivers[name]
        task = self._driver_tasks.pop(name, None)
        if task is not None:
            task.cancel()

    def driver(self, link: str) -> Driver:
        return self._drivers[link]

    def _driver(self, link: Link) -> Driver:
        if link.type is LinkType.SOFT:
            return SoftLink(self, self.clock, lambda plc: self.programs.of(plc))
        if link.type is LinkType.SIM:
            return SimLink(self.table, self.clock)
        return AbsentLink(self)

    def add_station(self, link: Link, plc: Plc) -> None:
        """A PLC of a link that is driven already."""
        live = link.type is LinkType.SOFT and plc.program is None
        station = Station(plc, self._drivers[link.name], self.table, self.item, live=live)
        self._stations[plc.item_id] = station
        self.add_items(station, list(plc.all_items()))

    def remove_station(self, name: str) -> None:
        station = self._stations.pop(name)
        self.remove_items(row for row, _ in list(station.items()))

    def add_items(self, station: Station, items: Sequence[Item]) -> list[int]:
        """Rows for items of a station."""
        rows: list[int] = self.table.add_many([(i.item_id, i.data_type, i.count) for i in items]).tolist()
        grow = max(rows, default=-1) + 1 - len(self._items)
        if grow > 0:
            self._items.extend([None] * grow)
            self._station_of.extend([None] * grow)
        for row, item in zip(rows, items, strict=True):
            self._items[row] = item
            self._station_of[row] = station
        station.add(zip(rows, items, strict=True))
        self.dynamic.forget_index()
        return rows

    def remove_items(self, rows: Iterable[int]) -> None:
        """Forget rows; their names are unknown from now on."""
        gone = list(rows)
        by_station: dict[Station, list[int]] = {}
        for row in gone:
            by_station.setdefault(self.station(row), []).append(row)
        for station, members in by_station.items():
            station.remove(members)
        for row in gone:
            self._items[row] = self._station_of[row] = None
        self.table.remove(gone)
        self.dynamic.forget_index()

    def replace_item(self, row: int, item: Item) -> None:
        """The item's description, limits or access changed, not its place or type."""
        self._items[row] = item
        self.dynamic.forget_index()

    def set_groups(self) -> None:
        """Take the groups of the project; a group that stays keeps what clients set."""
        before, self._groups = self._groups, {}
        for group in self.project.groups:
            known = before.get(group.name.casefold())
            if known is None or known.config != group:
                known = Group(group, self)
            self._groups[group.name.casefold()] = known

    def on_structure(self, listener: Callable[[], None]) -> None:
        """Call ``listener`` after items, PLCs or groups came, went or changed by the project file."""
        self._listeners.append(listener)

    def structure_changed(self) -> None:
        for listener in self._listeners:
            listener()

    # ------------------------------------------------------------------ looking things up

    @property
    def stations(self) -> MappingProxyType[str, Station]:
        """By ``Link.PLC`` as written."""
        return MappingProxyType(self._stations)

    @property
    def groups(self) -> list[Group]:
        return list(self._groups.values())

    def group(self, name: str) -> Group | None:
        """The group of that name, in any case."""
        return self._groups.get(name.casefold())

    def find(self, name: str) -> int | None:
        """Row of an item ID or run-time name, in any case; a well-formed run-time name makes its item."""
        row = self.table.find(name)
        if row is None:
            return self.dynamic.find(name) if "," in name else None
        self.dynamic.touch(row)
        return row

    def item(self, row: int) -> Item:
        """The entry of a row. Raises KeyError for a removed row."""
        item = self._items[row] if 0 <= row < len(self._items) else None
        if item is None:
            raise KeyError(row)
        return item

    def station(self, row: int) -> Station:
        station = self._station_of[row]
        if station is None:
            raise KeyError(row)
        return station

    # ------------------------------------------------------------------ values

    def stations_of(self, rows: Iterable[int]) -> tuple[Station, ...]:
        """The PLCs of these rows, each once."""
        return tuple({id(s): s for s in map(self.station, rows)}.values())

    async def read(self, rows: Sequence[int], max_age: float = 0.0, stations: Iterable[Station] | None = None) -> None:
        """Make the samples of ``rows`` no older than a reader wants (``max_age`` in seconds).

        ``stations``: those of the rows, from a reader that asks for the same again and again and has kept them.
        """
        self.freshen(rows, stations)

    def freshen(self, rows: Iterable[int], stations: Iterable[Station] | None = None) -> None:
        """Stamp what needs no polling; enough for a reader that must not wait."""
        now = self.now()
        for station in self.stations_of(rows) if stations is None else stations:
            station.freshen(now)

    def sample(self, row: int) -> Sample:
        return self.table.sample(row)

    async def write(self, writes: Sequence[tuple[int, ItemValue]]) -> list[Outcome]:
        """Write values to items, in order; returns when every PLC has taken or refused its own.

        Writes to one PLC reach it in one batch; different PLCs are written at the same time.
        """
        outcomes, batches = self._batches(writes)
        answers = await asyncio.gather(
            *(self._stations[name].link.write(name, list(batch.values())) for name, batch in batches.items())
        )
        return _merged(outcomes, batches, answers)

    def write_now(self, writes: Sequence[tuple[int, ItemValue]]) -> list[Outcome] | None:
        """As :meth:`write`, where every PLC takes its values at once; None, with nothing done, where one does not."""
        if not all(station.link.is_prompt(station.name) for station in {self.station(row) for row, _ in writes}):
            return None
        outcomes, batches = self._batches(writes)
        answers = [self._stations[name].link.write_now(name, list(batch.values())) for name, batch in batches.items()]
        return _merged(outcomes, batches, answers)

    def _batches(self, writes: Sequence[tuple[int, ItemValue]]) -> tuple[list[Outcome | None], _Batches]:
        """What each PLC is to take, by place in the request, and what is refused before it gets there."""
        outcomes: list[Outcome | None] = [None] * len(writes)
        batches: _Batches = {}
        for n, (row, value) in enumerate(writes):
            try:
                batches.setdefault(self.station(row).name, {})[n] = raw_write(self.item(row), value)
            except WriteRefused as refused:
                log.info("write refused: %s", refused)
                outcomes[n] = refused.outcome
        return outcomes, {name: batch for name, batch in batches.items() if batch}

    # ------------------------------------------------------------------ the links' side

    def now(self) -> int:
        """Wall time in ticks."""
        return to_ticks(self.clock.now())

    def received(self, station: str, data: bytes | bytearray | memoryview, start: int = 0) -> None:
        known = self._stations.get(station)
        if known is not None:  # a reload may have removed it while its link was reading
            known.reachable = True
            known.image.update(data, self.now(), start)

    def lost(self, station: str, quality: Quality) -> None:
        known = self._stations.get(station)
        if known is not None:
            known.reachable = False
            known.image.lost(quality, self.now())

    def refresh(self, station: Station) -> None:
        """Show rows that were added to a station from what its link knows already."""
        if not station.connected:
            self.lost(station.name, Quality.NOT_CONNECTED)
        elif station.live or station.runs:
            station.image.repeat(self.now())

    def show(self) -> None:
        """Take from every link what needs no waiting."""
        for driver in self._drivers.values():
            driver.show()

    async def run(self) -> None:
        """Run all links; ends only by cancellation."""
        async with asyncio.TaskGroup() as tasks:
            self._tasks = tasks
            for name, driver in self._drivers.items():
                self._driver_tasks[name] = tasks.create_task(driver.run())
            tasks.create_task(self.dynamic.run())


def _merged(outcomes: list[Outcome | None], batches: _Batches, answers: Iterable[Sequence[Outcome]]) -> list[Outcome]:
    for batch, answer in zip(batches.values(), answers, strict=True):
        for n, outcome in zip(batch, answer, strict=True):
            outcomes[n] = outcome
    return [outcome if outcome is not None else Outcome.COMM_FAILURE for outcome in outcomes]
