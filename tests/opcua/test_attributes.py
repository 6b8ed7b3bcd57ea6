"""Read and Write of items: what the request says is what happens (OPC UA Part 4, 5.10.2 and 5.10.4)."""

from __future__ import annotations

from datetime import timedelta
from typing import Any

import pytest
from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.server.address_space import AddressSpace
from asyncua.ua.attribute_ids import AttributeIds
from asyncua.ua.status_codes import StatusCodes

from pcaccess.gateway.gateway import Gateway
from pcaccess.items.quality import Quality
from pcaccess.opcua.attributes import ItemAttributes
from pcaccess.opcua.nodestore import NodeStore
from pcaccess.opcua.space import Space

PLC = "ns=2;s=MicroWin.NewPLC."
DEAD = "ns=2;s=MicroWin.Dead."
Both, Source, Server, Neither = (
    ua.TimestampsToReturn.Both,
    ua.TimestampsToReturn.Source,
    ua.TimestampsToReturn.Server,
    ua.TimestampsToReturn.Neither,
)


class Service:
    """The attribute service, with the requests of a test in short."""

    def __init__(self, gateway: Gateway) -> None:
        aspace = AddressSpace()
        space = Space(gateway)
        aspace._nodes = NodeStore(space)
        self.attributes = ItemAttributes(aspace, space, gateway)

    async def read(
        self,
        node: str,
        *,
        attribute: int = AttributeIds.Value,
        part: str | None = None,
        times: Any = Both,
        max_age: float = 0,
    ) -> ua.DataValue:
        wanted = ua.ReadValueId(ua.NodeId.from_string(node), attribute, part)
        params = ua.ReadParameters(MaxAge=max_age, TimestampsToReturn=times, NodesToRead=[wanted])
        return (await self.attributes.read_items(params))[0]

    async def value(self, node: str) -> Any:
        result = await self.read(node)
        assert result.Value is not None
        return result.Value.Value

    async def status(self, node: str, **options: Any) -> int:
        result = await self.read(node, **options)
        assert result.StatusCode is not None
        return int(result.StatusCode.value)

    async def write(
        self,
        node: str,
        value: Any,
        kind: ua.VariantType,
        *,
        attribute: int = AttributeIds.Value,
        part: str | None = None,
        status: int = 0,
    ) -> int:
        written = ua.DataValue(ua.Variant(value, kind), ua.StatusCode(status))
        params = ua.WriteParameters(NodesToWrite=[ua.WriteValue(ua.NodeId.from_string(node), attribute, part, written)])
        return int((await self.attributes.write(params))[0].value)


@pytest.fixture
def service(gateway: Gateway) -> Service:
    return Service(gateway)


Int16, Byte, Boolean, Float, String = (
    ua.VariantType.Int16,
    ua.VariantType.Byte,
    ua.VariantType.Boolean,
    ua.VariantType.Float,
    ua.VariantType.String,
)


# -- Read --------------------------------------------------------------------------------------------------------------


async def test_a_read_has_value_status_and_both_times(service: Service, clock: Any) -> None:
    result = await service.read(PLC + "Temperature")
    assert result.Value == ua.Variant(0, Int16)
    assert result.StatusCode == ua.StatusCode(0)
    assert (result.SourceTimestamp, result.ServerTimestamp) == (clock.now(), clock.now())


@pytest.mark.parametrize(("times", "source", "server"), [(Both, 1, 1), (Source, 1, 0), (Server, 0, 1), (Neither, 0, 0)])
@pytest.mark.parametrize("node", [PLC + "Temperature", PLC + "Text", DEAD + "Value", "ns=3;s=MicroWin.Dead/Mode"])
async def test_only_the_times_asked_for_are_returned(
    service: Service, node: str, times: Any, source: int, server: int
) -> None:
    """Part 4, 7.40 TimestampsToReturn."""
    result = await service.read(node, times=times)
    assert (result.SourceTimestamp is not None, result.ServerTimestamp is not None) == (source, server)


async def test_a_memory_plc_is_as_new_as_the_question(service: Service, clock: Any) -> None:
    clock.move(60)
    assert (await service.read(PLC + "Temperature")).SourceTimestamp == clock.now()


async def test_a_lost_plc_keeps_value_and_time(service: Service, gateway: Gateway, clock: Any) -> None:
    assert await service.write(PLC + "Temperature", 7, Int16) == 0
    then = clock.now()
    gateway.lost("MicroWin.NewPLC", Quality.COMM_FAILURE)
    clock.move(5)
    row = gateway.find("MicroWin.NewPLC.Temperature")
    assert row is not None
    sample = gateway.table.sample(row)
    assert (sample.value, sample.quality, sample.time) == (7, Quality.COMM_FAILURE, then)
    result = await service.read(PLC + "Temperature")
    assert result.Value == ua.Variant(7, Int16)
    assert result.StatusCode == ua.StatusCode(StatusCodes.BadNoCommunication)


