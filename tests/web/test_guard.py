"""Who may ask: programs of this machine and our own pages."""

from __future__ import annotations

import asyncio

import pytest
from websockets.exceptions import InvalidStatus

from tests.web.conftest import Served

VALUE = "/api/items/MicroWin.P.Level/value"


@pytest.mark.parametrize("host", ["127.0.0.1:9999", "localhost", "LOCALHOST:80", "[::1]:8080", "[::1]", "127.1.2.3"])
async def test_this_machine_has_several_names(web: Served, host: str) -> None:
    assert (await web.get("/api/groups", headers={"host": host})).status_code == 200


@pytest.mark.parametrize(
    "host",
    ["plant.example", "192.0.2.1:8080", "localhost.evil.example", "127.0.0.1.evil.example:80", "127.0.0.1:x", ""],
)
async def test_a_name_that_is_not_this_machine_is_refused(web: Served, host: str) -> None:
    response = await web.ask("PUT", VALUE, content=b"1", headers={"host": host})
    assert response.status_code == 421
    assert await web.value("MicroWin.P.Level") == 0


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "http://127.0.0.1:1"},
        {"origin": "null"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site"},
        {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"},
    ],
    ids=str,
)
async def test_pages_of_other_sites_can_neither_read_nor_write(web: Served, headers: dict[str, str]) -> None:
    for method, path, body in [("GET", "/api/items", b""), ("PUT", VALUE, b"1"), ("POST", "/api/write", b"{}")]:
        response = await web.ask(method, path, content=body, headers=headers)
        assert (response.status_code, response.json()["type"]) == (403, "urn:pcaccess:problem:cross-site")
    assert await web.value("MicroWin.P.Level") == 0


async def test_our_own_pages_may_ask(web: Served) -> None:
    headers = {"origin": web.server.url, "sec-fetch-site": "same-origin"}
    assert (await web.ask("PUT", VALUE, content=b"1", headers=headers)).status_code == 200
    link = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"}
    assert (await web.get("/", headers=link)).status_code == 200


async def test_nobody_gets_permission_to_ask_across_origins(web: Served) -> None:
    for method in ("GET", "OPTIONS"):
        response = await web.ask(method, "/api/items", headers={"access-control-request-method": "PUT"})
        assert not [name for name in response.headers if name.startswith("access-control")]
        assert response.headers["cross-origin-resource-policy"] == "same-origin"


@pytest.mark.parametrize("headers", [{"Origin": "http://evil.example"}, {"Sec-Fetch-Site": "cross-site"}], ids=str)
async def test_a_page_of_another_site_gets_no_websocket(web: Served, headers: dict[str, str]) -> None:
    with pytest.raises(InvalidStatus, match="403"):
        async with web.socket(additional_headers=headers):
            pass
    assert len(web.server.web.sockets) == 0


async def test_getting_never_writes(web: Served) -> None:
    for path in (f"{VALUE}?value=5", "/api/write", "/api/groups/Fast/write"):
        for method in ("GET", "HEAD"):
            await web.ask(method, path)
    assert await web.value("MicroWin.P.Level") == 0


@pytest.mark.parametrize("content_type", ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data", ""])
async def test_what_a_form_could_send_is_no_json(web: Served, content_type: str) -> None:
    headers = {"content-type": content_type} if content_type else {}
    for path in ("/api/write", "/api/read"):
        response = await web.ask("POST", path, content=b'{"items":[]}', headers=headers)
        assert response.status_code == 415


async def test_a_body_that_is_too_long_is_refused_before_it_is_stored(web: Served) -> None:
    headers = {"content-type": "application/json"}
    response = await web.ask("POST", "/api/read", content=b" " * 9_000_000, headers=headers)
    assert response.status_code == 413

    async def chunks():
        for _ in range(200):
            yield b" " * 65536

    response = await web.ask("POST", "/api/read", content=chunks(), headers=headers)
    assert response.status_code == 413


async def test_a_head_without_end_is_cut_off(web: Served) -> None:
    reader, writer = await asyncio.open_connection("127.0.0.1", web.server.port)
    writer.write(b"GET / HTTP/1.1\r\n")
    try:
        for n in range(1000):
            writer.write(b"X-%d: %s\r\n" % (n, b"x" * 1000))
            await writer.drain()
    except ConnectionError:
        pass
    answer = await asyncio.wait_for(_rest(reader), 20)
    assert answer == b"" or b" 400 " in answer.splitlines()[0]
    writer.close()
    assert (await web.get("/api/groups")).status_code == 200


async def _rest(reader: asyncio.StreamReader) -> bytes:
    try:
        return await reader.read()
    except ConnectionError:
        return b""


async def test_unknown_paths_and_methods_are_told_as_problems(web: Served) -> None:
    assert (await web.get("/api/nothing")).json()["status"] == 404
    response = await web.ask("DELETE", VALUE)
    assert (response.status_code, response.headers["allow"]) == (405, "GET, HEAD, PUT")
    assert (await web.ask("HEAD", "/api/groups")).text == ""


async def test_what_was_refused_is_counted(web: Served) -> None:
    await web.get("/api/items", headers={"origin": "http://evil.example"})
    assert (await web.json("/api/diagnostics"))["web"]["refused"] == {"cross-site": 1}
