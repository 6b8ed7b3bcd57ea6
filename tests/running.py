"""A gateway that really runs, on a free loopback port, and real clients of it.

async with running_gateway(TEXT) as running, running.client() as client:
    changes = await client.subscribe("ns=2;s=MicroWin.P.A")
    assert await changes.next() == (0, Quality.GOOD)
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asyncua import Client, ua

from pcaccess.clock import SystemClock
from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.reload import apply_project
from pcaccess.items.quality import Quality, from_status
from pcaccess.opcua.server import OpcUaServer
from pcaccess.project import diff
from pcaccess.project.load import load_project, load_text

PATIENCE = 40.0
"""Seconds that only a failing test waits; a machine with other work to do needs some of them."""


class Changes:
    """What a subscription reported, in order."""

    def __init__(self) -> None:
        self._queue: asyncio.Queue[ua.DataValue] = asyncio.Queue()

    def datachange_notification(self, _node: Any, _value: Any, data: Any) -> None:
        """Called by asyncua."""
        self._queue.put_nowait(data.monitored_item.Value)

    async def next_value(self) -> ua.DataValue:
        """The next notification, whole."""
        try:
            return await asyncio.wait_for(self._queue.get(), PATIENCE)
        except TimeoutError:
            raise AssertionError(f"no further change within {PATIENCE:g} s") from None

    async def next(self) -> tuple[Any, Quality]:
        """Value and quality of the next notification."""
        change = await self.next_value()
        return plain(change), quality_of(change)

    def empty(self) -> bool:
        return self._queue.empty()


def plain(value: ua.DataValue) -> Any:
    return value.Value.Value if value.Value is not None else None


def quality_of(value: ua.DataValue) -> Quality:
    return from_status(value.StatusCode.value if value.StatusCode else 0)[0]


class TestClient:
    """asyncua's client with the few calls that tests make."""

    __test__ = False

    def __init__(self, client: Client) -> None:
        self.ua = client

    def node(self, node_id: str) -> Any:
        return self.ua.get_node(node_id)

    async def read(self, node_id: str) -> ua.DataValue:
        """The whole DataValue, whatever its status."""
        value: ua.DataValue = await self.node(node_id).read_data_value(raise_on_bad_status=False)
        return value

    async def value(self, node_id: str) -> Any:
        return plain(await self.read(node_id))

    async def status(self, node_id: str) -> str:
        """Name of the StatusCode of a read."""
        code = (await self.read(node_id)).StatusCode
        return code.name if code is not None else "Good"

    async def write(self, node_id: str, value: Any, kind: ua.VariantType | None = None) -> str:
        """Write and return the name of the StatusCode; ``kind`` is the node's own type unless given."""
        if kind is None:
            kind = await self.node(node_id).read_data_type_as_variant_type()
        target = ua.WriteValue()
        target.NodeId, target.AttributeId = self.node(node_id).nodeid, ua.AttributeIds.Value
        target.Value = ua.DataValue(ua.Variant(value, kind, is_array=isinstance(value, list)))
        answer = await self.ua.uaclient.write(ua.WriteParameters(NodesToWrite=[target]))
        return str(answer[0].name)

    async def subscribe(self, *node_ids: str, interval: float = 20.0, **options: Any) -> Changes:
        """Subscribe to values; ``options`` go to asyncua's ``subscribe_data_change``."""
        changes = Changes()
        subscription = await self.ua.create_subscription(interval, changes)
        await subscription.subscribe_data_change([self.node(n) for n in node_ids], **options)
        return changes

    async def call(self, owner: str, method: str, *arguments: Any) -> Any:
        return await self.node(owner).call_method(self.node(method).nodeid, *arguments)


@dataclass(slots=True)
class Running:
    """The running gateway."""

    gateway: Gateway
    server: OpcUaServer

    @property
    def url(self) -> str:
        return self.server.url

    @asynccontextmanager
    async def client(self) -> AsyncIterator[TestClient]:
        async with Client(self.url, timeout=PATIENCE, watchdog_intervall=PATIENCE) as client:
            yield TestClient(client)

    def reload(self, text: str) -> diff.Changes:
        """Apply another project text."""
        return apply_project(self.gateway, load_text(text).project)

    def reload_file(self, path: Path) -> diff.Changes:
        """Apply a project file that was saved."""
        return apply_project(self.gateway, load_project(path).project)


@asynccontextmanager
async def running_gateway(project: str | Path) -> AsyncIterator[Running]:
    """Run a project (text, or the path of a file) until the block ends."""
    loaded = load_project(project) if isinstance(project, Path) else load_text(project)
    gateway = Gateway(loaded.project, SystemClock())
    gateway.show()
    server = OpcUaServer(gateway, "opc.tcp://127.0.0.1:0/pcaccess")
    await server.start()
    async with asyncio.TaskGroup() as tasks:
        running = tasks.create_task(gateway.run())
        try:
            yield Running(gateway, server)
        finally:
            await server.stop()
            running.cancel()


def names(references: Sequence[Any]) -> list[str]:
    """Browse names, for comparing."""
    return [reference.BrowseName.Name for reference in references]
