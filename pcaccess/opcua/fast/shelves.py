"""Rows of many encoded NodeIds at once: one shelf for each length, sorted by a hash of the bytes.

What is found is compared byte for byte, so a hash that two names share costs time and nothing else.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pcaccess.opcua.fast.columns import Positions, windows

MISSING: Final = -3
"""Not on a shelf."""

_FACTOR: Final = np.uint64(0x9E3779B97F4A7C15)
_HALF: Final = np.uint64(32)


class Shelves:
    """NodeIds and their rows."""

    def __init__(self, most: int, longest: int) -> None:
        """``most``: NodeIds that are kept, one more and all are forgotten; ``longest``: bytes of one."""
        self._most = most
        self._longest = longest
        self._shelves: dict[int, _Shelf] = {}
        self._kept = 0

    def clear(self) -> None:
        """Forget everything."""
        self._shelves.clear()
        self._kept = 0

    def learn(self, encoded: bytes, row: int) -> None:
        """A NodeId that will be asked for again."""
        if len(encoded) > self._longest:
            return
        if self._kept >= self._most:
            self.clear()
        self._kept += 1
        self._shelves.setdefault(len(encoded), _Shelf(len(encoded))).add(encoded, row)

    def rows(self, data: bytes, starts: Positions, lengths: Positions) -> Positions:
        """The row of each NodeId that lies in ``data``, or MISSING."""
        first = int(lengths[0])
        if (lengths == first).all():
            return self._rows_of(data, starts, first)
        rows = np.full(len(starts), MISSING, np.int64)
        for length in np.flatnonzero(np.bincount(np.minimum(lengths, self._longest + 1))).tolist():
            of_length = lengths == length
            rows[of_length] = self._rows_of(data, starts[of_length], length)
        return rows

    def _rows_of(self, data: bytes, starts: Positions, length: int) -> Positions:
        shelf = self._shelves.get(length)
        if shelf is None:
            return np.full(len(starts), MISSING, np.int64)
        return shelf.rows(windows(data, f"V{length}")[starts])


class _Shelf:
    """NodeIds of one length."""

    def __init__(self, length: int) -> None:
        self._kind = np.dtype(f"V{length}")
        self._new: dict[bytes, int] = {}
        self._hashes: NDArray[np.uint64] = np.zeros(0, np.uint64)
        self._names: NDArray[Any] = np.zeros(0, self._kind)
        self._rows: Positions = np.zeros(0, np.int64)

    def add(self, encoded: bytes, row: int) -> None:
        self._new[encoded] = row

    def _sort_in(self) -> None:
        new = np.frombuffer(b"".join(self._new), self._kind)
        rows = np.fromiter(self._new.values(), np.int64, len(self._new))
        self._new = {}
        hashes = np.concatenate((self._hashes, _hashes(new)))
        order = np.argsort(hashes, kind="stable")
        self._hashes = hashes[order]
        self._names = np.concatenate((self._names, new))[order]
        self._rows = np.concatenate((self._rows, rows))[order]

    def rows(self, names: NDArray[Any]) -> Positions:
        if self._new:
            self._sort_in()
        at = np.minimum(self._hashes.searchsorted(_hashes(names)), len(self._hashes) - 1)
        same = _octets(self._names.take(at)) == _octets(names)
        rows = self._rows.take(at)
        if not same.all():
            rows[~same.all(axis=1)] = MISSING
        return rows


def _octets(names: NDArray[Any]) -> NDArray[np.uint8]:
    return names.view(np.uint8).reshape(len(names), -1)


def _hashes(names: NDArray[Any]) -> NDArray[np.uint64]:
    """Of each name, over words of eight bytes."""
    octets = _octets(names)
    length = octets.shape[1]
    padded = np.zeros((len(names), (length + 7) // 8 * 8), np.uint8)
    padded[:, :length] = octets
    words = padded.view("<u8").T.copy()
    total: NDArray[np.uint64] = words[0] * _FACTOR
    total ^= total >> _HALF
    for word in words[1:]:
        total ^= word
        total *= _FACTOR
        total ^= total >> _HALF
    return total
