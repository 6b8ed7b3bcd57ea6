"""The Read service on encoded records: a request's bytes to rows, rows to the bytes of the reply.

A request is split by the bytes that stand between two NodeIds when nothing unusual is asked (the Value attribute, no
index range, no encoding). The pieces are looked up as they are: as each is exactly a NodeId that the lookup knows, and
a NodeId ends where its length says, no other reading of the request exists.

Not here: other attributes, index ranges, other namespaces, requests that make no sense: asyncua answers those.
Source:   OPC UA Part 4, 5.10.2 Read.
"""

from __future__ import annotations

import struct
from typing import Final

import numpy as np

from pcaccess.gateway.gateway import Gateway
from pcaccess.opcua.fast.columns import Marker, Positions
from pcaccess.opcua.fast.lookup import TEXT, Lookup
from pcaccess.opcua.fast.plans import Plans
from pcaccess.opcua.fast.readplans import ReadPlan, make_plan
from pcaccess.opcua.limits import MAX_NODES_PER_READ
from pcaccess.opcua.registered import Registered

_MAX_AGE: Final = struct.Struct("<d")
_HEAD: Final = struct.Struct("<ii")
_PLAIN: Final = b"\x0d\x00\x00\x00\xff\xff\xff\xff\x00\x00\xff\xff\xff\xff"
"""Value attribute, null index range, null data encoding: what follows each NodeId of a plain request."""

_MARKER: Final = Marker(_PLAIN)
_MANY: Final = 32
"""From so many nodes on columns are worth their cost."""


class Reads:
    """The Read service of one gateway."""

    def __init__(self, gateway: Gateway, lookup: Lookup) -> None:
        self._gateway = gateway
        self._table = gateway.table
        self._lookup = lookup
        self.plans: Plans[ReadPlan] = Plans()

    def plan(self, request: bytes, at: int, registered: Registered) -> ReadPlan | None:
        """How to answer the parameters that begin at ``at``. None: asyncua must.

        MaxAge says when to answer, not how: requests that differ in it alone share a plan.
        """
        if at + _MAX_AGE.size > len(request) or not self.max_age(request, at) >= 0:
            return None
        asked = request[at + _MAX_AGE.size :]
        plan = self.plans.get(asked)
        if plan is not None and plan.generation == self._table.generation and plan.owner in (None, registered.issue):
            return plan
        made = self._make(asked, registered)
        if made is not None:
            self.plans.offer(asked, made)
        elif plan is not None:
            self.plans.drop(asked)
        return made

    @staticmethod
    def max_age(request: bytes, at: int) -> float:
        """Milliseconds."""
        age: float = _MAX_AGE.unpack_from(request, at)[0]
        return age

    def reply(self, plan: ReadPlan, now: int) -> bytes:
        """The response's parameters, from the records as they are now."""
        for station in plan.live:
            station.freshen(now)
        for row in plan.dynamic:
            self._gateway.dynamic.touch(row)
        return plan.reply()

    async def fetch(self, plan: ReadPlan, max_age: float) -> None:
        """Wait until the samples are as new as the request wants them; milliseconds."""
        await self._gateway.read(plan.polled, max_age / 1000)

    def _make(self, asked: bytes, registered: Registered) -> ReadPlan | None:
        if len(asked) < _HEAD.size:
            return None
        times, count = _HEAD.unpack_from(asked)
        if not (0 <= times <= 3 and 0 < count <= MAX_NODES_PER_READ):
            return None
        found = self._find_few(asked, count, registered) if count < _MANY else self._find_many(asked, count, registered)
        if found is None:
            return None
        rows, has_handles = found
        plan = make_plan(times, rows, self._lookup, self._table)
        plan.owner = registered.issue if has_handles else None
        return plan

    def _find_many(self, asked: bytes, count: int, registered: Registered) -> tuple[Positions, bool] | None:
        ends = _MARKER.positions(asked, _HEAD.size, count)
        if ends is None or ends[-1] + len(_PLAIN) != len(asked):
            return None
        starts = np.empty_like(ends)
        starts[0], starts[1:] = _HEAD.size, ends[:-1] + len(_PLAIN)
        return None if (starts >= ends).any() else self._lookup.resolve_many(asked, starts, ends, registered)

    def _find_few(self, asked: bytes, count: int, registered: Registered) -> tuple[list[int], bool] | None:
        encoded = asked[_HEAD.size :].split(_PLAIN)
        if len(encoded) != count + 1 or encoded.pop():
            return None
        rows = self._lookup.resolve_few(encoded, registered)
        return None if rows is None else (rows, any(node[0] != TEXT for node in encoded))
