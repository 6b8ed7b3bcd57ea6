"""Websockets: subscriptions, changes, bounds, and clients that are slow."""

from __future__ import annotations

import asyncio
import math
from typing import Any

import numpy as np
import pytest
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from pcaccess.items.quality import Quality
from tests.web.conftest import PROJECT, Serve, Served, message, tell

LEVEL, FLOW, ON = "MicroWin.P.Level", "MicroWin.P.Flow", "MicroWin.P.On"


def put(web: Served, name: str, value: Any) -> None:
    row = web.gateway.find(f"MicroWin.P.{name}")
    assert row is not None
    web.gateway.table.put(row, value, web.gateway.now())


async def subscribe(web: Served, socket: ClientConnection, *items: str, **more: Any) -> Any:
    """Subscribe; what is told first."""
    answer = await tell(socket, op="subscribe", items=list(items), interval_ms=125, **more)
    assert answer["type"] == "subscribed", answer
    return await message(socket)


async def test_a_subscription_begins_with_everything_and_goes_on_with_changes(web: Served) -> None:
    async with web.socket() as socket:
        answer = await tell(socket, op="subscribe", name="tank", items=[LEVEL, FLOW], interval_ms=250)
        assert answer == {
            "type": "subscribed",
            "name": "tank",
            "interval_ms": 250,
            "items": [
                {"n": 0, "id": LEVEL, "type": "INT", "low": 0, "high": 100, "unit": "cm", "access": "RW"},
                {"n": 1, "id": FLOW, "type": "REAL", "low": None, "high": None, "unit": "", "access": "RW"},
            ],
        }
        first = await message(socket)
        assert first == {
            "type": "changes",
            "name": "tank",
            "n": [0, 1],
            "value": [0, 0.0],
            "quality": 192,
            "time": "2026-01-02T03:04:05.000Z",
        }
        await web.clock.advance(1)
        put(web, "Flow", 0.1)
        await web.clock.advance(0.25)
        change = await message(socket)
        assert (change["n"], change["value"], change["time"]) == ([1], [0.1], "2026-01-02T03:04:06.000Z")


async def test_what_is_equal_is_told_once_and_what_differs_in_a_column(web: Served) -> None:
    async with web.socket() as socket:
        await subscribe(web, socket, LEVEL, FLOW, ON, "MicroWin.P.Text", "MicroWin.P.Three")
        put(web, "Level", 1)
        put(web, "Three", [1.5, math.nan, 0.1])
        web.clock.move(0.01)
        put(web, "On", True)
        put(web, "Text", 'a "b"')
        row = web.gateway.find(FLOW)
        web.gateway.table.set_quality(np.array([row]), Quality.COMM_FAILURE, web.gateway.now())
        await web.clock.advance(0.125)
        change = await message(socket)
        at = {n: place for place, n in enumerate(change["n"])}
        assert sorted(at) == [0, 1, 2, 3, 4]
        values = [change["value"][at[n]] for n in range(5)]
        assert values == [1, 0.0, True, 'a "b"', [1.5, "NaN", 0.1]]
        assert [change["quality"][at[n]] for n in range(5)] == [192, 24, 192, 192, 192]
        assert change["time"][at[0]] == "2026-01-02T03:04:05.000Z"
        assert change["time"][at[2]] == "2026-01-02T03:04:05.010Z"


async def test_several_changes_between_two_messages_are_told_as_the_last(web: Served) -> None:
    async with web.socket() as socket:
        await subscribe(web, socket, LEVEL)
        for value in range(1, 6):
            put(web, "Level", value)
        await web.clock.advance(0.125)
        assert (await message(socket))["value"] == [5]
        await web.clock.advance(5)
        put(web, "Level", 9)
        await web.clock.advance(0.125)
        assert (await message(socket))["value"] == [9]  # nothing was sent while nothing changed


