"""Monitored items on items: what is reported, when, and how much of it is kept (OPC UA Part 4, 5.12 and 7.22)."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from asyncua import ua
from asyncua.server.address_space import AddressSpace
from asyncua.ua.attribute_ids import AttributeIds
from asyncua.ua.status_codes import StatusCodes

from pcaccess.gateway.gateway import Gateway
from pcaccess.items.quality import Quality
from pcaccess.items.sample import ItemValue
from pcaccess.items.table import as_rows
from pcaccess.opcua.monitors import ItemMonitors
from pcaccess.opcua.nodestore import NodeStore
from pcaccess.opcua.space import Space
from pcaccess.s7200.memory import locate

PLC = "MicroWin.NewPLC."
Reporting, Sampling, Disabled = ua.MonitoringMode.Reporting, ua.MonitoringMode.Sampling, ua.MonitoringMode.Disabled
Trigger = ua.DataChangeTrigger
Absolute, Percent = ua.DeadbandType.Absolute, ua.DeadbandType.Percent
PUBLISHING = 100.0


def filter_(trigger: Any = Trigger.StatusValue, band: Any = ua.DeadbandType.None_, value: float = 0) -> Any:
    return ua.DataChangeFilter(trigger, ua.UInt32(int(band)), ua.Double(value))


class Watch:
    """One subscription's monitored items, and the item table they look at."""

    def __init__(self, gateway: Gateway, clock: Any) -> None:
        self.gateway, self.clock = gateway, clock
        aspace = AddressSpace()
        space = Space(gateway)
        aspace._nodes = NodeStore(space)
        data = ua.CreateSubscriptionResult(ua.IntegerId(1), ua.Duration(PUBLISHING), ua.Counter(1), ua.Counter(1))
        subscription: Any = SimpleNamespace(data=data, max_queue_size=10_000)
        self.monitors = ItemMonitors(subscription, aspace, space, gateway)

    async def create(
        self,
        item: str,
        *,
        queue: int = 1,
        oldest: bool = True,
        sampling: float = -1,
        mode: Any = Reporting,
        what: Any = None,
        attribute: int = AttributeIds.Value,
        part: str | None = None,
        times: Any = ua.TimestampsToReturn.Both,
        node: str | None = None,
    ) -> ua.MonitoredItemCreateResult:
        wanted = ua.ReadValueId(ua.NodeId.from_string(node or f"ns=2;s={PLC}{item}"), attribute, part)
        asked = ua.MonitoringParameters(5, sampling, what, queue, oldest)
        made = ua.MonitoredItemCreateRequest(wanted, mode, asked)
        return (await self.monitors.create_monitored_items(ua.CreateMonitoredItemsParameters(1, times, [made])))[0]

    def modify(self, mid: int, *, queue: int = 1, oldest: bool = True, handle: int = 5, what: Any = None) -> Any:
        asked = ua.MonitoringParameters(handle, -1, what, queue, oldest)
        params = ua.ModifyMonitoredItemsParameters(
            1, ua.TimestampsToReturn.Both, [ua.MonitoredItemModifyRequest(mid, asked)]
        )
        return self.monitors.modify_monitored_items(params)[0]

    async def set_mode(self, mode: Any, mid: int) -> int:
        return int((await self.monitors.set_monitoring_mode(mode, [mid]))[0].value)

    def put(self, item: str, *values: ItemValue, every: float = 0.02) -> None:
        """Samples that a PLC sends, ``every`` seconds."""
        row = self.gateway.find(PLC + item)
        assert row is not None
        for value in values:
            self.clock.move(every)
            self.gateway.table.put(row, value, self.gateway.now())

    def lose(self, item: str, quality: Quality) -> None:
        row = self.gateway.find(PLC + item)
        assert row is not None
        self.gateway.table.set_quality(as_rows(row), quality, self.gateway.now())

    def publish(self) -> list[Any]:
        """Values of the notifications since the last publish."""
        return [n.Value.Value.Value for _, n in self.monitors.collect()]

    def statuses(self) -> list[int]:
        return [n.Value.StatusCode.value for _, n in self.monitors.collect()]


