"""Where the pieces of a bulk request lie: found and taken in columns, not one by one.

Units:    positions and lengths in bytes of the request.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Positions = NDArray[np.int64]


def windows(data: bytes, kind: str) -> NDArray[Any]:
    """A value of a NumPy type at every byte of ``data``, aligned or not; nothing is copied."""
    size = np.dtype(kind).itemsize
    return np.ndarray((max(0, len(data) - size + 1),), kind, data, strides=(1,))


class Marker:
    """Bytes that stand between two pieces, at least eight of them; its first does not come again inside."""

    def __init__(self, text: bytes) -> None:
        self._text = text
        self._head = np.uint64(int.from_bytes(text[:8], "little"))
        self._tail = np.uint64(int.from_bytes(text[-8:], "little"))
        self._tail_at = len(text) - 8

    def positions(self, data: bytes, start: int, count: int) -> Positions | None:
        """Where it stands in ``data`` from ``start`` on; None unless that is ``count`` times.

        Where pieces of one length fill ``data`` to its end, only those places are looked at; whoever knows what the
        pieces must be need not care what is in them.
        """
        first = data.find(self._text, start)
        if first < 0:
            return None
        words = windows(data, "<u8")
        step = first + len(self._text) - start
        if start + step * count == len(data):
            places = np.arange(first, len(data), step)
            if len(self._marked(words, places)) == count:
                return places
        octets = np.frombuffer(data, np.uint8)[: len(data) - len(self._text) + 1]
        places = np.flatnonzero(octets[start:] == self._text[0]) + start
        places = self._marked(words, places)
        return places if len(places) == count else None

    def _marked(self, words: NDArray[Any], places: Positions) -> Positions:
        """Those of ``places`` where it stands."""
        places = places[words[places] == self._head]
        return places[words[places + self._tail_at] == self._tail] if self._tail_at else places
