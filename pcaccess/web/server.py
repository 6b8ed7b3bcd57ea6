"""The web server of a gateway: its port, its start and stop. HTTP itself is uvicorn's, in the gateway's own loop.

uvicorn's own start is not used: it would exit the process when the port is taken, and install signal handlers.
"""

from __future__ import annotations

import errno
import logging
import socket
from typing import Final

import uvicorn
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.protocol import State

from pcaccess.gateway.gateway import Gateway
from pcaccess.project.network import DEFAULT_WEB, NetworkError, check_web, is_loopback
from pcaccess.web.app import Web, make_web
from pcaccess.web.guard import MAX_BODY
from pcaccess.web.sockets import PATIENCE, WIRE

log = logging.getLogger(__name__)

MAX_HEAD: Final = 64 * 1024
"""Bytes of request line and headers; a list of 1,000 item IDs in a query fits."""
MAX_CONNECTIONS: Final = 256
EVERYWHERE: Final = "0.0.0.0"
"""All addresses of this machine."""
_KEEP_ALIVE: Final = 30
_GRACE: Final = 2
"""Seconds that a stop waits for answers under way."""


class WebError(Exception):
    """The address cannot be served; the message says which and what to do."""


class BoundedHttp(HttpToolsProtocol):
    """uvicorn's HTTP with a bound on the head of a request."""

    _head = 0

    def on_message_begin(self) -> None:
        self._head = 1
        super().on_message_begin()

    def on_headers_complete(self) -> None:
        self._head = 0
        super().on_headers_complete()

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        if self._head:
            self._head += len(data)
            if self._head > MAX_HEAD:
                self.send_400_response(f"The head of a request has at most {MAX_HEAD} bytes.")


class TellingWebSocket(WebSocketsSansIOProtocol):
    """uvicorn's websocket as a :class:`Wire`: what thousands of messages are told over, and the end of slow clients."""

    async def run_asgi(self) -> None:
        self.scope[WIRE] = self  # type: ignore[typeddict-unknown-key]
        await super().run_asgi()

    def ready(self) -> bool:
        return self.writable.is_set()

    def tell(self, message: bytes) -> None:
        if self.conn.state is State.OPEN and not self.transport.is_closing():
            self.conn.send_text(message)
            self.transport.write(b"".join(self.conn.data_to_send()))

    def cut(self, code: int, reason: str) -> None:
        if self.conn.state is State.OPEN:
            self.conn.send_close(code, reason)
            self.transport.write(b"".join(self.conn.data_to_send()))
        self.transport.abort()


class WebServer:
    """Serves a gateway over HTTP. ``listen``: ``127.0.0.1:8080``; port 0 takes a free one."""

    def __init__(self, gateway: Gateway, listen: str | None = None, patience: float = PATIENCE) -> None:
        self._listen = listen or gateway.project.server.web or DEFAULT_WEB
        self._clients = gateway.project.server.web_clients
        self.web: Web = make_web(gateway, patience)
        self._socket: socket.socket | None = None
        config = uvicorn.Config(
            self.web.app,
            http=BoundedHttp,
            ws=TellingWebSocket,
            ws_max_size=MAX_BODY,
            ws_per_message_deflate=False,  # on loopback it only costs time
            lifespan="off",
            log_config=None,
            access_log=False,
            proxy_headers=False,
            server_header=False,
            date_header=False,  # it would need uvicorn's own loop, ten wake-ups a second
            limit_concurrency=MAX_CONNECTIONS,
            timeout_keep_alive=_KEEP_ALIVE,
            timeout_graceful_shutdown=_GRACE,
        )
        self._server = uvicorn.Server(config)

    @property
    def port(self) -> int:
        return int(self._socket.getsockname()[1]) if self._socket is not None else 0

    @property
    def url(self) -> str:
        """Where clients find it, with the port that was taken."""
        host = self._listen.rpartition(":")[0]
        return f"http://{socket.gethostname() if host == EVERYWHERE else host}:{self.port}"

    async def start(self) -> None:
        """Listen; raises WebError for an address that cannot be used."""
        listener = self._bind()
        config = self._server.config
        config.load()
        self._server.lifespan = config.lifespan_class(config)
        self._server.server_state.default_headers = []
        await self._server.startup(sockets=[listener])
        self._socket = listener
        if not is_loopback(listener.getsockname()[0]):
            log.warning("%s is open to the network, without passwords or encryption: %s", self.url, self._clients.value)
        # What uvicorn says of single requests is for its developers.
        logging.getLogger("uvicorn.error").setLevel(logging.ERROR)

    async def run(self) -> None:
        """Tell websocket clients what changes; ends only by cancellation."""
        await self.web.sockets.run()

    def _bind(self) -> socket.socket:
        try:
            checked = check_web(self._listen, self._clients)
        except NetworkError as error:
            raise WebError(str(error)) from None
        host, _, port = (checked or DEFAULT_WEB).rpartition(":")
        address = "127.0.0.1" if host == "localhost" else host
        listener = socket.socket(
            socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP
        )  # named, or asyncio leaves Nagle on
        try:
            if hasattr(socket, "SO_EXCLUSIVEADDRUSE"):  # Windows would let two programs share the port
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
            else:
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind((address, int(port)))
            listener.listen(128)
        except OSError as error:
            listener.close()
            if error.errno == errno.EADDRINUSE:
                raise WebError(
                    f"port {port} on {host} is in use; stop the other program, or choose another port under "
                    "server: web: in the project file (web: off does without)"
                ) from None
            raise WebError(f"cannot listen on {host}:{port}: {error.strerror}") from None
        listener.setblocking(False)
        return listener

    async def stop(self) -> None:
        """Close connections and stop; harmless when it never started."""
        if self._socket is not None:
            listener, self._socket = self._socket, None
            await self._server.shutdown(sockets=[listener])