async def test_subscriptions_have_names_and_end_one_by_one(web: Served) -> None:
    async with web.socket() as socket:
        await subscribe(web, socket, LEVEL, name="a")
        await subscribe(web, socket, LEVEL, name="b")
        assert web.server.web.sockets.subscriptions == 2
        assert await tell(socket, op="unsubscribe", name="a") == {"type": "unsubscribed", "name": "a"}
        put(web, "Level", 3)
        await web.clock.advance(0.125)
        assert (await message(socket))["name"] == "b"
        assert (await tell(socket, op="unsubscribe", name="a"))["detail"] == "there is no subscription 'a'"
        assert web.server.web.sockets.subscriptions == 1


async def test_a_second_subscription_of_a_name_replaces_the_first(web: Served) -> None:
    async with web.socket() as socket:
        await subscribe(web, socket, LEVEL)
        await subscribe(web, socket, FLOW)
        put(web, "Level", 3)
        put(web, "Flow", 4.0)
        await web.clock.advance(0.125)
        assert (await message(socket))["value"] == [4.0]


async def test_a_group_can_be_subscribed_by_name(web: Served) -> None:
    async with web.socket() as socket:
        answer = await tell(socket, op="subscribe", group="fast")
        assert [item["id"] for item in answer["items"]] == [FLOW, LEVEL, ON]


async def test_unknown_and_hidden_items_are_named_and_the_others_watched(web: Served) -> None:
    async with web.socket() as socket:
        answer = await tell(socket, op="subscribe", items=["Nope", LEVEL, "MicroWin.P.Secret"])
        assert [item.get("problem") for item in answer["items"]] == ["unknown-item", None, "not-readable"]
        assert (await message(socket))["n"] == [1]


async def test_an_empty_subscription_is_one(web: Served) -> None:
    async with web.socket() as socket:
        assert (await tell(socket, op="subscribe", items=[]))["items"] == []
        assert (await tell(socket, op="unsubscribe"))["type"] == "unsubscribed"


async def test_clients_are_told_when_the_project_changes(web: Served) -> None:
    alone = PROJECT[: PROJECT.index("groups:")]
    without = alone.replace("          - {name: Fixed, address: VW2, type: INT, access: R}\n", "")
    async with web.socket() as socket:
        await subscribe(web, socket, LEVEL, "MicroWin.P.Fixed", FLOW)
        web.reload(without)
        await web.clock.advance(0.125)
        assert await message(socket) == {"type": "changes", "name": "", "gone": [1]}
        put(web, "Flow", 2.0)
        await web.clock.advance(0.125)
        assert (await message(socket))["n"] == [2]
        web.reload(alone)
        await web.clock.advance(0.125)
        back = await message(socket)
        assert (back["n"], back["quality"]) == ([1], 192)
        assert "gone" not in back


async def test_a_late_subscriber_is_not_told_of_what_went_before_it_came(web: Served) -> None:
    alone = PROJECT[: PROJECT.index("groups:")]
    async with web.socket() as early, web.socket() as late:
        await subscribe(web, early, LEVEL, "MicroWin.P.Fixed")
        web.reload(alone.replace("          - {name: Fixed, address: VW2, type: INT, access: R}\n", ""))
        await web.clock.advance(0.125)
        assert (await message(early))["gone"] == [1]
        first = await subscribe(web, late, LEVEL, "MicroWin.P.Fixed")
        assert first["n"] == [0]


async def test_a_watched_dynamic_item_stays(web: Served) -> None:
    async with web.socket() as socket:
        await subscribe(web, socket, "2,VB500,BYTE")
        web.clock.move(5000)
        web.gateway.dynamic.sweep()
        assert len(web.gateway.dynamic) == 1
    while len(web.server.web.sockets):
        await web.clock.settle()
    web.clock.move(5000)
    web.gateway.dynamic.sweep()
    assert len(web.gateway.dynamic) == 0


async def test_clients_of_one_list_share_the_bytes(web: Served) -> None:
    async with web.socket() as one, web.socket() as two:
        await subscribe(web, one, LEVEL, FLOW)
        await subscribe(web, two, LEVEL, FLOW, name="other")
        assert web.server.web.sockets.watch([LEVEL, FLOW]) is web.server.web.sockets.watch([LEVEL, FLOW])
        put(web, "Level", 8)
        await web.clock.advance(0.125)
        assert [(await message(s))["value"] for s in (one, two)] == [[8], [8]]


