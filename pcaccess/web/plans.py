"""Requests that come again and again: the rows they mean are looked up once, and an answer is written once per change.

A plan belongs to the exact bytes of a request. It is made anew when rows come or go; its answer is written anew when
any sample may have moved. What is kept is bounded.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Final

from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.station import Station
from pcaccess.items.quality import Quality
from pcaccess.web.formats import Format
from pcaccess.web.rendering import Rendering

MAX_PLANS: Final = 64
MAX_ROWS: Final = 100_000
"""Of all kept plans together; about 200 bytes each."""


@dataclass(slots=True)
class Plan:
    """What one request means."""

    form: Format
    rendering: Rendering
    rows: list[int]
    stations: tuple[Station, ...]
    dynamic: list[int]
    """Rows that are kept only while somebody names them."""
    gaps: dict[int, bytes] = field(default_factory=dict)
    """Entries at places where there is no row, by place."""
    max_age: float = 0.0
    """Seconds that a sample may be old."""
    answer: bytes = b""
    moves: int = -1
    quality: Quality | None = None

    def write(self, quality: Quality | None) -> bytes:
        """The whole answer from the table as it is now."""
        form = self.form
        if not self.gaps:
            return form.opening + self.rendering.joined(quality) + form.closing
        entries = iter(self.rendering.entries(quality))
        length = len(self.rows) + len(self.gaps)
        return (
            form.opening + form.separator.join(self.gaps.get(n) or next(entries) for n in range(length)) + form.closing
        )


class Plans:
    """The plans of one gateway, the least used forgotten first."""

    def __init__(self, gateway: Gateway) -> None:
        self._gateway = gateway
        self._kept: OrderedDict[Hashable, Plan] = OrderedDict()
        self._rows = 0
        gateway.on_structure(self.forget)

    def forget(self) -> None:
        """Items changed in more than their values."""
        self._kept.clear()
        self._rows = 0

    def plan(
        self,
        form: Format,
        rows: Sequence[int | None],
        gap: Callable[[int], bytes] = lambda place: b"",
        max_age: float = 0.0,
    ) -> Plan:
        """A plan for ``rows``; ``gap(place)`` writes the entry where there is None, and is called once."""
        table = self._gateway.table
        known = [row for row in rows if row is not None]
        gaps = {place: gap(place) for place, row in enumerate(rows) if row is None}
        dynamic = [row for row in known if "," in table.item_id(row)]
        stations = self._gateway.stations_of(known)
        return Plan(form, Rendering(form, table, known), known, stations, dynamic, gaps, max_age)

    async def answer(
        self, key: Hashable, make: Callable[[], Plan], quality: Callable[[], Quality | None] = lambda: None
    ) -> bytes:
        """The answer to a request; ``make`` says what it means when that is not known.

        ``quality``: what all samples have instead of their own.
        """
        gateway = self._gateway
        plan = self._current(key, make)
        for row in plan.dynamic:
            gateway.dynamic.touch(row)
        await gateway.read(plan.rows, plan.max_age, plan.stations)
        if plan.rendering.generation != gateway.table.generation:  # rows went while a PLC was asked
            plan = self._current(key, make)
        instead = quality()
        if plan.moves != gateway.table.moves or plan.quality is not instead:
            plan.answer = plan.write(instead)
            plan.moves, plan.quality = gateway.table.moves, instead
        return plan.answer

    def _current(self, key: Hashable, make: Callable[[], Plan]) -> Plan:
        plan = self._kept.get(key)
        if plan is not None and plan.rendering.generation == self._gateway.table.generation:
            self._kept.move_to_end(key)
            return plan
        if plan is not None:
            self._drop(key)
        plan = make()
        size = len(plan.rows)
        while self._kept and (len(self._kept) >= MAX_PLANS or self._rows + size > MAX_ROWS):
            self._drop(next(iter(self._kept)))
        self._kept[key] = plan
        self._rows += size
        return plan

    def _drop(self, key: Hashable) -> None:
        self._rows -= len(self._kept.pop(key).rows)
