"""The item table: the live sample of every item, in columns, already encoded for OPC UA.

A row is a small integer. Each row's record lies in the block of its type (``records``); beside it stand the DA
quality code and the number of its last change. Everything that reads samples (OPC UA, web, history) reads rows;
everything that makes samples (links) writes rows in bulk. Nothing else keeps a value.

Units:    times are OPC UA ticks (``ticks``); rows are NumPy ``int64`` arrays or plain ints.
Errors:   ``add`` raises KeyError for an ID that exists (in any case); rows that were removed must not be used.
Not here: bytes of a PLC to values (``image``), access rules (``pcaccess.gateway``).
"""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pcaccess.items.names import Names
from pcaccess.items.quality import Limit, Quality, split_code
from pcaccess.items.records import (
    ALL_KINDS,
    KINDS,
    LAYOUTS,
    MASK_ALL,
    MASK_VALUE,
    NULL_VARIANT,
    OBJECT_KIND,
)
from pcaccess.items.rowset import Places, Rows, RowSet, span
from pcaccess.items.sample import ItemValue, Sample
from pcaccess.items.ticks import from_ticks
from pcaccess.items.varianttypes import VARIANT_TYPES
from pcaccess.s7200.types import DataType, Value

Listener = Callable[[Rows], None]

_ARRAY_FLAG: Final = 0x80
_FIRST_CAPACITY: Final = 64
_TIMES: Final = struct.Struct("<qq")
_GOOD: Final = Quality.GOOD.code
_GOOD_STATUS: Final = Quality.GOOD.status()


def as_rows(rows: int | Iterable[int] | Rows) -> Rows:
    """Rows in the form the table works with."""
    if isinstance(rows, np.ndarray):
        return rows
    return np.fromiter((rows,) if isinstance(rows, int) else rows, dtype=np.int64)


def encode_variant(data_type: DataType, value: ItemValue) -> bytes:
    """An OPC UA Variant of a string or an array (``list``); used for rows without a fixed record."""
    variant = VARIANT_TYPES[data_type]
    if isinstance(value, list):
        head = struct.pack("<Bi", variant | _ARRAY_FLAG, len(value))
        return head + b"".join(_encode_plain(data_type, v) for v in value)
    return bytes((variant,)) + _encode_plain(data_type, value)


def _encode_plain(data_type: DataType, value: Value) -> bytes:
    if data_type is DataType.STRING:
        raw = str(value).encode()
        return struct.pack("<i", len(raw)) + raw
    return np.array(value, dtype=KINDS[data_type].value_format).tobytes()