@pytest.fixture
def watch(gateway: Gateway, clock: Any) -> Watch:
    return Watch(gateway, clock)


# -- plain items -------------------------------------------------------------------------------------------------------


async def test_the_first_publish_has_the_value_there_is(watch: Watch) -> None:
    watch.put("Temperature", 7)
    result = await watch.create("Temperature")
    assert result.StatusCode.is_good()
    assert (result.RevisedQueueSize, result.RevisedSamplingInterval) == (1, PUBLISHING)
    assert watch.publish() == [7]
    assert watch.publish() == []


async def test_only_the_newest_value_is_published_and_only_after_a_change(watch: Watch) -> None:
    await watch.create("Temperature")
    watch.publish()
    watch.put("Temperature", 1, 2, 3)
    assert watch.publish() == [3]
    watch.put("Temperature", 3, 3)
    assert watch.publish() == []


async def test_a_value_that_went_and_came_back_is_reported_as_it_is(watch: Watch) -> None:
    await watch.create("Temperature")
    watch.publish()
    watch.put("Temperature", 1, 0)
    assert watch.publish() == [0]


async def test_a_change_of_quality_is_a_change(watch: Watch) -> None:
    await watch.create("Temperature")
    watch.publish()
    watch.lose("Temperature", Quality.COMM_FAILURE)
    assert watch.statuses() == [StatusCodes.BadNoCommunication]
    watch.put("Temperature", 0)
    assert watch.statuses() == [0]


async def test_each_monitored_item_has_its_own_handle_and_times(watch: Watch) -> None:
    await watch.create("Temperature", times=ua.TimestampsToReturn.Source)
    await watch.create("Temperature", times=ua.TimestampsToReturn.Neither)
    (_, one), (_, two) = watch.monitors.collect()
    assert (one.ClientHandle, two.ClientHandle) == (5, 5)
    assert (one.Value.SourceTimestamp is not None, one.Value.ServerTimestamp) == (True, None)
    assert (two.Value.SourceTimestamp, two.Value.ServerTimestamp) == (None, None)


@pytest.mark.parametrize("item", ["Text", "Row", "Bits", "Level", "Motor"])
async def test_items_of_every_kind_report(watch: Watch, item: str) -> None:
    await watch.create(item)
    assert len(watch.publish()) == 1
    new: ItemValue = {"Text": "x", "Row": [1, 2, 3, 4], "Bits": [True] * 11, "Level": 2.5, "Motor": True}[item]
    watch.put(item, new)
    assert watch.publish() == [new]


async def test_properties_are_watched_too(watch: Watch) -> None:
    await watch.create("", node=f"ns=3;s={PLC}Temperature/Quality")
    assert watch.publish() == [192]
    watch.lose("Temperature", Quality.COMM_FAILURE)
    assert watch.publish() == [24]
    assert watch.publish() == []


async def test_an_attribute_other_than_the_value_is_reported_once(watch: Watch) -> None:
    await watch.create("Temperature", attribute=AttributeIds.Description)
    assert len(watch.publish()) == 1
    watch.put("Temperature", 5)
    assert watch.publish() == []


# -- queues ------------------------------------------------------------------------------------------------------------


async def test_a_queue_keeps_the_changes_between_publishes(watch: Watch) -> None:
    result = await watch.create("Temperature", queue=5, sampling=10)
    assert (result.RevisedQueueSize, result.RevisedSamplingInterval) == (5, 10)
    watch.publish()
    watch.put("Temperature", 1, 2, 3)
    assert watch.publish() == [1, 2, 3]
    assert watch.publish() == []


