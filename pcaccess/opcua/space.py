"""The address space, made on demand from the running project.

No node of ours exists before somebody asks for it: a node is a description (:class:`Entry`) looked up by its
NodeId's string, and turned into what asyncua expects only for the services that take asyncua's own path. So 100,000
items cost nothing here.

Source:   OPC UA Part 3 (attributes), Part 5 (FolderType, BaseObjectType), Part 8 (DataItemType, AnalogItemType).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from asyncua import ua
from asyncua.ua.object_ids import ObjectIds

from pcaccess.gateway.gateway import Gateway
from pcaccess.opcua.entry import Entry, Reference
from pcaccess.opcua.gatewaynode import GatewayNodes, gateway_node
from pcaccess.opcua.groupnodes import GroupNodes, root_node
from pcaccess.opcua.ids import ITEMS, SYSTEM, item_node, name_in, standard, system_node
from pcaccess.opcua.plcnodes import PlcNodes
from pcaccess.opcua.values import access_level, data_type_node, data_value, times_of, value_of
from pcaccess.project.model import Folder, Item, Link, Plc
from pcaccess.s7200.address import Address


@dataclass(slots=True)
class _Branch:
    """A link, PLC or folder with what lies below it."""

    path: str
    name: str
    parent: str | None
    kind: str
    description: str
    children: list[str] = field(default_factory=list)
    items: list[str] = field(default_factory=list)
    plc: Plc | None = None


class Space:
    """Nodes of namespaces 2 and 3."""

    def __init__(self, gateway: Gateway) -> None:
        self._gateway = gateway
        self._branches: dict[str, _Branch] = {}
        self._groups = GroupNodes(gateway)
        self._plc_nodes = PlcNodes(gateway)
        self.gateway_nodes = GatewayNodes(gateway)
        self.rebuild()

    # ------------------------------------------------------------------ structure

    def rebuild(self) -> None:
        """Take over the project's structure again, after it changed."""
        self._branches = {}
        for link in self._gateway.project.links:
            self._add_link(link)

    def _add_link(self, link: Link) -> None:
        branch = self._add_branch(link.name, link.name, None, "link", link.description)
        for plc in link.plcs:
            below = self._add_branch(f"{branch.path}.{plc.name}", plc.name, branch, "plc", plc.description)
            below.plc = plc
            below.items = [item.item_id for item in plc.items]
            for folder in plc.folders:
                self._add_folder(folder, below)

    def _add_folder(self, folder: Folder, parent: _Branch) -> None:
        branch = self._add_branch(f"{parent.path}.{folder.name}", folder.name, parent, "folder", folder.description)
        branch.items = [item.item_id for item in folder.items]
        for child in folder.folders:
            self._add_folder(child, branch)

    def _add_branch(self, path: str, name: str, parent: _Branch | None, kind: str, description: str) -> _Branch:
        branch = _Branch(path, name, parent.path if parent else None, kind, description)
        self._branches[path.casefold()] = branch
        if parent:
            parent.children.append(path)
        return branch

    def roots(self) -> Iterator[Reference]:
        """What hangs under Objects."""
        for branch in self._branches.values():
            if branch.kind == "link":
                yield Reference(ObjectIds.Organizes, item_node(branch.path))
        yield Reference(ObjectIds.Organizes, root_node())
        yield Reference(ObjectIds.Organizes, gateway_node())

    # ------------------------------------------------------------------ nodes

    def find(self, node_id: ua.NodeId) -> Entry | None:
        """The node of that id, in any case; None when there is none."""
        name = node_id.Identifier
        if not isinstance(name, str):
            return None
        if node_id.NamespaceIndex == ITEMS:
            row = self._gateway.find(name)
            if row is not None:
                return self._item(row)
            branch = self._branches.get(name.casefold())
            return self._object(branch) if branch else None
        if node_id.NamespaceIndex == SYSTEM:
            return self._system(name)
        return None

    def row(self, node_id: ua.NodeId) -> int | None:
        """Row of an item's NodeId; the short way of the services that only want values."""
        if node_id.NamespaceIndex == ITEMS and isinstance(node_id.Identifier, str):
            return self._gateway.find(node_id.Identifier)
        return None

    def _object(self, branch: _Branch) -> Entry:
        def references() -> Iterator[Reference]:
            up = item_node(branch.parent) if branch.parent else standard(ObjectIds.ObjectsFolder)
            yield Reference(ObjectIds.Organizes, up, forward=False)
            for child in branch.children:
                yield Reference(ObjectIds.Organizes, item_node(child))
            for item_id in branch.items:
                yield Reference(ObjectIds.HasComponent, item_node(item_id))
            if branch.plc is not None:
                for name in self._plc_nodes.names(branch.path):
                    yield Reference(ObjectIds.HasComponent, system_node(branch.path, name))

        kind = ObjectIds.BaseObjectType if branch.kind == "plc" else ObjectIds.FolderType
        return Entry(
            item_node(branch.path),
            name_in(branch.name, ITEMS),
            ua.NodeClass.Object,
            kind,
            references,
            branch.description,
        )

    def _item(self, row: int) -> Entry:
        item = self._gateway.item(row)
        ranged = item.low is not None and item.high is not None

        def references() -> Iterator[Reference]:
            owner = item.item_id.rpartition(".")[0]
            if owner.casefold() in self._branches:
                yield Reference(ObjectIds.HasComponent, item_node(owner), forward=False)
            for name in properties_of(item):
                yield Reference(ObjectIds.HasProperty, system_node(item.item_id, name))

        count = item.count
        return Entry(
            item_node(item.item_id),
            name_in(item.name, ITEMS),
            ua.NodeClass.Variable,
            ObjectIds.AnalogItemType if ranged else ObjectIds.DataItemType,
            references,
            item.description,
            lambda: value_of(self._gateway, row),
            data_type_node(item.data_type),
            count if count > 1 else 0,
            access_level(item.access),
            row,
        )

    def _system(self, name: str) -> Entry | None:
        owner, _, rest = name.partition("/")
        row = self._gateway.find(owner)
        if row is not None:
            return self._property(row, rest)
        branch = self._branches.get(owner.casefold())
        if branch is not None and branch.plc is not None:
            return self._plc_nodes.find(branch.path, rest)
        return self._groups.find(name) or self.gateway_nodes.find(name)

    def _property(self, row: int, name: str) -> Entry | None:
        item = self._gateway.item(row)
        found = next((p for p in properties_of(item) if p.casefold() == name.casefold()), None)
        if found is None:
            return None
        namespace = 0 if found in _STANDARD_PROPERTIES else SYSTEM
        if found == "Quality":

            def value() -> ua.DataValue:
                code = ua.Variant(self._gateway.table.quality_code(row) & 0xFC, ua.VariantType.UInt16)
                return data_value(code, *times_of(self._gateway, row))

            data_type = standard(ObjectIds.UInt16)
        else:
            content, data_type = _constant(item, found)

            def value() -> ua.DataValue:
                now = self._gateway.clock.now()
                return data_value(content, now, now)

        def references() -> Iterator[Reference]:
            yield Reference(ObjectIds.HasProperty, item_node(item.item_id), forward=False)

        return Entry(
            system_node(item.item_id, found),
            name_in(found, namespace),
            ua.NodeClass.Variable,
            ObjectIds.PropertyType,
            references,
            value=value,
            data_type=data_type,
        )


