"""The Write service by hand: a request's bytes to rows and values, values to PLC memory in one go.

Values that need no look at (``pcaccess.gateway.writing.is_verbatim``) go from the request to memory as columns of
bytes. Single values of other items are decoded here and take the gateway's way; texts, arrays, index ranges and
whatever makes no sense are asyncua's.

Source:   OPC UA Part 4, 5.10.4 Write; Part 6, 5.2.2.16 Variant and 5.2.2.17 DataValue.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np
from asyncua import ua
from asyncua.ua.status_codes import StatusCodes

from pcaccess.gateway.bulk import BulkPlan, plan_bulk
from pcaccess.gateway.gateway import Gateway
from pcaccess.links.base import Outcome
from pcaccess.opcua.fast.lookup import DYNAMIC, FOREIGN, WRITABLE, Lookup
from pcaccess.opcua.limits import MAX_NODES_PER_WRITE
from pcaccess.opcua.values import WRITE_STATUS
from pcaccess.s7200.types import Value

_COUNT: Final = struct.Struct("<i")
_PLAIN: Final = b"\x0d\x00\x00\x00\xff\xff\xff\xff"
"""Value attribute, null index range: what stands between each NodeId and its DataValue in a plain request."""
_GOOD: Final = b"\x00\x00\x00\x00"
_NO_DIAGNOSTICS: Final = _COUNT.pack(-1)
_BULK: Final = 16
"""From so many values on columns are worth their cost."""

_CODECS: Final = MappingProxyType(
    {number: struct.Struct("<" + code) for number, code in enumerate("?bBhHiI", 1)} | {10: struct.Struct("<f")}
)
"""Variant types that an item can have as a single number or bit."""
_BOOLEAN: Final = 1


@dataclass(frozen=True, slots=True)
class _Shape:
    """A DataValue's first two bytes say how it goes on."""

    type: int
    value_end: int
    end: int
    has_status: bool


def _shapes() -> dict[bytes, _Shape]:
    """Value with any of status and times; status, source time, its picoseconds, server time, its picoseconds."""
    shapes = {}
    for mask in range(0x01, 0x40, 2):
        extra = sum(size for bit, size in ((2, 4), (4, 8), (0x10, 2), (8, 8), (0x20, 2)) if mask & bit)
        for number, codec in _CODECS.items():
            value_end = 2 + codec.size
            shapes[bytes((mask, number))] = _Shape(number, value_end, value_end + extra, bool(mask & 2))
    return shapes


_SHAPES: Final = MappingProxyType(_shapes())


@dataclass(slots=True)
class WriteRequest:
    """A request that was understood: what each node is to get, and what is refused already."""

    rows: list[int]
    """Per node its row, or a negative number where ``statuses`` has the answer."""
    types: list[int]
    values: list[bytes]
    """As encoded, little-endian."""
    statuses: list[int]
    dynamic: list[int]

    @property
    def pending(self) -> list[int]:
        """Nodes that are not refused yet."""
        return [n for n, row in enumerate(self.rows) if row >= 0]