async def test_a_full_queue_drops_the_oldest_and_marks_the_one_after_it(watch: Watch) -> None:
    """Part 4, 5.12.1.5: with discardOldest the Overflow bit is set in the value that is now the oldest."""
    await watch.create("Temperature", queue=3, sampling=10)
    watch.publish()
    watch.put("Temperature", 1, 2, 3, 4, 5)
    found = watch.monitors.collect()
    assert [n.Value.Value.Value for _, n in found] == [3, 4, 5]
    assert [n.Value.StatusCode.value for _, n in found] == [0x480, 0, 0]


async def test_a_full_queue_that_keeps_the_oldest_replaces_and_marks_the_newest(watch: Watch) -> None:
    await watch.create("Temperature", queue=3, oldest=False, sampling=10)
    watch.publish()
    watch.put("Temperature", 1, 2, 3, 4, 5)
    found = watch.monitors.collect()
    assert [n.Value.Value.Value for _, n in found] == [1, 2, 5]
    assert [n.Value.StatusCode.value for _, n in found] == [0, 0, 0x480]


async def test_a_queue_of_one_never_overflows(watch: Watch) -> None:
    await watch.create("Temperature", what=filter_(band=Absolute, value=0.5))
    watch.publish()
    watch.put("Temperature", 1, 2, 3)
    assert watch.statuses() == [0]


async def test_a_queue_takes_no_samples_faster_than_its_interval(watch: Watch) -> None:
    await watch.create("Temperature", queue=10, sampling=50)
    watch.publish()
    watch.put("Temperature", *range(1, 11), every=0.02)
    published = watch.publish()
    assert published == [3, 6, 9, 10]


@pytest.mark.parametrize(("asked", "revised"), [(0, 1), (1, 1), (50, 50), (2**32 - 1, 10_000)])
async def test_a_queue_is_bounded(watch: Watch, asked: int, revised: int) -> None:
    assert (await watch.create("Temperature", queue=asked)).RevisedQueueSize == revised


@pytest.mark.parametrize(("asked", "revised"), [(-1, PUBLISHING), (0, 10), (5, 10), (250, 250)])
async def test_a_sampling_interval_is_revised(watch: Watch, asked: float, revised: float) -> None:
    assert (await watch.create("Temperature", queue=2, sampling=asked)).RevisedSamplingInterval == revised


# -- filters -----------------------------------------------------------------------------------------------------------


async def test_an_absolute_dead_band_compares_with_the_value_last_reported(watch: Watch) -> None:
    """Part 4, 7.22.2: a slow ramp does report."""
    await watch.create("Temperature", what=filter_(band=Absolute, value=3))
    watch.publish()
    reported = []
    for value in range(1, 13):
        watch.put("Temperature", value)
        reported += watch.publish()
    assert reported == [4, 8, 12]


async def test_a_percent_dead_band_is_of_the_engineering_range(watch: Watch) -> None:
    """Part 8, 6.2: percent of EURange, here of 200 to 1000."""
    await watch.create("Temperature", what=filter_(band=Percent, value=10))
    watch.publish()
    watch.put("Temperature", 80)
    assert watch.publish() == []
    watch.put("Temperature", 81)
    assert watch.publish() == [81]


async def test_a_dead_band_lets_every_change_of_quality_through(watch: Watch) -> None:
    await watch.create("Temperature", what=filter_(band=Absolute, value=100))
    watch.publish()
    watch.lose("Temperature", Quality.COMM_FAILURE)
    assert watch.statuses() == [StatusCodes.BadNoCommunication]


async def test_a_dead_band_of_an_array_looks_at_each_element(watch: Watch) -> None:
    await watch.create("Row", what=filter_(band=Absolute, value=2))
    watch.publish()
    watch.put("Row", [2, 2, 2, 2])
    assert watch.publish() == []
    watch.put("Row", [0, 0, 0, 3])
    assert watch.publish() == [[0, 0, 0, 3]]


