"""A PLC's memory image to samples: changed bytes are found and decoded in bulk.

The image is the flat buffer of ``pcaccess.s7200.memory``. Rows are columns, grouped by raw type; an update compares the
new bytes with the old, finds by one prefix sum the rows any of whose bytes changed, and decodes only those. An update
of a few bytes, as one written value is, goes to its rows directly.

Units:    offsets in bytes of the flat buffer; times in ticks.
"""

from __future__ import annotations

import struct
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pcaccess.items.quality import Quality
from pcaccess.items.records import KINDS
from pcaccess.items.rowset import Rows, RowSet
from pcaccess.items.table import ItemTable, as_rows
from pcaccess.s7200.types import DataType, Value


@dataclass(frozen=True, slots=True)
class Linear:
    """Raw to scaled values: ``raw_low..raw_high`` becomes ``low..high``, optionally clamped there."""

    raw_low: float
    raw_high: float
    low: float
    high: float
    clamp: bool = False

    def coefficients(self) -> tuple[float, float, float, float]:
        """``(factor, offset, lowest, highest)``: scaled = raw * factor + offset, then kept within the bounds."""
        factor = (self.high - self.low) / (self.raw_high - self.raw_low)
        bounds = sorted((self.low, self.high)) if self.clamp else (-np.inf, np.inf)
        return factor, self.low - self.raw_low * factor, bounds[0], bounds[1]

    def scaled(self, raw: NDArray[Any]) -> NDArray[np.float32]:
        factor, offset, low, high = self.coefficients()
        return np.clip(raw * factor + offset, low, high).astype(np.float32)

    def raw(self, value: float) -> float:
        """The raw value of a scaled one, not rounded; a clamped scaling takes only what lies within it."""
        if self.clamp:
            value = min(max(value, min(self.low, self.high)), max(self.low, self.high))
        factor = (self.raw_high - self.raw_low) / (self.high - self.low)
        return (value - self.low) * factor + self.raw_low


@dataclass(frozen=True, slots=True)
class Field:
    """Where one row's value lies in the image and how it is read."""

    row: int
    offset: int
    bit: int
    raw_type: DataType
    count: int = 1
    length: int = 254
    linear: Linear | None = None

    @property
    def size(self) -> int:
        """Bytes of the image this value covers."""
        if self.raw_type is DataType.BOOL:
            return (self.bit + self.count + 7) // 8
        if self.raw_type is DataType.STRING:
            return (1 + self.length) * self.count
        return self.raw_type.size * self.count

    def reaches(self, start: int, end: int) -> bool:
        """Whether it has a byte in ``start..end``."""
        return self.offset < end and start < self.offset + self.size


_EMPTY: Final = np.zeros(0, np.int64)
_GOOD: Final = Quality.GOOD.code
FEW_BYTES: Final = 16
FEW_ROWS: Final = 12
"""Up to so much is done row by row: arrays cost more to set up than they save."""


