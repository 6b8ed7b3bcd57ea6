"""A bounded memory of what was worked out for requests that come again.

A request is kept from its second time on: one that never comes again costs nothing but a number.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import Final, Generic, Protocol, TypeVar

MAX_PLANS: Final = 4_096
MAX_BYTES: Final = 64 * 1024 * 1024
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
        self.bytes = 0
        """What is kept, requests included."""

    def __len__(self) -> int:
        return len(self._plans)

    def get(self, request: bytes) -> P | None:
        plan = self._plans.get(request)
        if plan is not None:
            self._plans.move_to_end(request)
        return plan

    def offer(self, request: bytes, plan: P) -> None:
        """Keep the plan, if its request was seen before."""
        number = hash(request)
        if number not in self._seen:
            if len(self._seen) >= MAX_SEEN:
                self._seen.clear()
            self._seen.add(number)
            return
        size = len(request) + plan.size
        if size > self._most_bytes // 8:
            return
        self.drop(request)
        self._plans[request] = plan
        self.bytes += size
        while len(self._plans) > self._most or self.bytes > self._most_bytes:
            self.drop(next(iter(self._plans)))

    def drop(self, request: bytes) -> None:
        """Forget one, if it is kept."""
        plan = self._plans.pop(request, None)
        if plan is not None:
            self.bytes -= len(request) + plan.size
