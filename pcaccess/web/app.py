"""The web application of one gateway: everything that is served on the port."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from starlette.requests import Request
from starlette.routing import Router, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send

from pcaccess.gateway.gateway import Gateway
from pcaccess.web.answers import TEXT_TYPE, Answer, json_answer
from pcaccess.web.catalogue import Catalogue
from pcaccess.web.counts import Counts
from pcaccess.web.endpoints import Endpoint
from pcaccess.web.groups import Groups
from pcaccess.web.guard import Guard
from pcaccess.web.health import Health
from pcaccess.web.items import Items
from pcaccess.web.openapi import openapi
from pcaccess.web.plans import Plans
from pcaccess.web.refusals import Refusal
from pcaccess.web.routes import Routes
from pcaccess.web.shapes import TEXT
from pcaccess.web.sockets import PATIENCE, Sockets

_START: Final = """pcaccess

  /api/items          items, with ?filter=, ?plc=, ?offset=, ?limit=
  /api/groups         groups; /api/groups/NAME.csv for spreadsheets
  /api/diagnostics    how the gateway is doing
  /metrics            the same for Prometheus
  /ws                 websocket: subscriptions
  /openapi.json       all of it, for programs
"""


@dataclass(frozen=True, slots=True)
class Web:
    """The application and what it consists of."""

    app: ASGIApp
    endpoints: list[Endpoint]
    sockets: Sockets
    counts: Counts


def make_web(gateway: Gateway, patience: float = PATIENCE) -> Web:
    """``patience``: seconds a websocket's message may wait for its client."""
    counts = Counts(gateway.clock.now())
    plans, catalogue = Plans(gateway), Catalogue(gateway)
    clients = gateway.project.server.web_clients
    sockets = Sockets(gateway, counts, patience)
    items = Items(gateway, plans, catalogue, counts)
    parts = (items, Groups(gateway, plans, items), Health(gateway, catalogue, sockets, counts))
    endpoints = [endpoint for part in parts for endpoint in part.endpoints()]
    described = openapi(endpoints)

    async def description(request: Request) -> Answer:
        return json_answer(described)

    async def start(request: Request) -> Answer:
        return Answer(_START.encode(), f"{TEXT_TYPE}; charset=utf-8")

    served = [
        *endpoints,
        Endpoint("GET", "/openapi.json", description, "The OpenAPI text", {"type": "object"}),
        Endpoint("GET", "/", start, "Where to begin", TEXT, media_type=TEXT_TYPE),
    ]
    others = Router([WebSocketRoute("/ws", sockets.serve)], redirect_slashes=False, default=_not_served)
    routes = Routes(served, clients, gateway.clock, counts, others)
    return Web(Guard(routes, clients, counts), endpoints, sockets, counts)


async def _not_served(scope: Scope, receive: Receive, send: Send) -> None:
    """Unknown paths."""
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008})
    elif scope["type"] == "http":
        refusal = Refusal("not-found", f"there is nothing at {scope['path'][:200]}; /openapi.json lists what there is")
        await refusal.answer()(scope, receive, send)
