"""One PLC of the running gateway: its project entry, its link, its image, its rows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from pcaccess.gateway.writing import linear
from pcaccess.items.image import Field, PlcImage
from pcaccess.items.table import ItemTable, Rows
from pcaccess.links.base import Link
from pcaccess.project.model import Item, Plc
from pcaccess.s7200.address import Address
from pcaccess.s7200.memory import MEMORY_SIZE, locate
from pcaccess.s7200.special import true_of_memory_alone

FRESH_TICKS = 100_000
"""A sample stamped within the last 10 ms is as good as now."""


@dataclass(slots=True)
class Station:
    """``live``: its samples need no polling and are current whenever somebody asks (soft, memory only)."""

    plc: Plc
    link: Link
    image: PlcImage
    live: bool
    runs: bool = False
    """A CPU keeps SM, timers and counters true."""
    reachable: bool = True
    """What the link last said of it."""
    stamped: int = 0

    @property
    def name(self) -> str:
        return self.plc.item_id

    @property
    def connected(self) -> bool:
        """Whether the PLC answers."""
        return self.plc.connected and self.reachable

    @property
    def mode(self) -> str:
        """``RUN`` or ``STOP``; a PLC of memory alone is in STOP, one that does not answer is ``UNKNOWN``."""
        return "STOP" if self.connected else "UNKNOWN"

    @property
    def scan_time(self) -> float:
        """Milliseconds of the last scan; 0 where nothing scans."""
        return 0.0

    def add(self, items: Iterable[tuple[int, Item]]) -> None:
        """Show rows for items of this PLC."""
        fields, silent = [], []
        for row, item in items:
            if isinstance(item.address, Address):
                offset, bit = locate(item.address)
                fields.append(
                    Field(row, offset, bit, item.raw_type, item.address.count, item.length, linear(item.scaling))
                )
                if not self.runs and not true_of_memory_alone(item.address, item.raw_type.size):
                    silent.append(row)
        self.image.add(fields, out_of_service=silent)

    @property
    def rows(self) -> Rows:
        return self.image.rows

    def freshen(self, table: ItemTable, now: int) -> None:
        """Somebody reads: the samples of a live station are as old as the question."""
        if self.live and self.plc.connected and now - self.stamped > FRESH_TICKS:
            self.stamped = now
            table.stamp(self.rows, now)


def new_image(table: ItemTable) -> PlcImage:
    return PlcImage(table, MEMORY_SIZE)
