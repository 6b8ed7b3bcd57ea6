"""The address space: every node is described on demand, and the descriptions fit together."""

from __future__ import annotations

from collections import deque

import pytest
from asyncua import ua
from asyncua.ua.attribute_ids import AttributeIds
from asyncua.ua.object_ids import ObjectIds

from pcaccess.gateway.gateway import Gateway
from pcaccess.opcua.ids import ITEMS, SYSTEM, standard
from pcaccess.opcua.nodestore import OURS, NodeStore
from pcaccess.opcua.space import Space

PLC = "MicroWin.NewPLC"
REFERENCES = {
    standard(ObjectIds.HasProperty): "property",
    standard(ObjectIds.HasComponent): "component",
    standard(ObjectIds.Organizes): "organizes",
}


class Nodes:
    """What asyncua's services would see."""

    def __init__(self, gateway: Gateway) -> None:
        self.space = Space(gateway)
        self.store = NodeStore(self.space)

    def value(self, node: str, attribute: AttributeIds = AttributeIds.Value) -> object:
        stored = self.store[ua.NodeId.from_string(node)].attributes[attribute]
        value = stored.value_callback(None, None) if stored.value_callback else stored.value
        assert value is not None
        assert value.Value is not None
        return value.Value.Value

    def type_of(self, node: str) -> int:
        entry = self.space.find(ua.NodeId.from_string(node))
        assert entry is not None
        return entry.type_definition

    def below(self, node: str, kind: str) -> list[str]:
        """Forward references of a kind, as the strings of their NodeIds."""
        return [
            str(r.NodeId.Identifier)
            for r in self.store[ua.NodeId.from_string(node)].references
            if r.IsForward and REFERENCES[r.ReferenceTypeId] == kind
        ]


@pytest.fixture
def nodes(gateway: Gateway) -> Nodes:
    return Nodes(gateway)


def test_the_tree_is_links_plcs_folders_items(nodes: Nodes) -> None:
    assert next(r.target.Identifier for r in nodes.space.roots()) == "MicroWin"
    assert nodes.below("ns=2;s=MicroWin", "organizes") == [PLC, "MicroWin.Dead"]
    assert nodes.below(f"ns=2;s={PLC}", "organizes") == [f"{PLC}.USR1"]
    assert f"{PLC}.Motor" in nodes.below(f"ns=2;s={PLC}", "component")
    assert nodes.below(f"ns=2;s={PLC}.USR1", "component") == [f"{PLC}.USR1.COUNTER_1"]


def test_every_reference_has_its_far_end_and_the_far_end_knows_it(nodes: Nodes) -> None:
    """OPC UA Part 3: a reference is seen from both ends, but a type need not know its instances."""
    todo = deque(r.target for r in nodes.space.roots())
    seen: set[ua.NodeId] = set()
    while todo:
        here = todo.popleft()
        if here in seen:
            continue
        seen.add(here)
        for reference in nodes.store[here].references:
            there = reference.NodeId
            if there.NamespaceIndex not in OURS:
                continue
            assert there in nodes.store, f"{here} refers to {there}, which does not exist"
            back = [(r.NodeId, r.IsForward) for r in nodes.store[there].references]
            organised = REFERENCES[reference.ReferenceTypeId] == "organizes" and "Groups" in str(here.Identifier)
            assert organised or (here, not reference.IsForward) in back, f"{there} does not know {here}"
            todo.append(there)
    assert len(seen) > 80


def test_a_node_is_found_in_any_case_and_named_as_written(nodes: Nodes) -> None:
    assert nodes.value("ns=2;s=MICROWIN.newplc.MOTOR", AttributeIds.NodeId) == ua.NodeId(f"{PLC}.Motor", ITEMS)
    assert nodes.value("ns=2;s=microwin.NEWPLC.usr1", AttributeIds.BrowseName) == ua.QualifiedName("USR1", ITEMS)


@pytest.mark.parametrize(
    "node",
    [
        "ns=2;s=MicroWin.NewPLC.Nothing",
        "ns=2;s=MicroWin.Nobody",
        "ns=2;s=",
        "ns=2;i=5",
        "ns=3;s=MicroWin.NewPLC.Motor/Nothing",
        "ns=3;s=MicroWin.NewPLC.Motor",
        "ns=3;s=MicroWin.NewPLC/Nothing",
        "ns=3;s=MicroWin/Mode",
        "ns=3;s=/Quality",
        "ns=4;s=MicroWin.NewPLC.Motor",
        "ns=0;i=2253",
    ],
)
def test_what_does_not_exist_is_no_node(nodes: Nodes, node: str) -> None:
    node_id = ua.NodeId.from_string(node)
    assert nodes.space.find(node_id) is None
    assert node_id not in nodes.store
    assert nodes.store.get(node_id) is None
    with pytest.raises(KeyError):
        nodes.store[node_id]


