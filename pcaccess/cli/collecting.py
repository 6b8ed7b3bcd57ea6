"""``pcaccess sheet collect`` and ``merge``."""

from __future__ import annotations

import asyncio
import contextlib
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from pcaccess.cli.failures import Failed
from pcaccess.cli.output import note
from pcaccess.cli.serving import stopped_by_signals
from pcaccess.clock import SystemClock
from pcaccess.s7200.types import DataType
from pcaccess.sheet.collect.collector import Collector
from pcaccess.sheet.collect.journal import journal_of
from pcaccess.sheet.collect.store import Store, newest_book, open_store
from pcaccess.sheet.collect.workbook import items_of
from pcaccess.sheet.entries import Chosen, Entry, SheetError
from pcaccess.sheet.files import opened_by
from pcaccess.sheet.sources import GatewaySource


@dataclass(frozen=True, slots=True)
class Collected:
    """What became of it."""

    rows: int
    items: int
    books: list[Path]
    missed: int
    failure: str | None


def collect(
    book: Path, source: GatewaySource, chosen: Chosen, every: float, duration: float | None, max_rows: int
) -> Collected:
    """Collect until the time is over or Ctrl-C; raises SheetError when it cannot begin."""
    clock = SystemClock()
    if (newest := newest_book(book)).exists() and (who := opened_by(newest)):
        note(f"{newest} is open in {who}; rows wait in {journal_of(book)} until it is closed")
    store = open_store(book, chosen, source.gateway, clock.now(), max_rows)
    collector = Collector(source.client, chosen.readable, store, clock, note)

    async def main() -> None:
        stop = asyncio.Event()
        with stopped_by_signals(stop):
            await collector.run(every, duration, stop)

    try:
        asyncio.run(main())
    except BaseExceptionGroup as group:
        raise group.exceptions[0] from None
    finally:
        store.close()
        source.client.close()
    return Collected(collector.rows, len(chosen.readable), store.books, collector.missed, collector.failure)


def chosen_again(book: Path, source: GatewaySource) -> Chosen | None:
    """The items of a workbook that exists, as the gateway has them now; None without a workbook."""
    newest = newest_book(book)
    if not newest.exists():
        return None
    known = {entry.item_id.casefold(): entry for entry in source.entries()}
    entries = []
    for item_id in items_of(newest):
        found = known.get(item_id.casefold()) or source.dynamic(item_id)
        if found is None:
            note(f"there is no item {item_id} any more; its column stays, with quality 4 (CONFIG_ERROR)")
        entries.append(found or Entry(item_id, DataType.REAL))
    return Chosen(entries)


def merge(book: Path, now: datetime, max_rows: int) -> int:
    """Put what a journal holds into its workbook; the number of rows. Raises SheetError."""
    journal = journal_of(book)
    if not journal.exists():
        raise Failed(f"there is no {journal}: nothing waits for {book}")
    store: Store | None = None
    with contextlib.ExitStack() as stack:
        store = open_store(book, None, "", now, max_rows)
        stack.callback(store.close)
        try:
            return store.save()
        except SheetError as error:
            raise SheetError(f"{error}; the rows stay in {journal}") from None