async def test_not_a_number_passes_a_dead_band_once(watch: Watch) -> None:
    await watch.create("Level", what=filter_(band=Absolute, value=1))
    watch.publish()
    watch.put("Level", float("nan"))
    assert len(watch.publish()) == 1
    watch.put("Level", float("nan"))
    assert watch.publish() == []
    watch.put("Level", 5.0)
    assert watch.publish() == [5.0]


async def test_trigger_status_reports_qualities_alone(watch: Watch) -> None:
    await watch.create("Temperature", what=filter_(Trigger.Status))
    watch.publish()
    watch.put("Temperature", 1)
    assert watch.publish() == []
    watch.lose("Temperature", Quality.COMM_FAILURE)
    assert watch.statuses() == [StatusCodes.BadNoCommunication]


async def test_trigger_timestamp_reports_every_new_time(watch: Watch) -> None:
    await watch.create("Temperature", what=filter_(Trigger.StatusValueTimestamp))
    watch.publish()
    watch.put("Temperature", 0)
    assert watch.publish() == [0]
    assert watch.publish() == []


@pytest.mark.parametrize(
    ("item", "what", "status"),
    [
        ("Text", filter_(band=Absolute, value=1), StatusCodes.BadFilterNotAllowed),
        ("Motor", filter_(band=Percent, value=1), StatusCodes.BadFilterNotAllowed),
        ("Unsigned", filter_(band=Percent, value=1), StatusCodes.BadDeadbandFilterInvalid),
        ("Temperature", filter_(band=Percent, value=101), StatusCodes.BadDeadbandFilterInvalid),
        ("Temperature", filter_(band=Absolute, value=-1), StatusCodes.BadDeadbandFilterInvalid),
        ("Temperature", filter_(band=Absolute, value=float("nan")), StatusCodes.BadDeadbandFilterInvalid),
        ("Temperature", ua.EventFilter(), StatusCodes.BadMonitoredItemFilterUnsupported),
        ("Nothing", None, StatusCodes.BadNodeIdUnknown),
        ("USR1", None, StatusCodes.BadAttributeIdInvalid),
        ("Command", None, StatusCodes.BadNotReadable),
    ],
)
async def test_what_cannot_be_watched_says_why(watch: Watch, item: str, what: Any, status: int) -> None:
    assert (await watch.create(item, what=what)).StatusCode.value == status
    assert watch.publish() == []


async def test_attributes_and_ranges_that_do_not_exist_are_refused(watch: Watch) -> None:
    assert (await watch.create("Motor", attribute=99)).StatusCode.value == StatusCodes.BadAttributeIdInvalid
    assert (await watch.create("Row", part="1:x")).StatusCode.value == StatusCodes.BadIndexRangeInvalid


async def test_a_part_of_an_array_reports_only_its_own_changes(watch: Watch) -> None:
    await watch.create("Row", part="1:2")
    assert watch.publish() == [[0, 0]]
    watch.put("Row", [9, 0, 0, 9])
    assert watch.publish() == []
    watch.put("Row", [9, 0, 5, 9])
    assert watch.publish() == [[0, 5]]


# -- modes, modify, delete ---------------------------------------------------------------------------------------------


async def test_a_disabled_item_reports_nothing_and_starts_afresh(watch: Watch) -> None:
    mid = (await watch.create("Temperature", mode=Disabled)).MonitoredItemId
    watch.put("Temperature", 1)
    assert watch.publish() == []
    assert watch.monitors.watched_rows() == []
    assert await watch.set_mode(Reporting, mid) == 0
    assert watch.publish() == [1]
    assert await watch.set_mode(Disabled, mid) == 0
    assert await watch.set_mode(Reporting, mid) == 0
    assert watch.publish() == [1]


async def test_a_sampling_item_queues_and_reports_when_it_may(watch: Watch) -> None:
    mid = (await watch.create("Temperature", mode=Sampling, queue=5, sampling=10)).MonitoredItemId
    assert watch.publish() == []
    watch.put("Temperature", 1, 2)
    assert watch.publish() == []
    await watch.set_mode(Reporting, mid)
    assert watch.publish() == [0, 1, 2]


