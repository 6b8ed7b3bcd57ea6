"""Our nodes in the form that asyncua's own services understand, made for one look and forgotten."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from asyncua import ua
from asyncua.server.address_space import AttributeValue, NodeData
from asyncua.ua.attribute_ids import AttributeIds

from pcaccess.opcua.entry import Entry, Reference
from pcaccess.opcua.ids import ITEMS, SYSTEM, standard
from pcaccess.opcua.space import Space

OURS = (ITEMS, SYSTEM)

LazyReference = tuple[bool, ua.NodeId, Callable[[], ua.ReferenceDescription | None]]
"""Whether it points forward, its type, and what describes its far end (None when that is gone)."""


class _OurNode(NodeData):
    """A node whose references are described when they are looked at: a folder may have 100,000."""

    def __init__(self, node_id: ua.NodeId, describe: Callable[[], list[ua.ReferenceDescription]]) -> None:
        self._describe = describe
        super().__init__(node_id)

    @property
    def references(self) -> list[ua.ReferenceDescription]:
        return self._describe()

    @references.setter
    def references(self, _: list[ua.ReferenceDescription]) -> None:
        pass  # asyncua's __init__ sets an empty list


class NodeStore(dict[ua.NodeId, NodeData]):
    """asyncua's dictionary of nodes; NodeIds of our namespaces are looked up in the :class:`Space` instead."""

    def __init__(self, space: Space) -> None:
        super().__init__()
        self._space = space

    def __missing__(self, node_id: ua.NodeId) -> NodeData:
        if node_id.NamespaceIndex in OURS:
            entry = self._space.find(node_id)
            if entry is not None:
                return self.node_data(entry)
        raise KeyError(node_id)

    def __contains__(self, node_id: object) -> bool:
        if super().__contains__(node_id):
            return True
        return (
            isinstance(node_id, ua.NodeId) and node_id.NamespaceIndex in OURS and self._space.find(node_id) is not None
        )

    def get(self, node_id: ua.NodeId, default: Any = None) -> Any:
        try:
            return self[node_id]
        except KeyError:
            return default

    def node_data(self, entry: Entry) -> NodeData:
        node = _OurNode(entry.node_id, lambda: self._described(entry))
        node.attributes = {key: AttributeValue(value) for key, value in attributes(entry).items()}
        if entry.value is not None:
            live = AttributeValue(ua.DataValue())
            read = entry.value
            live.value_callback = lambda _node, _attribute: read()
            node.attributes[AttributeIds.Value] = live
        node.call = entry.call
        return node

    def _described(self, entry: Entry) -> list[ua.ReferenceDescription]:
        return [description for r in self.references(entry) if (description := self.describe(r))]

    def references_of(self, node_id: ua.NodeId) -> Iterator[LazyReference]:
        """References of a node, each described only when somebody asks; KeyError for an unknown node."""
        entry = self._space.find(node_id) if node_id.NamespaceIndex in OURS else None
        if entry is None:
            for description in self[node_id].references:
                yield description.IsForward, description.ReferenceTypeId, partial(_itself, description)
        else:
            for reference in self.references(entry):
                yield reference.forward, standard(reference.type), partial(self.describe, reference)

    def references(self, entry: Entry) -> Iterator[Reference]:
        if entry.type_definition:  # methods have none
            yield Reference(_HAS_TYPE_DEFINITION, standard(entry.type_definition))
        yield from entry.references()

    def describe(self, reference: Reference) -> ua.ReferenceDescription | None:
        """What Browse says of the far end; None when it does not exist (any more)."""
        target = reference.target
        description = ua.ReferenceDescription()
        description.ReferenceTypeId = standard(reference.type)
        description.IsForward = reference.forward
        description.NodeId = target
        if target.NamespaceIndex in OURS:
            entry = self._space.find(target)
            if entry is None:
                return None
            description.BrowseName = entry.browse_name
            description.DisplayName = ua.LocalizedText(entry.browse_name.Name)
            description.NodeClass = entry.node_class
            description.TypeDefinition = standard(entry.type_definition)
            return description
        node = super().get(target)
        if node is None:
            return None
        description.BrowseName = _plain(node, AttributeIds.BrowseName)
        description.DisplayName = _plain(node, AttributeIds.DisplayName)
        description.NodeClass = _plain(node, AttributeIds.NodeClass)
        return description


def _itself(description: ua.ReferenceDescription) -> ua.ReferenceDescription:
    return description


_HAS_TYPE_DEFINITION = 40
"""HasTypeDefinition (OPC UA Part 6, NodeIds)."""


def _plain(node: NodeData, attribute: AttributeIds) -> Any:
    value = node.attributes[attribute].value
    return value.Value.Value if value is not None and value.Value is not None else None


def attributes(entry: Entry) -> dict[AttributeIds, ua.DataValue]:
    """All attributes of a node but its value (OPC UA Part 3, base, Object, Variable and Method node classes)."""
    ids, kinds = AttributeIds, ua.VariantType
    label = ua.LocalizedText(entry.browse_name.Name)
    found: dict[AttributeIds, ua.Variant] = {
        ids.NodeId: ua.Variant(entry.node_id, kinds.NodeId),
        ids.NodeClass: ua.Variant(entry.node_class, kinds.Int32),
        ids.BrowseName: ua.Variant(entry.browse_name, kinds.QualifiedName),
        ids.DisplayName: ua.Variant(label, kinds.LocalizedText),
        ids.Description: ua.Variant(ua.LocalizedText(ua.String(entry.description)), kinds.LocalizedText),
        ids.WriteMask: ua.Variant(0, kinds.UInt32),
        ids.UserWriteMask: ua.Variant(0, kinds.UInt32),
    }
    if entry.node_class == ua.NodeClass.Object:
        found[ids.EventNotifier] = ua.Variant(0, kinds.Byte)
    elif entry.node_class == ua.NodeClass.Method:
        found[ids.Executable] = ua.Variant(True, kinds.Boolean)
        found[ids.UserExecutable] = ua.Variant(True, kinds.Boolean)
    else:
        found[ids.DataType] = ua.Variant(entry.data_type, kinds.NodeId)
        found[ids.ValueRank] = ua.Variant(1 if entry.array else -1, kinds.Int32)
        if entry.array:
            found[ids.ArrayDimensions] = ua.Variant([entry.array], kinds.UInt32, is_array=True)
        found[ids.AccessLevel] = ua.Variant(entry.access, kinds.Byte)
        found[ids.UserAccessLevel] = ua.Variant(entry.access, kinds.Byte)
        found[ids.MinimumSamplingInterval] = ua.Variant(0.0, kinds.Double)
        found[ids.Historizing] = ua.Variant(False, kinds.Boolean)
    return {attribute: ua.DataValue(value) for attribute, value in found.items()}
