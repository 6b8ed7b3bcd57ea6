"""The REST client of spreadsheets against our own web server, and against things that are none."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest

from pcaccess.sheet.client import GatewayClient, Gone, Refused, check_gateway
from pcaccess.sheet.entries import SheetError
from tests.web.conftest import serve


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("opc.tcp://127.0.0.1:4840/pcaccess", "is the OPC UA endpoint"),
        ("127.0.0.1:8080", "is not the address of a gateway"),
        ("http://127.0.0.1:8080/api", "is not the address of a gateway"),
        ("http://127.0.0.1:eighty", "expected http://HOST:PORT"),
        ("https://127.0.0.1", "is not the address of a gateway"),
    ],
)
def test_an_address_that_is_none_says_what_is_expected(url: str, said: str) -> None:
    with pytest.raises(SheetError, match=said):
        check_gateway(url)


def test_an_address_loses_its_slash_and_keeps_its_user() -> None:
    assert check_gateway("http://127.0.0.1:8080/") == "http://127.0.0.1:8080"
    assert check_gateway("http://anna:secret@127.0.0.1:8080") == "http://anna:secret@127.0.0.1:8080"


async def test_samples_come_in_order_and_unknown_items_have_an_error() -> None:
    async with serve() as web:
        client = GatewayClient(web.server.url)
        samples = await asyncio.to_thread(client.read, ["MicroWin.P.Flow", "Nope", "MicroWin.P.On"])
        client.close()
    assert [sample.get("value") for sample in samples] == [0.0, None, False]
    assert samples[1]["problem"] == "unknown-item"


async def test_a_refusal_says_what_the_gateway_said() -> None:
    async with serve() as web:
        client = GatewayClient(web.server.url)
        with pytest.raises(Refused, match="there is no item Nope"):
            await asyncio.to_thread(client.get, "/api/items/Nope")
        client.close()


async def test_a_gateway_that_went_away_under_an_open_connection_is_told() -> None:
    async with serve() as web:
        port = web.server.port
        client = GatewayClient(f"http://127.0.0.1:{port}")
        await asyncio.to_thread(client.get, "/api/groups")
    with pytest.raises(Gone, match="does not answer"):
        await asyncio.to_thread(client.get, "/api/groups")
    client.close()


def test_nobody_there_says_what_to_start() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        url = f"http://127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(Gone, match=r"does not answer .*; is `pcaccess run` running there\?"):
            GatewayClient(url).get("/api/groups")


class Strange(BaseHTTPRequestHandler):
    """A web server that is not pcaccess."""

    status = 404

    def do_GET(self) -> None:
        self.send_response(self.status)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(b"<html>hello</html>")

    def log_message(self, *words: object) -> None: ...


@contextlib.contextmanager
def other_server(code: int) -> Iterator[str]:
    handler = type("Other", (Strange,), {"status": code})
    with HTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            thread.join()


@pytest.mark.parametrize(
    ("status", "said"),
    [(200, "not as pcaccess does"), (404, "not as pcaccess does"), (401, "wants a user name and a password")],
)
def test_another_server_is_recognised(status: int, said: str) -> None:
    with other_server(status) as url:
        client = GatewayClient(url)
        with pytest.raises(Refused, match=said):
            client.get("/api/groups")
        client.close()


def test_what_does_not_speak_http_is_recognised() -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()

        def answer() -> None:
            connection, _ = listener.accept()
            with connection:
                connection.recv(1000)
                connection.sendall(b"SSH-2.0-OpenSSH\r\n\r\n")

        thread = threading.Thread(target=answer)
        thread.start()
        client = GatewayClient(f"http://127.0.0.1:{listener.getsockname()[1]}")
        with pytest.raises(Gone, match="not as a web server does"):
            client.get("/api/groups")
        client.close()
        thread.join()


def test_silence_has_an_end() -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        client = GatewayClient(f"http://127.0.0.1:{listener.getsockname()[1]}", timeout=0.05)
        with pytest.raises(Gone, match=r"did not answer within 0\.05 s"):
            client.get("/api/groups")
        client.close()
