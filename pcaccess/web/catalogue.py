"""Every item by name, for lists and searches. Made when somebody asks, and again when items came or went.

Searching happens in another thread, on a copy, because 100,000 names would hold up the event loop.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import translate
from typing import Final

from pcaccess.gateway.gateway import Gateway
from pcaccess.problems import nearest_word

LOOKED_AT: Final = 2000
"""Names that are compared with a misspelt one; more would take longer than anybody waits."""


@dataclass(frozen=True, slots=True)
class Entry:
    row: int
    item_id: str
    plc: str
    text: str
    """ID and description, casefolded, for searching."""


@dataclass(frozen=True, slots=True)
class Search:
    """What somebody looks for; everything empty is every item."""

    words: str = ""
    """A pattern for the whole ID when it has ``*`` or ``?``, otherwise a part of ID or description; any case."""
    plc: str = ""
    """``Link.PLC`` or a link; any case."""


class Catalogue:
    """The items of one gateway in the project's order, dynamic ones behind those of their PLC."""

    def __init__(self, gateway: Gateway) -> None:
        self._gateway = gateway
        self._entries: list[Entry] = []
        self._generation = -1
        gateway.on_structure(self._forget)

    def _forget(self) -> None:
        self._generation = -1

    async def entries(self) -> list[Entry]:
        """Every item; treat it as read-only."""
        generation = self._gateway.table.generation
        if generation != self._generation:
            items = [(s.name, list(s.items())) for s in self._gateway.stations.values()]
            self._entries = await asyncio.to_thread(
                lambda: [
                    Entry(row, item.item_id, plc, f"{item.item_id}\n{item.description}".casefold())
                    for plc, members in items
                    for row, item in members
                ]
            )
            self._generation = generation
        return self._entries

    async def find(self, search: Search) -> list[Entry]:
        """Items that fit."""
        found = await self.entries()
        if search != Search():
            found = await asyncio.to_thread(_matching, found, search)
        table = self._gateway.table
        if table.generation != self._generation:  # items went meanwhile
            found = [entry for entry in found if table.item_id(entry.row) == entry.item_id]
        return found

    async def nearest(self, name: str) -> str | None:
        """The item whose ID is most like ``name``: of its own folder first."""
        entries = await self.entries()
        return await asyncio.to_thread(_nearest, name, entries)


def _matching(entries: Sequence[Entry], search: Search) -> list[Entry]:
    plc = search.plc.casefold()
    if plc:
        entries = [e for e in entries if e.plc.casefold() == plc or e.plc.casefold().startswith(f"{plc}.")]
    words = search.words.casefold()
    if "*" in words or "?" in words:
        pattern = re.compile(translate(words.replace("[", "[[]")))
        return [e for e in entries if pattern.match(e.text.partition("\n")[0])]
    return [e for e in entries if words in e.text]


def _nearest(name: str, entries: Sequence[Entry]) -> str | None:
    folder = f"{name.rpartition('.')[0]}.".casefold()
    siblings = [e.item_id for e in entries if e.text.startswith(folder)]
    return nearest_word(name, (siblings or [e.item_id for e in entries])[:LOOKED_AT])