@pytest.mark.parametrize(
    ("item", "data_type", "rank", "access"),
    [
        ("Motor", ObjectIds.Boolean, -1, 3),
        ("High", ObjectIds.Byte, -1, 3),
        ("Signed", ObjectIds.SByte, -1, 3),
        ("Temperature", ObjectIds.Int16, -1, 3),
        ("Unsigned", ObjectIds.UInt16, -1, 3),
        ("Big", ObjectIds.Int32, -1, 3),
        ("Huge", ObjectIds.UInt32, -1, 3),
        ("Level", ObjectIds.Float, -1, 3),
        ("Scaled", ObjectIds.Float, -1, 3),
        ("Text", ObjectIds.String, -1, 3),
        ("Row", ObjectIds.Int16, 1, 3),
        ("Bits", ObjectIds.Boolean, 1, 3),
        ("Input", ObjectIds.Boolean, -1, 1),
        ("Command", ObjectIds.Int16, -1, 2),
    ],
)
def test_an_item_says_its_type_and_access(nodes: Nodes, item: str, data_type: int, rank: int, access: int) -> None:
    node = f"ns=2;s={PLC}.{item}"
    assert nodes.value(node, AttributeIds.DataType) == standard(data_type)
    assert nodes.value(node, AttributeIds.ValueRank) == rank
    assert nodes.value(node, AttributeIds.AccessLevel) == access
    assert nodes.value(node, AttributeIds.UserAccessLevel) == access


def test_an_array_says_how_long_it_is_and_a_single_value_nothing(nodes: Nodes) -> None:
    assert nodes.value(f"ns=2;s={PLC}.Row", AttributeIds.ArrayDimensions) == [4]
    motor = nodes.store[ua.NodeId(f"{PLC}.Motor", ITEMS)]
    assert AttributeIds.ArrayDimensions not in motor.attributes


def test_a_ranged_item_is_analog_and_has_its_range_and_unit(nodes: Nodes) -> None:
    node = f"ns=2;s={PLC}.Temperature"
    assert nodes.type_of(node) == ObjectIds.AnalogItemType
    owner = f"{PLC}.Temperature/"
    assert nodes.below(node, "property") == [
        owner + name for name in ("Quality", "Address", "RunTimeName", "Definition", "EURange", "EngineeringUnits")
    ]
    assert nodes.value(f"ns=3;s={owner}EURange") == ua.Range(200.0, 1000.0)
    unit = nodes.value(f"ns=3;s={owner}EngineeringUnits")
    assert isinstance(unit, ua.EUInformation)
    assert unit.DisplayName == ua.LocalizedText("°C")


def test_an_item_without_a_range_is_a_plain_data_item(nodes: Nodes) -> None:
    assert nodes.type_of(f"ns=2;s={PLC}.Motor") == ObjectIds.DataItemType
    assert f"{PLC}.Motor/EURange" not in nodes.below(f"ns=2;s={PLC}.Motor", "property")
    assert nodes.space.find(ua.NodeId(f"{PLC}.Motor/EURange", SYSTEM)) is None


def test_standard_properties_have_standard_names(nodes: Nodes) -> None:
    """OPC UA Part 8: EURange, EngineeringUnits and Definition are browse names of namespace 0."""
    found = {
        name: nodes.value(f"ns=3;s={PLC}.Temperature/{name}", AttributeIds.BrowseName)
        for name in ("EURange", "EngineeringUnits", "Definition", "Quality")
    }
    assert found["EURange"] == ua.QualifiedName("EURange", 0)
    assert found["EngineeringUnits"] == ua.QualifiedName("EngineeringUnits", 0)
    assert found["Definition"] == ua.QualifiedName("Definition", 0)
    assert found["Quality"] == ua.QualifiedName("Quality", SYSTEM)


def test_an_item_tells_its_address_and_run_time_name(nodes: Nodes) -> None:
    owner = f"ns=3;s={PLC}.Temperature/"
    assert nodes.value(owner + "Address") == "VW0"
    assert nodes.value(owner + "RunTimeName") == "MicroWin:2:0.0.0.0:0000:0000,VW0,INT,RW,1000.000,200.000"
    assert nodes.value(owner + "Definition") == "VW0 as INT"
    assert nodes.value(f"ns=3;s={PLC}.Scaled/Definition") == "VW202 as INT, 0..32000 scaled to 0..10"


def test_quality_is_the_da_code_of_the_live_sample(nodes: Nodes) -> None:
    assert nodes.value(f"ns=3;s={PLC}.Temperature/Quality") == 192
    assert nodes.value("ns=3;s=MicroWin.Dead.Value/Quality") == 8
    assert nodes.value(f"ns=3;s={PLC}.Clock/Quality") == 28


def test_a_value_comes_live_from_the_table(nodes: Nodes, gateway: Gateway) -> None:
    row = gateway.find(f"{PLC}.Temperature")
    assert row is not None
    gateway.table.put(row, 321, gateway.now())
    assert nodes.value(f"ns=2;s={PLC}.Temperature") == 321


def test_a_plc_tells_how_it_is(nodes: Nodes) -> None:
    assert nodes.value(f"ns=3;s={PLC}/Connected") is True
    assert nodes.value(f"ns=3;s={PLC}/Mode") == "STOP"
    assert nodes.value(f"ns=3;s={PLC}/ScanTime") == 0.0
    assert nodes.value("ns=3;s=MicroWin.Dead/Connected") is False
    assert nodes.value("ns=3;s=MicroWin.Dead/Mode") == "UNKNOWN"


def test_descriptions_are_those_of_the_project(nodes: Nodes) -> None:
    assert nodes.value(f"ns=2;s={PLC}.Motor", AttributeIds.Description) == ua.LocalizedText("Contactor")
    assert nodes.value(f"ns=2;s={PLC}", AttributeIds.Description) == ua.LocalizedText("The press")


def test_nodes_of_asyncua_are_kept_as_they_are(nodes: Nodes) -> None:
    mine = object()
    nodes.store[standard(ObjectIds.Server)] = mine
    assert nodes.store[standard(ObjectIds.Server)] is mine
    assert standard(ObjectIds.Server) in nodes.store
    assert nodes.store.get(standard(ObjectIds.Server)) is mine
