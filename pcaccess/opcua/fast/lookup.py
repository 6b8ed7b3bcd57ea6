"""Encoded NodeIds to rows, and what the fast services must know of a row, in columns.

Both are filled when somebody asks and forgotten when the table says that rows went or the project changed, so that
100,000 items cost nothing until they are used.

Source:   OPC UA Part 6, 5.2.2.9 NodeId (encoding 3 is a string: 03, namespace, length, text).
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import Final
from weakref import WeakKeyDictionary

import numpy as np
from asyncua import ua
from numpy.typing import NDArray

from pcaccess.gateway.bulk import TYPES, Columns
from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.station import Station
from pcaccess.gateway.writing import is_verbatim
from pcaccess.items.rowset import Rows
from pcaccess.items.varianttypes import VARIANT_TYPES
from pcaccess.opcua.fast.columns import Positions
from pcaccess.opcua.fast.shelves import MISSING, Shelves
from pcaccess.opcua.ids import ITEMS, SYSTEM
from pcaccess.opcua.limits import MAX_REGISTERED_NODES
from pcaccess.opcua.registered import Issue, Registered
from pcaccess.opcua.space import Space
from pcaccess.project.model import Access
from pcaccess.s7200.address import Address
from pcaccess.s7200.memory import locate

MAX_NAMES: Final = 262_144
"""Encoded NodeIds that are remembered; one more forgets them all."""
MAX_NAME: Final = 512
"""Bytes of a NodeId that is worth remembering."""

KNOWN: Final = 0x01
READABLE: Final = 0x02
WRITABLE: Final = 0x04
VERBATIM: Final = 0x08
"""Writable, and every value of its type goes into memory as it is."""
POLLED: Final = 0x10
"""Its sample may be older than a reader wants: the gateway must be asked."""
DYNAMIC: Final = 0x20
"""Goes when nobody uses it, so that every use must be told."""

UNKNOWN_NODE: Final = -1
"""There is no such node."""
FOREIGN: Final = -2
"""There is, or asyncua must decide: another namespace, a folder, a property."""

_STRING_HEAD: Final = struct.Struct("<BHi")
_HEAD: Final = 7
TEXT: Final = 3
"""First byte of a NodeId that is a string."""


class Lookup:
    """Rows by encoded NodeId, facts by row."""

    def __init__(self, gateway: Gateway, space: Space) -> None:
        self._gateway = gateway
        self._space = space
        self._names: dict[bytes, int] = {}
        self._shelves = Shelves(MAX_NAMES, MAX_NAME)
        self._handles: WeakKeyDictionary[Issue, Shelves] = WeakKeyDictionary()
        """Of each session."""
        self._flags: NDArray[np.uint8] = np.zeros(0, np.uint8)
        self._types: NDArray[np.uint8] = np.zeros(0, np.uint8)
        self._station: NDArray[np.int32] = np.zeros(0, np.int32)
        self._raw: NDArray[np.uint8] = np.zeros(0, np.uint8)
        self._offset: NDArray[np.int64] = np.zeros(0, np.int64)
        self._bit: NDArray[np.uint8] = np.zeros(0, np.uint8)
        self._stations: list[Station] = []
        self._station_numbers: dict[int, int] = {}
        self._removals = gateway.table.removals
        gateway.on_structure(self.forget)

    def forget(self) -> None:
        """Names may mean other rows, and rows other items."""
        self._names.clear()
        self._shelves.clear()
        self._handles.clear()
        self._flags[:] = 0
        self._stations.clear()
        self._station_numbers.clear()
        self._removals = self._gateway.table.removals

    def _refresh(self) -> None:
        """Before a look-up: forget what is no longer true."""
        if self._removals != self._gateway.table.removals:
            self.forget()

    # ------------------------------------------------------------------ names

    def resolve_few(self, nodes: Iterable[bytes], registered: Registered) -> list[int] | None:
        """The rows of encoded NodeIds, ``UNKNOWN_NODE`` where there is none. None: asyncua must decide.

        ``registered``: the handles of the session that asks.
        """
        self._refresh()
        removals = self._gateway.table.removals
        rows = [self._resolve(node, registered) for node in nodes]
        if FOREIGN in rows or self._gateway.table.removals != removals:  # making one dynamic item ended another
            return None
        return rows

    def _resolve(self, encoded: bytes, registered: Registered) -> int:
        """Row of an encoded NodeId, ``UNKNOWN_NODE`` or ``FOREIGN``."""
        known = self._names.get(encoded)
        if known is not None:
            return known
        row = self._look_up(encoded, registered)
        if row >= 0 and encoded[0] == TEXT and len(encoded) <= MAX_NAME:
            if len(self._names) >= MAX_NAMES:
                self._names.clear()
            self._names[encoded] = row
        return row

    def resolve_many(
        self, data: bytes, starts: Positions, ends: Positions, registered: Registered
    ) -> tuple[Positions, bool] | None:
        """The rows of NodeIds in ``data``, ``UNKNOWN_NODE`` where there is none; and whether a handle is among them.

        None: asyncua must decide. Each piece is looked up as it is, so a row means that it is one whole NodeId.
        """
        self._refresh()
        removals = self._gateway.table.removals
        rows = self._shelves.rows(data, starts, ends - starts)
        missing = np.flatnonzero(rows == MISSING)
        has_handles = False
        if len(missing) and registered:
            own = self._handles.setdefault(registered.issue, Shelves(MAX_REGISTERED_NODES, MAX_NAME))
            found = own.rows(data, starts[missing], ends[missing] - starts[missing])
            has_handles = bool((found != MISSING).any())
            rows[missing] = found
            missing = missing[found == MISSING]
        for n in missing.tolist():
            encoded = data[starts[n] : ends[n]]
            row = self._look_up(encoded, registered)
            if row == FOREIGN:
                return None
            if encoded[0] != TEXT:
                has_handles = True
                own.learn(encoded, row)
            elif row >= 0:
                self._shelves.learn(encoded, row)
            rows[n] = row
        # Making one dynamic item may have ended another.
        return (rows, has_handles) if self._gateway.table.removals == removals else None

    def _look_up(self, encoded: bytes, registered: Registered) -> int:
        text = _item_name(encoded)
        if text is not None:
            row = self._gateway.find(text)
            if row is None:
                exists = self._space.find(ua.NodeId(ua.String(text), ua.Int16(ITEMS))) is not None
                return FOREIGN if exists else UNKNOWN_NODE
            return row
        handle = _handle(encoded)
        target = None if handle is None else registered.find(handle)
        row = None if target is None else self._space.row(target)
        return FOREIGN if row is None else row

    # ------------------------------------------------------------------ facts

    def flags(self, rows: Rows) -> NDArray[np.uint8]:
        """Facts of each row, as the constants above."""
        self._learn(rows)
        return self._flags[rows]

    def fact(self, row: int) -> tuple[int, Station]:
        """Facts and PLC of one row."""
        if row >= len(self._flags) or not self._flags[row]:
            self._learn(np.array([row]))
        return int(self._flags[row]), self._stations[self._station[row]]

    def variant_types(self, rows: Rows) -> NDArray[np.uint8]:
        """OPC UA type number that a single value of each row has; 0 for arrays. After :meth:`flags`."""
        return self._types[rows]

    def stations(self, rows: Rows) -> list[Station]:
        """The PLCs of some rows. After :meth:`flags`."""
        numbers = self._station[rows]
        if len(numbers) and (numbers == numbers[0]).all():
            return [self._stations[numbers[0]]]
        return [self._stations[n] for n in np.unique(numbers).tolist()]

    def variant_type(self, row: int) -> int:
        """The same of one row. After :meth:`fact`."""
        return int(self._types[row])

    def columns(self, rows: Rows) -> Columns:
        """Where the values of verbatim rows go. After :meth:`flags`."""
        return Columns(self._station[rows], self._raw[rows], self._offset[rows], self._bit[rows])

    def station(self, number: int) -> Station:
        """The PLC of a number in :meth:`columns`."""
        return self._stations[number]

    def _learn(self, rows: Rows) -> None:
        highest = int(rows.max(initial=-1))
        if highest >= len(self._flags):
            size = max(1024, 2 * (highest + 1))
            for name in ("_flags", "_types", "_station", "_raw", "_offset", "_bit"):
                old = getattr(self, name)
                column = np.zeros(size, old.dtype)
                column[: len(old)] = old
                setattr(self, name, column)
        for row in rows[self._flags[rows] == 0].tolist():
            self._learn_one(row)

    def _learn_one(self, row: int) -> None:
        gateway = self._gateway
        item, station = gateway.item(row), gateway.station(row)
        flags = KNOWN
        if item.access & Access.R:
            flags |= READABLE
        if item.access & Access.W:
            flags |= WRITABLE
        if is_verbatim(item) and isinstance(item.address, Address):
            flags |= VERBATIM
            self._raw[row] = TYPES.index(item.raw_type)
            self._offset[row], self._bit[row] = locate(item.address)
        if station.polled:
            flags |= POLLED
        if row in gateway.dynamic:
            flags |= DYNAMIC
        self._flags[row] = flags
        self._types[row] = VARIANT_TYPES[item.data_type] if item.count == 1 else 0
        number = self._station_numbers.get(id(station))
        if number is None:
            number = self._station_numbers[id(station)] = len(self._stations)
            self._stations.append(station)
        self._station[row] = number


def _item_name(encoded: bytes) -> str | None:
    """The text of a string NodeId of the items' namespace, if ``encoded`` is just that."""
    if len(encoded) < _HEAD:
        return None
    kind, namespace, length = _STRING_HEAD.unpack_from(encoded)
    if kind != TEXT or namespace != ITEMS or length != len(encoded) - _HEAD:
        return None
    try:
        return encoded[_HEAD:].decode()
    except UnicodeDecodeError:
        return None


def _handle(encoded: bytes) -> int | None:
    """The number of a NodeId of the system namespace, if ``encoded`` is just that: what RegisterNodes hands out."""
    if len(encoded) == 4 and encoded.startswith(bytes((1, SYSTEM))):
        return int.from_bytes(encoded[2:], "little")
    if len(encoded) == 7 and encoded.startswith(bytes((2, SYSTEM, 0))):
        return int.from_bytes(encoded[3:], "little")
    return None
