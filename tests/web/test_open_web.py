"""A web server that the project file opens to the network, asked as from another machine. (Tests listen on none.)"""

from __future__ import annotations

import socket

import httpx
import pytest

from pcaccess.gateway.gateway import Gateway
from pcaccess.project.load import load_text
from pcaccess.web.app import Web, make_web
from tests.clocks import HandClock
from tests.web.conftest import PROJECT

VALUE = "/api/items/MicroWin.P.Level/value"
CHANGES = [
    ("PUT", VALUE, 5),
    ("POST", "/api/write", {"items": [{"id": "MicroWin.P.Level", "value": 5}]}),
    ("POST", "/api/groups/Fast/write", {"values": [None, 5, None]}),
    ("PATCH", "/api/groups/Fast", {"active": False}),
]


def opened(clients: str) -> Web:
    text = f"server: {{web: '0.0.0.0:0', web_clients: {clients}}}\n{PROJECT}"
    gateway = Gateway(load_text(text).project, HandClock())
    gateway.show()
    return make_web(gateway)


def client(web: Web, address: str, host: str = "192.0.2.1:8080") -> httpx.AsyncClient:
    return httpx.AsyncClient(
        transport=httpx.ASGITransport(web.app, client=(address, 4711)),
        base_url="http://gateway",
        headers={"host": host},
    )


async def test_others_may_read_and_only_this_machine_writes() -> None:
    web = opened("anyone may read")
    async with client(web, "192.0.2.7") as other, client(web, "127.0.0.1") as near:
        assert (await other.get(VALUE)).text == "0"
        read = await other.post("/api/read", json={"items": ["MicroWin.P.Level"]})
        assert read.json()["samples"][0]["value"] == 0
        for method, path, body in CHANGES:
            refused = await other.request(method, path, json=body)
            assert (refused.status_code, refused.json()["type"]) == (403, "urn:pcaccess:problem:only-reading")
        assert (await other.get(VALUE)).text == "0"
        for method, path, body in CHANGES:
            assert (await near.request(method, path, json=body)).status_code == 200
        assert (await other.get(VALUE)).text == "5"


async def test_others_may_write_when_the_project_says_so() -> None:
    web = opened("anyone may read and write")
    async with client(web, "192.0.2.7") as other:
        for method, path, body in CHANGES:
            assert (await other.request(method, path, json=body)).status_code == 200


def test_whatever_is_not_reading_is_a_change() -> None:
    endpoints = opened("anyone may read").endpoints
    reading = {(e.method, e.path) for e in endpoints if not e.changes and e.method != "GET"}
    assert reading == {("POST", "/api/read")}
    assert sum(e.changes for e in endpoints) == len(CHANGES)


@pytest.mark.parametrize(
    ("host", "status"),
    [
        ("192.0.2.1:8080", 200),
        ("[2001:db8::1]", 200),
        ("localhost", 200),
        (socket.gethostname().upper(), 200),
        (f"{socket.gethostname()}.local:8080", 200),
        (f"{socket.gethostname()}.evil.example", 421),
        ("evil.example", 421),
    ],
)
async def test_addresses_and_own_names_are_good_hosts(host: str, status: int) -> None:
    async with client(opened("anyone may read"), "192.0.2.7", host) as other:
        assert (await other.get(VALUE)).status_code == status


async def test_pages_of_other_sites_are_refused_all_the_same() -> None:
    async with client(opened("anyone may read and write"), "192.0.2.7") as other:
        answer = await other.put(VALUE, json=5, headers={"origin": "http://evil.example"})
        assert answer.json()["type"] == "urn:pcaccess:problem:cross-site"
