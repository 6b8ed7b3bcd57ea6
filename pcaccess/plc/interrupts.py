"""Interrupts: which event runs which routine, and the queues in which events wait.

Events wait in three queues by group (communication, inputs and pulses, timed); the groups have priority in that
order, within a group the order of coming decides among what waits, as the manual has it. A routine is never
interrupted. This module knows no time and runs nothing: the runtime raises events and takes the next routine.

Units:    events are numbers 0..33.
Source:   System Manual, Interrupts (table of events, queue depths); document 004, section 9.28, table 9.5.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from enum import Enum
from types import MappingProxyType
from typing import Final

MAX_EVENT: Final = 33
INPUT_EVENTS: Final = 8
"""Events 0..7: rising and falling edge of I0.0, I0.1, I0.2, I0.3 in turn."""
TIMED_0: Final = 10
TIMED_1: Final = 11
T32_EVENT: Final = 21
T96_EVENT: Final = 22


class Group(Enum):
    """The value is (priority, depth of the queue, bit of SMB4 that tells of its overflow)."""

    COMMUNICATION = (0, 4, 0)
    IO = (1, 16, 1)
    TIMED = (2, 8, 2)

    @property
    def depth(self) -> int:
        return self.value[1]

    @property
    def overflow_bit(self) -> int:
        return self.value[2]


_COMMUNICATION: Final = frozenset({8, 9, 23, 24, 25, 26})
_TIMED: Final = frozenset({TIMED_0, TIMED_1, T32_EVENT, T96_EVENT})


def group_of(event: int) -> Group:
    if event in _COMMUNICATION:
        return Group.COMMUNICATION
    return Group.TIMED if event in _TIMED else Group.IO


class InterruptTable:
    """Attachments, the global enable, and what waits."""

    def __init__(self, communication_depth: int = Group.COMMUNICATION.depth) -> None:
        """``communication_depth``: 4, or 8 on the CPUs with two ports."""
        self.enabled = False
        self._routines: dict[int, int] = {}
        self._waiting: dict[Group, deque[int]] = {group: deque() for group in Group}
        self._depth = {group: group.depth for group in Group} | {Group.COMMUNICATION: communication_depth}
        self._overflows: set[Group] = set()

    @property
    def attached(self) -> Mapping[int, int]:
        """Event -> routine."""
        return MappingProxyType(self._routines)

    @property
    def has_work(self) -> bool:
        """A routine may run now."""
        return self.enabled and any(self._waiting.values())

    def attach(self, event: int, routine: int) -> None:
        self._routines[event] = routine

    def detach(self, event: int) -> None:
        """The event means nothing any more; what waits of it is forgotten when its turn comes."""
        self._routines.pop(event, None)

    def raise_event(self, event: int) -> Group | None:
        """The event happened; returns its group when the queue is full and the event is lost."""
        if event not in self._routines:
            return None
        group = group_of(event)
        queue = self._waiting[group]
        if len(queue) >= self._depth[group]:
            self._overflows.add(group)
            return group
        queue.append(event)
        return None

    def take(self) -> int | None:
        """The routine that runs next; None when nothing waits or interrupts are off."""
        if not self.enabled:
            return None
        for queue in self._waiting.values():
            while queue:
                routine = self._routines.get(queue.popleft())
                if routine is not None:
                    return routine
        return None

    def emptied(self) -> frozenset[Group]:
        """Groups whose overflow is over because their queue is empty."""
        over = frozenset(group for group in self._overflows if not self._waiting[group])
        self._overflows -= over
        return over

    def forget_waiting(self) -> None:
        """STOP in an interrupt routine: what waits is ignored."""
        for queue in self._waiting.values():
            queue.clear()

    def reset(self) -> None:
        """The change to RUN: interrupts off, nothing attached, nothing waits."""
        self.enabled = False
        self._routines.clear()
        self._overflows.clear()
        self.forget_waiting()
