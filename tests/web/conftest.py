"""A web server on a real port, its gateway on a clock that tests move by hand; every answer is held against the
OpenAPI text."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Any

import httpx
import jsonschema
import pytest
from websockets.asyncio.client import ClientConnection, connect

from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.reload import apply_project
from pcaccess.project.load import load_text
from pcaccess.web.openapi import openapi
from pcaccess.web.server import WebServer
from tests.clocks import HandClock

PROJECT = """
project: Test
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: P
        address: 2
        items:
          - {name: Level, address: VW0, type: INT, high: 100, low: 0, unit: cm, description: Tank level}
          - {name: Fixed, address: VW2, type: INT, access: R}
          - {name: On, address: V4.0, type: BOOL}
          - {name: Flow, address: VD8, type: REAL}
          - {name: Text, address: VB100, type: STRING, length: 20}
          - {name: Three, address: "VD200[3]", type: REAL}
          - {name: Secret, address: VW300, type: INT, access: W}
      - name: Away
        address: 3
        connected: false
        items: [{name: Lost, address: VW0, type: INT}]
groups:
  - {name: Fast, update_rate: 250ms, items: [MicroWin.P.Flow, MicroWin.P.Level, MicroWin.P.On]}
"""


class Served:
    """A gateway and its web server, seen from outside."""

    def __init__(self, gateway: Gateway, server: WebServer, clock: HandClock, http: httpx.AsyncClient) -> None:
        self.gateway = gateway
        self.server = server
        self.clock = clock
        self.http = http
        self._described = openapi(server.web.endpoints)

    async def ask(self, method: str, path: str, **more: Any) -> httpx.Response:
        """One request; its answer must be what the OpenAPI text says."""
        response = await self.http.request(method, path, **more)
        self._check(method, response)
        return response

    async def get(self, path: str, **more: Any) -> httpx.Response:
        return await self.ask("GET", path, **more)

    async def json(self, path: str, **more: Any) -> Any:
        """What a good answer holds."""
        response = await self.get(path, **more)
        assert response.status_code == 200, response.text
        return response.json()

    async def value(self, item_id: str) -> Any:
        """Of an item, as the gateway has it."""
        return (await self.json(f"/api/items/{item_id}"))["sample"]["value"]

    def reload(self, text: str) -> None:
        apply_project(self.gateway, load_text(text).project)

    def socket(self, **more: Any) -> connect:
        return connect(f"{self.server.url.replace('http', 'ws')}/ws", **more)

    def _check(self, method: str, response: httpx.Response) -> None:
        path = response.request.url.path
        if method == "HEAD" or "json" not in response.headers["content-type"]:
            return
        shape = next((shape for shape in self._described["paths"] if _fits(shape, path)), None)
        operation = self._described["paths"].get(shape, {}).get(method.lower())
        if operation is None and response.status_code == 200:
            return  # the OpenAPI text itself
        schema: Any = {"$ref": "#/components/schemas/Problem"}
        if operation is not None:
            assert str(response.status_code) in operation["responses"], f"{response.status_code} is not described"
            (content,) = operation["responses"][str(response.status_code)]["content"].values()
            schema = content["schema"]
        jsonschema.validate(response.json(), {**schema, "components": self._described["components"]})


def _fits(shape: str, path: str) -> bool:
    return re.fullmatch(re.sub(r"{\w+}", "[^/]+", shape.replace(".", r"\.")), path) is not None


@asynccontextmanager
async def serve(text: str = PROJECT, **more: Any) -> AsyncIterator[Served]:
    clock = HandClock()
    gateway = Gateway(load_text(text).project, clock)
    gateway.show()
    server = WebServer(gateway, "127.0.0.1:0", **more)
    await server.start()
    async with asyncio.TaskGroup() as tasks, httpx.AsyncClient(base_url=server.url) as http:
        running = tasks.create_task(server.run())
        try:
            yield Served(gateway, server, clock, http)
        finally:
            await server.stop()
            running.cancel()


Serve = Callable[..., AbstractAsyncContextManager[Served]]


@pytest.fixture
def start_web() -> Serve:
    return serve


@pytest.fixture
async def web() -> AsyncIterator[Served]:
    async with serve() as served:
        yield served


async def message(socket: ClientConnection) -> Any:
    """The next one."""
    async with asyncio.timeout(10):
        return json.loads(await socket.recv())


async def tell(socket: ClientConnection, **wanted: Any) -> Any:
    """Send a wish; the answer to it."""
    await socket.send(json.dumps(wanted))
    return await message(socket)
