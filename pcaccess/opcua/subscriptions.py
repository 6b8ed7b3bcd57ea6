"""Subscriptions that gather our items' changes at each publish.

Mended here: publishing intervals were taken as they came and ModifySubscription did nothing.

Source:   OPC UA Part 4, 5.13 Subscription service set.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any, Final

from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.server.address_space import AddressSpace
from asyncua.server.internal_server import InternalServer
from asyncua.server.internal_subscription import InternalSubscription
from asyncua.server.subscription_service import SubscriptionService
from asyncua.ua.status_codes import StatusCodes

from pcaccess.gateway.gateway import Gateway
from pcaccess.opcua.monitors import ItemMonitors
from pcaccess.opcua.space import Space

log = logging.getLogger(__name__)

FASTEST_PUBLISHING: Final = 10.0
SLOWEST_PUBLISHING: Final = 3_600_000.0
"""Milliseconds."""


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
