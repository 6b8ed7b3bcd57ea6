"""A gateway with its OPC UA server on a free port of the loopback, and a scripted client that talks to it."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from asyncua import Client, ua

from pcaccess.clock import Clock, SystemClock
from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.reload import apply_project
from pcaccess.items.quality import Quality, from_status
from pcaccess.opcua.server import OpcUaServer
from pcaccess.project.load import load_project, load_text

PATIENCE: Final = 40.0
"""Seconds that only a failing test waits; a machine with other work to do needs some of them."""


@dataclass(frozen=True)
class Change:
    """What a client was told of an item."""

    value: Any
    quality: Quality = Quality.GOOD


class Changes:
    """Notifications of one subscription to one node, in order of arrival."""

    def __init__(self) -> None:
        self._queue: asyncio.Queue[ua.DataValue] = asyncio.Queue()
        self.seen: list[Change] = []

    def datachange_notification(self, node: Any, value: Any, data: Any) -> None:
        self._queue.put_nowait(data.monitored_item.Value)

    async def next(self) -> Change:
        return change(await self.next_value())

    async def next_value(self) -> ua.DataValue:
        """The next notification with its times."""
        try:
            value = await asyncio.wait_for(self._queue.get(), PATIENCE)
        except TimeoutError:
            raise AssertionError(f"no further change; so far: {self.seen}") from None
        self.seen.append(change(value))
        return value

    async def until(self, wanted: Change) -> None:
        """Skip what comes before a change."""
        while await self.next() != wanted:
            pass

    def empty(self) -> bool:
        return self._queue.empty()


def change(value: ua.DataValue) -> Change:
    status = value.StatusCode.value if value.StatusCode is not None else 0
    return Change(value.Value.Value if value.Value is not None else None, from_status(status)[0])


class ScriptedClient:
    """asyncua's client with the words that tests use. Nodes: item IDs, or NodeIds such as ``i=2253``."""

    def __init__(self, client: Client) -> None:
        self.opc = client

    def node(self, name: str) -> Any:
        return self.opc.get_node(name if "=" in name else f"ns=2;s={name}")

    async def read_value(self, name: str) -> ua.DataValue:
        return await self.node(name).read_data_value(raise_on_bad_status=False)

    async def read(self, name: str) -> Change:
        return change(await self.read_value(name))

    async def write(self, name: str, value: Any, kind: ua.VariantType) -> int:
        """Write and give the StatusCode."""
        written = ua.DataValue(ua.Variant(value, kind, is_array=isinstance(value, list)))
        params = ua.WriteParameters([ua.WriteValue(self.node(name).nodeid, ua.AttributeIds.Value, None, written)])
        (status,) = await self.opc.uaclient.write(params)
        return status.value

    async def value(self, name: str) -> Any:
        return (await self.read(name)).value

    async def status(self, name: str) -> str:
        """Name of the StatusCode of a read."""
        code = (await self.read_value(name)).StatusCode
        return code.name if code is not None else "Good"

    async def put(self, name: str, value: Any, kind: ua.VariantType | None = None) -> str:
        """Write, as the node's own type unless another is given, and give the StatusCode's name."""
        if kind is None:
            kind = await self.node(name).read_data_type_as_variant_type()
        return ua.StatusCode(ua.UInt32(await self.write(name, value, kind))).name

    async def call(self, owner: str, method: str, *arguments: Any) -> Any:
        return await self.node(owner).call_method(self.node(method).nodeid, *arguments)

    async def subscribe(self, name: str, interval: float = 100) -> Changes:
        """Changes of a node, published every ``interval`` milliseconds."""
        changes = Changes()
        subscription = await self.opc.create_subscription(interval, changes)
        await subscription.subscribe_data_change(self.node(name))
        return changes


@dataclass(frozen=True)
class RunningGateway:
    gateway: Gateway
    server: OpcUaServer

    @property
    def url(self) -> str:
        return self.server.url

    @asynccontextmanager
    async def client(self) -> AsyncIterator[ScriptedClient]:
        async with Client(self.url, timeout=PATIENCE, watchdog_intervall=PATIENCE) as client:
            yield ScriptedClient(client)

    def reload(self, text: str) -> None:
        """Apply another project text."""
        apply_project(self.gateway, load_text(text).project)

    def reload_file(self, path: Path) -> None:
        """Apply a project file that was saved."""
        apply_project(self.gateway, load_project(path).project)

    def cut(self, station: str) -> None:
        """The PLC ``Link.PLC`` is lost."""
        self.gateway.lost(station, Quality.NOT_CONNECTED)


StartGateway = Callable[..., AbstractAsyncContextManager[RunningGateway]]


@asynccontextmanager
async def start_gateway(
    project: str | Path, clock: Clock | None = None, base: Path | None = None, port: int = 0
) -> AsyncIterator[RunningGateway]:
    """Serve a project (a text or a file) until the block ends. Tasks end with it; a fault of theirs fails the test."""
    loaded = load_project(project) if isinstance(project, Path) else load_text(project, base=base)
    gateway = Gateway(loaded.project, clock or SystemClock())
    gateway.show()
    server = OpcUaServer(gateway, f"opc.tcp://127.0.0.1:{port}/test")
    await server.start()
    # Not "async with": it would wrap a failed assertion of the test in an ExceptionGroup.
    tasks = asyncio.TaskGroup()
    await tasks.__aenter__()
    running = tasks.create_task(gateway.run())
    try:
        yield RunningGateway(gateway, server)
    finally:
        await server.stop()
        running.cancel()
        await tasks.__aexit__(None, None, None)
