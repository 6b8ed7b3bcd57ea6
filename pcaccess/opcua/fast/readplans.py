"""How to answer a Read: made once for what a request asks, good as long as no rows come or go.

A few values are copied record by record; many are gathered through one index of bytes, whatever their types.

Source:   OPC UA Part 4, 7.40 TimestampsToReturn; Part 6, 5.2.2.17 DataValue.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from asyncua.ua.status_codes import StatusCodes
from numpy.typing import NDArray

from pcaccess.gateway.station import Station
from pcaccess.items.records import LAYOUTS, MASK_SERVER, MASK_SOURCE, MASK_STATUS, MASK_VALUE, OBJECT_KIND
from pcaccess.items.table import ItemTable
from pcaccess.opcua.fast.lookup import DYNAMIC, POLLED, READABLE, Lookup

SMALL: Final = 8
"""Up to so many values are copied one by one: arrays cost more to set up than they save."""

_COUNT: Final = struct.Struct("<i")
_NO_DIAGNOSTICS: Final = _COUNT.pack(-1)
_STATUS: Final = struct.Struct("<I")
_TIME: Final = struct.Struct("<q")
_SOURCE, _SERVER, _BOTH, _NEITHER = range(4)
_MASKS: Final = tuple(MASK_STATUS | times for times in (MASK_SOURCE, MASK_SERVER, MASK_SOURCE | MASK_SERVER, 0))
_CUTS: Final = (8, 8, 0, 16)
"""Bytes at the end of a record that each TimestampsToReturn leaves out; Server alone takes Source's place."""


Found = Sequence[int] | NDArray[np.int64]
"""Rows, negative for unknown nodes."""


def _refusal(status: int) -> bytes:
    return struct.pack("<BI", MASK_STATUS, status)


_UNKNOWN: Final = _refusal(StatusCodes.BadNodeIdUnknown)
_NOT_READABLE: Final = _refusal(StatusCodes.BadNotReadable)


class ReadPlan:
    """What both kinds of plan have."""

    def __init__(self, times: int, table: ItemTable) -> None:
        self.generation = table.generation
        self.owner: object | None = None
        """``Registered.issue`` of the session whose handles the request has; None for names that all may use."""
        self.live: list[Station] = []
        """PLCs whose samples are as new as the question."""
        self.polled: list[int] = []
        """Rows that the gateway must be asked for first."""
        self.dynamic: list[int] = []
        """Rows that go when nobody uses them."""
        self.size = 400
        """Bytes that keeping the plan costs, about."""
        self._table = table
        self._times = times

    def reply(self) -> bytes:
        """The parameters of the response: results from the records as they are now, and no diagnostics."""
        raise NotImplementedError

    def _object(self, place: int) -> bytes:
        """A string or an array."""
        mask = _MASKS[self._times]
        record = self._table.block(OBJECT_KIND.index)[place]
        has_value = int(record["mask"]) & MASK_VALUE
        parts = [bytes((mask | has_value,))]
        if has_value:
            parts.append(self._table.object_variant(place))
        parts.append(_STATUS.pack(int(record["status"])))
        if mask & MASK_SOURCE:
            parts.append(_TIME.pack(int(record["source"])))
        if mask & MASK_SERVER:
            parts.append(_TIME.pack(int(record["server"])))
        return b"".join(parts)


class SmallPlan(ReadPlan):
    """A few values."""

    def __init__(self, times: int, found: Sequence[int], lookup: Lookup, table: ItemTable) -> None:
        """``found``: rows, negative for unknown nodes."""
        super().__init__(times, table)
        self._head = _COUNT.pack(len(found))
        self._copies: list[Callable[[], bytes]] = []
        for row in found:
            if row < 0:
                self._copies.append(lambda: _UNKNOWN)
                continue
            flags, station = lookup.fact(row)
            if station.live and station not in self.live:
                self.live.append(station)
            if flags & POLLED:
                self.polled.append(row)
            if flags & DYNAMIC:
                self.dynamic.append(row)
            self._copies.append(self._copy(row) if flags & READABLE else lambda: _NOT_READABLE)
        self.size += 400 * len(found)

    def _copy(self, row: int) -> Callable[[], bytes]:
        """What copies one record in the form the request asks for."""
        kind, place = self._table.place(row)
        if kind == OBJECT_KIND.index:
            return lambda: self._object(place)
        size = LAYOUTS[kind].size
        view = self._table.buffer(kind)[place * size : (place + 1) * size]
        if self._times == _BOTH:
            return view.tobytes
        mask = bytes((_MASKS[self._times] | MASK_VALUE,))
        if self._times == _SERVER:
            value, server = view[1:-16], view[-8:]
            return lambda: b"".join((mask, value, server))
        value = view[1 : size - _CUTS[self._times]]
        return lambda: mask + value

    def reply(self) -> bytes:
        copies = self._copies
        if len(copies) == 1:
            return self._head + copies[0]() + _NO_DIAGNOSTICS
        return b"".join((self._head, *[copy() for copy in copies], _NO_DIAGNOSTICS))