async def test_disabling_forgets_what_was_queued(watch: Watch) -> None:
    mid = (await watch.create("Temperature", queue=5, sampling=10)).MonitoredItemId
    watch.publish()
    watch.put("Temperature", 1, 2)
    await watch.set_mode(Disabled, mid)
    await watch.set_mode(Reporting, mid)
    assert watch.publish() == [2]


async def test_modify_takes_handle_queue_and_filter(watch: Watch) -> None:
    mid = (await watch.create("Temperature")).MonitoredItemId
    watch.publish()
    result = watch.modify(mid, queue=4, handle=77, what=filter_(band=Absolute, value=10))
    assert (result.StatusCode.is_good(), result.RevisedQueueSize) == (True, 4)
    watch.put("Temperature", 5)
    watch.publish()
    watch.put("Temperature", 14)
    assert watch.publish() == []
    watch.put("Temperature", 50)
    (_, found), *_ = watch.monitors.collect()
    assert (found.ClientHandle, found.Value.Value.Value) == (77, 50)


async def test_a_shorter_queue_keeps_the_newest(watch: Watch) -> None:
    mid = (await watch.create("Temperature", queue=5, sampling=10)).MonitoredItemId
    watch.publish()
    watch.put("Temperature", 1, 2, 3, 4)
    watch.modify(mid, queue=2)
    found = watch.monitors.collect()
    assert [(n.Value.Value.Value, n.Value.StatusCode.value) for _, n in found] == [(3, 0x480), (4, 0)]


async def test_what_does_not_exist_cannot_be_changed(watch: Watch) -> None:
    unknown = StatusCodes.BadMonitoredItemIdInvalid
    assert watch.modify(999).StatusCode.value == unknown
    assert await watch.set_mode(Reporting, 999) == unknown
    assert watch.monitors.delete_monitored_items([999])[0].value == unknown


async def test_a_refused_modification_changes_nothing(watch: Watch) -> None:
    mid = (await watch.create("Text")).MonitoredItemId
    watch.publish()
    refused = watch.modify(mid, handle=9, what=filter_(band=Absolute, value=1))
    assert refused.StatusCode.value == StatusCodes.BadFilterNotAllowed
    watch.put("Text", "x")
    (_, found), *_ = watch.monitors.collect()
    assert found.ClientHandle == 5


async def test_a_deleted_item_is_silent(watch: Watch) -> None:
    mid = (await watch.create("Temperature")).MonitoredItemId
    assert watch.monitors.delete_monitored_items([mid])[0].is_good()
    watch.put("Temperature", 1)
    assert watch.publish() == []
    assert watch.monitors.watched_rows() == []


async def test_the_end_of_a_subscription_ends_its_monitored_items(watch: Watch, gateway: Gateway) -> None:
    await watch.create("Temperature", queue=5)
    await watch.create("Motor")
    watch.publish()
    watch.monitors.delete_all_monitored_items()
    watch.put("Temperature", 1)
    assert watch.publish() == []
    assert gateway.table._listeners == []


# -- rows that come and go ---------------------------------------------------------------------------------------------


async def test_a_removed_item_is_reported_once_as_unknown_and_again_when_it_is_back(
    watch: Watch, gateway: Gateway
) -> None:
    for queue in (1, 5):
        await watch.create("Temperature", queue=queue)
    watch.put("Temperature", 7)
    watch.publish()
    row = gateway.find(PLC + "Temperature")
    assert row is not None
    item, station = gateway.item(row), gateway.station(row)
    station.image.remove([row])
    gateway.table.remove([row])
    assert watch.statuses() == [StatusCodes.BadNodeIdUnknown] * 2
    assert watch.statuses() == []
    (again,) = gateway.add_items(station, [item])
    gateway.refresh(station)
    gateway.received(station.name, b"\x00\x2a", locate(item.address)[0])
    assert gateway.find(PLC + "Temperature") == again
    assert watch.publish() == [42, 42]
