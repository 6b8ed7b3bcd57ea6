"""Run-time names as NodeIds, and a project that changes under its clients."""

from __future__ import annotations

from tests.gateways import Change, start_gateway

PROJECT = """
project: Test
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: P
        address: 2
        cpu: CPU 224
        items:
          - {name: Temperature, address: VW0, type: INT, access: RW, high: 1000, low: 200}
          - {name: Other, address: VW2, type: INT}
"""
ITEM = "ns=2;s=MicroWin.P.Temperature"
RUN_TIME_NAME = "ns=2;s=MicroWin:2:0.0.0.0:0000:0000,VW0,INT,RW,1000.000,200.000"


async def test_the_run_time_name_property_used_as_a_node_is_the_same_item() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        assert f"ns=2;s={await client.value('ns=3;s=MicroWin.P.Temperature/RunTimeName')}" == RUN_TIME_NAME
        assert await client.put(RUN_TIME_NAME, 300) == "Good"
        assert await client.value(ITEM) == 300
        assert (await client.node(RUN_TIME_NAME).read_browse_name()).Name == "Temperature"


async def test_reading_writing_and_subscribing_each_make_the_item_they_name() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        assert await client.value("ns=2;s=2,QB0,byte") == 0
        assert await client.put("ns=2;s=2,VB100,BYTE", 200) == "Good"
        changes = await client.subscribe("ns=2;s=MicroWin:2:0.0.0.0:0000:0000,VW100,WORD,RW")
        assert await changes.next() == Change(200 << 8)
        await client.put("ns=2;s=2,vb101,byte", 1)
        assert await changes.next() == Change((200 << 8) + 1)


async def test_nonsense_stays_unknown() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        for name in ("2,VB99999,BYTE", "7,VB0,BYTE", "MicroWin.P.Nothing", "2,,"):
            assert await client.status(f"ns=2;s={name}") == "BadNodeIdUnknown"


async def test_dynamic_items_have_the_attributes_of_items() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        node = client.node("ns=2;s=2,VW50,INT,R,100,0")
        assert (await node.read_attribute(17)).Value.Value == 1  # AccessLevel
        assert await client.value("ns=3;s=2,VW50,INT,R,100,0/Address") == "VW50"
        assert await client.put("ns=2;s=2,VW50,INT,R,100,0", 1) == "BadNotWritable"


async def test_after_a_reload_new_items_are_there_removed_ones_unknown_and_subscriptions_go_on() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        kept = await client.subscribe(ITEM)
        lost = await client.subscribe("ns=2;s=MicroWin.P.Other")
        assert await kept.next() == Change(0)
        assert await lost.next() == Change(0)
        running.reload(PROJECT.replace("Other, address: VW2", "New, address: VW4"))
        assert await client.status("ns=2;s=MicroWin.P.New") == "Good"
        assert await client.status("ns=2;s=MicroWin.P.Other") == "BadNodeIdUnknown"
        gone = await lost.next_value()
        assert gone.StatusCode is not None
        assert gone.StatusCode.name == "BadNodeIdUnknown"
        await client.put(ITEM, 250)
        assert await kept.next() == Change(250)
        assert kept.empty()
        running.reload(PROJECT)
        assert await lost.next() == Change(0)


async def test_browsing_follows_a_reload() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        running.reload(PROJECT.replace("name: MicroWin", "name: Another"))
        children = [str(n.nodeid.to_string()) for n in await client.opc.nodes.objects.get_children()]
        assert "ns=2;s=Another" in children
        assert "ns=2;s=MicroWin" not in children
