"""What a server offers: links, PLCs, folders and items, with what is known of each without reading its value."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

from asyncua import ua
from asyncua.ua.attribute_ids import AttributeIds
from asyncua.ua.object_ids import ObjectIds

from pcaccess.cli.failures import Failed
from pcaccess.cli.names import Unknown, built_in, content, resolve, walk
from pcaccess.cli.output import Cell, Column, Row
from pcaccess.cli.remote import Child, Remote, connect, is_property
from pcaccess.cli.values import TYPES

COLUMNS: Final = (
    Column("Item ID"),
    Column("Type"),
    Column("Access"),
    Column("Address"),
    Column("Range"),
    Column("Unit"),
    Column("Description"),
)
_ATTRIBUTES: Final = (AttributeIds.DataType, AttributeIds.ArrayDimensions, AttributeIds.UserAccessLevel)
_VARIABLES: Final = ("item", "property")
_BELONGING: Final = ("Address", "RunTimeName", "EURange", "EngineeringUnits")
_ACCESS: Final = ("", "R", "W", "RW")


@dataclass(frozen=True, slots=True)
class Listed:
    """One node of the tree."""

    item_id: str
    kind: str
    """``link``, ``plc``, ``folder``, ``item`` or ``property``; ``object`` on foreign servers."""
    type: str | None = None
    count: int = 1
    """Elements of an array."""
    access: str = ""
    address: str | None = None
    run_time_name: str | None = None
    low: float | None = None
    high: float | None = None
    unit: str | None = None
    description: str = ""

    def as_json(self) -> dict[str, Any]:
        common = {"id": self.item_id, "kind": self.kind, "description": self.description}
        if self.kind not in _VARIABLES:
            return common
        return common | {
            "type": self.type,
            "count": self.count,
            "access": self.access,
            "address": self.address,
            "run_time_name": self.run_time_name,
            "low": self.low,
            "high": self.high,
            "unit": self.unit,
        }

    def as_row(self) -> Row:
        """Cells of ``COLUMNS``."""
        ranged = "" if self.low is None or self.high is None else f"{self.low:g}..{self.high:g}"
        kind = (self.type or "") if self.kind in _VARIABLES else Cell(self.kind, "dim")
        return (
            self.item_id,
            kind,
            self.access,
            self.address or "",
            ranged,
            self.unit or "",
            self.description,
        )


async def browse(url: str, name: str | None, depth: int | None, *, everything: bool = False) -> list[Listed]:
    """Nodes below the one named (below the root without a name), or the item itself when it is one.

    ``depth``: levels, None for all. ``everything``: also what belongs to PLCs and items.
    """
    async with connect(url) as remote:
        start = remote.roots()
        if name is not None:
            (found,) = await resolve(remote, [name])
            if isinstance(found, Unknown):
                raise Failed(found.message)
            if found.is_item and not everything:
                return await _describe(remote, [(found.node, "item")])
            start = found.node
        nodes = await walk(remote, start, depth, properties=everything)
        return await _describe(remote, [(child.NodeId, _kind(remote, child)) for _, child in nodes])


def _kind(remote: Remote, child: Child) -> str:
    ours = remote.items is None or child.NodeId.NamespaceIndex == remote.items
    if child.NodeClass == ua.NodeClass.Variable:
        return "item" if ours and not is_property(child) else "property"
    if remote.items is None or not ours:
        return "object"
    if child.TypeDefinition.Identifier == ObjectIds.BaseObjectType:
        return "plc"
    return "folder" if "." in str(child.NodeId.Identifier) else "link"


async def _describe(remote: Remote, nodes: Sequence[tuple[ua.NodeId, str]]) -> list[Listed]:
    asked = [(n, *question) for n, (node, kind) in enumerate(nodes) for question in _questions(remote, node, kind)]
    answers = await remote.read((node, attribute) for _, _, node, attribute in asked)
    known: list[dict[str, Any]] = [{} for _ in nodes]
    for (n, key, _, _), answer in zip(asked, answers, strict=True):
        known[n][key] = content(answer)
    return [_listed(remote.name(node), kind, facts) for (node, kind), facts in zip(nodes, known, strict=True)]


def _questions(remote: Remote, node: ua.NodeId, kind: str) -> Iterator[tuple[str, ua.NodeId, AttributeIds]]:
    """What to ask of a node, and what the answer is called."""
    yield "Description", node, AttributeIds.Description
    if kind in _VARIABLES:
        for attribute in _ATTRIBUTES:
            yield attribute.name, node, attribute
    if kind == "item":
        for name in _BELONGING:
            place = remote.belonging(node, name)
            if place is not None:
                yield name, place, AttributeIds.Value


def _listed(item_id: str, kind: str, facts: dict[str, Any]) -> Listed:
    limits = facts.get("EURange")
    data_type = TYPES.get(built_in(facts.get("DataType")))
    dimensions = facts.get("ArrayDimensions")
    return Listed(
        item_id,
        kind,
        data_type.name if data_type else None,
        dimensions[0] if dimensions else 1,
        _ACCESS[(facts.get("UserAccessLevel") or 0) & 3],
        facts.get("Address"),
        facts.get("RunTimeName"),
        limits.Low if limits else None,
        limits.High if limits else None,
        _text(facts.get("EngineeringUnits")),
        _text(facts.get("Description")) or "",
    )


def _text(value: Any) -> str | None:
    """The text of a LocalizedText, or of the unit that EUInformation describes."""
    localized = getattr(value, "DisplayName", value)
    return getattr(localized, "Text", None)
