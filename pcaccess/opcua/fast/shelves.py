"""Rows of many encoded NodeIds at once: one shelf for each length, sorted by a hash of the bytes.

In a plain request each NodeId is followed by the same bytes (``BEHIND``), which fill it up to whole words. What is
found is compared word for word, so a hash that two names share costs time and nothing else.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pcaccess.opcua.fast.columns import Positions, windows

MISSING: Final = -3
"""Not on a shelf."""

BEHIND: Final = b"\x0d\x00\x00\x00\xff\xff\xff\xff"
"""Value attribute, null index range."""

_HALF: Final = np.uint64(32)
_WORD: Final = 8


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
        """The row of each NodeId that lies in ``data`` with ``BEHIND`` after it, or MISSING."""
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
        return shelf.rows(windows(data, f"V{shelf.size}")[starts])


class _Shelf:
    """NodeIds of one length."""

    def __init__(self, length: int) -> None:
        width = -(-length // _WORD)
        self.size = width * _WORD
        """Bytes of a NodeId and what fills it up."""
        self._filling = BEHIND[: self.size - length]
        self._factors = np.random.default_rng(length).integers(0, 1 << 63, width, np.uint64) * np.uint64(2) + np.uint64(
            1
        )
        self._new: dict[bytes, int] = {}
        self._hashes: NDArray[np.uint64] = np.zeros(0, np.uint64)
        self._names: NDArray[Any] = np.zeros(0, f"V{self.size}")
        self._rows: Positions = np.zeros(0, np.int64)

    def add(self, encoded: bytes, row: int) -> None:
        self._new[encoded + self._filling] = row

    def _sort_in(self) -> None:
        new = np.frombuffer(b"".join(self._new), self._names.dtype)
        rows = np.fromiter(self._new.values(), np.int64, len(self._new))
        self._new = {}
        hashes = np.concatenate((self._hashes, self._hash(_words(new))))
        order = np.argsort(hashes, kind="stable")
        self._hashes = hashes[order]
        self._names = np.concatenate((self._names, new))[order]
        self._rows = np.concatenate((self._rows, rows))[order]

    def rows(self, names: NDArray[Any]) -> Positions:
        if self._new:
            self._sort_in()
        words = _words(names)
        at = self._hashes.searchsorted(self._hash(words))
        same = _words(self._names.take(at, mode="clip")) == words
        rows = self._rows.take(at, mode="clip")
        if not same.all():
            rows[~same.all(axis=1)] = MISSING
        return rows

    def _hash(self, words: NDArray[np.uint64]) -> NDArray[np.uint64]:
        """Multilinear; the upper half of a word is folded into the lower, where a factor spreads it."""
        hashes: NDArray[np.uint64] = (words ^ (words >> _HALF)) @ self._factors
        return hashes


def _words(names: NDArray[Any]) -> NDArray[np.uint64]:
    return names.view("<u8").reshape(len(names), -1)