class Writes:
    """The Write service of one gateway."""

    def __init__(self, gateway: Gateway, lookup: Lookup) -> None:
        self._gateway = gateway
        self._lookup = lookup

    # ------------------------------------------------------------------ understanding

    def parse(self, request: bytes, registered: Callable[[ua.NodeId], ua.NodeId]) -> WriteRequest | None:
        """``request`` is what follows the request header. None: asyncua must."""
        if len(request) < _COUNT.size:
            return None
        (count,) = _COUNT.unpack_from(request)
        pieces = request[_COUNT.size :].split(_PLAIN)
        if not 0 < count <= MAX_NODES_PER_WRITE or len(pieces) != count + 1:
            return None
        encoded, types, values = [pieces[0]], [], []
        for piece in pieces[1:]:
            shape = _SHAPES.get(piece[:2])
            if shape is None:
                return None
            end = shape.value_end
            if shape.has_status and piece[end : end + 4] != _GOOD:
                return None
            types.append(shape.type)
            values.append(piece[2:end])
            encoded.append(piece[shape.end :])
            if len(piece) < shape.end:
                return None
        if encoded.pop():
            return None
        rows = self._find(encoded, registered)
        return None if rows is None else self._checked(rows, types, values)

    def _find(self, encoded: Sequence[bytes], registered: Callable[[ua.NodeId], ua.NodeId]) -> list[int] | None:
        self._lookup.refresh()
        removals = self._gateway.table.removals
        found: list[int] = []
        for known, node in zip(self._lookup.rows(encoded), encoded, strict=True):
            row = self._lookup.resolve(node, registered) if known is None else known
            if row == FOREIGN:
                return None
            found.append(row)
        return found if self._gateway.table.removals == removals else None

    def _checked(self, found: list[int], types: list[int], values: list[bytes]) -> WriteRequest:
        """Refuse what the item is not for: access and type, as asyncua's path does, in that order."""
        rows = np.array(found, np.int64)
        known = rows >= 0
        statuses = np.where(known, StatusCodes.Good, StatusCodes.BadNodeIdUnknown).astype(np.int64)
        flags = np.zeros(len(rows), np.uint8)
        flags[known] = self._lookup.flags(rows[known])
        fits = np.zeros(len(rows), np.bool_)
        fits[known] = self._lookup.variant_types(rows[known]) == np.array(types)[known]
        writable = (flags & WRITABLE) != 0
        statuses[known & ~fits] = StatusCodes.BadTypeMismatch
        statuses[known & ~writable] = StatusCodes.BadNotWritable
        dynamic = rows[(flags & DYNAMIC) != 0].tolist()
        rows[statuses != StatusCodes.Good] = -1
        return WriteRequest(rows.tolist(), types, values, statuses.tolist(), dynamic)

    # ------------------------------------------------------------------ doing

    def write_now(self, request: WriteRequest) -> bytes | None:
        """Write what every PLC takes at once and give the response's parameters; None, with nothing done, if not."""
        for row in request.dynamic:
            self._gateway.dynamic.touch(row)
        pending = request.pending
        if len(pending) >= _BULK:
            plan = plan_bulk(self._gateway, [request.rows[n] for n in pending])
            if plan is not None:
                return self._write_bulk(request, pending, plan)
        outcomes = self._gateway.write_now(self._decoded(request, pending))
        return None if outcomes is None else self._reply(request, pending, outcomes)

    async def write(self, request: WriteRequest) -> bytes:
        """Write, and wait until every PLC has taken its values."""
        pending = request.pending
        return self._reply(request, pending, await self._gateway.write(self._decoded(request, pending)))

    def _decoded(self, request: WriteRequest, pending: Sequence[int]) -> list[tuple[int, Value]]:
        return [(request.rows[n], _CODECS[request.types[n]].unpack(request.values[n])[0]) for n in pending]

    def _write_bulk(self, request: WriteRequest, pending: Sequence[int], plan: BulkPlan) -> bytes | None:
        data = []
        for target in plan.targets:
            positions = [pending[p] for p in target.positions.tolist()]
            little = np.frombuffer(b"".join([request.values[p] for p in positions]), np.uint8)
            columns = little.reshape(len(positions), -1)
            boolean = request.types[positions[0]] == _BOOLEAN
            data.append((columns != 0).astype(np.uint8) if boolean else columns[:, ::-1])
        outcomes = plan.write(data)
        if outcomes is None:
            return None
        statuses = np.array(request.statuses, np.int64)
        where = np.array(pending, np.int64)
        for target, outcome in zip(plan.targets, outcomes, strict=True):
            statuses[where[target.positions]] = WRITE_STATUS[outcome]
        return self._encoded(statuses.tolist())

    def _reply(self, request: WriteRequest, pending: Sequence[int], outcomes: Sequence[Outcome]) -> bytes:
        for n, outcome in zip(pending, outcomes, strict=True):
            request.statuses[n] = WRITE_STATUS[outcome]
        return self._encoded(request.statuses)

    def _encoded(self, statuses: Sequence[int]) -> bytes:
        return _COUNT.pack(len(statuses)) + struct.pack(f"<{len(statuses)}I", *statuses) + _NO_DIAGNOSTICS
