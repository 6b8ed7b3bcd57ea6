"""asyncua's server classes with our parts in them: the one module that reaches into asyncua.

Every internal of asyncua that the gateway relies on is named in ``INTERNALS``; ``tests/opcua/test_asyncua_contract.py``
checks each, so that a new asyncua version fails there and nowhere else.

Mended on the way (stock asyncua 2.1, docs/decisions/2026-11-22-asyncua.md): any password made an administrator;
a request's AuthenticationToken was not compared with its session's, and tokens could be guessed; a frame of any
declared size was buffered before anyone had logged in; publishing intervals were taken as they came.
"""

from __future__ import annotations

import asyncio
import logging
import secrets
from collections.abc import Callable
from typing import Any, Final

from asyncua import ua
from asyncua.common.connection import TransportLimits
from asyncua.common.utils import ServiceError
from asyncua.crypto.permission_rules import User, UserRole
from asyncua.server.address_space import AddressSpace, ViewService
from asyncua.server.binary_server_asyncio import BinaryServer, OPCUAProtocol
from asyncua.server.internal_server import InternalServer
from asyncua.server.internal_session import InternalSession
from asyncua.server.internal_subscription import InternalSubscription
from asyncua.server.server import Server
from asyncua.server.subscription_service import SubscriptionService
from asyncua.server.uaprocessor import UaProcessor
from asyncua.server.user_managers import UserManager
from asyncua.ua.object_ids import ObjectIds
from asyncua.ua.status_codes import StatusCodes

from pcaccess.gateway.gateway import Gateway
from pcaccess.opcua.attributes import ItemAttributes
from pcaccess.opcua.ids import APPLICATION_URI, standard
from pcaccess.opcua.monitors import ItemMonitors
from pcaccess.opcua.nodestore import OURS, NodeStore
from pcaccess.opcua.space import Space

log = logging.getLogger(__name__)

INTERNALS: Final = (
    (InternalServer, "__init__ create_session lookup_external_session register_external_session stop time_task"),
    (InternalSession, "auth_token read create_subscription is_activated activate_session"),
    (AddressSpace, "_nodes read_attribute_value"),
    (ViewService, "_suitable_reftype _get_sub_ref _browse"),
    (SubscriptionService, "create_subscription modify_subscription subscriptions _sub_id_counter"),
    (InternalSubscription, "has_published_results _subscription_loop _triggered_datachanges monitored_item_srv"),
    (UaProcessor, "_process_message _connection session set_policies"),
    (OPCUAProtocol, "connection_made data_received _buffer processor"),
    (BinaryServer, "_make_protocol start stop"),
)
"""Class and the names of it that this package overrides, calls or reads."""

MAX_FRAME: Final = 65_535
"""Bytes of one chunk. Clients learn it from Acknowledge; whoever sends more is cut off before it is buffered."""
MAX_MESSAGE: Final = 16 * 1024 * 1024
FASTEST_PUBLISHING: Final = 10.0
SLOWEST_PUBLISHING: Final = 3_600_000.0
"""Milliseconds."""
MAX_CONNECTIONS: Final = 200

_ANONYMOUS: Final = User(role=UserRole.Anonymous)
_SESSIONLESS: Final = frozenset(
    standard(number)
    for number in (
        ObjectIds.CreateSessionRequest_Encoding_DefaultBinary,
        ObjectIds.ActivateSessionRequest_Encoding_DefaultBinary,
        ObjectIds.FindServersRequest_Encoding_DefaultBinary,
        ObjectIds.GetEndpointsRequest_Encoding_DefaultBinary,
        ObjectIds.RegisterServerRequest_Encoding_DefaultBinary,
        ObjectIds.RegisterServer2Request_Encoding_DefaultBinary,
        ObjectIds.CloseSecureChannelRequest_Encoding_DefaultBinary,
    )
)
"""Services that carry no AuthenticationToken of an active session."""


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


