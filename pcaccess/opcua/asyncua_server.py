"""asyncua's server made of our parts: sessions, views, subscriptions, attributes and connections of our own.

What of asyncua is touched is in ``internals``. Mended on the way (docs/decisions/2026-11-22-asyncua.md): any password
made an administrator; a stop waited up to a second for a clock.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
from typing import Any, Final

from asyncua import ua
from asyncua.crypto.permission_rules import User, UserRole
from asyncua.server.binary_server_asyncio import BinaryServer, OPCUAProtocol
from asyncua.server.internal_server import InternalServer
from asyncua.server.internal_session import InternalSession
from asyncua.server.server import Server
from asyncua.server.user_managers import UserManager
from asyncua.ua.object_ids import ObjectIds

from pcaccess.gateway.gateway import Gateway
from pcaccess.opcua.attributes import ItemAttributes
from pcaccess.opcua.connection import Connection, Limits
from pcaccess.opcua.fast.plane import DataPlane
from pcaccess.opcua.ids import APPLICATION_URI, standard
from pcaccess.opcua.limits import MAX_CONNECTIONS, PUBLISHED
from pcaccess.opcua.nodestore import OURS, NodeStore
from pcaccess.opcua.sessions import Session
from pcaccess.opcua.space import Space
from pcaccess.opcua.subscriptions import Subscriptions
from pcaccess.opcua.views import Views

_ANONYMOUS: Final = User(role=UserRole.Anonymous)


class AnonymousOnly(UserManager):
    """Until users exist, everybody on this machine is an ordinary user and nobody an administrator."""

    def get_user(
        self,
        iserver: InternalServer,
        username: str | None = None,
        password: str | None = None,
        certificate: Any = None,
    ) -> User | None:
        return User(role=UserRole.User) if username is None else None


class Internal(InternalServer):
    """asyncua's internal server over our space."""

    def __init__(self, space: Space, gateway: Gateway) -> None:
        super().__init__(user_manager=AnonymousOnly())
        self.allow_remote_admin = False
        self.supported_tokens = (ua.AnonymousIdentityToken,)  # type: ignore[assignment]
        self.max_connections = MAX_CONNECTIONS
        self.space = space
        self.nodes = NodeStore(space)
        self.aspace._nodes = self.nodes
        self.item_attributes = ItemAttributes(self.aspace, space, gateway)
        self.attribute_service = self.item_attributes
        self.views = Views(self.aspace, self.nodes)
        self.view_service = self.views
        self.subscription_service: Subscriptions = Subscriptions(self.aspace, self, space, gateway)
        self.isession.subscription_service = self.subscription_service
        self.plane = DataPlane(gateway, space)
        self._handles = itertools.count(1)

    def create_session(
        self,
        name: str,
        user: User = _ANONYMOUS,
        external: bool = False,
    ) -> InternalSession:
        return Session(self, self.aspace, self.subscription_service, name, user=user, external=external)

    def session_of(self, token: ua.NodeId) -> Session | None:
        """The client's session of that AuthenticationToken."""
        session = self.lookup_external_session(token)
        return session if isinstance(session, Session) else None

    def next_handle(self) -> int:
        """A number for a registered node. None comes twice: a handle of one session means nothing in another."""
        return next(self._handles)

    def refresh_roots(self) -> None:
        """Hang the links of the project, as it is now, under Objects."""
        objects = self.nodes[standard(ObjectIds.ObjectsFolder)]
        objects.references = [r for r in objects.references if r.NodeId.NamespaceIndex not in OURS]
        objects.references += [d for root in self.space.roots() if (d := self.nodes.describe(root))]

    async def publish_limits(self) -> None:
        """Tell clients what ``limits`` enforces."""
        for number, value in PUBLISHED.items():
            await self.write_attribute_value(standard(number), ua.DataValue(value))

    async def stop(self) -> None:
        if self.time_task is not None:
            self.time_task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self.time_task
            self.time_task = None
        for session in list(self._external_sessions.values()):
            await session.close_session(True)
        await super().stop()


class Listener(BinaryServer):
    """The socket server with our protocol class."""

    def _make_protocol(self) -> OPCUAProtocol:
        return Connection(
            iserver=self.iserver,
            policies=self._policies,
            clients=self.clients,
            closing_tasks=self.closing_tasks,
            limits=self.limits,
        )


class GatewayServer(Server):
    """asyncua's server made of the classes above."""

    def __init__(self, gateway: Gateway) -> None:
        self.space = Space(gateway)
        self.internal = Internal(self.space, gateway)
        super().__init__(iserver=self.internal)
        self._application_uri = APPLICATION_URI
        self.product_uri = APPLICATION_URI
        self.name = "pcaccess"
        self.manufacturer_name = "pcaccess"
        self.application_type = ua.ApplicationType.Server
        self.limits = Limits()
        self.set_security_policy([ua.SecurityPolicyType.NoSecurity])

    async def listen(self, host: str, port: int) -> int:
        """Bind and serve; returns the port, which the system chooses when ``port`` is 0. Raises OSError."""
        self.bserver = Listener(self.internal, host, port, self.limits)
        await self.bserver.start()
        self.set_endpoint(self.endpoint._replace(netloc=f"{host}:{self.bserver.port}").geturl())
        await self.internal.publish_limits()
        await self._setup_server_nodes()
        self.bserver.set_policies(self._policies)
        await self.internal.start()
        return int(self.bserver.port)