class _Group:
    """Single values of one raw type, all scaled or all not, as columns in the order of their offsets."""

    def __init__(self, raw_type: DataType, scaled: bool) -> None:
        self.raw_type = raw_type
        self.served_type = DataType.REAL if scaled else raw_type
        self.size = raw_type.size
        self.rows: Rows = _EMPTY
        self.offsets: NDArray[np.int64] = _EMPTY
        self.members = RowSet(_EMPTY)
        self._starts: array[int] = array("q")
        self._bits = np.zeros(0, np.uint8)
        self._scaling: NDArray[np.float64] | None = np.zeros((0, 4)) if scaled else None
        self._one = struct.Struct(raw_type.struct_format or ">B")

    def add(self, fields: list[Field]) -> None:
        rows = np.concatenate((self.rows, np.array([f.row for f in fields], np.int64)))
        offsets = np.concatenate((self.offsets, np.array([f.offset for f in fields], np.int64)))
        bits = np.concatenate((self._bits, np.array([f.bit for f in fields], np.uint8)))
        scaling = self._scaling
        if scaling is not None:
            scaling = np.concatenate((scaling, [f.linear.coefficients() for f in fields if f.linear is not None]))
        order = np.argsort(offsets, kind="stable")
        self._take(rows[order], offsets[order], bits[order], scaling if scaling is None else scaling[order])

    def remove(self, gone: Rows) -> None:
        stays = ~np.isin(self.rows, gone)
        if not stays.all():
            scaling = self._scaling
            scaling = scaling if scaling is None else scaling[stays]
            self._take(self.rows[stays], self.offsets[stays], self._bits[stays], scaling)

    def _take(
        self, rows: Rows, offsets: NDArray[np.int64], bits: NDArray[np.uint8], scaling: NDArray[np.float64] | None
    ) -> None:
        self.rows, self._bits, self._scaling = rows, bits, scaling
        self._starts = array("q", offsets.tobytes())
        self.offsets = np.frombuffer(self._starts, np.int64)
        self.members = RowSet(rows)

    def touching(self, start: int, end: int) -> range:
        """Which of the rows have a byte in ``start..end``."""
        first = bisect_right(self._starts, start - self.size)
        return range(first, bisect_left(self._starts, end, first))

    def decode(self, image: NDArray[np.uint8], which: NDArray[np.intp]) -> NDArray[Any]:
        offsets = self.offsets[which]
        if self.raw_type is DataType.BOOL:
            bits: NDArray[Any] = (image[offsets] >> self._bits[which]) & 1
            return bits
        raw = image[offsets[:, None] + np.arange(self.size)].view(self.raw_type.struct_format)[:, 0]
        if self._scaling is not None:
            factor, offset, low, high = self._scaling[which].T
            scaled: NDArray[Any] = np.clip(raw * factor + offset, low, high).astype(np.float32)
            return scaled
        native: NDArray[Any] = raw.astype(KINDS[self.raw_type].value_format)
        return native

    def decode_one(self, image: memoryview, n: int) -> float:
        """The same for one row."""
        raw: float = self._one.unpack_from(image, self._starts[n])[0]
        if self.raw_type is DataType.BOOL:
            return int(raw) >> int(self._bits[n]) & 1
        if self._scaling is None:
            return raw
        factor, offset, low, high = self._scaling[n].tolist()
        return min(max(raw * factor + offset, low), high)  # type: ignore[no-any-return]


