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
from numpy.typing import NDArray

from pcaccess.gateway.bulk import write_blocks, write_few
from pcaccess.gateway.gateway import Gateway
from pcaccess.links.base import Outcome
from pcaccess.opcua.fast.lookup import DYNAMIC, FOREIGN, VERBATIM, WRITABLE, Lookup
from pcaccess.opcua.limits import MAX_NODES_PER_WRITE
from pcaccess.opcua.values import WRITE_STATUS
from pcaccess.s7200.types import DataType, Value

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
_SIZES: Final = np.array([_CODECS[n].size if n in _CODECS else 0 for n in range(max(_CODECS) + 1)], np.int64)
_BOOLEAN: Final = 1
_DONE: Final = int(StatusCodes.Good)


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
    """Variant types."""
    values: list[bytes]
    """As encoded, little-endian."""
    statuses: list[int]
    verbatim: bool
    """No rules apply to any of the values."""
    dynamic: list[int]


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
        rows = self._find(encoded, registered)
        if rows is None:
            return None
        return (self._check_many if count >= _BULK else self._check_few)(rows, types, values)

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

    def _check_few(self, rows: list[int], types: list[int], values: list[bytes]) -> WriteRequest:
        """Refuse what the item is not for: access, then type, as asyncua's path does."""
        request = WriteRequest(rows, types, values, [_DONE] * len(rows), True, [])
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

    def _check_many(self, found: list[int], types: list[int], values: list[bytes]) -> WriteRequest:
        """The same in columns."""
        rows = np.array(found, np.int64)
        known = rows >= 0
        flags, fits = np.zeros(len(rows), np.uint8), np.zeros(len(rows), np.bool_)
        flags[known] = self._lookup.flags(rows[known])
        fits[known] = self._lookup.variant_types(rows[known]) == np.array(types, np.uint8)[known]
        statuses = np.where(known, _DONE, StatusCodes.BadNodeIdUnknown)
        statuses[known & ~fits] = StatusCodes.BadTypeMismatch
        statuses[known & ((flags & WRITABLE) == 0)] = StatusCodes.BadNotWritable
        refused = statuses != _DONE
        dynamic = rows[(flags & DYNAMIC) != 0].tolist()
        rows[refused] = -1
        verbatim = bool((((flags & VERBATIM) != 0) | refused).all())
        return WriteRequest(rows.tolist(), types, values, statuses.tolist(), verbatim, dynamic)

    # ------------------------------------------------------------------ doing

    def write_now(self, request: WriteRequest) -> bytes | None:
        """Write what every PLC takes at once and give the response's parameters; None, with nothing done, if not."""
        for row in request.dynamic:
            self._gateway.dynamic.touch(row)
        rows = request.rows
        pending = [n for n, row in enumerate(rows) if row >= 0]
        outcomes: list[Outcome] | None = None
        if request.verbatim and len(pending) >= _BULK:
            outcomes = self._write_blocks(request, pending)
        elif request.verbatim:
            outcomes = write_few(self._gateway, [(rows[n], self._memory(request, n)) for n in pending])
        if outcomes is None:
            outcomes = self._gateway.write_now(self._decoded(request, pending))
        return None if outcomes is None else self._reply(request, pending, outcomes)

    async def write(self, request: WriteRequest) -> bytes:
        """Write, and wait until every PLC has taken its values."""
        pending = [n for n, row in enumerate(request.rows) if row >= 0]
        return self._reply(request, pending, await self._gateway.write(self._decoded(request, pending)))

    def _decoded(self, request: WriteRequest, pending: Sequence[int]) -> list[tuple[int, Value]]:
        return [(request.rows[n], _CODECS[request.types[n]].unpack(request.values[n])[0]) for n in pending]

    def _memory(self, request: WriteRequest, n: int) -> bytes:
        """A value as it stands in PLC memory."""
        value = request.values[n]
        if request.types[n] == _BOOLEAN:
            return b"\x01" if value != b"\x00" else value
        return value[::-1]

    def _write_blocks(self, request: WriteRequest, pending: Sequence[int]) -> list[Outcome] | None:
        values = [request.values[n] for n in pending] if len(pending) < len(request.values) else request.values
        joined = np.frombuffer(b"".join(values), np.uint8)
        sizes = _SIZES[np.array([request.types[n] for n in pending], np.uint8)]
        starts = np.cumsum(sizes) - sizes

        def data_of(positions: NDArray[np.intp], raw_type: DataType) -> NDArray[np.uint8]:
            if raw_type is DataType.BOOL:
                bits: NDArray[np.uint8] = (joined[starts[positions]] != 0).astype(np.uint8)[:, None]
                return bits
            data: NDArray[np.uint8] = joined[starts[positions][:, None] + np.arange(raw_type.size)[::-1]]
            return data

        rows = np.array([request.rows[n] for n in pending], np.int64)
        return write_blocks(self._lookup.columns(rows), self._lookup.station, data_of)

    def _reply(self, request: WriteRequest, pending: Sequence[int], outcomes: Sequence[Outcome]) -> bytes:
        statuses = request.statuses
        for n, outcome in zip(pending, outcomes, strict=True):
            if outcome is not Outcome.DONE:
                statuses[n] = WRITE_STATUS[outcome]
        return _COUNT.pack(len(statuses)) + struct.pack(f"<{len(statuses)}I", *statuses) + _NO_DIAGNOSTICS
