"""The Write service by hand: a request's bytes to rows and values, values to PLC memory in one go.

Values that need no look at (``pcaccess.gateway.writing.is_verbatim``) go from the request to memory as columns of
bytes. Single values of other items are decoded here and take the gateway's way; texts, arrays, index ranges and
whatever makes no sense are asyncua's.

Source:   OPC UA Part 4, 5.10.4 Write; Part 6, 5.2.2.16 Variant and 5.2.2.17 DataValue.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from asyncua.ua.status_codes import StatusCodes

from pcaccess.gateway.bulk import write_few
from pcaccess.gateway.gateway import Gateway
from pcaccess.links.base import Outcome
from pcaccess.opcua.fast.bulkwrites import BulkWrite, read_bulk
from pcaccess.opcua.fast.lookup import DYNAMIC, VERBATIM, WRITABLE, Lookup
from pcaccess.opcua.fast.writerequest import (
    CODECS,
    COUNT,
    DONE,
    EXTRAS,
    HAS_STATUS,
    NO_DIAGNOSTICS,
    PLAIN,
    WriteRequest,
)
from pcaccess.opcua.limits import MAX_NODES_PER_WRITE
from pcaccess.opcua.registered import Registered
from pcaccess.opcua.values import WRITE_STATUS
from pcaccess.s7200.types import Value

_BOOLEAN: Final = 1
_GOOD: Final = b"\x00\x00\x00\x00"
_BULK: Final = 16
"""From so many values on columns are worth their cost."""


@dataclass(frozen=True, slots=True)
class _Shape:
    """A DataValue's first two bytes say how it goes on."""

    type: int
    value_end: int
    end: int
    has_status: bool


def _shapes() -> dict[bytes, _Shape]:
    shapes = {}
    for mask, extra in EXTRAS.items():
        for number, codec in CODECS.items():
            value_end = 2 + codec.size
            shapes[bytes((mask, number))] = _Shape(number, value_end, value_end + extra, bool(mask & HAS_STATUS))
    return shapes


_SHAPES: Final = MappingProxyType(_shapes())


class Writes:
    """The Write service of one gateway."""

    def __init__(self, gateway: Gateway, lookup: Lookup) -> None:
        self._gateway = gateway
        self._lookup = lookup

    # ------------------------------------------------------------------ understanding

    def parse(self, request: bytes, registered: Registered) -> WriteRequest | BulkWrite | None:
        """``request`` is what follows the request header. None: asyncua must."""
        if len(request) < COUNT.size:
            return None
        (count,) = COUNT.unpack_from(request)
        if not 0 < count <= MAX_NODES_PER_WRITE:
            return None
        if count >= _BULK:
            return read_bulk(request, count, self._lookup, registered)
        return self._parse_few(request, count, registered)

    def _parse_few(self, request: bytes, count: int, registered: Registered) -> WriteRequest | None:
        pieces = request[COUNT.size :].split(PLAIN)
        if len(pieces) != count + 1:
            return None
        encoded, types, values = [pieces[0]], [], []
        for piece in pieces[1:]:
            shape = _SHAPES.get(piece[:2])
            if shape is None or len(piece) < shape.end:
                return None
            end = shape.value_end
            if shape.has_status and piece[end : end + 4] != _GOOD:
                return None
            types.append(shape.type)
            values.append(piece[2:end])
            encoded.append(piece[shape.end :])
        if encoded.pop():
            return None
        rows = self._lookup.resolve_few(encoded, registered)
        return None if rows is None else self._check_few(rows, types, values)

    def _check_few(self, rows: list[int], types: list[int], values: list[bytes]) -> WriteRequest:
        """Refuse what the item is not for: access, then type, as asyncua's path does."""
        request = WriteRequest(rows, types, values, [DONE] * len(rows), True, [])
        for n, row in enumerate(rows):
            if row < 0:
                request.statuses[n] = StatusCodes.BadNodeIdUnknown
                continue
            flags, _ = self._lookup.fact(row)
            if flags & DYNAMIC:
                request.dynamic.append(row)
            if not flags & WRITABLE:
                request.statuses[n], rows[n] = StatusCodes.BadNotWritable, -1
            elif self._lookup.variant_type(row) != types[n]:
                request.statuses[n], rows[n] = StatusCodes.BadTypeMismatch, -1
            elif not flags & VERBATIM:
                request.verbatim = False
        return request

    # ------------------------------------------------------------------ doing

    def write_now(self, request: WriteRequest | BulkWrite) -> bytes | None:
        """Write what every PLC takes at once and give the response's parameters; None, with nothing done, if not."""
        for row in request.dynamic:
            self._gateway.dynamic.touch(row)
        if isinstance(request, BulkWrite):
            done = request.write_blocks(self._lookup)
            if done is not None:
                return done
            request = request.one_by_one()
        rows = request.rows
        pending = [n for n, row in enumerate(rows) if row >= 0]
        outcomes: list[Outcome] | None = None
        if request.verbatim:
            outcomes = write_few(self._gateway, [(rows[n], self._memory(request, n)) for n in pending])
        if outcomes is None:
            outcomes = self._gateway.write_now(self._decoded(request, pending))
        return None if outcomes is None else self._reply(request, pending, outcomes)

    async def write(self, request: WriteRequest | BulkWrite) -> bytes:
        """Write, and wait until every PLC has taken its values."""
        if isinstance(request, BulkWrite):
            request = request.one_by_one()
        pending = [n for n, row in enumerate(request.rows) if row >= 0]
        return self._reply(request, pending, await self._gateway.write(self._decoded(request, pending)))

    def _decoded(self, request: WriteRequest, pending: Sequence[int]) -> list[tuple[int, Value]]:
        return [(request.rows[n], CODECS[request.types[n]].unpack(request.values[n])[0]) for n in pending]

    def _memory(self, request: WriteRequest, n: int) -> bytes:
        """A value as it stands in PLC memory."""
        value = request.values[n]
        if request.types[n] == _BOOLEAN:
            return b"\x01" if value != b"\x00" else value
        return value[::-1]

    def _reply(self, request: WriteRequest, pending: Sequence[int], outcomes: Sequence[Outcome]) -> bytes:
        statuses = request.statuses
        for n, outcome in zip(pending, outcomes, strict=True):
            if outcome is not Outcome.DONE:
                statuses[n] = WRITE_STATUS[outcome]
        return COUNT.pack(len(statuses)) + struct.pack(f"<{len(statuses)}I", *statuses) + NO_DIAGNOSTICS