class PlcImage:
    """The image of one PLC as the gateway last saw it, and the rows that show it."""

    def __init__(self, table: ItemTable, size: int) -> None:
        self._table = table
        self._image = np.zeros(size, np.uint8)
        self._bytes = self._image.data
        self._known: NDArray[np.bool_] | None = np.zeros(size, np.bool_)
        """Bytes that were seen; None once all were."""
        self._groups: dict[tuple[DataType, bool], _Group] = {}
        self._objects: list[Field] = []
        self._silent: set[int] = set()
        self._silent_told = True
        self._members: RowSet | None = None

    @property
    def rows(self) -> Rows:
        """All rows that the PLC's memory shows."""
        return self._row_set().rows

    def _row_set(self) -> RowSet:
        if self._members is None:
            rows = [group.rows for group in self._groups.values()]
            rows.append(as_rows(field.row for field in self._objects))
            self._members = RowSet(np.concatenate(rows))
        return self._members

    def add(self, fields: Iterable[Field], *, out_of_service: Iterable[int] = ()) -> None:
        """More rows. Rows ``out_of_service`` have an address but no one who keeps it true."""
        silent = set(out_of_service)
        by_kind: dict[tuple[DataType, bool], list[Field]] = {}
        for field in fields:
            if field.row in silent:
                continue
            if field.count != 1 or field.raw_type is DataType.STRING:
                self._objects.append(field)
            else:
                by_kind.setdefault((field.raw_type, field.linear is not None), []).append(field)
        for kind, members in by_kind.items():
            self._groups.setdefault(kind, _Group(*kind)).add(members)
        self._objects.sort(key=lambda field: field.offset)
        self._silent |= silent
        self._silent_told = self._silent_told and not silent
        self._members = None

    def remove(self, rows: Iterable[int]) -> None:
        gone = set(rows)
        for group in self._groups.values():
            group.remove(as_rows(gone))
        self._objects = [field for field in self._objects if field.row not in gone]
        self._silent -= gone
        self._members = None

    # ------------------------------------------------------------------ samples

    def update(self, data: bytes | bytearray | memoryview, now: int, start: int = 0) -> None:
        """The PLC was read at ``now``: ``data`` stands at ``start`` of the image.

        Rows wholly inside are as new as ``now``; rows that only reach in are decoded again if a byte of theirs
        changed, once all of their bytes have been seen.
        """
        if not self._silent_told:
            self._silent_told = True
            self._table.set_quality(as_rows(self._silent), Quality.OUT_OF_SERVICE, now)
        if len(data) > FEW_BYTES or self._known is not None or not self._update_few(bytes(data), now, start):
            self._update_many(np.frombuffer(data, np.uint8), now, start)

    def _update_few(self, new: bytes, now: int, start: int) -> bool:
        end = start + len(new)
        touched = [(group, which) for group in self._groups.values() if (which := group.touching(start, end))]
        if sum(len(which) for _, which in touched) > FEW_ROWS or any(f.reaches(start, end) for f in self._objects):
            return False
        old = bytes(self._bytes[start:end])
        self._bytes[start:end] = new
        table = self._table
        for group, which in touched:
            for n in which:
                row, at = int(group.rows[n]), group.offsets[n] - start
                first, last = max(at, 0), at + group.size
                if old[first:last] != new[first:last] or table.quality_code(row) != _GOOD:
                    table.put_number(row, group.decode_one(self._bytes, n), now)
                elif first == at and last <= len(new):
                    table.stamp_one(row, now)
        return True

    def _update_many(self, new: NDArray[np.uint8], now: int, start: int) -> None:
        end = start + len(new)
        differs = np.zeros(len(self._image), np.bool_)
        differs[start:end] = self._image[start:end] != new
        self._image[start:end] = new
        unknown = None
        if self._known is not None:
            differs[start:end] |= ~self._known[start:end]
            self._known[start:end] = True
            if self._known.all():
                self._known = None
            else:
                unknown = np.concatenate(([0], np.cumsum(~self._known)))
        running = np.concatenate(([0], np.cumsum(differs)))
        for group in self._groups.values():
            self._update_group(group, running, unknown, start, end, now)
        for field in self._objects:
            first, last = field.offset, field.offset + field.size
            if not field.reaches(start, end) or (unknown is not None and unknown[last] > unknown[first]):
                continue
            if running[last] > running[first] or self._table.quality_code(field.row) != _GOOD:
                self._table.put_object(field.row, self._decode_object(field), now)
            elif start <= first and last <= end:
                self._table.stamp(as_rows(field.row), now)

    def _update_group(
        self,
        group: _Group,
        running: NDArray[np.int64],
        unknown: NDArray[np.int64] | None,
        start: int,
        end: int,
        now: int,
    ) -> None:
        touched = group.touching(start, end)
        if not touched:
            return
        first, last = touched.start, touched.stop
        at, rows = group.offsets[first:last], group.rows[first:last]
        dirty = (running[at + group.size] > running[at]) | self._table.is_not_good(rows)
        inside = (at >= start) & (at + group.size <= end)
        if unknown is not None:
            dirty &= unknown[at + group.size] == unknown[at]
        if inside.all():
            self._table.stamp(group.members if len(rows) == len(group.rows) else rows, now)
        else:
            self._table.stamp(rows[inside], now)
        which = np.flatnonzero(dirty)
        if len(which):
            which += first
            self._table.put_numbers(group.served_type, group.rows[which], group.decode(self._image, which), now)

    def repeat(self, now: int) -> None:
        """The PLC still holds what it held; rows that came since get their values."""
        known = self._known
        if known is None:
            self._update_many(self._image.copy(), now, 0)
            return
        edges = np.flatnonzero(np.diff(known, prepend=False, append=False))
        for start, end in edges.reshape(-1, 2).tolist():
            self._update_many(self._image[start:end].copy(), now, start)

    def stamp(self, now: int) -> None:
        """The PLC's memory is known to be what it was: all its rows are as new as ``now``."""
        self._table.stamp(self._row_set(), now)

    def lost(self, quality: Quality, now: int) -> None:
        """The PLC does not answer: every row keeps value and time and takes ``quality``."""
        self._table.set_quality(np.concatenate((self.rows, as_rows(self._silent))), quality, now)
        self._silent_told = not self._silent

    def _decode_object(self, field: Field) -> Value | list[Value]:
        image = self._image
        if field.raw_type is DataType.STRING and field.count == 1:
            return field.raw_type.decode(image[field.offset : field.offset + field.size].tobytes())
        if field.raw_type is DataType.BOOL:
            bits = field.bit + np.arange(field.count)
            return [bool(v) for v in (image[field.offset + bits // 8] >> (bits % 8)) & 1]
        data = image[field.offset : field.offset + field.size].tobytes()
        if field.raw_type is DataType.STRING:
            step = 1 + field.length
            return [field.raw_type.decode(data[i * step : (i + 1) * step]) for i in range(field.count)]
        raw = np.frombuffer(data, field.raw_type.struct_format)
        values: list[Value] = (field.linear.scaled(raw) if field.linear else raw).tolist()
        return values
