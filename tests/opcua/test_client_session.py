"""A scripted client session: what any OPC UA client may do with a running gateway, over a real connection."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import AsyncIterator
from typing import Any

import pytest
import pytest_asyncio
from asyncua import Client, ua
from asyncua.sync import Client as SyncClient
from asyncua.ua.status_codes import StatusCodes
from asyncua.ua.uaerrors import BadIdentityTokenRejected, BadSessionIdInvalid

from pcaccess.gateway.reload import apply_project
from pcaccess.items.quality import Quality
from pcaccess.opcua.limits import MAX_FRAME
from pcaccess.project.load import load_text
from tests.gateways import PATIENCE, Change, RunningGateway, ScriptedClient, start_gateway

pytestmark = pytest.mark.asyncio(loop_scope="module")

PLANT = """
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: NewPLC
        address: 2
        cpu: CPU 224
        items:
          - {name: Motor, address: Q0.0, type: BOOL, access: RW}
          - {name: Temperature, address: VW0, type: INT, access: RW, high: 1000, low: 200, unit: °C}
          - {name: NewItem, address: VB0, type: BYTE, access: RW}
          - {name: Setpoint, address: VW200, type: INT, access: RW, high: 100, low: 0, write_limits: refuse}
          - {name: Scaled, address: VW202, type: REAL, access: RW, scaling: {raw: [0, 32000], scaled: [0, 10]}}
          - {name: Input, address: I0.1, type: BOOL, access: R}
      - name: PCAccess
        address: 3
        folders: [{name: USR1, items: [{name: COUNTER_1, address: VW0, type: INT, access: RW}]}]
      - {name: Gone, address: 4, connected: false, items: [{name: Value, address: VW0, type: INT, access: RW}]}
