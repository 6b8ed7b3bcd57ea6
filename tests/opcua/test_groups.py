"""Groups through a real client."""

from __future__ import annotations

import pytest
from asyncua import ua

from tests.gateways import start_gateway

PROJECT = """
project: Test
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: P
        address: 2
        items:
          - {name: A, address: VW0, type: INT}
          - {name: B, address: V10.0, type: BOOL}
          - {name: C, address: VD20, type: REAL, access: R}
groups:
  - {name: Fast, update_rate: 250ms, items: [MicroWin.P.B, MicroWin.P.A, MicroWin.P.C]}
"""
FAST = "ns=3;s=Groups/Fast"


async def test_groups_are_found_by_browsing_and_organise_their_items() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        found = [str(node.nodeid.to_string()) for node in await client.opc.nodes.objects.get_children()]
        assert "ns=3;s=Groups" in found
        children = [str(n.nodeid.to_string()) for n in await client.node(FAST).get_children()]
        assert children[:3] == ["ns=2;s=MicroWin.P.B", "ns=2;s=MicroWin.P.A", "ns=2;s=MicroWin.P.C"]
        assert [n.removeprefix(f"{FAST}/") for n in children[3:]] == [
            "UpdateRate",
            "IsActive",
            "DeadBand",
            "SyncRead",
            "SyncWrite",
        ]


async def test_sync_read_and_write_take_all_items_in_order() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        values = [
            ua.Variant(True, ua.VariantType.Boolean),
            ua.Variant(-5, ua.VariantType.Int16),
            ua.Variant(1.5, ua.VariantType.Float),
        ]
        errors = await client.call(FAST, f"{FAST}/SyncWrite", ua.Variant(values, ua.VariantType.Variant, is_array=True))
        assert [code.name for code in errors] == ["Good", "Good", "BadNotWritable"]
        read, qualities, times, errors = await client.call(
            FAST, f"{FAST}/SyncRead", ua.Variant(2, ua.VariantType.Int32)
        )
        assert [variant.Value if isinstance(variant, ua.Variant) else variant for variant in read] == [True, -5, 0.0]
        assert qualities == [192, 192, 192]
        assert len(times) == 3
        assert [code.name for code in errors] == ["Good", "Good", "Good"]


async def test_one_value_of_the_wrong_type_is_refused_and_the_others_are_written() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        values = [
            ua.Variant(1, ua.VariantType.Int16),
            ua.Variant(7, ua.VariantType.Int16),
            ua.Variant(None, ua.VariantType.Null),
        ]
        errors = await client.call(FAST, f"{FAST}/SyncWrite", ua.Variant(values, ua.VariantType.Variant, is_array=True))
        assert [code.name for code in errors] == ["BadTypeMismatch", "Good", "Good"]
        assert await client.value("ns=2;s=MicroWin.P.A") == 7


async def test_rate_and_flag_can_be_written_within_bounds() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        assert await client.value(f"{FAST}/UpdateRate") == 250.0
        assert await client.put(f"{FAST}/UpdateRate", 500.0) == "Good"
        assert await client.put(f"{FAST}/IsActive", False) == "Good"
        assert await client.put(f"{FAST}/UpdateRate", -1.0) == "BadOutOfRange"
        assert await client.put(f"{FAST}/DeadBand", 101.0) == "BadOutOfRange"
        assert await client.put(f"{FAST}/UpdateRate", 1, ua.VariantType.Int16) == "BadTypeMismatch"
        assert (await client.value(f"{FAST}/UpdateRate"), await client.value(f"{FAST}/IsActive")) == (500.0, False)


async def test_a_setting_can_be_subscribed() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        changes = await client.subscribe(f"{FAST}/IsActive")
        assert (await changes.next()).value is True
        await client.put(f"{FAST}/IsActive", False)
        assert (await changes.next()).value is False


@pytest.mark.parametrize("arguments", [(), (ua.Variant(9, ua.VariantType.Int32),)])
async def test_a_call_with_wrong_arguments_says_so(arguments: tuple[ua.Variant, ...]) -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        with pytest.raises(ua.UaStatusCodeError):
            await client.call(FAST, f"{FAST}/SyncRead", *arguments)


async def test_methods_say_what_they_take_and_give() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        inputs = await client.value(f"{FAST}/SyncRead/InputArguments")
        outputs = await client.value(f"{FAST}/SyncRead/OutputArguments")
        assert [argument.Name for argument in inputs] == ["Source"]
        assert [argument.Name for argument in outputs] == ["Values", "Qualities", "TimeStamps", "Errors"]
