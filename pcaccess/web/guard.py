"""Who may ask: this machine's own programs and our own pages, nobody else's pages.

A browser would let any page send requests to 127.0.0.1. So the Host header must name this machine (a foreign name
that resolves to 127.0.0.1 is DNS rebinding), an Origin must be ours, and what the browser itself calls cross-site is
refused. Answers carry no CORS permission. Where the project file opens the server to the network, this machine's names
there and any address are good hosts too: no page can make an address lead elsewhere.

Source:   RFC 9110 (Host, 421), RFC 6454 (Origin), W3C Fetch Metadata (Sec-Fetch-Site).
"""

from __future__ import annotations

import socket
from functools import cache
from typing import Final

from starlette.types import ASGIApp, Receive, Scope, Send

from pcaccess.project.network import WebClients, is_address, is_loopback
from pcaccess.web.counts import Counts
from pcaccess.web.refusals import Refusal

MAX_BODY: Final = 8 * 1024 * 1024
"""Bytes; a write of 50,000 items has about half of it."""
_OWN_SITES: Final = (b"same-origin", b"none")
_PAGES: Final = ("/api", "/ws", "/metrics", "/openapi.json")
"""Below these there are no pages: nobody is led there by a link."""
_REMEMBERED: Final = 64


class Guard:
    """Stands before the application; refuses what must not come in."""

    def __init__(self, app: ASGIApp, clients: WebClients, counts: Counts) -> None:
        self._app = app
        self._open = clients is not WebClients.THIS_MACHINE
        self._counts = counts
        self._good_hosts: set[bytes] = set()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if refusal is None:
            await self._app(scope, receive, send)
            return
        self._counts.refused[refusal.kind] += 1
        if scope["type"] == "websocket":
            # Before the handshake is accepted, closing it is answered with 403.
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": str(refusal)})
        else:
            await refusal.answer()(scope, receive, send)

    def _refusal(self, scope: Scope) -> Refusal | None:
        host, origin, site, mode, length = b"", b"", b"", b"", b""
        for name, value in scope["headers"]:
            if name == b"host":
                host = value
            elif name == b"origin":
                origin = value
            elif name == b"sec-fetch-site":
                site = value
            elif name == b"sec-fetch-mode":
                mode = value
            elif name == b"content-length":
                length = value
        if host not in self._good_hosts and not self._is_good_host(host):
            named = host.decode("latin-1") or "nothing"
            names = "an address or the name of this machine" if self._open else "127.0.0.1 or localhost"
            return Refusal("wrong-host", f"the request names the host {named}; use {names}")
        if origin and origin.lower().partition(b"://")[2] != host.lower():
            return Refusal("cross-site", f"the request comes from a page of {origin.decode('latin-1')}")
        if site and site not in _OWN_SITES and not (mode == b"navigate" and _is_page(scope)):
            return Refusal("cross-site", "the browser says that a page of another site sent this request")
        if length and int(length) > MAX_BODY:
            return Refusal("too-large", f"{int(length)} bytes; at most {MAX_BODY} are taken")
        return None

    def _is_good_host(self, host: bytes) -> bool:
        name, _, port = host.decode("latin-1").rpartition(":")
        if not name or name.endswith(":") or "]" in port:  # no port, or the colons of an IPv6 address
            name = host.decode("latin-1")
        elif not port.isdecimal():
            return False
        plain = name.removeprefix("[").removesuffix("]")
        good = is_loopback(plain) or (self._open and (is_address(plain) or plain.lower() in _own_names()))
        if good and len(self._good_hosts) < _REMEMBERED:
            self._good_hosts.add(host)
        return good


def _is_page(scope: Scope) -> bool:
    return scope["type"] == "http" and scope["method"] == "GET" and not scope["path"].startswith(_PAGES)


@cache
def _own_names() -> frozenset[str]:
    """What this machine is called on the network, as far as it knows without asking others."""
    name = socket.gethostname().lower()
    return frozenset({name, f"{name}.local"})
