"""``/ws``: clients subscribe to items and are sent what changes.

A client sends ``{"op": "subscribe", "name": …, "items": […]}`` or ``{"op": "unsubscribe", "name": …}``, one JSON object
a message; the protocol is told in docs/rest.md. Everything is bounded: connections, subscriptions, items, and how long
a client may take nothing.

One task per interval tells all clients in turn, so that those who watch the same list are told with the same bytes. It
never waits for a client: one that still has unread messages is left out of this turn and told more in the next.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final, Protocol
from weakref import WeakValueDictionary

import orjson
from starlette.websockets import WebSocket, WebSocketDisconnect

from pcaccess.gateway.gateway import Gateway
from pcaccess.web.counts import Counts
from pcaccess.web.endpoints import members, parse_json
from pcaccess.web.refusals import Refusal
from pcaccess.web.watches import Told, Watch

log = logging.getLogger(__name__)

WIRE: Final = "pcaccess.wire"
"""Where a websocket's scope has its :class:`Wire`."""
MAX_CONNECTIONS: Final = 64
MAX_SUBSCRIPTIONS: Final = 16
"""Of one connection."""
MAX_ITEMS: Final = 50_000
"""Of all subscriptions of one connection together."""
MAX_NAME: Final = 100
FASTEST_MS: Final = 50
SLOWEST_MS: Final = 3_600_000
USUAL_MS: Final = 500
PATIENCE: Final = 15.0
"""Seconds that a client may take nothing."""
_TRY_AGAIN_LATER: Final = 1013
_NOT_UNDERSTOOD: Final = 1003


class Wire(Protocol):
    """What the transport below a websocket can say and do."""

    def ready(self) -> bool:
        """The client has taken what was sent before."""

    def tell(self, message: bytes) -> None:
        """Send JSON without waiting; nothing happens when the client is gone."""

    def cut(self, code: int, reason: str) -> None:
        """Say why, as far as the client still takes it, and end the connection at once."""


@dataclass(eq=False, slots=True)
class _Subscription:
    """What one client watches under one name."""

    name: str
    watch: Watch
    interval: float
    """Seconds between messages."""
    connection: _Connection
    told: Told = field(default_factory=Told)

    def message(self) -> bytes | None:
        """What the client does not know yet; None when there is nothing."""
        self.told, changes = self.watch.changes(self.told)
        if changes is None:
            return None
        return b"".join((b'{"type":"changes","name":', orjson.dumps(self.name), b",", changes, b"}"))


class Sockets:
    """All websockets of one gateway. Clients can come and go at any time; they are told while :meth:`run` runs."""

    def __init__(self, gateway: Gateway, counts: Counts, patience: float = PATIENCE) -> None:
        self._gateway = gateway
        self._counts = counts
        self._patience = patience
        self._open: set[_Connection] = set()
        self._watches: WeakValueDictionary[tuple[str, ...], Watch] = WeakValueDictionary()
        self._turns: dict[float, set[_Subscription]] = {}
        """Subscriptions by interval; each interval has its task."""
        self._tasks: asyncio.TaskGroup | None = None
        gateway.dynamic.hold(self.watched_rows)

    def __len__(self) -> int:
        return len(self._open)

    @property
    def subscriptions(self) -> int:
        return sum(len(connection.subscriptions) for connection in self._open)

    def watched_rows(self) -> set[int]:
        """Rows that clients are subscribed to."""
        return {row for c in self._open for s in c.subscriptions.values() for row in s.watch.rows}

    async def serve(self, websocket: WebSocket) -> None:
        """One client, until it goes."""
        await websocket.accept()
        if len(self._open) >= MAX_CONNECTIONS:
            await websocket.close(_TRY_AGAIN_LATER, f"there are already {MAX_CONNECTIONS} websockets")
            return
        connection = _Connection(websocket, websocket.scope[WIRE], self._gateway, self._counts, self)
        self._open.add(connection)
        try:
            await connection.listen()
        except WebSocketDisconnect:
            pass
        finally:
            self._open.discard(connection)
            connection.forget_all()

    def watch(self, item_ids: list[str]) -> Watch:
        """The watch of a list, which clients that ask for the same list share."""
        key = tuple(item_ids)
        watch = self._watches.get(key)
        if watch is None:
            watch = self._watches[key] = Watch(self._gateway, item_ids)
        return watch

    # ------------------------------------------------------------------ telling them

    def start_telling(self, subscription: _Subscription) -> None:
        interval = subscription.interval
        if interval in self._turns:
            self._turns[interval].add(subscription)
            return
        self._turns[interval] = {subscription}
        if self._tasks is not None:
            self._tasks.create_task(self._tell(interval))

    def stop_telling(self, subscription: _Subscription) -> None:
        self._turns.get(subscription.interval, set()).discard(subscription)

    async def run(self) -> None:
        """Tell clients what changes; ends only by cancellation."""
        async with asyncio.TaskGroup() as tasks:
            self._tasks = tasks
            for interval in self._turns:
                tasks.create_task(self._tell(interval))
            await asyncio.get_running_loop().create_future()

    async def _tell(self, interval: float) -> None:
        """Every subscription of one interval, at whole multiples of it, until there is none."""
        clock, turns = self._gateway.clock, self._turns[interval]
        number = 0
        while turns:
            number = max(number, int(clock.monotonic() / interval)) + 1
            await clock.sleep(number * interval - clock.monotonic())
            now = clock.monotonic()
            for subscription in tuple(turns):
                self._tell_one(subscription, now)
        del self._turns[interval]

    def _tell_one(self, subscription: _Subscription, now: float) -> None:
        connection = subscription.connection
        if connection.is_ready(now):
            message = subscription.message()
            if message is not None:
                connection.tell(message)
        elif now - connection.waiting_since > self._patience:
            log.warning("a websocket was cut off: its client took nothing for %g s", self._patience)
            self._counts.slow += 1
            connection.forget_all()
            connection.cut("you do not take what you subscribed to")


