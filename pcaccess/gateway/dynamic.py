"""Dynamic items: a well-formed run-time name is an item the first time anybody names it.

The run-time name of a configured item *is* that item. Any other name of existing bytes of a known PLC makes a new one,
within the project's bounds (``dynamic_items``); unused ones go after their idle time. A dynamic name for bytes that a
configured item covers never has more access than that item.

Units:    ticks (``pcaccess.items.ticks``).
Errors:   a name that cannot be an item is None, with a line in the log that says why.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from pcaccess.gateway.station import Station
from pcaccess.items.ticks import TICKS_PER_SECOND
from pcaccess.project.model import Access, Item, Traits
from pcaccess.project.names import RunTimeName, RunTimeNameError, Stations, parse_run_time_name
from pcaccess.s7200.address import Address, AddressError
from pcaccess.s7200.memory import locate
from pcaccess.s7200.types import MAX_STRING, DataType

if TYPE_CHECKING:
    from pcaccess.gateway.gateway import Gateway

log = logging.getLogger(__name__)

_LONGEST_SWEEP: Final = 30.0
"""Seconds between looks for idle items, or a tenth of the idle time if that is less."""
_MOST_TOLD: Final = 1000


@dataclass(slots=True)
class _Index:
    """Items by what names them beside their ID; made when the first run-time name is asked for."""

    names: dict[str, int] = field(default_factory=dict)
    """Casefolded run-time name."""
    unlinked: dict[str, int | None] = field(default_factory=dict)
    """The same without the link, of items that only their whole name tells: scaled and simulated ones. None: of two."""
    places: dict[tuple[str, str, DataType], list[int]] = field(default_factory=dict)
    """Station, address and served type."""


class DynamicNames:
    """Finds and makes items by run-time name."""

    def __init__(self, gateway: Gateway) -> None:
        self._gateway = gateway
        self._used: dict[int, int] = {}
        self._index: _Index | None = None
        self._stations: Stations | None = None
        self._holders: list[Callable[[], Iterable[int]]] = []
        self._told: set[str] = set()

    def hold(self, rows: Callable[[], Iterable[int]]) -> None:
        """``rows()`` are in use, subscribed for example, and stay however long nobody names them."""
        self._holders.append(rows)

    def touch(self, row: int) -> None:
        """Somebody named the row."""
        if row in self._used:
            self._used[row] = self._gateway.now()

    def __contains__(self, row: int) -> bool:
        """Whether the row is a dynamic item's."""
        return row in self._used

    def __len__(self) -> int:
        return len(self._used)

    def forget_index(self) -> None:
        """Items or PLCs came or went."""
        self._index = None
        self._stations = None
        self._told.clear()

    def _warn(self, text: str, why: str) -> None:
        """Once per name: a client that asks ten times a second must not fill the log."""
        if text not in self._told:
            if len(self._told) >= _MOST_TOLD:
                self._told.clear()
            self._told.add(text)
            log.warning("%s %s", text, why)

    def find(self, text: str) -> int | None:
        """Row of a run-time name; makes the item where the project allows it."""
        row = self._indexed().names.get(text.casefold())
        if row is not None:
            self.touch(row)
            return row
        try:
            name = parse_run_time_name(text)
        except RunTimeNameError as error:
            row = self._indexed().unlinked.get(text.casefold())
            if row is None:
                log.debug("%s is no run-time name: %s", text, error)
            else:
                self.touch(row)
            return row
        station = self._station(name, text)
        if station is None:
            return None
        try:
            address = name.address.as_type(name.served_type)
            station.plc.cpu.check(address, size=name.served_type.size)
        except AddressError as error:
            log.info("%s cannot be an item: %s", text, error)
            return None
        row = self._known(station, name, address)
        if row is None:
            row = self._make(station, name, address, text)
        return row

    def _station(self, name: RunTimeName, text: str) -> Station | None:
        if self._stations is None:
            self._stations = Stations(self._gateway.project)
        fitting = self._stations.find(name)
        if len(fitting) > 1:
            names = " and ".join(plc.item_id for plc in fitting)
            self._warn(text, f"fits {names}; put the link's name in front")
            return None
        return self._gateway.stations.get(fitting[0].item_id) if fitting else None

    def _known(self, station: Station, name: RunTimeName, address: Address) -> int | None:
        """The item of the same place and type; of several the one with the least access."""
        rows = self._indexed().places.get((station.name, str(address), name.served_type), [])
        if not rows:
            return None
        row = min(rows, key=lambda r: self._gateway.item(r).access.value.bit_count())
        self.touch(row)
        return row

    def _indexed(self) -> _Index:
        if self._index is None:
            self._index = _Index()
            for station in self._gateway.stations.values():
                for row, item in station.items():
                    name = item.run_time_name.casefold()
                    self._index.names.setdefault(name, row)
                    if item.scaling is not None or not isinstance(item.address, Address):
                        unlinked = name.partition(":")[2]
                        self._index.unlinked[unlinked] = None if unlinked in self._index.unlinked else row
                    place = (station.name, str(item.address), item.data_type)
                    self._index.places.setdefault(place, []).append(row)
        return self._index

    def _make(self, station: Station, name: RunTimeName, address: Address, text: str) -> int | None:
        settings = self._gateway.project.dynamic_items
        access = (
            (name.access or Access.RW) & settings.access & self._covering_access(station, address, name.served_type)
        )
        if not access:
            log.info("%s: dynamic items have no access of that kind here", text)
            return None
        if len(self._used) >= settings.max:
            self.sweep()
        if len(self._used) >= settings.max:
            self._warn(text, f"is not made: there are already {settings.max} dynamic items")
            return None
        low, high = _limits(name)
        traits = Traits(
            station=station.plc.station,
            data_type=name.served_type,
            raw_type=name.served_type,
            access=access,
            length=MAX_STRING if name.served_type is DataType.STRING else 0,
            low=low,
            high=high,
            write_limits=station.plc.write_limits,
        )
        item = Item("", address, traits)
        item = replace(item, item_id=item.run_time_name)
        row = self._gateway.add_items(station, [item])[0]
        self._gateway.table.add_alias(text, row)
        self._used[row] = self._gateway.now()
        self._gateway.refresh(station)
        return row

    def _covering_access(self, station: Station, address: Address, data_type: DataType) -> Access:
        """What all configured items over the same bytes allow."""
        first, bit = locate(address)
        last = first + _extent(data_type, address.count, bit, MAX_STRING)
        allowed = Access.RW
        for row, item in station.items():
            if row in self._used or not isinstance(item.address, Address):
                continue
            start, start_bit = locate(item.address)
            end = start + _extent(item.raw_type, item.address.count, start_bit, item.length or MAX_STRING)
            if start < last and first < end and not _different_bits(data_type, address, item.raw_type, item.address):
                allowed &= item.access
        return allowed

    # ------------------------------------------------------------------ idle items

    def sweep(self) -> None:
        """Remove the items that nobody used for the idle time."""
        settings = self._gateway.project.dynamic_items
        oldest = self._gateway.now() - int(settings.idle * TICKS_PER_SECOND)
        held = {row for rows in self._holders for row in rows()}
        gone = [row for row, used in self._used.items() if used < oldest and row not in held]
        for row in held & self._used.keys():
            self._used[row] = self._gateway.now()
        if gone:
            self.drop(gone)

    def drop(self, rows: Iterable[int]) -> None:
        """Remove dynamic items."""
        gone = list(rows)
        for row in gone:
            self._used.pop(row, None)
        self._gateway.remove_items(gone)

    def rows_of(self, station: Station) -> list[int]:
        """Dynamic rows of one PLC."""
        return [row for row, _ in station.items() if row in self._used]

    async def run(self) -> None:
        """Sweep from time to time; ends only by cancellation."""
        while True:
            await self._gateway.clock.sleep(min(_LONGEST_SWEEP, self._gateway.project.dynamic_items.idle / 10))
            self.sweep()


def _limits(name: RunTimeName) -> tuple[float | None, float | None]:
    """Low and high in their order; PC Access writes zeros where there are none."""
    if name.low is None or name.high is None or name.low == name.high:
        return None, None
    return min(name.low, name.high), max(name.low, name.high)


def _extent(data_type: DataType, count: int, bit: int, length: int) -> int:
    """Bytes from the first one on that a value touches."""
    if data_type is DataType.BOOL:
        return (bit + count + 7) // 8
    if data_type is DataType.STRING:
        return (1 + length) * count
    return data_type.size * count


def _different_bits(type_a: DataType, a: Address, type_b: DataType, b: Address) -> bool:
    """Two single bits of one byte do not cover each other."""
    return type_a is type_b is DataType.BOOL and a.count == b.count == 1 and locate(a) != locate(b)
