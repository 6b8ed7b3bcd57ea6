"""Rows that are often stamped together, with their places in the table's blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pcaccess.items.table import ItemTable

Rows = NDArray[np.int64]
Places = NDArray[np.int64] | slice


class RowSet:
    """Looks its places up again only when rows came or went."""

    def __init__(self, rows: Rows) -> None:
        self.rows = rows
        self._generation = -1
        self._spans: list[tuple[int, Places]] = []

    def placed(self, table: ItemTable) -> list[tuple[int, Places]]:
        """Kind and places."""
        if self._generation != table.generation:
            self._spans = table.spans(self.rows)
            self._generation = table.generation
        return self._spans


def span(places: NDArray[np.int64]) -> Places:
    """A slice where the places follow each other, which is many times faster than a list of them."""
    if len(places) > 1 and places[-1] - places[0] == len(places) - 1 and (np.diff(places) == 1).all():
        return slice(int(places[0]), int(places[-1]) + 1)
    return places
