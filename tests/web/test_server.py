"""Start and stop, the port, and two gateways in one process."""

from __future__ import annotations

import socket

import httpx
import pytest
from websockets.exceptions import ConnectionClosed

from pcaccess.gateway.gateway import Gateway
from pcaccess.project.load import load_text
from pcaccess.web.server import WebError, WebServer
from tests.clocks import HandClock
from tests.web.conftest import PROJECT, Serve, message, tell


def server(listen: str) -> WebServer:
    return WebServer(Gateway(load_text(PROJECT).project, HandClock()), listen)


async def test_a_port_in_use_says_which_and_what_to_do() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(WebError) as failed:
            await server(f"127.0.0.1:{port}").start()
    assert str(failed.value) == (
        f"port {port} on 127.0.0.1 is in use; stop the other program, or choose another port under server: web: in "
        "the project file (web: off does without)"
    )


@pytest.mark.parametrize("listen", ["0.0.0.0:0", "192.0.2.1:8080", "plant.example:80"])
async def test_it_does_not_listen_beyond_this_machine(listen: str) -> None:
    with pytest.raises(WebError, match="open to everybody on the network"):
        await server(listen).start()


async def test_localhost_is_this_machine() -> None:
    one = server("localhost:0")
    await one.start()
    async with httpx.AsyncClient() as http:
        assert (await http.get(f"http://127.0.0.1:{one.port}/")).status_code == 200
    assert one.url == f"http://localhost:{one.port}"
    await one.stop()


async def test_after_a_stop_the_port_is_free_again(start_web: Serve) -> None:
    async with start_web() as web:
        port = web.server.port
        await web.get("/api/items")
    again = server(f"127.0.0.1:{port}")
    await again.start()
    await again.stop()
    await again.stop()


async def test_websocket_clients_are_told_that_it_stops(start_web: Serve) -> None:
    async with start_web() as web:
        socket = await web.socket()
        await tell(socket, op="subscribe", group="Fast")
        await message(socket)
    with pytest.raises(ConnectionClosed) as closed:
        await socket.recv()
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 1012


async def test_two_gateways_in_one_process_do_not_know_each_other(start_web: Serve) -> None:
    async with start_web() as one, start_web() as other:
        await one.ask("PUT", "/api/items/MicroWin.P.Level/value", json=5)
        assert (await one.value("MicroWin.P.Level"), await other.value("MicroWin.P.Level")) == (5, 0)
        assert (await other.json("/api/diagnostics"))["web"]["written"] == {}
