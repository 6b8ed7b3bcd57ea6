"""The OPC UA server of a gateway: start, stop, where it listens."""

from __future__ import annotations

import errno
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

from asyncua import ua

from pcaccess import __version__
from pcaccess.collector import paused
from pcaccess.gateway.gateway import Gateway
from pcaccess.opcua.asyncua_server import GatewayServer
from pcaccess.opcua.gatewaynode import Reload
from pcaccess.opcua.ids import APPLICATION_URI, ITEMS, ITEMS_URI, SYSTEM, SYSTEM_URI

LOOPBACK: Final = ("127.0.0.1", "localhost", "::1")


class EndpointError(Exception):
    """The endpoint cannot be served; the message says which and what to do."""


PLAIN: Final = (ua.SecurityPolicyType.NoSecurity,)
SECURE: Final = (
    ua.SecurityPolicyType.Basic256Sha256_Sign,
    ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt,
)


@dataclass(frozen=True, slots=True)
class Identity:
    """Who the server is to clients that sign and encrypt: files, PEM or DER."""

    certificate: Path
    key: Path
    policies: tuple[ua.SecurityPolicyType, ...] = PLAIN + SECURE
    """What clients may choose from."""


class OpcUaServer:
    """Serves a gateway's items."""

    def __init__(self, gateway: Gateway, endpoint: str | None = None, identity: Identity | None = None) -> None:
        """``endpoint``: ``opc.tcp://127.0.0.1:4840/pcaccess``; port 0 takes a free one.

        Without ``identity`` nothing is signed or encrypted.
        """
        self._gateway = gateway
        self._identity = identity
        self._endpoint = endpoint or gateway.project.server.endpoint
        self._server = GatewayServer(gateway)
        self._port = 0
        gateway.dynamic.hold(self.watched_rows)

    @property
    def url(self) -> str:
        """Where clients find it, with the port that was taken."""
        parts = urlsplit(self._endpoint)
        return parts._replace(netloc=f"{parts.hostname}:{self._port}").geturl()

    @property
    def port(self) -> int:
        return self._port

    def offer_reload(self, reload: Reload) -> None:
        """Let clients call ``Gateway/Reload``."""
        self._server.space.gateway_nodes.reload = reload

    def watched_rows(self) -> set[int]:
        """Rows that clients are subscribed to."""
        return self._server.internal.subscription_service.watched_rows()

    async def start(self) -> None:
        """Listen; raises EndpointError for an endpoint that cannot be used."""
        parts = urlsplit(self._endpoint)
        host, port = parts.hostname or "127.0.0.1", 4840 if parts.port is None else parts.port
        if host not in LOOPBACK:
            raise EndpointError(
                f"{self._endpoint}: only this machine may connect until users and certificates exist; "
                "use opc.tcp://127.0.0.1:4840/pcaccess"
            )
        server = self._server
        if self._identity is not None:
            await self._identify(self._identity)
        server.set_endpoint(self._endpoint)
        with paused():
            await server.init()
        for index, uri in ((ITEMS, ITEMS_URI), (SYSTEM, SYSTEM_URI)):
            if await server.register_namespace(uri) != index:
                raise EndpointError(f"namespace {uri} did not get index {index}")
        await server.set_build_info(
            APPLICATION_URI, "pcaccess", "pcaccess", __version__, __version__, self._gateway.clock.now()
        )
        server.internal.refresh_roots()
        self._gateway.on_structure(self._structure_changed)
        try:
            self._port = await server.listen(host, port)
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise EndpointError(
                    f"port {port} on {host} is in use; stop the other program or choose another port under "
                    "server: endpoint: in the project file"
                ) from None
            raise EndpointError(f"cannot listen on {host}:{port}: {error.strerror}") from None

    async def _identify(self, identity: Identity) -> None:
        server = self._server
        for load, file, what in (
            (server.load_certificate, identity.certificate, "certificate"),
            (server.load_private_key, identity.key, "private key"),
        ):
            try:
                await load(file)
            except (OSError, ValueError, TypeError) as error:
                raise EndpointError(f"{file} cannot be used as the server's {what}: {error}") from None
        server.set_security_policy(list(identity.policies))

    def _structure_changed(self) -> None:
        self._server.space.rebuild()
        self._server.internal.refresh_roots()

    async def stop(self) -> None:
        """Close connections and stop; harmless when it never started."""
        await self._server.stop()