class Session(InternalSession):
    """A session whose token cannot be guessed."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        if self.external:
            self.iserver.unregister_external_session(self)
            self.auth_token = ua.NodeId(ua.ByteString(secrets.token_bytes(32)), ua.Int16(0))
            self.iserver.register_external_session(self)

    async def read(self, params: ua.ReadParameters) -> list[ua.DataValue]:
        service = self.iserver.attribute_service
        if self.external and isinstance(service, ItemAttributes):
            return await service.read_items(params)
        return await super().read(params)


class Views(ViewService):
    """asyncua's view service with the sub-type test remembered: it walked the type tree once per reference."""

    def __init__(self, aspace: AddressSpace) -> None:
        super().__init__(aspace)
        self._suitable: dict[tuple[ua.NodeId, ua.NodeId, bool], bool] = {}

    def _suitable_reftype(self, ref1: ua.NodeId, ref2: ua.NodeId, subtypes: bool) -> bool:
        key = (ref1, ref2, subtypes)
        known = self._suitable.get(key)
        if known is None:
            if len(self._suitable) > 1000:
                self._suitable.clear()
            known = self._suitable[key] = super()._suitable_reftype(ref1, ref2, subtypes)
        return known

    def _browse(self, desc: ua.BrowseDescription) -> ua.BrowseResult:
        if desc.NodeId not in self._aspace:
            return ua.BrowseResult(StatusCode=ua.StatusCode(ua.UInt32(StatusCodes.BadNodeIdUnknown)))
        return super()._browse(desc)


