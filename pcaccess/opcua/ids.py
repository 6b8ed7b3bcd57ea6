"""Namespaces and NodeIds of the address space (docs/architecture.md, OPC UA address space)."""

from __future__ import annotations

from typing import Final

from asyncua import ua

ITEMS_URI: Final = "urn:pcaccess:items"
SYSTEM_URI: Final = "urn:pcaccess:system"
APPLICATION_URI: Final = "urn:pcaccess:server"
ITEMS: Final = 2
"""Namespace index of links, PLCs, folders and items; their string is the item ID or run-time name."""
SYSTEM: Final = 3
"""Namespace index of everything that belongs to them, so that no item name can collide."""


def item_node(item_id: str) -> ua.NodeId:
    return _string_node(item_id, ITEMS)


def system_node(owner: str, name: str) -> ua.NodeId:
    """``MicroWin.NewPLC.Temperature/Quality``."""
    return _string_node(f"{owner}/{name}", SYSTEM)


def standard(number: int) -> ua.NodeId:
    """A node of the OPC UA namespace."""
    return ua.NodeId(ua.Int32(number), ua.Int16(0))


def _string_node(identifier: str, namespace: int) -> ua.NodeId:
    return ua.NodeId(ua.String(identifier), ua.Int16(namespace))


def name_in(name: str, namespace: int) -> ua.QualifiedName:
    """A browse name."""
    return ua.QualifiedName(ua.String(name), ua.UInt16(namespace))
