"""A bounded memory of what was worked out for requests that come again.

A large plan is kept from the second time its request comes: one that never comes again costs nothing but a number.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import Final, Generic, Protocol, TypeVar

MAX_PLANS: Final = 4_096
MAX_BYTES: Final = 64 * 1024 * 1024
SMALL_PLAN: Final = 4_096
"""Bytes of a plan that is kept the first time."""
MAX_SEEN: Final = 65_536
"""Numbers of requests seen once; one more forgets them all."""


class Plan(Protocol):
    """What the cache must know of a plan."""

    @property
    def size(self) -> int:
        """Bytes that keeping it costs, its request not counted."""


P = TypeVar("P", bound=Plan)


class Plans(Generic[P]):
    """Plans by the bytes of their request behind the request header; the one used longest ago goes first."""

    def __init__(self, most: int = MAX_PLANS, most_bytes: int = MAX_BYTES) -> None:
        self._plans: OrderedDict[bytes, P] = OrderedDict()
        self._seen: set[int] = set()
        self._most = most
        self._most_bytes = most_bytes
        self._last = b""
        self._last_plan: P | None = None
        self.bytes = 0
        """What is kept, requests included."""

    def __len__(self) -> int:
        return len(self._plans)

    def get(self, request: bytes) -> P | None:
        if request == self._last:  # comparing is many times faster than hashing
            return self._last_plan
        plan = self._plans.get(request)
        if plan is not None:
            self._plans.move_to_end(request)
            self._last, self._last_plan = request, plan
        return plan

    def offer(self, request: bytes, plan: P) -> None:
        """Keep the plan, if it is small or its request was seen before."""
        size = len(request) + plan.size
        if size > SMALL_PLAN and not self._was_seen(hash(request)):
            return
        if size > self._most_bytes // 8:
            return
        self.drop(request)
        self._plans[request] = plan
        self.bytes += size
        while len(self._plans) > self._most or self.bytes > self._most_bytes:
            self.drop(next(iter(self._plans)))

    def _was_seen(self, number: int) -> bool:
        if number in self._seen:
            return True
        if len(self._seen) >= MAX_SEEN:
            self._seen.clear()
        self._seen.add(number)
        return False

    def drop(self, request: bytes) -> None:
        """Forget one, if it is kept."""
        self._last, self._last_plan = b"", None
        plan = self._plans.pop(request, None)
        if plan is not None:
            self.bytes -= len(request) + plan.size