"""
PLC = "MicroWin.NewPLC."
Int16, Byte, Boolean, Float = (getattr(ua.VariantType, name) for name in ("Int16", "Byte", "Boolean", "Float"))


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def running() -> AsyncIterator[RunningGateway]:
    """One gateway for the module; each test puts the items that it looks at where it wants them."""
    async with start_gateway(PLANT) as gateway:
        yield gateway


@pytest_asyncio.fixture(loop_scope="module")
async def client(running: RunningGateway) -> AsyncIterator[ScriptedClient]:
    async with running.client() as scripted:
        yield scripted


# -- looking around ------------------------------------------------------------------------------------------------


async def test_the_tree_is_browsed_from_objects_down(client: ScriptedClient) -> None:
    async def below(node: Any) -> dict[str, Any]:
        names = [(await child.read_browse_name(), child) for child in await node.get_children()]
        return {name.Name: await below(child) for name, child in names if name.NamespaceIndex == 2}

    tree = (await below(client.opc.nodes.objects))["MicroWin"]
    assert {name: sorted(children) for name, children in tree.items()} == {
        "NewPLC": ["Input", "Motor", "NewItem", "Scaled", "Setpoint", "Temperature"],
        "PCAccess": ["USR1"],
        "Gone": ["Value"],
    }
    assert list(tree["PCAccess"]["USR1"]) == ["COUNTER_1"]


async def test_a_browse_in_pieces_gives_the_whole(client: ScriptedClient) -> None:
    node = client.node("MicroWin.NewPLC").nodeid
    whole = [child.nodeid for child in await client.node("MicroWin.NewPLC").get_children()]
    wanted = ua.BrowseDescription(NodeId=node, BrowseDirection=ua.BrowseDirection.Forward, ResultMask=ua.UInt32(63))
    asked = ua.BrowseParameters(NodesToBrowse=[wanted], RequestedMaxReferencesPerNode=ua.Counter(2))
    (piece,) = await client.opc.uaclient.browse(asked)
    found = [reference.NodeId for reference in piece.References]
    while piece.ContinuationPoint:
        more = ua.BrowseNextParameters(False, [piece.ContinuationPoint])
        (piece,) = await client.opc.uaclient.browse_next(more)
        assert len(piece.References) <= 2
        found += [reference.NodeId for reference in piece.References]
    assert set(whole) <= set(found)


async def test_the_namespaces_are_where_the_documentation_says(client: ScriptedClient) -> None:
    assert (await client.opc.get_namespace_array())[2:4] == ["urn:pcaccess:items", "urn:pcaccess:system"]


async def test_an_item_tells_its_range_unit_address_and_run_time_name(client: ScriptedClient) -> None:
    properties = await client.node(f"{PLC}Temperature").get_properties()
    values = {(await p.read_browse_name()).Name: await p.read_value() for p in properties}
    assert (values["EURange"].Low, values["EURange"].High) == (200, 1000)
    assert values["EngineeringUnits"].DisplayName.Text == "°C"
    assert values["Address"] == "VW0"
    assert values["RunTimeName"] == "MicroWin:2:0.0.0.0:0000:0000,VW0,INT,RW,1000.000,200.000"
    assert values["Quality"] == 192


# -- reading -------------------------------------------------------------------------------------------------------


async def test_a_synchronous_client_reads_and_writes(running: RunningGateway) -> None:
    def session() -> tuple[Any, Any]:
        with SyncClient(running.url) as blocking:
            node = blocking.get_node(f"ns=2;s={PLC}Temperature")
            node.write_value(321, Int16)
            return node.read_value(), blocking.get_node(f"ns=2;s={PLC}Motor").read_data_type_as_variant_type()

    assert await asyncio.to_thread(session) == (321, Boolean)


async def test_many_reads_at_once_are_each_answered(client: ScriptedClient) -> None:
    await client.write(f"{PLC}Temperature", 258, Int16)
    answers = await asyncio.gather(*(client.read(f"{PLC}{name}") for name in ["Temperature", "NewItem"] * 50))
    assert answers == [Change(258), Change(1)] * 50


async def test_items_over_the_same_bytes_agree_in_one_read(client: ScriptedClient) -> None:
    await client.write(f"{PLC}NewItem", 0x7F, Byte)
    await client.write("ns=2;s=2,VB1,BYTE", 0xFF, Byte)
    values = await client.opc.read_values([client.node(f"{PLC}{name}") for name in ("Temperature", "NewItem")])
    assert values == [0x7FFF, 0x7F]


async def test_every_sample_has_a_source_time_and_it_moves_on(client: ScriptedClient) -> None:
    async def sample() -> ua.DataValue:
        wanted = [ua.ReadValueId(client.node(f"{PLC}Input").nodeid, ua.AttributeIds.Value)]
        (value,) = await client.opc.uaclient.read(ua.ReadParameters(0, ua.TimestampsToReturn.Both, wanted))
        return value

    first = second = await sample()
    while second.SourceTimestamp == first.SourceTimestamp:
        second = await sample()
    assert second.SourceTimestamp > first.SourceTimestamp
    assert second.ServerTimestamp >= second.SourceTimestamp


async def test_names_are_found_in_any_case(client: ScriptedClient) -> None:
    node = client.node("MICROWIN.newplc.MOTOR")
    assert (await node.read_browse_name()).Name == "Motor"
    assert (await node.read_attribute(ua.AttributeIds.NodeId)).Value.Value.Identifier == f"{PLC}Motor"


# -- writing -------------------------------------------------------------------------------------------------------


async def test_a_write_is_in_the_plc_when_it_is_answered(client: ScriptedClient) -> None:
    for value in (-32768, 0, 32767):
        assert await client.write(f"{PLC}Temperature", value, Int16) == StatusCodes.Good
        assert await client.read(f"{PLC}Temperature") == Change(value)


@pytest.mark.parametrize(
    ("item", "value", "kind", "status"),
    [
        ("Input", True, Boolean, StatusCodes.BadNotWritable),
        ("Temperature", 1.5, Float, StatusCodes.BadTypeMismatch),
        ("Temperature", [1, 2], Int16, StatusCodes.BadTypeMismatch),
        ("Setpoint", 101, Int16, StatusCodes.BadOutOfRange),
        ("Scaled", 11.0, Float, StatusCodes.BadOutOfRange),
        ("Nowhere", 1, Int16, StatusCodes.BadNodeIdUnknown),
    ],
)
async def test_a_refused_write_says_why(
    client: ScriptedClient, item: str, value: Any, kind: ua.VariantType, status: int
) -> None:
    assert await client.write(f"{PLC}{item}", value, kind) == status


# -- being told of changes -----------------------------------------------------------------------------------------


async def test_changes_arrive_at_100_ms(client: ScriptedClient) -> None:
    await client.write(f"{PLC}Temperature", 1, Int16)
    changes = await client.subscribe(f"{PLC}Temperature", interval=100)
    assert await changes.next() == Change(1)
    for value in (2, 3):
        await client.write(f"{PLC}Temperature", value, Int16)
        assert await changes.next() == Change(value)
    assert changes.empty()


async def test_a_change_of_a_shared_byte_reaches_every_item_over_it(client: ScriptedClient) -> None:
    await client.write(f"{PLC}Temperature", 0, Int16)
    word, byte = await client.subscribe(f"{PLC}Temperature"), await client.subscribe(f"{PLC}NewItem")
    assert (await word.next(), await byte.next()) == (Change(0), Change(0))
    await client.write(f"{PLC}NewItem", 1, Byte)
    assert (await word.next(), await byte.next()) == (Change(256), Change(1))


async def test_one_clients_write_is_anothers_change(running: RunningGateway, client: ScriptedClient) -> None:
    await client.write(f"{PLC}Motor", False, Boolean)
    changes = await client.subscribe(f"{PLC}Motor")
    assert await changes.next() == Change(False)
    async with running.client() as other:
        await other.write(f"{PLC}Motor", True, Boolean)
    assert await changes.next() == Change(True)


# -- qualities -----------------------------------------------------------------------------------------------------


async def test_an_unconnected_plc_is_not_connected_and_only_it(client: ScriptedClient) -> None:
    assert (await client.read("MicroWin.Gone.Value")).quality is Quality.NOT_CONNECTED
    assert await client.node("ns=3;s=MicroWin.Gone.Value/Quality").read_value() == 8
    assert (await client.read(f"{PLC}Temperature")).quality is Quality.GOOD
    assert await client.write("MicroWin.Gone.Value", 1, Int16) == StatusCodes.BadNotConnected


async def test_a_plc_that_is_lost_keeps_its_last_value_and_time_and_comes_back() -> None:
    def project(connected: str) -> str:
        return PLANT.replace("- name: NewPLC\n", f"- name: NewPLC\n        connected: {connected}\n")

    async with start_gateway(project("true")) as running, running.client() as client:
        await client.write(f"{PLC}Temperature", 250, Int16)
        changes = await client.subscribe(f"{PLC}Temperature")
        neighbour = await client.subscribe("MicroWin.PCAccess.USR1.COUNTER_1")
        assert (await changes.next(), await neighbour.next()) == (Change(250), Change(0))
        apply_project(running.gateway, load_text(project("false")).project)
        lost = await changes.next_value()
        again = await client.read_value(f"{PLC}Temperature")
        assert changes.seen[-1] == Change(250, Quality.NOT_CONNECTED)
        assert (again.Value.Value, again.SourceTimestamp) == (250, lost.SourceTimestamp)
        apply_project(running.gateway, load_text(project("true")).project)
        assert await changes.next() == Change(250)
        assert neighbour.empty()


# -- who may talk --------------------------------------------------------------------------------------------------


async def test_a_wrong_authentication_token_is_refused(client: ScriptedClient) -> None:
    protocol = client.opc.uaclient.protocol
    right = protocol.authentication_token
    protocol.authentication_token = ua.NodeId(b"guessed", 0)
    with pytest.raises(BadSessionIdInvalid):
        await client.read(f"{PLC}Motor")
    protocol.authentication_token = right
    assert (await client.read(f"{PLC}Motor")).quality is Quality.GOOD


async def test_another_clients_token_is_refused(running: RunningGateway, client: ScriptedClient) -> None:
    async with running.client() as other:
        stolen, own = client.opc.uaclient.protocol.authentication_token, other.opc.uaclient.protocol
        right, own.authentication_token = own.authentication_token, stolen
        with pytest.raises(BadSessionIdInvalid):
            await other.write(f"{PLC}Motor", True, Boolean)
        own.authentication_token = right


async def test_nobody_is_an_administrator_by_name(running: RunningGateway) -> None:
    intruder = Client(running.url)
    intruder.set_user("admin")
    intruder.set_password("anything")
    with pytest.raises((BadIdentityTokenRejected, ua.UaError)):
        await intruder.connect()


async def test_a_frame_larger_than_agreed_closes_the_connection_at_once(running: RunningGateway) -> None:
    reader, writer = await asyncio.open_connection("127.0.0.1", running.server.port)
    writer.write(b"MSGF" + struct.pack("<I", MAX_FRAME + 1) + b"x" * 100)
    answer = await asyncio.wait_for(end_of(reader), PATIENCE)
    assert (answer[:4], struct.unpack_from("<I", answer, 8)[0]) == (b"ERRF", ua.StatusCodes.BadTcpMessageTooLarge)
    writer.close()
    async with running.client() as client:
        assert (await client.read(f"{PLC}Motor")).quality is Quality.GOOD


async def end_of(reader: asyncio.StreamReader) -> bytes:
    """What arrives until the connection ends, in order or by a reset."""
    try:
        return await reader.read()
    except ConnectionError:
        return b""


# -- size ----------------------------------------------------------------------------------------------------------


class Awaited:
    """Values that many nodes must reach; ``done`` when the last one did."""

    def __init__(self, wanted: dict[str, int]) -> None:
        self.missing = dict(wanted)
        self.done = asyncio.Event()

    def datachange_notification(self, node: Any, value: Any, data: Any) -> None:
        if self.missing.get(node.nodeid.Identifier) == value:
            del self.missing[node.nodeid.Identifier]
        if not self.missing:
            self.done.set()


async def test_ten_thousand_items_are_browsed_watched_written_and_read() -> None:
    """Two PLCs with 50 folders of 100 items, each item written with its number."""

    def folder(number: int) -> str:
        items = ", ".join(f"{{name: I{i}, address: VW{number * 200 + i * 2}, access: RW}}" for i in range(100))
        return f"{{name: F{number}, items: [{items}]}}"

    plcs = ", ".join(
        f"{{name: {plc}, cpu: CPU 226, folders: [{', '.join(map(folder, range(50)))}]}}" for plc in ("P", "Q")
    )
    text = f"links: [{{name: L, type: soft, plcs: [{plcs}]}}]"
    wanted = {f"L.{plc}.F{f}.I{i}": f * 100 + i for plc in ("P", "Q") for f in range(50) for i in range(100)}
    async with start_gateway(text) as running, running.client() as client:
        nodes = [client.node(name) for name in wanted]
        awaited = Awaited(wanted)
        found = [len(await folder.get_children()) for folder in await client.node("L.P").get_children()]
        assert found[:50] == [100] * 50
        subscription = await client.opc.create_subscription(100, awaited)
        for start in range(0, len(nodes), 1000):
            await subscription.subscribe_data_change(nodes[start : start + 1000])
        variants = [ua.Variant(value, Int16) for value in wanted.values()]
        for start in range(0, len(nodes), 1000):
            await client.opc.write_values(nodes[start : start + 1000], variants[start : start + 1000])
        values = []
        for start in range(0, len(nodes), 1000):
            values += await client.opc.read_values(nodes[start : start + 1000])
        assert values == list(wanted.values())
        await asyncio.wait_for(awaited.done.wait(), PATIENCE)
        assert awaited.missing == {}
