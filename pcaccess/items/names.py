"""Rows by name, without regard to case, at twelve bytes a name.

A name is found by the hash of its folded text in a sorted column, and compared with the text that its item has anyway;
a dictionary of 100,000 names would cost ten times as much. The names that are asked for often are remembered.

Errors:   ``check`` raises KeyError for a name that exists in any case; ``add`` trusts that it was called.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

FEW: Final = 64
"""So few names at once go into a dictionary of folded texts: a column would be copied for them."""
MAX_ASKED: Final = 16_384
"""Spellings that are remembered; one more forgets them all."""


class Names:
    """Names and aliases of rows."""

    def __init__(self, written: Callable[[int], str]) -> None:
        """``written`` gives the name of a row as it was added."""
        self._written = written
        self._few: dict[str, int] = {}
        """Folded names that came a few at a time, and aliases."""
        self._runs: list[tuple[NDArray[np.int64], NDArray[np.int32]]] = []
        """Sorted hashes of folded names, with their rows; each at most half as long as the one before when it came."""
        self._asked: dict[str, int] = {}

    def find(self, name: str) -> int | None:
        """Row of a name in any case."""
        row = self._asked.get(name)
        if row is None:
            row = self._look_up(name.casefold())
            if row is not None:
                if len(self._asked) >= MAX_ASKED:
                    self._asked.clear()
                self._asked[name] = row
        return row

    def _look_up(self, folded: str) -> int | None:
        row = self._few.get(folded)
        if row is not None or not self._runs:
            return row
        number = hash(folded)
        for hashes, rows in self._runs:
            at = int(hashes.searchsorted(number))
            while at < len(hashes) and hashes[at] == number:
                row = int(rows[at])
                if self._written(row).casefold() == folded:
                    return row
                at += 1
        return None

    def check(self, names: Sequence[str]) -> None:
        """Raise KeyError if one of the names exists, or comes twice."""
        folded = [name.casefold() for name in names]
        suspects: Iterable[int] = range(len(names))
        if len(names) > FEW and len(set(folded)) == len(folded) and self._few.keys().isdisjoint(folded):
            hashes = _hashes(folded)
            known = np.zeros(len(folded), np.bool_)
            for run, _ in self._runs:
                known |= run.take(run.searchsorted(hashes), mode="clip") == hashes
            suspects = np.flatnonzero(known).tolist()
        seen: set[str] = set()
        for n in suspects:
            if folded[n] in seen or self._look_up(folded[n]) is not None:
                raise KeyError(f"exists already: {folded[n]}")
            seen.add(folded[n])

    def add(self, names: Sequence[str], rows: Sequence[int]) -> None:
        """A row for each name."""
        folded = [name.casefold() for name in names]
        if len(names) <= FEW:
            self._few.update(zip(folded, rows, strict=True))
        else:
            self._add_run(_hashes(folded), np.array(rows, np.int32))

    def _add_run(self, hashes: NDArray[np.int64], rows: NDArray[np.int32]) -> None:
        """Shorter runs go into it, so that there are few to look into and each name was copied a few times only."""
        while self._runs and len(self._runs[-1][0]) < 2 * len(hashes):
            earlier, their_rows = self._runs.pop()
            hashes, rows = np.concatenate((earlier, hashes)), np.concatenate((their_rows, rows))
        order = np.argsort(hashes, kind="stable")
        self._runs.append((hashes[order], rows[order]))

    def add_alias(self, name: str, row: int) -> None:
        """Another name of a row; one that is taken stays with its row."""
        if self.find(name) is None:
            self._few[name.casefold()] = row

    def remove(self, rows: Iterable[int]) -> None:
        """Forget all names of some rows."""
        gone = set(rows)
        removed = np.fromiter(gone, np.int32, len(gone))
        self._asked.clear()
        self._few = {name: row for name, row in self._few.items() if row not in gone}
        kept = [(hashes, numbers, ~np.isin(numbers, removed)) for hashes, numbers in self._runs]
        self._runs = [(hashes[stay], numbers[stay]) for hashes, numbers, stay in kept if stay.any()]


def _hashes(folded: Sequence[str]) -> NDArray[np.int64]:
    return np.fromiter(map(hash, folded), np.int64, len(folded))