class BulkPlan(ReadPlan):
    """Many values: where each byte of the reply comes from."""

    def __init__(self, times: int, found: Found, lookup: Lookup, table: ItemTable) -> None:
        """``found``: rows, negative for unknown nodes."""
        super().__init__(times, table)
        places = np.asarray(found, np.int64)
        is_known = places >= 0
        known = places if is_known.all() else places[is_known]
        flags = lookup.flags(known)
        self.live = [station for station in lookup.stations(known) if station.live]
        every = int(np.bitwise_or.reduce(flags)) if len(flags) else 0
        if every & (POLLED | DYNAMIC):
            self.polled = known[(flags & POLLED) != 0].tolist()
            self.dynamic = known[(flags & DYNAMIC) != 0].tolist()
        readable = is_known.copy()
        readable[is_known] = (flags & READABLE) != 0
        self._head = _COUNT.pack(len(places))
        self._objects: list[tuple[int, int]] = []
        """Where in the reply strings and arrays go, and their places."""
        self._arrange(places, readable)

    def _arrange(self, places: NDArray[np.int64], readable: NDArray[np.bool_]) -> None:
        """Records are copied side by side by kind, then an index puts their bytes in order."""
        positions = np.flatnonzero(readable)
        kinds, at_place = self._table.places(places if len(positions) == len(places) else places[positions])
        starts, lengths = np.zeros(len(places), np.int64), np.zeros(len(places), np.int64)
        self._parts: list[tuple[NDArray[np.void], NDArray[np.int64], NDArray[np.void], int]] = []
        regions: list[tuple[int, NDArray[np.int64], int]] = []
        at = 0
        for kind in np.flatnonzero(np.bincount(kinds, minlength=len(LAYOUTS))).tolist():
            if kind == OBJECT_KIND.index:
                continue
            of_kind = np.flatnonzero(kinds == kind)
            size, number = LAYOUTS[kind].size, len(of_kind)
            where = positions[of_kind]
            starts[where] = np.arange(at, at + number * size, size)
            lengths[where] = size - _CUTS[self._times]
            regions.append((kind, at_place[of_kind], at))
            at += number * size
        constants = b""
        for position in np.flatnonzero(~readable).tolist() if len(positions) < len(places) else ():
            refusal = _UNKNOWN if places[position] < 0 else _NOT_READABLE
            offset = constants.find(refusal)
            if offset < 0:
                offset, constants = len(constants), constants + refusal
            starts[position], lengths[position] = at + offset, len(refusal)
        self._side_by_side = np.empty(at + len(constants), np.uint8)
        self._side_by_side[at:] = np.frombuffer(constants, np.uint8)
        for kind, members, first in regions:
            size = LAYOUTS[kind].size
            void = np.dtype(f"V{size}")
            region = self._side_by_side[first : first + len(members) * size].view(void)
            self._parts.append((self._table.block(kind).view(void), members, region, kind))
        ends = np.cumsum(lengths)
        self._index = np.repeat(starts - ends + lengths, lengths)
        self._index += np.arange(len(self._index))
        objects = kinds == OBJECT_KIND.index
        if objects.any():
            self._objects = list(zip(ends[positions[objects]].tolist(), at_place[objects].tolist(), strict=True))
        self.size += self._index.nbytes + self._side_by_side.nbytes + 16 * len(places) + 100 * len(self._objects)

    def reply(self) -> bytes:
        for block, members, region, kind in self._parts:
            block.take(members, out=region, mode="clip")
            if self._times != _BOTH:
                records = region.view(self._table.block(kind).dtype)
                records["mask"] = _MASKS[self._times] | MASK_VALUE
                if self._times == _SERVER:
                    records["source"] = records["server"]
        taken = self._side_by_side.take(self._index).data
        if not self._objects:
            return b"".join((self._head, taken, _NO_DIAGNOSTICS))
        parts: list[bytes | memoryview] = [self._head]
        before = 0
        for at, place in self._objects:
            parts += (taken[before:at], self._object(place))
            before = at
        return b"".join((*parts, taken[before:], _NO_DIAGNOSTICS))


def make_plan(times: int, found: Found, lookup: Lookup, table: ItemTable) -> ReadPlan:
    """A plan of the kind that suits the number of values."""
    if len(found) <= SMALL:
        return SmallPlan(times, [int(row) for row in found], lookup, table)
    return BulkPlan(times, found, lookup, table)
