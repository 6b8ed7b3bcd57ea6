"""What a node is to us: a description, made when somebody asks for it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from asyncua import ua

Value = Callable[[], ua.DataValue]


@dataclass(slots=True)
class Reference:
    """A reference of a node: its type, direction, and the far end by NodeId."""

    type: int
    target: ua.NodeId
    forward: bool = True


@dataclass(slots=True)
class Entry:
    """One node: what Read and Browse may ask of it."""

    node_id: ua.NodeId
    browse_name: ua.QualifiedName
    node_class: ua.NodeClass
    type_definition: int
    references: Callable[[], Iterator[Reference]]
    description: str = ""
    value: Value | None = None
    data_type: ua.NodeId | None = None
    array: int = 0
    """Elements of an array value, 0 for a single value."""
    access: int = 1
    row: int | None = None
    """Row of the item table, for items."""
    call: Callable[..., Any] | None = None
    write: Callable[[Any], int] | None = None
    """Takes a new value of ``data_type`` and gives the StatusCode, for what can be set beside items."""
