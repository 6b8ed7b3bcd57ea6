"""Nodes that a session registered: handles of a few bytes, each standing for a NodeId.

Source:   OPC UA Part 4, 5.8.5 RegisterNodes and 5.8.6 UnregisterNodes.
"""

from __future__ import annotations

from collections.abc import Iterable

from asyncua import ua


class Issue:
    """While it stays the same object, no handle was given back, and what was worked out from handles is true."""

    __slots__ = ("__weakref__",)


class Registered:
    """The handles of one session, by their numbers."""

    def __init__(self) -> None:
        self._nodes: dict[int, ua.NodeId] = {}
        self.issue = Issue()

    def __len__(self) -> int:
        return len(self._nodes)

    def add(self, number: int, node: ua.NodeId) -> None:
        self._nodes[number] = node

    def find(self, number: int) -> ua.NodeId | None:
        """What a handle stands for."""
        return self._nodes.get(number)

    def give_back(self, numbers: Iterable[int]) -> None:
        """Forget handles; whatever is none is passed over."""
        for number in numbers:
            if self._nodes.pop(number, None) is not None:
                self.issue = Issue()
