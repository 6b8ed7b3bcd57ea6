"""A PLC's memory image to samples: changed bytes are found and decoded in bulk.

The image is the flat buffer of ``pcaccess.s7200.memory``. Rows are grouped by raw type; an update compares the new
bytes with the old, finds by one prefix sum the rows any of whose bytes changed, and decodes only those.

Units:    offsets in bytes of the flat buffer; times in ticks.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pcaccess.items.quality import Quality
from pcaccess.items.records import KINDS
from pcaccess.items.table import ItemTable, Rows, as_rows
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


class _Group:
    """Single values of one raw type, all scaled or all not, as columns."""

    def __init__(self, raw_type: DataType, fields: list[Field]) -> None:
        self.raw_type = raw_type
        fields.sort(key=lambda f: f.offset)
        self.rows = np.array([f.row for f in fields], np.int64)
        self.offsets = np.array([f.offset for f in fields], np.int64)
        self._bits = np.array([f.bit for f in fields], np.uint8)
        self._columns = self.offsets[:, None] + np.arange(raw_type.size)
        linears = [f.linear for f in fields if f.linear is not None]
        self._scaling = np.array([line.coefficients() for line in linears]) if linears else None

    def decode(self, image: NDArray[np.uint8], which: NDArray[np.intp]) -> NDArray[Any]:
        if self.raw_type is DataType.BOOL:
            bits: NDArray[Any] = (image[self.offsets[which]] >> self._bits[which]) & 1
            return bits
        raw = image[self._columns[which]].view(self.raw_type.struct_format)[:, 0]
        if self._scaling is not None:
            factor, offset, low, high = self._scaling[which].T
            scaled: NDArray[Any] = np.clip(raw * factor + offset, low, high).astype(np.float32)
            return scaled
        native: NDArray[Any] = raw.astype(KINDS[self.raw_type].value_format)
        return native

    @property
    def served_type(self) -> DataType:
        return self.raw_type if self._scaling is None else DataType.REAL


_EMPTY: Final = np.zeros(0, np.int64)


class PlcImage:
    """The image of one PLC as the gateway last saw it, and the rows that show it."""

    def __init__(self, table: ItemTable, size: int) -> None:
        self._table = table
        self._image = np.zeros(size, np.uint8)
        self._known = np.zeros(size, np.bool_)
        self._fields: dict[int, Field] = {}
        self._groups: list[_Group] | None = None
        self._objects: list[Field] = []
        self._rows: Rows = _EMPTY
        self._out_of_service: frozenset[int] = frozenset()

    @property
    def rows(self) -> Rows:
        """All rows of this PLC."""
        self._arrange()
        return self._rows

    def field(self, row: int) -> Field:
        return self._fields[row]

    def add(self, fields: Iterable[Field], *, out_of_service: Iterable[int] = ()) -> None:
        """More rows. Rows ``out_of_service`` have an address but no one who keeps it true."""
        for field in fields:
            self._fields[field.row] = field
        self._out_of_service |= frozenset(out_of_service)
        self._groups = None

    def remove(self, rows: Iterable[int]) -> None:
        gone = set(rows)
        for row in gone:
            self._fields.pop(row, None)
        self._out_of_service -= gone
        self._groups = None

    def _arrange(self) -> list[_Group]:
        if self._groups is None:
            by_kind: dict[tuple[DataType, bool], list[Field]] = {}
            self._objects = []
            for field in self._fields.values():
                if field.row in self._out_of_service:
                    continue
                if field.count != 1 or field.raw_type is DataType.STRING:
                    self._objects.append(field)
                else:
                    by_kind.setdefault((field.raw_type, field.linear is None), []).append(field)
            self._groups = [_Group(raw_type, fields) for (raw_type, _), fields in by_kind.items()]
            self._rows = as_rows(row for row in self._fields if row not in self._out_of_service)
        return self._groups

    def update(self, data: bytes | bytearray | memoryview, now: int, start: int = 0) -> None:
        """The PLC was read at ``now``: ``data`` stands at ``start`` of the image.

        Rows wholly inside are as new as ``now``; rows that only reach in are decoded again if a byte of theirs
        changed, once all of their bytes have been seen.
        """
        new = np.frombuffer(data, np.uint8)
        end = start + len(new)
        differs = np.zeros(len(self._image), np.bool_)
        differs[start:end] = (self._image[start:end] != new) | ~self._known[start:end]
        self._image[start:end] = new
        self._known[start:end] = True
        running = np.concatenate(([0], np.cumsum(differs)))
        unknown = None if self._known.all() else np.concatenate(([0], np.cumsum(~self._known)))
        for group in self._arrange():
            self._update_group(group, running, unknown, start, end, now)
        for field in self._objects:
            first, last = field.offset, field.offset + field.size
            if last <= start or first >= end or (unknown is not None and unknown[last] > unknown[first]):
                continue
            if running[last] > running[first] or self._stale(field):
                self._table.put_object(field.row, self._decode_object(field), now)
            elif start <= first and last <= end:
                self._table.stamp(as_rows(field.row), now)
        if self._out_of_service:
            self._table.set_quality(as_rows(self._out_of_service), Quality.OUT_OF_SERVICE, now)

    def repeat(self, now: int) -> None:
        """The PLC still holds what it held; rows that came since get their values."""
        self.update(self._image.tobytes(), now)

    def _update_group(
        self,
        group: _Group,
        running: NDArray[np.int64],
        unknown: NDArray[np.int64] | None,
        start: int,
        end: int,
        now: int,
    ) -> None:
        size = group.raw_type.size
        first = int(np.searchsorted(group.offsets, start - size, "right"))
        last = int(np.searchsorted(group.offsets, end, "left"))
        if first >= last:
            return
        at, rows = group.offsets[first:last], group.rows[first:last]
        dirty = (running[at + size] > running[at]) | self._table.is_not_good(rows)
        inside = (at >= start) & (at + size <= end)
        if unknown is not None:
            dirty &= unknown[at + size] == unknown[at]
        self._table.stamp(rows if inside.all() else rows[inside], now)
        which = np.flatnonzero(dirty)
        if len(which):
            which += first
            self._table.put_numbers(group.served_type, group.rows[which], group.decode(self._image, which), now)

    def _stale(self, field: Field) -> bool:
        return bool(self._table.is_not_good(as_rows(field.row))[0])

    def lost(self, quality: Quality, now: int) -> None:
        """The PLC does not answer: every row keeps value and time and takes ``quality``."""
        rows = as_rows(self._fields)
        self._table.set_quality(rows, quality, now)

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