class _Connection:
    """One client and what it watches."""

    def __init__(self, websocket: WebSocket, wire: Wire, gateway: Gateway, counts: Counts, sockets: Sockets) -> None:
        self.subscriptions: dict[str, _Subscription] = {}
        self.waiting_since = 0.0
        """Monotonic time since when the client has taken nothing."""
        self._waiting = False
        self._websocket = websocket
        self._wire = wire
        self._gateway = gateway
        self._counts = counts
        self._sockets = sockets
        self._operations: dict[str, Callable[[dict[str, Any]], dict[str, Any]]] = {
            "subscribe": self._subscribe,
            "unsubscribe": self._unsubscribe,
        }

    def is_ready(self, now: float) -> bool:
        """Whether the client has taken what it was sent."""
        ready = self._wire.ready()
        if not ready and not self._waiting:
            self.waiting_since = now
        self._waiting = not ready
        return ready

    def cut(self, reason: str) -> None:
        self._wire.cut(_TRY_AGAIN_LATER, reason)

    def tell(self, message: bytes) -> None:
        """Send a message; to a client that just went it is lost, and whoever listens to it learns of that."""
        self._wire.tell(message)
        self._counts.messages += 1
        self._counts.bytes_sent += len(message)

    async def listen(self) -> None:
        """Do what the client asks until it goes."""
        while True:
            message = await self._websocket.receive()
            if message["type"] == "websocket.disconnect":
                return
            text = message.get("text")
            if text is None:
                await self._websocket.close(_NOT_UNDERSTOOD, "send JSON as text")
                return
            # Waits for a client that asks and does not read.
            await self._websocket.send_text(orjson.dumps(self._answer(text)).decode())
            for subscription in self.subscriptions.values():
                if subscription.told == Told():  # new, and the client knows of it now
                    first = subscription.message()
                    if first is not None:
                        self.tell(first)
                    self._sockets.start_telling(subscription)

    def forget_all(self) -> None:
        for name in tuple(self.subscriptions):
            self._forget(name)

    def _forget(self, name: str) -> None:
        subscription = self.subscriptions.pop(name, None)
        if subscription is not None:
            self._sockets.stop_telling(subscription)

    # ------------------------------------------------------------------ what clients ask

    def _answer(self, text: str) -> dict[str, Any]:
        try:
            wanted = parse_json(text.encode())
            operation = self._operations.get(str(wanted.get("op"))) if isinstance(wanted, dict) else None
            if operation is None:
                raise Refusal("bad-request", f"expected op: {' or '.join(self._operations)}")
            return operation(wanted)
        except Refusal as refusal:
            return {"type": "error", **refusal.more, "problem": refusal.kind, "detail": str(refusal)}

    def _subscribe(self, wanted: dict[str, Any]) -> dict[str, Any]:
        given = members(wanted, op=str, name=str, items=list, group=str, interval_ms=(int, float))
        name, interval = given.get("name", ""), given.get("interval_ms", USUAL_MS)
        if len(name) > MAX_NAME:
            raise Refusal("bad-request", f"a name has at most {MAX_NAME} characters")
        if not FASTEST_MS <= interval <= SLOWEST_MS:
            raise Refusal("bad-request", f"interval_ms: expected {FASTEST_MS} to {SLOWEST_MS}", name=name)
        item_ids = self._wanted_items(given)
        others = [s for s in self.subscriptions.values() if s.name != name]
        if len(others) >= MAX_SUBSCRIPTIONS:
            raise Refusal("too-busy", f"a connection has at most {MAX_SUBSCRIPTIONS} subscriptions", name=name)
        if sum(len(s.watch) for s in others) + len(item_ids) > MAX_ITEMS:
            raise Refusal("too-busy", f"a connection watches at most {MAX_ITEMS} items", name=name)
        self._forget(name)
        watch = self._sockets.watch(item_ids)
        self.subscriptions[name] = _Subscription(name, watch, interval / 1000, self)
        return {"type": "subscribed", "name": name, "interval_ms": interval, "items": watch.described()}

    def _wanted_items(self, given: dict[str, Any]) -> list[str]:
        if ("items" in given) == ("group" in given):
            raise Refusal("bad-request", "expected either items, a list of item IDs, or group")
        if "group" in given:
            group = self._gateway.group(given["group"])
            if group is None:
                raise Refusal("unknown-group", f"there is no group {given['group'][:200]}")
            return list(group.items)
        items: list[str] = given["items"]
        if not all(isinstance(item_id, str) for item_id in items):
            raise Refusal("bad-request", "items: expected a list of item IDs")
        return items

    def _unsubscribe(self, wanted: dict[str, Any]) -> dict[str, Any]:
        name = members(wanted, op=str, name=str).get("name", "")
        if name not in self.subscriptions:
            raise Refusal("bad-request", f"there is no subscription {name[:MAX_NAME]!r}", name=name[:MAX_NAME])
        self._forget(name)
        return {"type": "unsubscribed", "name": name}
