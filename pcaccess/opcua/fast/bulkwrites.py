"""A Write of many single values, in columns from the request's bytes to the PLC's memory."""

from __future__ import annotations

from typing import Final

import numpy as np
from asyncua.ua.status_codes import StatusCodes
from numpy.typing import NDArray

from pcaccess.gateway.bulk import write_blocks
from pcaccess.opcua.fast.columns import Marker, Positions, windows
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
from pcaccess.opcua.registered import Registered
from pcaccess.opcua.values import WRITE_STATUS
from pcaccess.s7200.types import DataType

_MARKER: Final = Marker(PLAIN)
_SIZES: Final = np.array([CODECS[n].size if n in CODECS else 0 for n in range(256)], np.int64)
"""By the first byte of a Variant; 0 for what is none of the above."""
_EXTRAS: Final = np.array([EXTRAS.get(mask, -1) for mask in range(256)], np.int64)
"""By mask; -1 without a value."""


class BulkWrite:
    """A request that was understood."""

    __slots__ = ("_body", "_statuses", "_types", "_values", "_verbatim", "dynamic", "rows")

    def __init__(
        self, body: bytes, rows: Positions, types: NDArray[np.uint8], values: Positions, lookup: Lookup
    ) -> None:
        """Refuse what the item is not for: access, then type, as asyncua's path does.

        ``rows``: negative for unknown nodes; ``values``: where they begin in ``body``.
        """
        known = rows >= 0
        flags, fits = np.zeros(len(rows), np.uint8), np.zeros(len(rows), np.bool_)
        flags[known] = lookup.flags(rows[known])
        fits[known] = lookup.variant_types(rows[known]) == types[known]
        statuses = np.full(len(rows), DONE, np.uint32)
        statuses[~fits] = StatusCodes.BadTypeMismatch
        statuses[(flags & WRITABLE) == 0] = StatusCodes.BadNotWritable
        statuses[~known] = StatusCodes.BadNodeIdUnknown
        refused = statuses != DONE
        self.dynamic: list[int] = rows[(flags & DYNAMIC) != 0].tolist()
        self.rows = np.where(refused, -1, rows)
        self._body = body
        self._types = types
        self._values = values
        self._statuses = statuses
        self._verbatim = bool((((flags & VERBATIM) != 0) | refused).all())

    def write_blocks(self, lookup: Lookup) -> bytes | None:
        """Straight into PLC memory; gives the response's parameters. None, with nothing done, where that cannot be."""
        if not self._verbatim:
            return None
        pending = np.flatnonzero(self.rows >= 0)
        values = self._values[pending]

        def data_of(positions: NDArray[np.intp], raw_type: DataType) -> NDArray[np.uint8]:
            column = windows(self._body, f"<u{raw_type.size}")[values[positions]]
            if raw_type is DataType.BOOL:
                column = column != 0
            swapped: NDArray[np.uint8] = column.astype(f">u{raw_type.size}").view(np.uint8).reshape(len(column), -1)
            return swapped

        refused = write_blocks(lookup.columns(self.rows[pending]), lookup.station, data_of)
        if refused is None:
            return None
        for positions, outcome in refused:
            self._statuses[pending[positions]] = WRITE_STATUS[outcome]
        return b"".join((COUNT.pack(len(self._statuses)), self._statuses.astype("<u4").tobytes(), NO_DIAGNOSTICS))

    def one_by_one(self) -> WriteRequest:
        """The same, for what has to look at every value."""
        types, body = self._types.tolist(), self._body
        values = [body[at : at + CODECS[number].size] for at, number in zip(self._values.tolist(), types, strict=True)]
        return WriteRequest(self.rows.tolist(), types, values, self._statuses.tolist(), self._verbatim, self.dynamic)


def read_bulk(body: bytes, count: int, lookup: Lookup, registered: Registered) -> BulkWrite | None:
    """``body`` is what follows the request header. None: asyncua must.

    Where one value ends the next node begins, and each node must be one whole NodeId, so that no other reading of the
    request exists.
    """
    marks = _MARKER.positions(body, COUNT.size, count)
    if marks is None or marks[-1] + len(PLAIN) + 2 > len(body):
        return None
    octets = np.frombuffer(body, np.uint8)
    heads = marks + len(PLAIN)
    masks, values = octets[heads], heads + 2
    types = octets[heads + 1]
    sizes, extras = _SIZES[types], _EXTRAS[masks]
    ends = values + sizes + extras
    starts = np.concatenate(([COUNT.size], ends[:-1]))
    if not sizes.all() or (extras < 0).any() or ends[-1] != len(body) or (starts >= marks).any():
        return None
    stated = np.flatnonzero(masks & HAS_STATUS)
    if len(stated) and windows(body, "<u4")[(values + sizes)[stated]].any():
        return None
    found = lookup.resolve_many(body, starts, marks, registered)
    return None if found is None else BulkWrite(body, found[0], types, values, lookup)
