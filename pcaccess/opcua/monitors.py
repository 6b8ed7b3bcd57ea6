"""Monitored items on our nodes: what changed since the last publish is found by comparing row counters.

A plain item (its value, no dead band, queue of one) costs one integer comparison per publish, all of them in one
NumPy expression. Queues, dead bands and other attributes are sampled one by one (:class:`Sampled`).

Source:   OPC UA Part 4, 5.12 MonitoredItem service set and 7.22 monitoring filters (dead bands compare with the value
          last reported, so that a slow ramp does report).
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from asyncua import ua
from asyncua.server.address_space import AddressSpace
from asyncua.server.internal_subscription import InternalSubscription
from asyncua.server.monitored_item_service import MonitoredItemService
from asyncua.ua.attribute_ids import AttributeIds
from asyncua.ua.status_codes import StatusCodes
from numpy.typing import NDArray

from pcaccess.gateway.gateway import Gateway
from pcaccess.items.rowset import Rows
from pcaccess.opcua.attributes import with_times
from pcaccess.opcua.nodestore import OURS
from pcaccess.opcua.ranges import RangeError, parse_range, take_range
from pcaccess.opcua.space import Space
from pcaccess.opcua.values import value_of
from pcaccess.project.model import Access

MAX_QUEUE: Final = 10_000
FASTEST_SAMPLING: Final = 10.0
"""Milliseconds."""

_OVERFLOW: Final = 0x480
"""InfoType DataValue and the Overflow bit of a StatusCode (Part 4, 7.39)."""


@dataclass(slots=True)
class Filter:
    """What counts as a change."""

    trigger: ua.DataChangeTrigger = ua.DataChangeTrigger.StatusValue
    dead_band: float = 0.0
    """Absolute; a percent dead band is already multiplied by the engineering range."""

    def passes(self, old: ua.DataValue | None, new: ua.DataValue) -> bool:
        if old is None or old.StatusCode != new.StatusCode:
            return True
        if self.trigger == ua.DataChangeTrigger.StatusValueTimestamp and old.SourceTimestamp != new.SourceTimestamp:
            return True
        if self.trigger == ua.DataChangeTrigger.Status:
            return False
        before, after = _content(old), _content(new)
        if before == after or (before != before and after != after):  # NaN follows NaN: nothing new
            return False
        if not self.dead_band:
            return True
        if isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
            return any(abs(a - b) > self.dead_band for a, b in zip(after, before, strict=True))
        if isinstance(before, int | float) and isinstance(after, int | float):
            return not abs(after - before) <= self.dead_band
        return True


def _content(value: ua.DataValue) -> Any:
    return value.Value.Value if value.Value is not None else None


@dataclass(slots=True)
class Monitor:
    """One monitored item."""

    id: int
    handle: int
    wanted: ua.ReadValueId
    times: ua.TimestampsToReturn
    mode: ua.MonitoringMode
    row: int | None
    filter: Filter
    queue_size: int
    discard_oldest: bool
    sampling: float
    """Milliseconds between samples of a queue."""
    seen: int = -1
    """Change number of the row at the last sample."""
    last: ua.DataValue | None = None
    queue: deque[ua.DataValue] = field(default_factory=deque)
    sampled_at: int = 0

    @property
    def is_plain(self) -> bool:
        """Only the newest value of an item counts, and any change of it."""
        return (
            self.row is not None
            and self.queue_size <= 1
            and not self.filter.dead_band
            and self.filter.trigger == ua.DataChangeTrigger.StatusValue
            and not self.wanted.IndexRange
        )

    def resize(self, size: int) -> None:
        """Make the queue that long; a shorter one loses values as if they had come into it."""
        kept, self.queue, self.queue_size = self.queue, deque(), size
        for value in kept:
            self.push(value)

    def push(self, value: ua.DataValue) -> None:
        """Queue a sample that passed the filter; a full queue loses one and says so in its status."""
        self.last = value
        if len(self.queue) >= self.queue_size:
            if self.queue_size > 1:
                lost_next_to = 1 if self.discard_oldest else -1
                if self.discard_oldest:
                    self.queue.popleft()
                    self.queue.append(value)
                else:
                    self.queue[-1] = value
                marked = self.queue[0] if lost_next_to == 1 else self.queue[-1]
                where = 0 if lost_next_to == 1 else len(self.queue) - 1
                self.queue[where] = _overflowed(marked)
                return
            self.queue.clear()
        self.queue.append(value)


def _overflowed(value: ua.DataValue) -> ua.DataValue:
    status = (value.StatusCode.value if value.StatusCode else 0) | _OVERFLOW
    return ua.DataValue(value.Value, ua.StatusCode(ua.UInt32(status)), value.SourceTimestamp, value.ServerTimestamp)


class ItemMonitors(MonitoredItemService):
    """Monitored items of one subscription; nodes that are not ours stay with asyncua."""

    def __init__(
        self, subscription: InternalSubscription, aspace: AddressSpace, space: Space, gateway: Gateway
    ) -> None:
        super().__init__(subscription, aspace)
        self._space = space
        self._gateway = gateway
        self._monitors: dict[int, Monitor] = {}
        self._times = ua.TimestampsToReturn.Both
        self._plain: list[Monitor] = []
        self._plain_rows: Rows = np.zeros(0, np.int64)
        self._plain_seen: NDArray[np.int64] = np.zeros(0, np.int64)
        self._sampled: list[Monitor] = []
        self._by_row: dict[int, list[Monitor]] = {}
        self._unlisten: Any = None
        self._arranged = True
        self._generation = gateway.table.generation

    # ------------------------------------------------------------------ services

    async def create_monitored_items(
        self, params: ua.CreateMonitoredItemsParameters
    ) -> list[ua.MonitoredItemCreateResult]:
        self._times = params.TimestampsToReturn
        return await super().create_monitored_items(params)

    async def _create_data_change_monitored_item(
        self, params: ua.MonitoredItemCreateRequest
    ) -> ua.MonitoredItemCreateResult:
        wanted = params.ItemToMonitor
        if wanted.NodeId is None or wanted.NodeId.NamespaceIndex not in OURS:
            return await super()._create_data_change_monitored_item(params)
        result = ua.MonitoredItemCreateResult()
        made = self._monitor(params)
        if isinstance(made, int):
            result.StatusCode = ua.StatusCode(ua.UInt32(made))
            return result
        self._disarrange()
        self._monitors[made.id] = made
        if made.mode != ua.MonitoringMode.Disabled:
            self._gateway.freshen([made.row] if made.row is not None else [])
        result.MonitoredItemId = ua.IntegerId(made.id)
        result.RevisedQueueSize = ua.Counter(made.queue_size)
        result.RevisedSamplingInterval = ua.Duration(made.sampling)
        return result

    def _monitor(self, params: ua.MonitoredItemCreateRequest) -> Monitor | int:
        """The new monitored item, or the status that refuses it."""
        wanted = params.ItemToMonitor
        entry = self._space.find(wanted.NodeId)
        if entry is None:
            return StatusCodes.BadNodeIdUnknown
        is_value = wanted.AttributeId == AttributeIds.Value
        if not is_value:
            known = self.aspace.read_attribute_value(wanted.NodeId, wanted.AttributeId).StatusCode
            if known is not None and known.is_bad():
                return int(known.value)
        elif entry.value is None:  # an object has no value to watch
            return StatusCodes.BadAttributeIdInvalid
        elif entry.row is not None and not self._gateway.item(entry.row).access & Access.R:
            return StatusCodes.BadNotReadable
        if wanted.IndexRange:
            try:
                parse_range(str(wanted.IndexRange))
            except RangeError as error:
                return error.status
        row = entry.row if is_value else None
        filter_ = self._filter(params.RequestedParameters.Filter, row)
        if isinstance(filter_, int):
            return filter_
        self._monitored_item_counter += 1
        monitor = Monitor(
            self._monitored_item_counter,
            int(params.RequestedParameters.ClientHandle),
            wanted,
            self._times,
            params.MonitoringMode,
            row,
            filter_,
            1,
            True,
            0.0,
        )
        self._revise(monitor, params.RequestedParameters)
        return monitor

    def _revise(self, monitor: Monitor, asked: ua.MonitoringParameters) -> None:
        monitor.discard_oldest = bool(asked.DiscardOldest)
        monitor.resize(max(1, min(int(asked.QueueSize), MAX_QUEUE)))
        publishing = float(self.isub.data.RevisedPublishingInterval)
        asked_rate = float(asked.SamplingInterval)
        if monitor.queue_size == 1 or asked_rate < 0:
            monitor.sampling = publishing
        else:
            monitor.sampling = max(asked_rate, FASTEST_SAMPLING)

    def _filter(self, asked: Any, row: int | None) -> Filter | int:
        if asked is None or (isinstance(asked, ua.ExtensionObject) and asked.TypeId.is_null()):
            return Filter()
        if not isinstance(asked, ua.DataChangeFilter):
            return StatusCodes.BadMonitoredItemFilterUnsupported
        kind = ua.DeadbandType(int(asked.DeadbandType))
        band = float(asked.DeadbandValue)
        if kind == ua.DeadbandType.None_:
            return Filter(asked.Trigger)
        if row is None or not self._gateway.table.data_type(row).is_numeric:
            return StatusCodes.BadFilterNotAllowed
        if not band >= 0:
            return StatusCodes.BadDeadbandFilterInvalid
        if kind == ua.DeadbandType.Percent:
            item = self._gateway.item(row)
            if item.low is None or item.high is None or band > 100:
                return StatusCodes.BadDeadbandFilterInvalid
            band *= (item.high - item.low) / 100
        return Filter(asked.Trigger, band)

    def _modify_monitored_item(self, params: ua.MonitoredItemModifyRequest) -> ua.MonitoredItemModifyResult:
        monitor = self._monitors.get(int(params.MonitoredItemId))
        if monitor is None:
            if int(params.MonitoredItemId) in self._monitored_items:
                return super()._modify_monitored_item(params)
            return ua.MonitoredItemModifyResult(
                StatusCode=ua.StatusCode(ua.UInt32(StatusCodes.BadMonitoredItemIdInvalid))
            )
        filter_ = self._filter(params.RequestedParameters.Filter, monitor.row)
        if isinstance(filter_, int):
            return ua.MonitoredItemModifyResult(StatusCode=ua.StatusCode(ua.UInt32(filter_)))
        self._disarrange()
        monitor.filter = filter_
        monitor.handle = int(params.RequestedParameters.ClientHandle)
        self._revise(monitor, params.RequestedParameters)
        return ua.MonitoredItemModifyResult(
            RevisedSamplingInterval=ua.Duration(monitor.sampling), RevisedQueueSize=ua.Counter(monitor.queue_size)
        )

    async def _set_monitoring_mode(self, mode: ua.MonitoringMode, mid: int) -> ua.StatusCode:
        monitor = self._monitors.get(mid)
        if monitor is None:
            return await super()._set_monitoring_mode(mode, mid)
        self._disarrange()
        if monitor.mode == ua.MonitoringMode.Disabled:
            monitor.seen, monitor.last = -1, None
        if mode == ua.MonitoringMode.Disabled:
            monitor.queue.clear()
        monitor.mode = mode
        return ua.StatusCode()

    def _delete_monitored_items(self, mid: int) -> ua.StatusCode:
        if mid not in self._monitors:
            return super()._delete_monitored_items(mid)
        self._disarrange()
        del self._monitors[mid]
        return ua.StatusCode()

    def delete_all_monitored_items(self) -> None:
        super().delete_all_monitored_items()
        self._disarrange()
        self._monitors.clear()
        self._arrange()

    # ------------------------------------------------------------------ publishing

    def watched_rows(self) -> list[int]:
        """Rows that somebody is told about: their PLCs are polled, and they are in use."""
        return [m.row for m in self._monitors.values() if m.row is not None and m.mode != ua.MonitoringMode.Disabled]

    def _disarrange(self) -> None:
        """Before a monitored item comes, goes or changes: take back what the columns know."""
        if self._arranged:
            for monitor, seen in zip(self._plain, self._plain_seen.tolist(), strict=True):
                monitor.seen = seen
            self._arranged = False

    def _arrange(self) -> None:
        self._disarrange()
        self._rebind()
        active = [m for m in self._monitors.values() if m.mode != ua.MonitoringMode.Disabled]
        self._plain = [m for m in active if m.is_plain and m.mode == ua.MonitoringMode.Reporting]
        plain = {m.id for m in self._plain}
        self._sampled = [m for m in active if m.id not in plain]
        self._plain_rows = np.array([m.row for m in self._plain], np.int64)
        self._plain_seen = np.array([m.seen for m in self._plain], np.int64)
        self._by_row = {}
        for monitor in self._sampled:
            if monitor.row is not None and monitor.queue_size > 1:
                self._by_row.setdefault(monitor.row, []).append(monitor)
        if self._by_row and self._unlisten is None:
            self._unlisten = self._gateway.table.listen(self._rows_changed)
        elif not self._by_row and self._unlisten is not None:
            self._unlisten()
            self._unlisten = None
        self._arranged = True

    def _rebind(self) -> None:
        """Rows come and go when the project changes; a monitored item follows its NodeId."""
        self._generation = self._gateway.table.generation
        for monitor in self._monitors.values():
            if monitor.wanted.AttributeId != AttributeIds.Value:
                continue
            row = self._space.row(monitor.wanted.NodeId)
            if row != monitor.row:
                monitor.row, monitor.seen, monitor.last = row, -1, None

    def _rows_changed(self, rows: Rows) -> None:
        """A queue keeps changes between publishes, no faster than its sampling interval."""
        now = self._gateway.now()
        for row in self._by_row.keys() & set(rows.tolist()):
            for monitor in self._by_row[row]:
                if now - monitor.sampled_at >= monitor.sampling * 10_000:
                    self._sample(monitor, now)

    def _sample(self, monitor: Monitor, now: int) -> None:
        monitor.sampled_at = now
        value = self._read(monitor)
        if monitor.filter.passes(monitor.last, value):
            monitor.push(value)

    def _read(self, monitor: Monitor) -> ua.DataValue:
        if monitor.row is not None:
            monitor.seen = int(self._gateway.table.changed(np.array([monitor.row]))[0])
            value = value_of(self._gateway, monitor.row)
        else:
            value = self.aspace.read_attribute_value(monitor.wanted.NodeId, monitor.wanted.AttributeId)
        if monitor.wanted.IndexRange:
            try:
                return take_range(value, str(monitor.wanted.IndexRange))
            except RangeError as error:
                return ua.DataValue(None, ua.StatusCode(ua.UInt32(error.status)))
        return value

    def collect(self) -> list[tuple[int, ua.MonitoredItemNotification]]:
        """Notifications since the last call, with the id of the monitored item of each."""
        if not self._arranged or self._generation != self._gateway.table.generation:
            self._arrange()
        found: list[tuple[int, ua.MonitoredItemNotification]] = []
        if len(self._plain):
            changed = self._gateway.table.changed(self._plain_rows)
            which = np.flatnonzero(changed > self._plain_seen)
            self._plain_seen[which] = changed[which]
            for n in which.tolist():
                monitor = self._plain[n]
                found.append((monitor.id, self._notification(monitor, value_of(self._gateway, int(monitor.row or 0)))))
        now = self._gateway.now()
        for monitor in self._sampled:
            if not self._is_current(monitor):
                self._sample(monitor, now)
            if monitor.mode == ua.MonitoringMode.Reporting:
                found.extend((monitor.id, self._notification(monitor, value)) for value in monitor.queue)
                monitor.queue.clear()
        return found

    def _is_current(self, monitor: Monitor) -> bool:
        if monitor.row is None or monitor.last is None:
            return False
        if monitor.filter.trigger == ua.DataChangeTrigger.StatusValueTimestamp:
            return False
        return bool(self._gateway.table.changed(np.array([monitor.row]))[0] <= monitor.seen)

    def _notification(self, monitor: Monitor, value: ua.DataValue) -> ua.MonitoredItemNotification:
        return ua.MonitoredItemNotification(
            ClientHandle=ua.IntegerId(monitor.handle), Value=with_times(value, monitor.times)
        )
