"""The Read service on encoded records: a request's bytes to rows, rows to the bytes of the reply.

A request for many values is split by the bytes that stand between two NodeIds when nothing unusual is asked (the Value
attribute, no index range, no encoding). The pieces are looked up as they are: as each is exactly a NodeId that the
lookup knows, and a NodeId ends where its length says, no other reading of the request exists.

Not here: other attributes, index ranges, other namespaces, requests that make no sense: asyncua answers those.
Source:   OPC UA Part 4, 5.10.2 Read; Part 6, 5.2.2.17 DataValue.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from asyncua import ua
from asyncua.ua.status_codes import StatusCodes
from numpy.typing import NDArray

from pcaccess.gateway.gateway import Gateway
from pcaccess.items.records import LAYOUTS, MASK_SERVER, MASK_SOURCE, MASK_STATUS, MASK_VALUE, OBJECT_KIND
from pcaccess.items.table import ItemTable
from pcaccess.opcua.fast.lookup import DYNAMIC, FOREIGN, POLLED, READABLE, Lookup
from pcaccess.opcua.fast.plans import Plans
from pcaccess.opcua.limits import MAX_NODES_PER_READ

_HEAD: Final = struct.Struct("<dii")
_COUNT: Final = struct.Struct("<i")
_PLAIN: Final = b"\x0d\x00\x00\x00\xff\xff\xff\xff\x00\x00\xff\xff\xff\xff"
"""Value attribute, null index range, null data encoding: what follows each NodeId of a plain request."""
_NO_DIAGNOSTICS: Final = _COUNT.pack(-1)
_SMALL: Final = 8
"""Up to so many values are copied one by one: arrays cost more to set up than they save."""

_SOURCE, _SERVER, _BOTH, _NEITHER = range(4)
_TIME_MASKS: Final = (MASK_SOURCE, MASK_SERVER, MASK_SOURCE | MASK_SERVER, 0)
_CUTS: Final = (8, 8, 0, 16)
"""Bytes at the end of a record that each TimestampsToReturn leaves out; Server alone takes Source's place."""

Registered = Callable[[ua.NodeId], ua.NodeId]


def _refusal(status: int) -> bytes:
    return struct.pack("<BI", MASK_STATUS, status)


_UNKNOWN: Final = _refusal(StatusCodes.BadNodeIdUnknown)
_NOT_READABLE: Final = _refusal(StatusCodes.BadNotReadable)


class ReadPlan:
    """How to answer one request, as long as no rows come or go."""

    def __init__(self, max_age: float, times: int, found: Sequence[int], lookup: Lookup, table: ItemTable) -> None:
        """``found``: rows, or ``UNKNOWN_NODE``."""
        self.generation = table.generation
        self.max_age = max_age
        self.owner: object | None = None
        """The session whose registered nodes the request names; None for names that all may use."""
        self._table = table
        self._times = times
        self._mask = MASK_STATUS | _TIME_MASKS[times]
        places = np.array(found, np.int64)
        known = places[places >= 0]
        flags = lookup.flags(known)
        self.live = [station for station in lookup.stations(known) if station.live]
        """PLCs whose samples are as new as the question."""
        self.polled: list[int] = known[(flags & POLLED) != 0].tolist()
        self.dynamic: list[int] = known[(flags & DYNAMIC) != 0].tolist()
        readable = np.zeros(len(places), np.bool_)
        readable[places >= 0] = (flags & READABLE) != 0
        self._head = _COUNT.pack(len(places))
        self._gather = _Gather(places, readable, self._mask, times, table)
        self.size = 400 + self._gather.size + 64 * len(self.dynamic)

    def reply(self) -> bytes:
        """The parameters of the response: results, and no diagnostics."""
        return b"".join((self._head, *self._gather.parts(), _NO_DIAGNOSTICS))


