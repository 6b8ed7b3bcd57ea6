"""A clock that tests move by hand."""

from __future__ import annotations

import asyncio
import heapq
from datetime import UTC, datetime, timedelta


class HandClock:
    """Starts at a fixed moment; :meth:`advance` moves it and wakes who slept until then."""

    def __init__(self) -> None:
        self._start = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
        self._passed = 0.0
        self._sleepers: list[tuple[float, int, asyncio.Future[None]]] = []
        self._number = 0

    def now(self) -> datetime:
        return self._start + timedelta(seconds=self._passed)

    def monotonic(self) -> float:
        return self._passed

    async def sleep(self, seconds: float) -> None:
        self._number += 1
        waiter: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        heapq.heappush(self._sleepers, (self._passed + seconds, self._number, waiter))
        await waiter

    def move(self, seconds: float) -> None:
        """Move without waking anybody."""
        self._passed += seconds

    async def advance(self, seconds: float) -> None:
        """Move step by step to each sleeper's moment, letting it run before the next."""
        await self.settle()
        end = self._passed + seconds
        while self._sleepers and self._sleepers[0][0] <= end:
            due, _, waiter = heapq.heappop(self._sleepers)
            self._passed = max(self._passed, due)
            if not waiter.done():
                waiter.set_result(None)
            await self.settle()
        self._passed = end

    async def settle(self) -> None:
        """Let every task run until it waits."""
        for _ in range(10):
            await asyncio.sleep(0)
