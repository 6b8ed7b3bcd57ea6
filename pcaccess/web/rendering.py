"""Rows of the item table, written in one format, in the order somebody asked for, again and again.

A rendering looks the rows up once. IDs never change and are kept as bytes; of values and qualities only those are
written anew that changed since the last time; times, which move at every read, are one and the same for most rows.

Errors:   a rendering is good for one ``ItemTable.generation``; whoever keeps one compares that first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pcaccess.items.quality import Quality
from pcaccess.items.records import KINDS, OBJECT_KIND
from pcaccess.items.rowset import Rows
from pcaccess.items.sample import Sample
from pcaccess.items.table import ItemTable, as_rows
from pcaccess.items.ticks import to_ticks
from pcaccess.s7200.types import DataType
from pcaccess.web.formats import Format, Ticks, all_equal, numbers, value_text

TYPES_OF_KINDS: Final = tuple(KINDS)
"""Data type of each kind of record that has a fixed size."""
_NOTHING_YET: Final = -1


@dataclass(frozen=True, slots=True)
class _Part:
    """Rows whose records are of one kind, and so lie in one block of the table."""

    kind: int
    at: NDArray[np.int64]
    """Where they stand in the order asked for."""
    rows: Rows
    places: NDArray[np.int64]


class Rendering:
    """The samples of some rows in one format."""

    def __init__(self, form: Format, table: ItemTable, rows: Sequence[int]) -> None:
        self.generation = table.generation
        self._form = form
        self._table = table
        self._types = [table.data_type(row) for row in rows]
        self._heads = [form.head(table.item_id(row)) for row in rows]
        self._tails: dict[tuple[DataType, int], bytes] = {}
        self._bodies = [b""] * len(rows)
        """Entries without their times."""
        self._seen = _NOTHING_YET
        self._instead: Quality | None = None
        listed = as_rows(rows)
        kinds, places = table.places(listed)
        self._parts = []
        for kind in np.unique(kinds).tolist():
            at = np.flatnonzero(kinds == kind)
            self._parts.append(_Part(kind, at, listed[at], places[at]))

    def entries(self, instead: Quality | None = None) -> list[bytes]:
        """Each sample. ``instead``: the quality that all of them have instead of their own."""
        self._refresh(instead)
        times = self._form.times(self._ticks())
        return [body + time for body, time in zip(self._bodies, times, strict=True)]

    def joined(self, instead: Quality | None = None) -> bytes:
        """All samples with the format's separator between them."""
        if not self._bodies:
            return b""
        self._refresh(instead)
        separator = self._form.separator
        ticks = self._ticks()
        if all_equal(ticks):
            time = self._form.times(ticks[:1])[0]
            return (time + separator).join(self._bodies) + time
        pieces = [separator] * (3 * len(self._bodies))
        pieces[0::3] = self._bodies
        pieces[1::3] = self._form.times(ticks)
        pieces.pop()
        return b"".join(pieces)

    def _ticks(self) -> Ticks:
        """Source time of each entry."""
        ticks = np.empty(len(self._bodies), np.int64)
        for part in self._parts:
            ticks[part.at] = self._table.block(part.kind)["source"][part.places]
        return ticks

    def _refresh(self, instead: Quality | None) -> None:
        """Write what changed since the last time."""
        if instead is not self._instead:
            self._instead, self._seen = instead, _NOTHING_YET
        counter = self._table.counter
        if self._seen == counter:
            return
        for part in self._parts:
            which = self._table.changed(part.rows) > self._seen
            number = np.count_nonzero(which)
            if number == len(which):
                self._write(part.kind, part.at, part.rows, part.places)
            elif number:
                self._write(part.kind, part.at[which], part.rows[which], part.places[which])
        self._seen = counter

    def _write(self, kind: int, at: NDArray[np.int64], rows: Rows, places: NDArray[np.int64]) -> None:
        table, heads, bodies = self._table, self._heads, self._bodies
        codes = table.quality_codes(rows).tolist() if self._instead is None else [self._instead.code] * len(rows)
        if kind == OBJECT_KIND.index:
            for n, row, code in zip(at.tolist(), rows.tolist(), codes, strict=True):
                value = self._form.text(self._types[n], table.sample(row).value)
                bodies[n] = heads[n] + value + self._tail(self._types[n], code)
            return
        data_type = TYPES_OF_KINDS[kind]
        values = numbers(self._form, data_type, table.block(kind)["value"][places])
        tails = {code: self._tail(data_type, code) for code in set(codes)}
        for n, number, code in zip(at.tolist(), values, codes, strict=True):
            bodies[n] = heads[n] + number + tails[code]

    def _tail(self, data_type: DataType, code: int) -> bytes:
        tail = self._tails.get((data_type, code))
        if tail is None:
            tail = self._tails[data_type, code] = self._form.tail(data_type, code)
        return tail


def sample_entry(form: Format, item_id: str, data_type: DataType, sample: Sample) -> bytes:
    """One sample that does not come from the table, for example one that a dead band holds back."""
    time = form.times(np.array([to_ticks(sample.time)], np.int64))[0]
    value = value_text(form, data_type, sample.value)
    return form.head(item_id) + value + form.tail(data_type, sample.code) + time