class _Gather:
    """Copies the records of a plan's rows, in the order of the request."""

    def __init__(
        self, places: NDArray[np.int64], readable: NDArray[np.bool_], mask: int, times: int, table: ItemTable
    ) -> None:
        self._table = table
        self._mask = mask
        self._times = times
        rows = places[readable]
        self._kinds, self._places = table.places(rows)
        self._refused = {n: _NOT_READABLE if places[n] >= 0 else _UNKNOWN for n in np.flatnonzero(~readable).tolist()}
        self._positions = np.flatnonzero(readable)
        self._objects = (self._kinds == OBJECT_KIND.index).any()
        self._small = self._make_small() if len(places) <= _SMALL else None
        self._plan: tuple[Any, ...] | None = None
        self._count = len(places)
        self.size = 700 * self._count if self._small is not None else 0
        if self._small is None:
            self._arrange()

    # ------------------------------------------------------------------ a few values

    def _make_small(self) -> list[Callable[[], bytes]]:
        return [self._one(int(k), int(p)) for k, p in zip(self._kinds, self._places, strict=True)]

    def _one(self, kind: int, place: int) -> Callable[[], bytes]:
        """What copies one record in the form the request asks for."""
        if kind == OBJECT_KIND.index:
            return lambda: self._object(place)
        size = LAYOUTS[kind].size
        view = self._table.buffer(kind)[place * size : (place + 1) * size]
        if self._times == _BOTH:
            return view.tobytes
        mask = bytes((self._mask | MASK_VALUE,))
        if self._times == _SERVER:
            value, server = view[1:-16], view[-8:]
            return lambda: b"".join((mask, value, server))
        value = view[1 : size - _CUTS[self._times]]
        return lambda: mask + value

    def _object(self, place: int) -> bytes:
        """A string or an array."""
        record = self._table.block(OBJECT_KIND.index)[place]
        has_value = int(record["mask"]) & MASK_VALUE
        head = bytes((self._mask | has_value,))
        variant = self._table.object_variant(place) if has_value else b""
        tail = struct.pack("<I", int(record["status"]))
        if self._mask & MASK_SOURCE:
            tail += struct.pack("<q", int(record["source"]))
        if self._mask & MASK_SERVER:
            tail += struct.pack("<q", int(record["server"]))
        return head + variant + tail

    # ------------------------------------------------------------------ many values

    def _arrange(self) -> None:
        """Where each byte of the reply comes from: one index into the records side by side."""
        cut = _CUTS[self._times]
        starts = np.zeros(self._count, np.int64)
        lengths = np.zeros(self._count, np.int64)
        parts: list[tuple[int, NDArray[np.int64], int, int]] = []
        at = 0
        for kind in np.unique(self._kinds).tolist():
            if kind == OBJECT_KIND.index:
                continue
            of_kind = self._kinds == kind
            size, number = LAYOUTS[kind].size, int(of_kind.sum())
            positions = self._positions[of_kind]
            starts[positions] = at + np.arange(number) * size
            lengths[positions] = size - cut
            parts.append((kind, self._places[of_kind], at, at + number * size))
            at += number * size
        constants = b""
        for position, refusal in self._refused.items():
            where = constants.find(refusal)
            if where < 0:
                where, constants = len(constants), constants + refusal
            starts[position], lengths[position] = at + where, len(refusal)
        ends = np.cumsum(lengths)
        index = np.repeat(starts - ends + lengths, lengths) + np.arange(int(ends[-1]))
        objects: list[tuple[int, int]] = []
        if self._objects:
            of_kind = self._kinds == OBJECT_KIND.index
            at_reply = ends[self._positions[of_kind]]
            objects = list(zip(at_reply.tolist(), self._places[of_kind].tolist(), strict=True))
        self._plan = (parts, at, constants, index, objects)
        self.size = index.nbytes + 16 * self._count + 100 * len(objects)

    def _many(self) -> list[bytes | memoryview]:
        if self._plan is None:
            raise RuntimeError("not arranged")
        parts, size, constants, index, objects = self._plan
        compact = np.empty(size + len(constants), np.uint8)
        for kind, places, first, last in parts:
            block = self._table.block(kind)
            region = compact[first:last].view(block.dtype)
            region[:] = block.take(places)
            if self._times != _BOTH:
                region["mask"] = self._mask | MASK_VALUE
                if self._times == _SERVER:
                    region["source"] = region["server"]
        compact[size:] = np.frombuffer(constants, np.uint8)
        taken = compact.take(index).data
        if not objects:
            return [taken]
        found: list[bytes | memoryview] = []
        before = 0
        for at, place in objects:
            found += (taken[before:at], self._object(place))
            before = at
        found.append(taken[before:])
        return found

    def parts(self) -> list[bytes | memoryview]:
        """The encoded results."""
        if self._small is None:
            return self._many()
        if not self._refused:
            return [copy() for copy in self._small]
        copies = iter(self._small)
        return [self._refused[n] if n in self._refused else next(copies)() for n in range(self._count)]


class Reads:
    """The Read service of one gateway."""

    def __init__(self, gateway: Gateway, lookup: Lookup) -> None:
        self._gateway = gateway
        self._table = gateway.table
        self._lookup = lookup
        self.plans: Plans[ReadPlan] = Plans()

    def plan(self, request: bytes, session: object, registered: Registered) -> ReadPlan | None:
        """How to answer; ``request`` is what follows the request header. None: asyncua must."""
        plan = self.plans.get(request)
        if plan is not None and plan.generation == self._table.generation and plan.owner in (None, session):
            return plan
        made = self._make(request, session, registered)
        if made is not None:
            self.plans.offer(request, made)
        elif plan is not None:
            self.plans.drop(request)
        return made

    def reply(self, plan: ReadPlan) -> bytes:
        """The response's parameters, from the records as they are now."""
        if plan.live:
            now = self._gateway.now()
            for station in plan.live:
                station.freshen(now)
        for row in plan.dynamic:
            self._gateway.dynamic.touch(row)
        return plan.reply()

    async def fetch(self, plan: ReadPlan) -> None:
        """Wait until the samples are as new as the request wants them."""
        await self._gateway.read(plan.polled, plan.max_age)

    def _make(self, request: bytes, session: object, registered: Registered) -> ReadPlan | None:
        if len(request) < _HEAD.size:
            return None
        max_age, times, count = _HEAD.unpack_from(request)
        if not (max_age >= 0 and 0 <= times <= 3 and 0 < count <= MAX_NODES_PER_READ):
            return None
        encoded = request[_HEAD.size :].split(_PLAIN)
        if len(encoded) != count + 1 or encoded.pop():
            return None
        self._lookup.refresh()
        removals = self._table.removals
        found = self._lookup.rows(encoded)
        owner = None
        if None in found:
            for n, row in enumerate(found):
                if row is not None:
                    continue
                resolved = self._lookup.resolve(encoded[n], registered)
                if resolved == FOREIGN:
                    return None
                if encoded[n][0] != 3:
                    owner = session
                found[n] = resolved
            if self._table.removals != removals:  # making one dynamic item ended another
                return None
        plan = ReadPlan(max_age / 1000, times, found, self._lookup, self._table)  # type: ignore[arg-type]
        plan.owner = owner
        return plan
