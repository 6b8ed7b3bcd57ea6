"""The client commands against a server that is not pcaccess: stock asyncua, where NodeIds are the names."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio
from asyncua import Server, ua

from pcaccess.cli.failures import Failed
from pcaccess.cli.remote import connect
from tests.cli.conftest import Command, Outcome, invoke

pytestmark = pytest.mark.asyncio(loop_scope="module")


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def url() -> AsyncIterator[str]:
    """Where a server with a folder and a few variables is."""
    server = Server()
    await server.init()
    server.set_endpoint("opc.tcp://127.0.0.1:0/other")
    server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
    index = await server.register_namespace("urn:other")
    plant = await server.nodes.objects.add_folder(ua.NodeId("Plant", index), f"{index}:Plant")
    for name, value, kind in (("Speed", 12.5, ua.VariantType.Double), ("Count", 3, ua.VariantType.Int64)):
        node = await plant.add_variable(ua.NodeId(name, index), f"{index}:{name}", value, kind)
        await node.set_writable()
    await plant.add_variable(ua.NodeId(7, index), f"{index}:Fixed", [True, False], ua.VariantType.Boolean)
    async with server:
        assert server.bserver is not None
        yield f"opc.tcp://127.0.0.1:{server.bserver.port}/other"


@pytest.fixture
def client(url: str, monkeypatch: pytest.MonkeyPatch) -> Command:
    monkeypatch.setenv("PCACCESS_URL", url)

    async def run(*arguments: str) -> Outcome:
        return await asyncio.to_thread(invoke, *arguments)

    return run


async def test_what_is_no_standard_node_is_listed_by_its_node_id(client: Command) -> None:
    outcome = await client("browse", "-r")
    assert [line.split()[:2] for line in outcome.lines[1:]] == [
        ["ns=2;s=Plant", "object"],
        ["ns=2;s=Speed", "Double"],
        ["ns=2;s=Count", "Int64"],
        ["ns=2;i=7", "BOOL"],
    ]


async def test_a_quality_is_derived_from_the_status(client: Command) -> None:
    (speed, fixed) = json.loads((await client("read", "ns=2;s=Speed", "ns=2;i=7", "--json")).out)
    assert (speed["value"], speed["type"], speed["quality"], speed["status"]) == (12.5, "Double", 192, "Good")
    assert (fixed["value"], fixed["type"]) == ([True, False], "BOOL")


async def test_values_of_foreign_types_are_written(client: Command) -> None:
    outcome = await client("write", "ns=2;s=Count", "-5000000000", "ns=2;s=Speed", "1e300", "ns=2;i=7", "true,true")
    assert outcome.lines == ["ns=2;s=Count = -5000000000", "ns=2;s=Speed = 1e+300"]
    assert (outcome.code, outcome.err.count("\n")) == (1, 1)


async def test_a_branch_and_a_pattern_are_watched(client: Command) -> None:
    branch = await client("watch", "ns=2;s=Plant", "--count", "3", "--json")
    pattern = await client("watch", "ns=2;s=S*", "--count", "1", "--json")
    assert {json.loads(line)["id"] for line in branch.lines} == {"ns=2;s=Speed", "ns=2;s=Count", "ns=2;i=7"}
    assert [json.loads(line)["id"] for line in pattern.lines] == ["ns=2;s=Speed"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("read", "MicroWin.NewPLC.Motor"), "this server is not pcaccess; its nodes are named as in ns=2;s=NAME"),
        (("read", "ns=2;s=Nothing"), "there is no item ns=2;s=Nothing"),
        (("watch", "--group", "Fast"), "is not pcaccess and has no groups"),
        (("reload",), "is not pcaccess"),
        (("plc", "start", "ns=2;s=Plant"), "is not pcaccess and has no PLCs"),
        (("plc", "status"), "is not pcaccess and has no PLCs"),
    ],
)
async def test_what_only_pcaccess_has_is_told(client: Command, arguments: tuple[str, ...], words: str) -> None:
    outcome = await client(*arguments)
    assert (outcome.code, outcome.out) == (1, "")
    assert words in outcome.err


async def test_what_is_no_opc_ua_server_is_told() -> None:
    async def hang_up(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.close()

    server = await asyncio.start_server(hang_up, "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    async with server:
        outcome = await asyncio.to_thread(invoke, "read", "i=2258", "--url", f"opc.tcp://127.0.0.1:{port}")
    assert outcome.code == 1
    assert outcome.err.startswith("pcaccess: ")
    assert "pcaccess run" in outcome.err


async def test_a_server_that_never_answers_is_told() -> None:
    async def be_silent(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.read()
        writer.close()

    server = await asyncio.start_server(be_silent, "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    async with server:
        with pytest.raises(Failed) as caught:
            async with connect(f"opc.tcp://127.0.0.1:{port}", patience=0.05):
                pass
    assert "answered like an OPC UA server within 0.05 s" in str(caught.value)