@pytest.mark.parametrize(
    ("wish", "detail"),
    [
        ({"op": "dance"}, "expected op: subscribe or unsubscribe"),
        ({"op": "subscribe"}, "expected either items, a list of item IDs, or group"),
        ({"op": "subscribe", "items": [], "group": "Fast"}, "expected either items, a list of item IDs, or group"),
        ({"op": "subscribe", "items": [1]}, "items: expected a list of item IDs"),
        ({"op": "subscribe", "group": "Slow"}, "there is no group Slow"),
        ({"op": "subscribe", "items": [], "interval_ms": 1}, "interval_ms: expected 50 to 3600000"),
        ({"op": "subscribe", "items": [], "often": 1}, "there is no member 'often' here; expected op, name, items, "),
        ({"op": "subscribe", "items": ["x"] * 50_001}, "a connection watches at most 50000 items"),
    ],
)
async def test_a_wish_that_makes_no_sense_is_answered_and_the_connection_stays(
    web: Served, wish: dict[str, Any], detail: str
) -> None:
    async with web.socket() as socket:
        answer = await tell(socket, **wish)
        assert answer["type"] == "error"
        assert answer["detail"].startswith(detail)
        assert (await tell(socket, op="subscribe", items=[]))["type"] == "subscribed"


async def test_what_is_no_json_is_answered_and_bytes_end_the_connection(web: Served) -> None:
    async with web.socket() as socket:
        await socket.send("hello")
        assert (await message(socket))["detail"].startswith("the body is not JSON")
        await socket.send(b"\x00")
        with pytest.raises(ConnectionClosed) as closed:
            await socket.recv()
        assert closed.value.rcvd is not None
        assert (closed.value.rcvd.code, closed.value.rcvd.reason) == (1003, "send JSON as text")


async def test_a_connection_has_so_many_subscriptions_and_no_more(web: Served) -> None:
    async with web.socket() as socket:
        for n in range(16):
            await subscribe(web, socket, LEVEL, name=str(n))
        assert (await tell(socket, op="subscribe", name="more", items=[LEVEL]))["problem"] == "too-busy"


async def test_so_many_websockets_and_no_more(web: Served) -> None:
    sockets = [await web.socket() for _ in range(64)]
    async with web.socket() as late:
        with pytest.raises(ConnectionClosed) as closed:
            await late.recv()
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.reason == "there are already 64 websockets"
    for socket in sockets:
        await socket.close()


async def test_a_client_that_takes_nothing_is_left_out_then_cut_off_and_others_go_on(start_web: Serve) -> None:
    lines = "\n".join(f"          - {{name: T{n}, address: VB{n * 100}, type: STRING, length: 90}}" for n in range(100))
    text = f"""
links:
  - name: L
    type: soft
    plcs:
      - name: P
        cpu: CPU 226
        items:
{lines}
"""
    async with start_web(text, patience=5) as web, web.socket() as healthy:
        names = [f"L.P.T{n}" for n in range(100)]
        rows = [web.gateway.table.find(name) for name in names]
        reader, writer = await asyncio.open_connection("127.0.0.1", web.server.port)
        writer.write(
            b"GET /ws HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
        )
        await reader.readuntil(b"\r\n\r\n")
        writer.transport.pause_reading()  # type: ignore[attr-defined]
        wish = b'{"op":"subscribe","interval_ms":125,"items":[%s]}' % b",".join(b'"%s"' % n.encode() for n in names)
        writer.write(b"\x81" + bytes([0x80 | 126]) + len(wish).to_bytes(2, "big") + bytes(4) + wish)
        await tell(healthy, op="subscribe", interval_ms=125, items=names[:1])
        await message(healthy)
        while web.server.web.sockets.subscriptions < 2:
            await web.clock.settle()
        told = 0
        while web.server.web.counts.slow == 0:
            told += 1
            assert told < 5000
            for row in rows:
                web.gateway.table.put(row, f"{told:090d}", web.gateway.now())
            await web.clock.advance(0.125)
            assert (await message(healthy))["value"] == [f"{told:090d}"]
        assert web.server.web.sockets.subscriptions == 1
        assert (await web.json("/api/diagnostics"))["web"]["cut_off_slow"] == 1
        writer.close()
