"""Lists of items that websocket clients watch: what changed since a client was last told, as one message in columns.

Clients that watch the same list share its watch, and whoever asks at the same moment for the same span of changes gets
the same bytes. Columns, because thousands of changes are then written in a handful of calls; a column whose entries are
all equal is written once. A client that is slow, or asks seldom, is told the latest change of each item.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np
import orjson
from numpy.typing import NDArray

from pcaccess.gateway.gateway import Gateway
from pcaccess.items.records import OBJECT_KIND
from pcaccess.project.model import Access
from pcaccess.web.formats import JSON, Ticks, all_equal, iso_time, iso_times, json_numbers
from pcaccess.web.rendering import TYPES_OF_KINDS

_PLAIN_QUALITY: Final = 0xFC
"""A DA code without its limit bits."""


@dataclass(frozen=True, slots=True)
class Told:
    """Up to where a client knows: changes of samples, and which items there are."""

    counter: int = -1
    version: int = -1


@dataclass(frozen=True, slots=True)
class _Part:
    """Watched rows whose records are of one kind: a piece of the watch's columns."""

    kind: int
    start: int
    end: int


class Watch:
    """A list of items. ``n`` of an item is its place in the list."""

    def __init__(self, gateway: Gateway, item_ids: Sequence[str]) -> None:
        self._gateway = gateway
        self._ids = tuple(item_ids)
        self._rows: list[int | None] = [None] * len(self._ids)
        self._versions = np.zeros(len(self._ids), np.int64)
        self._gone: dict[int, int] = {}
        """Place of an item that is no more, and the version since when."""
        self._version = 0
        # Columns of what can be watched, those of one kind of record side by side.
        self._parts: list[_Part] = []
        self._at = self._watched = self._places = self._came = np.zeros(0, np.int64)
        self._at_json = b""
        self._generation = -1
        self._last: tuple[Told, Told, bytes] | None = None
        self._arrange()
        self._gone.clear()

    def __len__(self) -> int:
        return len(self._ids)

    @property
    def rows(self) -> list[int]:
        """Rows it watches."""
        return [row for row in self._rows if row is not None]

    def described(self) -> list[dict[str, Any]]:
        """What a client needs to know of each item, in the order of ``n``."""
        return [self._describe(n) for n in range(len(self._ids))]

    def _describe(self, n: int) -> dict[str, Any]:
        row = self._rows[n]
        if row is None:
            why = "unknown-item" if self._gateway.find(self._ids[n]) is None else "not-readable"
            return {"n": n, "id": self._ids[n], "problem": why}
        item = self._gateway.item(row)
        more = {"low": item.low, "high": item.high, "unit": item.unit, "access": str(item.access)}
        return {"n": n, "id": item.item_id, "type": item.data_type.name, **more}

    # ------------------------------------------------------------------ which rows

    def _arrange(self) -> None:
        """Look the rows up again after items came or went."""
        gateway, table, before = self._gateway, self._gateway.table, self._rows
        self._rows = [self._find(item_id) for item_id in self._ids]
        self._generation = table.generation
        differing = [n for n, row in enumerate(self._rows) if row != before[n]]
        if differing:
            self._version += 1
            self._versions[differing] = self._version
        for n in differing:
            if self._rows[n] is None:
                self._gone[n] = self._version
            else:
                self._gone.pop(n, None)
        at = np.array([n for n, row in enumerate(self._rows) if row is not None], np.int64)
        kinds, _ = table.places(np.array(self.rows, np.int64))
        self._at = at[np.argsort(kinds, kind="stable")]
        self._at_json = _numbers(self._at)
        self._watched = np.array([self._rows[n] for n in self._at.tolist()], np.int64)
        self._came = self._versions[self._at]
        kinds, self._places = table.places(self._watched)
        edges = [0, *(np.flatnonzero(np.diff(kinds)) + 1).tolist(), len(kinds)]
        self._parts = [_Part(int(kinds[a]), a, b) for a, b in pairwise(edges) if a < b]
        gateway.freshen(self.rows)

    def _find(self, item_id: str) -> int | None:
        row = self._gateway.find(item_id)
        return row if row is not None and self._gateway.item(row).access & Access.R else None

    # ------------------------------------------------------------------ what changed

    def changes(self, told: Told) -> tuple[Told, bytes | None]:
        """Up to where the client knows then, and the members of its message; None when nothing changed."""
        table = self._gateway.table
        if table.generation != self._generation:
            self._arrange()
        now = Told(table.counter, self._version)
        if told == now:
            return now, None
        if self._last is None or self._last[:2] != (told, now):
            self._last = (told, now, self._write(told))
        return now, self._last[2] or None

    def _write(self, told: Told) -> bytes:
        """The members of a message; nothing when there is nothing to tell."""
        gone = [n for n, version in self._gone.items() if version > told.version] if self._gone else []
        head = b'"gone":' + orjson.dumps(gone) + b"," if gone else b""
        which = self._which(told)
        if which is not None and not which.any():
            return head[:-1]
        at, codes = self._at_json, self._gateway.table.quality_codes(self._watched)
        if which is not None:
            at, codes = _numbers(self._at[which]), codes[which]
        values, ticks = self._columns(which)
        quality = b"%d" % (codes[0] & _PLAIN_QUALITY) if all_equal(codes) else _numbers(codes & _PLAIN_QUALITY)
        return b"".join(
            (head, b'"n":', at, b',"value":[', values, b'],"quality":', quality, b',"time":', _times(ticks))
        )

    def _which(self, told: Told) -> NDArray[np.bool_] | None:
        """What a client does not know yet; None is everything."""
        changed = self._gateway.table.changed(self._watched)
        if len(changed) and np.minimum.reduce(changed) > told.counter:
            return None
        which: NDArray[np.bool_] = changed > told.counter
        if self._version > told.version:
            which |= self._came > told.version
        return which

    def _columns(self, which: NDArray[np.bool_] | None) -> tuple[bytes, list[Ticks]]:
        """Values and source times of the rows chosen, the times in pieces; None chooses all."""
        table = self._gateway.table
        values, ticks = [], []
        for part in self._parts:
            piece = slice(part.start, part.end)
            rows, places = self._watched[piece], self._places[piece]
            if which is not None:
                rows, places = rows[which[piece]], places[which[piece]]
                if not len(rows):
                    continue
            block = table.block(part.kind)
            ticks.append(block["source"].take(places))
            if part.kind == OBJECT_KIND.index:
                values += [JSON.text(table.data_type(row), table.sample(row).value) for row in rows.tolist()]
            else:
                values.append(json_numbers(TYPES_OF_KINDS[part.kind], block["value"].take(places)))
        return b",".join(values), ticks


def _numbers(column: NDArray[Any]) -> bytes:
    return orjson.dumps(column, option=orjson.OPT_SERIALIZE_NUMPY)


def _times(pieces: Sequence[Ticks]) -> bytes:
    """One time when all are equal, else a list."""
    first = pieces[0][:1]
    if all(all_equal(piece, first) for piece in pieces):
        return f'"{iso_time(int(first[0]))}"'.encode()
    return b'["' + b'","'.join(iso_times(np.concatenate(pieces))) + b'"]'