_STANDARD_PROPERTIES = frozenset({"Definition", "EURange", "EngineeringUnits"})


def properties_of(item: Item) -> list[str]:
    """Names of the properties an item's node has."""
    names = ["Quality", "Address", "RunTimeName", "Definition"]
    if item.low is not None and item.high is not None:
        names.append("EURange")
    if item.unit:
        names.append("EngineeringUnits")
    return names


def _constant(item: Item, name: str) -> tuple[ua.Variant, ua.NodeId]:
    if name == "EURange":
        return ua.Variant(ua.Range(ua.Double(item.low or 0.0), ua.Double(item.high or 0.0))), standard(ObjectIds.Range)
    if name == "EngineeringUnits":
        unit = ua.LocalizedText(ua.String(item.unit))
        info = ua.EUInformation(
            NamespaceUri=ua.String("urn:pcaccess:units"), UnitId=ua.Int32(-1), DisplayName=unit, Description=unit
        )
        return ua.Variant(info), standard(ObjectIds.EUInformation)
    text = {
        "Address": str(item.address),
        "RunTimeName": item.run_time_name,
        "Definition": _definition(item),
    }[name]
    return ua.Variant(text, ua.VariantType.String), standard(ObjectIds.String)


def _definition(item: Item) -> str:
    """How the value is made, for people (OPC UA Part 8, Definition)."""
    if not isinstance(item.address, Address):
        return item.address
    text = f"{item.address} as {item.raw_type.name}"
    if item.scaling is not None:
        s = item.scaling
        text += f", {s.raw_low:g}..{s.raw_high:g} scaled to {s.scaled_low:g}..{s.scaled_high:g}"
    return text