class ItemTable:
    """Columns of all items. Not thread-safe: it belongs to the gateway's event loop."""

    def __init__(self, now: int) -> None:
        """``now``: ticks; the time of rows nobody has read yet."""
        self._born = now
        self._blocks: list[NDArray[Any]] = [np.zeros(0, kind.dtype) for kind in ALL_KINDS]
        self._buffers = [_bytes_of(block) for block in self._blocks]
        self._used = [0] * len(ALL_KINDS)
        self._free: list[list[int]] = [[] for _ in ALL_KINDS]
        self._objects: list[bytes] = []
        self._object_values: list[ItemValue | None] = []
        self._kind = np.zeros(0, np.uint8)
        self._place = np.zeros(0, np.int64)
        self._quality = np.zeros(0, np.uint16)
        self._changed = np.zeros(0, np.int64)
        self._types: list[DataType | None] = []
        self._counts: dict[int, int] = {}
        self._ids: list[str] = []
        self._names = Names(self.item_id)
        self._free_rows: list[int] = []
        self._listeners: list[Listener] = []
        self.counter = 0
        """Number of the last change of anything; a row's own number is in :meth:`changed`."""
        self.moves = 0
        """Grows whenever any sample may have changed, be it only its time: an answer made before is then old."""
        self.generation = 0
        """Grows whenever rows go, come, or move: whoever keeps places of records must look them up again."""
        self.removals = 0
        """Grows whenever rows go: a row number kept from before may be another item now."""

    # ------------------------------------------------------------------ rows

    def __len__(self) -> int:
        return len(self._ids) - len(self._free_rows)

    def add(self, item_id: str, data_type: DataType, count: int = 1) -> int:
        """A new row, WAITING_FOR_INITIAL_DATA until its first sample."""
        return int(self.add_many([(item_id, data_type, count)])[0])

    def add_many(self, items: Sequence[tuple[str, DataType, int]]) -> Rows:
        """A new row for each ``(ID, type, element count)``; nothing is added when one of the IDs exists."""
        names = [item_id for item_id, _, _ in items]
        self._names.check(names)
        rows = self._take_rows(len(items))
        by_kind: dict[int, list[int]] = {}
        numbers = rows.tolist()
        for (item_id, data_type, count), row in zip(items, numbers, strict=True):
            by_kind.setdefault(_kind_of(data_type, count), []).append(row)
            self._types[row], self._ids[row] = data_type, item_id
            if count != 1:
                self._counts[row] = count
        self._names.add(names, numbers)
        for kind, members in by_kind.items():
            self._place_rows(kind, np.array(members, np.int64))
        self._quality[rows] = Quality.WAITING_FOR_INITIAL_DATA.code
        self.counter += 1
        self._changed[rows] = self.counter
        self.generation += 1
        return rows

    def reserve(self, items: Iterable[tuple[DataType, int]]) -> None:
        """Make room for rows of these types and element counts, so that adding them in parts copies nothing."""
        more = Counter(_kind_of(data_type, count) for data_type, count in items)
        for kind, number in more.items():
            self._enlarge(kind, self._used[kind] + number)
        self._enlarge_rows(len(self._ids) + more.total())

    def _place_rows(self, kind: int, rows: Rows) -> None:
        places = self._take_places(kind, len(rows))
        self._kind[rows], self._place[rows] = kind, places
        block = self._blocks[kind]
        block["status"][places] = Quality.WAITING_FOR_INITIAL_DATA.status()
        block["source"][places] = block["server"][places] = self._born
        if kind == OBJECT_KIND.index:
            block["mask"][places] = MASK_ALL & ~MASK_VALUE
            for place in places.tolist():
                self._objects[place], self._object_values[place] = NULL_VARIANT, None
        else:
            block["mask"][places] = MASK_ALL
            block["type"][places] = ALL_KINDS[kind].variant_type
            block["value"][places] = 0

    def add_alias(self, name: str, row: int) -> None:
        """Another name for a row, for example its run-time name."""
        self._names.add_alias(name, row)

    def remove(self, rows: Iterable[int]) -> None:
        """Forget rows; their numbers may be given to later items."""
        gone = {int(r) for r in rows}
        for row in gone:
            kind, place = int(self._kind[row]), int(self._place[row])
            self._free[kind].append(place)
            if kind == OBJECT_KIND.index:
                self._objects[place], self._object_values[place] = NULL_VARIANT, None
            self._types[row], self._ids[row] = None, ""
            self._counts.pop(row, None)
        self._free_rows.extend(gone)
        self._names.remove(gone)
        self.generation += 1
        self.removals += 1

    def find(self, name: str) -> int | None:
        """Row of an ID or alias, without regard to case."""
        return self._names.find(name)

    def item_id(self, row: int) -> str:
        """The ID as written; empty for a removed row."""
        return self._ids[row]

    def data_type(self, row: int) -> DataType:
        data_type = self._types[row]
        if data_type is None:
            raise KeyError(f"row {row} was removed")
        return data_type

    def count(self, row: int) -> int:
        """Elements of an array row, 1 for others."""
        return self._counts.get(row, 1)

    def _take_rows(self, number: int) -> Rows:
        reused = [self._free_rows.pop() for _ in range(min(number, len(self._free_rows)))]
        first, fresh = len(self._ids), number - len(reused)
        if first + fresh > len(self._kind):
            self._enlarge_rows(_capacity(len(self._kind), first + fresh))
        self._ids.extend([""] * fresh)
        self._types.extend([None] * fresh)
        return np.array([*reused, *range(first, first + fresh)], np.int64)

    def _take_places(self, kind: int, number: int) -> NDArray[np.int64]:
        free = self._free[kind]
        reused = [free.pop() for _ in range(min(number, len(free)))]
        first, fresh = self._used[kind], number - len(reused)
        if first + fresh > len(self._blocks[kind]):
            self._enlarge(kind, _capacity(len(self._blocks[kind]), first + fresh))
        self._used[kind] += fresh
        if kind == OBJECT_KIND.index:
            self._objects.extend([NULL_VARIANT] * fresh)
            self._object_values.extend([None] * fresh)
        return np.array([*reused, *range(first, first + fresh)], np.int64)

    def _enlarge_rows(self, size: int) -> None:
        if size > len(self._kind):
            self._kind, self._place = _grown(self._kind, size), _grown(self._place, size)
            self._quality, self._changed = _grown(self._quality, size), _grown(self._changed, size)

    def _enlarge(self, kind: int, size: int) -> None:
        if size > len(self._blocks[kind]):
            self._blocks[kind] = _grown(self._blocks[kind], size)
            self._buffers[kind] = _bytes_of(self._blocks[kind])
            self.generation += 1

    # ------------------------------------------------------------------ reading

    def sample(self, row: int) -> Sample:
        """The live sample of one row."""
        kind, place = int(self._kind[row]), int(self._place[row])
        record = self._blocks[kind][place]
        quality, limit = split_code(int(self._quality[row]))
        return Sample(self._value(row, kind, place), quality, from_ticks(int(record["source"])), limit)

    def _value(self, row: int, kind: int, place: int) -> ItemValue:
        if kind == OBJECT_KIND.index:
            value = self._object_values[place]
            if value is not None:
                return value
            return "" if self.count(row) == 1 else []
        plain = self._blocks[kind][place]["value"].item()
        return bool(plain) if self._types[row] is DataType.BOOL else plain

    def quality_code(self, row: int) -> int:
        """DA code with limit bits."""
        return int(self._quality[row])

    def quality_codes(self, rows: Rows) -> NDArray[np.uint16]:
        """DA code with limit bits of each row."""
        return self._quality[rows]

    def is_not_good(self, rows: Rows) -> NDArray[np.bool_]:
        """Which rows have another quality than GOOD without limit bits."""
        bad: NDArray[np.bool_] = self._quality[rows] != Quality.GOOD.code
        return bad

    def encoded(self, row: int) -> tuple[bytes, int, int, int]:
        """Encoded variant (empty when there is no value yet), StatusCode, source and server ticks of one row."""
        kind, place = int(self._kind[row]), int(self._place[row])
        record = self._blocks[kind][place]
        if kind == OBJECT_KIND.index:
            variant = self._objects[place] if record["mask"] & MASK_VALUE else b""
        else:
            variant = bytes((record["type"],)) + record["value"].tobytes()
        return variant, int(record["status"]), int(record["source"]), int(record["server"])

    def changed(self, rows: Rows) -> NDArray[np.int64]:
        """Number of the last change of value or status of each row; compare with a remembered ``counter``."""
        return self._changed[rows]

    def source_ticks(self, rows: Rows) -> NDArray[np.int64]:
        """Source time of each row."""
        ticks = np.empty(len(rows), np.int64)
        kinds, places = self.places(rows)
        for kind in np.unique(kinds):
            ticks[kinds == kind] = self._blocks[kind]["source"][places[kinds == kind]]
        return ticks

    def places(self, rows: Rows) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
        """Kind index and place in the kind's block of each row, for readers of :meth:`block`."""
        return self._kind[rows], self._place[rows]

    def place(self, row: int) -> tuple[int, int]:
        """The same of one row."""
        return int(self._kind[row]), int(self._place[row])

    def block(self, kind: int) -> NDArray[Any]:
        """Records of one kind; replaced by a larger array when ``generation`` grows."""
        return self._blocks[kind]

    def buffer(self, kind: int) -> memoryview:
        """The bytes of :meth:`block`."""
        return self._buffers[kind]

    def object_variant(self, place: int) -> bytes:
        """Encoded variant of a string or array at ``place`` of the object block."""
        return self._objects[place]

    # ------------------------------------------------------------------ writing

    def listen(self, listener: Listener) -> Callable[[], None]:
        """Call ``listener`` with the rows whose value or status changed; returns what ends that."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def put_numbers(self, data_type: DataType, rows: Rows, values: NDArray[Any], now: int) -> None:
        """Good samples of single values of one type, in bulk.

        ``values`` has the type's NumPy format; ``rows`` are all of ``data_type``.
        """
        if not len(rows):
            return
        kind = KINDS[data_type].index
        places = span(self._place[rows])
        block = self._blocks[kind]
        differs = block["value"][places] != values
        if data_type is DataType.REAL:  # NaN is not equal to itself, and must not report for ever
            differs &= ~(np.isnan(values) & np.isnan(block["value"][places]))
        block["value"][places] = values
        self._finish(rows, differs, places, block, now)

    def put_number(self, row: int, value: float, now: int) -> None:
        """A good sample of one single value, many times faster than an array of one."""
        self.moves += 1
        kind = int(self._kind[row])
        layout, buffer = LAYOUTS[kind], self._buffers[kind]
        at = int(self._place[row]) * layout.size
        mask, variant_type, before, *_ = layout.unpack_from(buffer, at)
        layout.pack_into(buffer, at, mask, variant_type, value, _GOOD_STATUS, now, now)
        after = layout.unpack_from(buffer, at)[2]  # a REAL is rounded on the way
        same = before == after or (before != before and after != after)
        if not same or self._quality[row] != _GOOD:
            self._quality[row] = _GOOD
            self._report(as_rows(row))

    def put_object(self, row: int, value: ItemValue, now: int) -> None:
        """A good sample of a string or an array."""
        place = int(self._place[row])
        block = self._blocks[OBJECT_KIND.index]
        differs = not _same(self._object_values[place], value)
        if differs:
            self._objects[place] = encode_variant(self.data_type(row), value)
            self._object_values[place] = value
            block["mask"][place] = MASK_ALL
        self._finish(as_rows(row), np.array([differs]), as_rows(place), block, now)

    def put(self, row: int, value: ItemValue, now: int) -> None:
        """A good sample of any row; ``value`` must fit its type."""
        if self._kind[row] == OBJECT_KIND.index:
            self.put_object(row, value, now)
        else:
            self.put_number(row, value, now)  # type: ignore[arg-type]

    def _finish(self, rows: Rows, differs: NDArray[np.bool_], places: Places, block: NDArray[Any], now: int) -> None:
        self.moves += 1
        block["source"][places] = now
        block["server"][places] = now
        differs = differs | (self._quality[rows] != Quality.GOOD.code)
        if differs.any():
            changed = rows[differs]
            block["status"][self._place[changed]] = Quality.GOOD.status()
            self._quality[changed] = Quality.GOOD.code
            self._report(changed)

    def stamp(self, rows: Rows | RowSet, now: int) -> None:
        """The PLC was read and nothing changed: only the times of these rows move."""
        self.moves += 1
        members = rows if isinstance(rows, RowSet) else RowSet(rows)
        for kind, places in members.placed(self):
            self._blocks[kind]["source"][places] = now
            self._blocks[kind]["server"][places] = now

    def stamp_one(self, row: int, now: int) -> None:
        """The same for one single value."""
        self.moves += 1
        kind = int(self._kind[row])
        size = LAYOUTS[kind].size
        _TIMES.pack_into(self._buffers[kind], (int(self._place[row]) + 1) * size - _TIMES.size, now, now)

    def set_quality(self, rows: Rows, quality: Quality, now: int, limit: Limit = Limit.NONE) -> None:
        """Set a quality; value and source time stay, only the server time moves."""
        self.moves += 1
        code, status = quality.code | limit, quality.status(limit)
        for kind, members in self._by_kind(rows):
            places = self._place[members]
            self._blocks[kind]["server"][places] = now
            self._blocks[kind]["status"][places] = status
        changed = rows[self._quality[rows] != code]
        if len(changed):
            self._quality[changed] = code
            self._report(changed)

    def _report(self, rows: Rows) -> None:
        self.counter += 1
        self._changed[rows] = self.counter
        for listener in tuple(self._listeners):
            listener(rows)

    def _by_kind(self, rows: Rows) -> Iterator[tuple[int, Rows]]:
        """``(kind, rows of that kind)``, together all of ``rows``."""
        if not len(rows):
            return
        kinds = self._kind[rows]
        first = int(kinds[0])
        if (kinds == first).all():
            yield first, rows
            return
        for kind in np.unique(kinds):
            yield int(kind), rows[kinds == kind]

    def spans(self, rows: Rows) -> list[tuple[int, Places]]:
        """Kind and places of ``rows``, as :class:`RowSet` keeps them."""
        return [(kind, span(self._place[members])) for kind, members in self._by_kind(rows)]


def _kind_of(data_type: DataType, count: int) -> int:
    fixed = count == 1 and data_type is not DataType.STRING
    return KINDS[data_type].index if fixed else OBJECT_KIND.index


def _same(a: ItemValue | None, b: ItemValue) -> bool:
    """Equal, where NaN is equal to itself, so that it does not report for ever."""
    if a == b or not isinstance(a, list) or not isinstance(b, list):
        return a == b
    return len(a) == len(b) and all(x == y or (x != x and y != y) for x, y in zip(a, b, strict=True))


def _bytes_of(block: NDArray[Any]) -> memoryview:
    return block.view(np.uint8).data


def _capacity(now: int, needed: int) -> int:
    """Rows to make room for: an eighth more than there are, so that growing seldom copies and little is unused."""
    return max(_FIRST_CAPACITY, now + now // 8, needed)


def _grown(column: NDArray[Any], size: int) -> NDArray[Any]:
    larger = np.zeros(size, column.dtype)
    larger[: len(column)] = column
    return larger