class Subscription(InternalSubscription):
    """A subscription that gathers our items' changes at each publish."""

    def __init__(self, *arguments: Any, space: Space, gateway: Gateway, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._clock = gateway.clock
        self.monitored_item_srv: ItemMonitors = ItemMonitors(self, self.monitored_item_srv.aspace, space, gateway)

    async def _subscription_loop(self) -> None:
        """As asyncua's, but the interval may change while it runs, and lost time is not made up in a burst."""
        due = self._clock.monotonic()
        try:
            await self.publish_results()
            while not self._closing:
                due = max(due + self.data.RevisedPublishingInterval / 1000, self._clock.monotonic())
                await self._clock.sleep(due - self._clock.monotonic())
                await self.publish_results()
        except Exception:
            # asyncua keeps this task in a drawer and never looks: without this line a fault here is silence.
            log.exception("subscription %s ended", self.data.SubscriptionId)
            raise

    def has_published_results(self) -> bool:
        if self._publishing_enabled:
            for item, notification in self.monitored_item_srv.collect():
                self._triggered_datachanges.setdefault(item, []).append(notification)
        return super().has_published_results()


class Subscriptions(SubscriptionService):
    """Makes our subscriptions."""

    def __init__(self, aspace: AddressSpace, iserver: InternalServer, space: Space, gateway: Gateway) -> None:
        super().__init__(aspace, iserver=iserver)
        self._space = space
        self._gateway = gateway

    async def create_subscription(
        self,
        params: ua.CreateSubscriptionParameters,
        callback: Callable[..., Any],
        session_id: ua.NodeId,
        request_callback: Callable[..., Any] | None = None,
    ) -> ua.CreateSubscriptionResult:
        server = self.iserver
        if server is None or len(self.subscriptions) >= server.max_subscriptions:
            raise ServiceError(StatusCodes.BadTooManySubscriptions)
        self._sub_id_counter += 1
        result = ua.CreateSubscriptionResult(
            SubscriptionId=ua.IntegerId(self._sub_id_counter),
            RevisedPublishingInterval=revise_publishing(params.RequestedPublishingInterval),
            RevisedLifetimeCount=ua.Counter(self._clamp_lifetime_count(params.RequestedLifetimeCount)),
            RevisedMaxKeepAliveCount=ua.Counter(self._clamp_keep_alive_count(params.RequestedMaxKeepAliveCount)),
        )
        subscription = Subscription(
            result,
            self.aspace,
            callback,
            session_id,
            request_callback=request_callback,
            delete_callback=lambda: self.subscriptions.pop(result.SubscriptionId, None),
            no_acks_limit=server.max_unacked_messages_per_subscription,
            max_queue_size=server.max_monitored_item_queue_size,
            publishing_enabled=params.PublishingEnabled,
            space=self._space,
            gateway=self._gateway,
        )
        await subscription.start()
        self.subscriptions[result.SubscriptionId] = subscription
        return result

    def modify_subscription(self, params: ua.ModifySubscriptionParameters) -> ua.ModifySubscriptionResult:
        subscription = self.subscriptions.get(params.SubscriptionId)
        if subscription is None:
            raise ServiceError(StatusCodes.BadSubscriptionIdInvalid)
        data = subscription.data
        data.RevisedPublishingInterval = revise_publishing(params.RequestedPublishingInterval)
        data.RevisedLifetimeCount = ua.Counter(self._clamp_lifetime_count(params.RequestedLifetimeCount))
        data.RevisedMaxKeepAliveCount = ua.Counter(self._clamp_keep_alive_count(params.RequestedMaxKeepAliveCount))
        return ua.ModifySubscriptionResult(
            data.RevisedPublishingInterval, data.RevisedLifetimeCount, data.RevisedMaxKeepAliveCount
        )

    def watched_rows(self) -> set[int]:
        """Rows that any client is subscribed to."""
        rows: set[int] = set()
        for subscription in self.subscriptions.values():
            if isinstance(subscription, Subscription):
                rows.update(subscription.monitored_item_srv.watched_rows())
        return rows


def revise_publishing(asked: float) -> ua.Duration:
    """Milliseconds between publishes: what was asked for, within our bounds (0 asks for the fastest)."""
    if not asked > 0:
        return ua.Duration(FASTEST_PUBLISHING)
    return ua.Duration(min(max(float(asked), FASTEST_PUBLISHING), SLOWEST_PUBLISHING))


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
        self.attribute_service = ItemAttributes(self.aspace, space, gateway)
        self.view_service = Views(self.aspace)
        self.subscription_service: Subscriptions = Subscriptions(self.aspace, self, space, gateway)
        self.isession.subscription_service = self.subscription_service

    def create_session(
        self,
        name: str,
        user: User = _ANONYMOUS,
        external: bool = False,
    ) -> InternalSession:
        return Session(self, self.aspace, self.subscription_service, name, user=user, external=external)

    async def stop(self) -> None:
        """As asyncua's, but without waiting until its clock has slept out its second."""
        if self.time_task is not None:
            self.time_task.cancel()
            await asyncio.wait([self.time_task])
            self.time_task = None
        await super().stop()

    def refresh_roots(self) -> None:
        """Hang the links of the project, as it is now, under Objects."""
        objects = self.nodes[standard(ObjectIds.ObjectsFolder)]
        objects.references = [r for r in objects.references if r.NodeId.NamespaceIndex not in OURS]
        objects.references += [d for root in self.space.roots() if (d := self.nodes.describe(root))]


class Processor(UaProcessor):
    """Checks every request's AuthenticationToken against the session of its channel."""

    async def _process_message(self, typeid: Any, requesthdr: Any, seqhdr: Any, body: Any) -> Any:
        if (
            self.session is not None
            and typeid not in _SESSIONLESS
            and requesthdr.AuthenticationToken != self.session.auth_token
        ):
            raise ServiceError(StatusCodes.BadSessionIdInvalid)
        return await super()._process_message(typeid, requesthdr, seqhdr, body)


class Protocol(OPCUAProtocol):
    """One connection; refuses frames larger than agreed before they are buffered."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        if self.processor is not None:
            self.processor = Processor(self.iserver, self.transport, self.limits)
            self.processor.set_policies(self.policies)

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        if len(self._buffer) >= 8:
            declared = int.from_bytes(self._buffer[4:8], "little")
            if declared > MAX_FRAME:
                log.warning("%s sent a frame of %d bytes; closing the connection", self.peer_name, declared)
                self._buffer = b""
                if self.transport is not None:
                    self.transport.abort()


class Listener(BinaryServer):
    """The socket server with our protocol class."""

    def _make_protocol(self) -> OPCUAProtocol:
        return Protocol(
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
        self.limits = TransportLimits(MAX_FRAME, MAX_FRAME, MAX_MESSAGE // MAX_FRAME + 1, MAX_MESSAGE)
        self.set_security_policy([ua.SecurityPolicyType.NoSecurity])

    async def listen(self, host: str, port: int) -> int:
        """Bind and serve; returns the port, which the system chooses when ``port`` is 0. Raises OSError."""
        self.bserver = Listener(self.internal, host, port, self.limits)
        await self.bserver.start()
        self.set_endpoint(self.endpoint._replace(netloc=f"{host}:{self.bserver.port}").geturl())
        await self._setup_server_nodes()
        self.bserver.set_policies(self._policies)
        await self.internal.start()
        return int(self.bserver.port)