async def test_a_plc_that_is_not_connected_is_bad_and_only_it(service: Service) -> None:
    assert await service.status(DEAD + "Value") == StatusCodes.BadNotConnected
    assert await service.status(DEAD + "Text") == StatusCodes.BadNotConnected
    assert await service.status(PLC + "Temperature") == 0


@pytest.mark.parametrize(
    ("node", "options", "status"),
    [
        (PLC + "Nothing", {}, StatusCodes.BadNodeIdUnknown),
        ("ns=3;s=MicroWin.NewPLC.Motor/Nothing", {}, StatusCodes.BadNodeIdUnknown),
        (PLC + "Command", {}, StatusCodes.BadNotReadable),
        ("ns=2;s=MicroWin.NewPLC", {}, StatusCodes.BadAttributeIdInvalid),
        (PLC + "Motor", {"attribute": AttributeIds.EventNotifier}, StatusCodes.BadAttributeIdInvalid),
        (PLC + "Motor", {"attribute": 99}, StatusCodes.BadAttributeIdInvalid),
        (PLC + "Motor", {"part": "0"}, StatusCodes.BadIndexRangeNoData),
        (PLC + "Row", {"part": "9"}, StatusCodes.BadIndexRangeNoData),
        (PLC + "Row", {"part": "2:1"}, StatusCodes.BadIndexRangeInvalid),
        (PLC + "Row", {"part": "0,0"}, StatusCodes.BadIndexRangeInvalid),
        (PLC + "Row", {"part": "x"}, StatusCodes.BadIndexRangeInvalid),
    ],
)
async def test_what_cannot_be_read_says_why(service: Service, node: str, options: dict[str, Any], status: int) -> None:
    assert await service.status(node, **options) == status


async def test_an_index_range_takes_its_part(service: Service) -> None:
    assert await service.write(PLC + "Row", [1, 2, 3, 4], Int16) == 0
    assert await service.write(PLC + "Text", "abcdef", String) == 0
    for node, part, value in [
        ("Row", "1:2", [2, 3]),
        ("Row", "3", [4]),
        ("Row", "2:90", [3, 4]),
        ("Text", "1:3", "bcd"),
        ("Text", "5", "f"),
    ]:
        result = await service.read(PLC + node, part=part)
        assert result.Value is not None
        assert result.Value.Value == value


@pytest.mark.parametrize(
    ("options", "status"),
    [
        ({"max_age": -1.0}, StatusCodes.BadMaxAgeInvalid),
        ({"times": 4}, StatusCodes.BadTimestampsToReturnInvalid),
    ],
)
async def test_a_request_that_makes_no_sense_is_refused_whole(
    service: Service, options: dict[str, Any], status: int
) -> None:
    with pytest.raises(ServiceError) as refused:
        await service.read(PLC + "Motor", **options)
    assert refused.value.code == status


async def test_reading_nothing_is_refused(service: Service) -> None:
    with pytest.raises(ServiceError) as refused:
        await service.attributes.read_items(ua.ReadParameters())
    assert refused.value.code == StatusCodes.BadNothingToDo


# -- Write -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("item", "value", "kind"),
    [
        ("Motor", True, Boolean),
        ("High", 200, Byte),
        ("Signed", -100, ua.VariantType.SByte),
        ("Temperature", -5, Int16),
        ("Unsigned", 65535, ua.VariantType.UInt16),
        ("Big", -(2**31), ua.VariantType.Int32),
        ("Huge", 2**32 - 1, ua.VariantType.UInt32),
        ("Level", 1.5, Float),
        ("Scaled", 2.5, Float),
        ("Text", "Grüße", String),
        ("Text", "", String),
        ("Row", [1, -2, 3, -4], Int16),
        ("Bits", [True, False] * 5 + [True], Boolean),
    ],
)
async def test_a_value_of_every_type_is_written_and_read_back(
    service: Service, item: str, value: Any, kind: ua.VariantType
) -> None:
    assert await service.write(PLC + item, value, kind) == 0
    assert await service.value(PLC + item) == value


async def test_a_write_shows_in_every_item_over_the_same_bytes(service: Service) -> None:
    assert await service.write(PLC + "Temperature", 0x1234, Int16) == 0
    assert await service.value(PLC + "High") == 0x12


