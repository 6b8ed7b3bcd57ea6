"""Sessions: tokens that cannot be guessed, and services that see only what is the session's own.

Mended here (docs/decisions/2026-11-22-asyncua.md): tokens were sequential, and no service asked whose subscription
it was given.

Source:   OPC UA Part 4, 5.6 Session service set, 5.8.5 RegisterNodes, 5.13.7 TransferSubscriptions.
"""

from __future__ import annotations

import dataclasses
import secrets
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.server.internal_session import InternalSession, SessionState
from asyncua.ua.status_codes import StatusCodes

from pcaccess.opcua import limits
from pcaccess.opcua.ids import SYSTEM
from pcaccess.opcua.limits import check_operations
from pcaccess.opcua.registered import Registered
from pcaccess.opcua.views import ContinuationPoints

if TYPE_CHECKING:
    from pcaccess.opcua.asyncua_server import Internal

_Named = TypeVar("_Named", bound=Any)
"""A structure of asyncua with a NodeId field."""


class Session(InternalSession):
    """A client's session (``external``), or the server's own."""

    iserver: Internal

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.points = ContinuationPoints()
        self.channel: object | None = None
        """The connection that activated it last; no other may use it (5.6.3)."""
        self.certificate: bytes | None = None
        """Of the client that made it."""
        self.registered = Registered()
        if self.external:
            self.iserver.unregister_external_session(self)
            self.auth_token = ua.NodeId(ua.ByteString(secrets.token_bytes(32)), ua.Int16(0))
            self.iserver.register_external_session(self)

    @property
    def is_closed(self) -> bool:
        return self.state is SessionState.Closed

    # ------------------------------------------------------------------ Read, Write, Call

    async def read(self, params: ua.ReadParameters) -> list[ua.DataValue]:
        if not self.external:
            return await super().read(params)
        check_operations(params.NodesToRead, limits.MAX_NODES_PER_READ)
        params.NodesToRead = self._resolved(params.NodesToRead)
        return await self.iserver.item_attributes.read_items(params)

    async def write(self, params: ua.WriteParameters) -> list[ua.StatusCode]:
        if self.external:
            check_operations(params.NodesToWrite, limits.MAX_NODES_PER_WRITE)
            params.NodesToWrite = self._resolved(params.NodesToWrite)
        return await super().write(params)

    async def call(self, params: list[ua.CallMethodRequest]) -> list[ua.CallMethodResult]:
        if self.external:
            check_operations(params, limits.MAX_METHODS_PER_CALL)
        return await super().call(params)

    # ------------------------------------------------------------------ View

    async def browse(self, params: ua.BrowseParameters) -> list[ua.BrowseResult]:
        if not self.external:
            return await super().browse(params)
        check_operations(params.NodesToBrowse, limits.MAX_NODES_PER_BROWSE)
        if params.View.ViewId is not None and not params.View.ViewId.is_null():
            raise ServiceError(StatusCodes.BadViewIdUnknown)
        params.NodesToBrowse = self._resolved(params.NodesToBrowse)
        return self.iserver.views.browse_in_portions(params, self.points)

    async def browse_next(self, parameters: ua.BrowseNextParameters) -> list[ua.BrowseResult]:
        check_operations(parameters.ContinuationPoints, limits.MAX_NODES_PER_BROWSE)
        return self.iserver.views.browse_next(parameters, self.points)

    async def translate_browsepaths_to_nodeids(self, params: list[ua.BrowsePath]) -> list[ua.BrowsePathResult]:
        if self.external:
            check_operations(params, limits.MAX_PATHS_PER_TRANSLATE)
        return await super().translate_browsepaths_to_nodeids(params)

    async def register_nodes(self, nodes: list[ua.NodeId]) -> list[ua.NodeId]:
        """A handle of a few bytes for each item; anything else stays as it is."""
        check_operations(nodes, limits.MAX_NODES_PER_REGISTER)
        return [self._register(node) for node in nodes]

    def _register(self, node: ua.NodeId) -> ua.NodeId:
        if self.iserver.space.row(node) is None or len(self.registered) >= limits.MAX_REGISTERED_NODES:
            return node
        number = self.iserver.next_handle()
        self.registered.add(number, node)
        return ua.NodeId(ua.Int32(number), ua.Int16(SYSTEM))

    async def unregister_nodes(self, nodes: list[ua.NodeId]) -> None:
        """Forget handles; whatever is none is passed over (5.8.6)."""
        check_operations(nodes, limits.MAX_NODES_PER_REGISTER)
        self.registered.give_back(number for node in nodes if (number := _handle(node)) is not None)

    def _meant(self, node: ua.NodeId) -> ua.NodeId:
        """What a handle of this session stands for; any other NodeId is itself."""
        number = _handle(node)
        return (None if number is None else self.registered.find(number)) or node

    def _resolved(self, wanted: list[_Named]) -> list[_Named]:
        if not self.registered:
            return wanted
        return [
            w if (node := self._meant(w.NodeId)) is w.NodeId else dataclasses.replace(w, NodeId=node) for w in wanted
        ]

    # ------------------------------------------------------------------ subscriptions

    def _owns(self, subscription_id: int) -> bool:
        subscription = self.subscription_service.subscriptions.get(subscription_id)
        return subscription is not None and subscription.session_id == self.session_id

    def _check_owner(self, subscription_id: int) -> None:
        if self.external and not self._owns(subscription_id):
            raise ServiceError(StatusCodes.BadSubscriptionIdInvalid)

    def _check_items(self, subscription_id: int, operations: Sequence[object] | None) -> None:
        """What every service on monitored items asks first."""
        self._check_owner(subscription_id)
        if self.external:
            check_operations(operations, limits.MAX_MONITORED_ITEMS_PER_CALL)

    async def create_monitored_items(
        self, params: ua.CreateMonitoredItemsParameters
    ) -> list[ua.MonitoredItemCreateResult]:
        self._check_items(params.SubscriptionId, params.ItemsToCreate)
        if self.external and self.registered:
            for item in params.ItemsToCreate:
                (item.ItemToMonitor,) = self._resolved([item.ItemToMonitor])
        return await super().create_monitored_items(params)

    async def modify_monitored_items(
        self, params: ua.ModifyMonitoredItemsParameters
    ) -> list[ua.MonitoredItemModifyResult]:
        self._check_items(params.SubscriptionId, params.ItemsToModify)
        return await super().modify_monitored_items(params)

    async def delete_monitored_items(self, params: ua.DeleteMonitoredItemsParameters) -> list[ua.StatusCode]:
        self._check_items(params.SubscriptionId, params.MonitoredItemIds)
        return await super().delete_monitored_items(params)

    async def set_monitoring_mode(self, params: ua.SetMonitoringModeParameters) -> list[ua.StatusCode]:
        self._check_items(params.SubscriptionId, params.MonitoredItemIds)
        return await super().set_monitoring_mode(params)

    def modify_subscription(self, params: ua.ModifySubscriptionParameters) -> ua.ModifySubscriptionResult:
        self._check_owner(params.SubscriptionId)
        return super().modify_subscription(params)

    async def set_publishing_mode(self, params: ua.SetPublishingModeParameters) -> list[ua.StatusCode]:
        if not self.external:
            return await super().set_publishing_mode(params)
        ids = params.SubscriptionIds
        check_operations(ids, limits.MAX_MONITORED_ITEMS_PER_CALL)
        params.SubscriptionIds = list(dict.fromkeys(i for i in ids if self._owns(i)))
        done = dict(zip(params.SubscriptionIds, await super().set_publishing_mode(params), strict=True))
        return [done.get(i, _invalid_subscription()) for i in ids]

    async def delete_subscriptions(self, ids: list[int]) -> list[ua.StatusCode]:
        if not self.external:
            return await super().delete_subscriptions(ids)
        owned = list(dict.fromkeys(i for i in ids if self._owns(i)))
        done = dict(zip(owned, await super().delete_subscriptions(owned), strict=True))
        return [done.pop(i, _invalid_subscription()) for i in ids]

    def publish(self, acks: Iterable[ua.SubscriptionAcknowledgement] | None = None) -> tuple[int, list[ua.StatusCode]]:
        if not self.external:
            return super().publish(acks)
        own = sum(s.session_id == self.session_id for s in self.subscription_service.subscriptions.values())
        if not own:
            raise ServiceError(StatusCodes.BadNoSubscription)
        results = []
        for ack in acks or ():
            if not self._owns(ack.SubscriptionId):
                results.append(_invalid_subscription())
                continue
            held = self.subscription_service.subscriptions[ack.SubscriptionId]._not_acknowledged_results
            known = held.pop(ack.SequenceNumber, None) is not None
            results.append(ua.StatusCode(ua.UInt32(0 if known else StatusCodes.BadSequenceNumberUnknown)))
        return own, results

    def republish(self, params: ua.RepublishParameters) -> ua.NotificationMessage:
        self._check_owner(params.SubscriptionId)
        held = self.subscription_service.subscriptions[params.SubscriptionId]._not_acknowledged_results
        result: ua.PublishResult | None = held.get(params.RetransmitSequenceNumber)
        if result is None:
            raise ServiceError(StatusCodes.BadMessageNotAvailable)
        message: ua.NotificationMessage = result.NotificationMessage
        return message

    async def transfer_subscriptions(  # type: ignore[override]
        self, params: ua.TransferSubscriptionsParameters, callback: Callable[..., Any]
    ) -> list[ua.TransferResult]:
        """Only a session's own: an anonymous user cannot show that he is the same one (5.13.7)."""
        results = []
        for subscription_id in params.SubscriptionIds:
            if self._owns(subscription_id):
                one = dataclasses.replace(params, SubscriptionIds=[subscription_id])
                results += await super().transfer_subscriptions(one, callback)
            else:
                known = subscription_id in self.subscription_service.subscriptions
                status = StatusCodes.BadUserAccessDenied if known else StatusCodes.BadSubscriptionIdInvalid
                results.append(ua.TransferResult(StatusCode=ua.StatusCode(ua.UInt32(status))))
        return results


def _handle(node: ua.NodeId) -> int | None:
    """The number of what may be a handle."""
    return node.Identifier if node.NamespaceIndex == SYSTEM and isinstance(node.Identifier, int) else None


def _invalid_subscription() -> ua.StatusCode:
    return ua.StatusCode(ua.UInt32(StatusCodes.BadSubscriptionIdInvalid))