@pytest.mark.parametrize(
    ("item", "value", "kind", "status"),
    [
        ("Nothing", 1, Int16, StatusCodes.BadNodeIdUnknown),
        ("Input", True, Boolean, StatusCodes.BadNotWritable),
        ("Motor", 1, Int16, StatusCodes.BadTypeMismatch),
        ("Temperature", 1, ua.VariantType.UInt16, StatusCodes.BadTypeMismatch),
        ("Level", 1.0, ua.VariantType.Double, StatusCodes.BadTypeMismatch),
        ("Text", b"x", ua.VariantType.ByteString, StatusCodes.BadTypeMismatch),
        ("Motor", None, ua.VariantType.Null, StatusCodes.BadTypeMismatch),
        ("Row", 1, Int16, StatusCodes.BadTypeMismatch),
        ("Row", [1, 2, 3], Int16, StatusCodes.BadTypeMismatch),
        ("Temperature", [1], Int16, StatusCodes.BadTypeMismatch),
        ("Setpoint", 101, Int16, StatusCodes.BadOutOfRange),
        ("Scaled", 11.0, Float, StatusCodes.BadOutOfRange),
        ("Scaled", float("nan"), Float, StatusCodes.BadOutOfRange),
        ("Text", "eleven char", String, StatusCodes.BadOutOfRange),
        ("Text", "日", String, StatusCodes.BadOutOfRange),
    ],
)
async def test_what_cannot_be_written_says_why_and_changes_nothing(
    service: Service, gateway: Gateway, item: str, value: Any, kind: ua.VariantType, status: int
) -> None:
    counter = gateway.table.counter
    assert await service.write(PLC + item, value, kind) == status
    assert gateway.table.counter == counter


async def test_a_scaled_item_of_16_bits_takes_what_its_raw_value_holds(service: Service) -> None:
    assert await service.write(PLC + "Scaled", 10.2, Float) == 0
    assert await service.value(PLC + "Scaled") == pytest.approx(10.2, abs=1e-3)


async def test_a_plc_that_is_not_connected_refuses_writes(service: Service) -> None:
    assert await service.write(DEAD + "Value", 1, Int16) == StatusCodes.BadNotConnected


async def test_only_the_value_can_be_written(service: Service) -> None:
    for attribute, status in [
        (AttributeIds.Description, StatusCodes.BadNotWritable),
        (99, StatusCodes.BadAttributeIdInvalid),
    ]:
        assert await service.write(PLC + "Motor", "x", String, attribute=attribute) == status
    assert await service.write("ns=2;s=MicroWin.NewPLC", 1, Int16) == StatusCodes.BadNotWritable
    quality = "ns=3;s=MicroWin.NewPLC.Motor/Quality"
    assert await service.write(quality, 0, ua.VariantType.UInt16) == StatusCodes.BadNotWritable


async def test_a_plc_keeps_no_status(service: Service) -> None:
    """Part 4, 5.10.4: BadWriteNotSupported where value, status and time cannot be written together."""
    bad = StatusCodes.BadSensorFailure
    assert await service.write(PLC + "Motor", True, Boolean, status=bad) == StatusCodes.BadWriteNotSupported


async def test_a_part_of_an_array_or_text_can_be_written(service: Service) -> None:
    assert await service.write(PLC + "Row", [7, 8], Int16, part="1:2") == 0
    assert await service.value(PLC + "Row") == [0, 7, 8, 0]
    assert await service.write(PLC + "Text", "abcdef", String) == 0
    assert await service.write(PLC + "Text", "XY", String, part="2:3") == 0
    assert await service.value(PLC + "Text") == "abXYef"


@pytest.mark.parametrize(
    ("item", "value", "part", "status"),
    [
        ("Row", [1, 2, 3], "1:2", StatusCodes.BadIndexRangeNoData),
        ("Row", [1, 2], "3:4", StatusCodes.BadIndexRangeNoData),
        ("Row", [1], "1,1", StatusCodes.BadIndexRangeInvalid),
        ("Temperature", 1, "0", StatusCodes.BadIndexRangeInvalid),
    ],
)
async def test_a_part_that_does_not_fit_is_refused(
    service: Service, item: str, value: Any, part: str, status: int
) -> None:
    assert await service.write(PLC + item, value, Int16, part=part) == status
    assert await service.value(PLC + "Row") == [0, 0, 0, 0]


async def test_writes_of_one_request_take_effect_in_their_order(service: Service) -> None:
    def to(item: str, value: int, kind: ua.VariantType) -> ua.WriteValue:
        node = ua.NodeId.from_string(PLC + item)
        return ua.WriteValue(node, AttributeIds.Value, None, ua.DataValue(ua.Variant(value, kind)))

    params = ua.WriteParameters(
        NodesToWrite=[to("Temperature", 0x0102, Int16), to("High", 9, Byte), to("Nothing", 1, Int16)]
    )
    statuses = [s.value for s in await service.attributes.write(params)]
    assert statuses == [0, 0, StatusCodes.BadNodeIdUnknown]
    assert await service.value(PLC + "Temperature") == 0x0902


async def test_times_do_not_run_backwards(service: Service, clock: Any) -> None:
    before = (await service.read(PLC + "Temperature")).SourceTimestamp
    clock.move(0.005)
    assert await service.write(PLC + "Temperature", 3, Int16) == 0
    clock.move(0.005)
    after = (await service.read(PLC + "Temperature")).SourceTimestamp
    assert before is not None
    assert after is not None
    assert timedelta() <= after - before <= timedelta(seconds=0.01)
