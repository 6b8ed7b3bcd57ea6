"""Samples and items as OPC UA types."""

from __future__ import annotations

from datetime import datetime
from types import MappingProxyType
from typing import Final

from asyncua import ua
from asyncua.ua.status_codes import StatusCodes

from pcaccess.gateway.gateway import Gateway
from pcaccess.items.sample import ItemValue, Sample
from pcaccess.items.ticks import from_ticks
from pcaccess.items.varianttypes import VARIANT_TYPES
from pcaccess.links.base import Outcome
from pcaccess.opcua.ids import standard
from pcaccess.project.model import Access
from pcaccess.s7200.types import DataType

WRITE_STATUS: Final = MappingProxyType(
    {
        Outcome.DONE: StatusCodes.Good,
        Outcome.NOT_WRITABLE: StatusCodes.BadNotWritable,
        Outcome.TYPE_MISMATCH: StatusCodes.BadTypeMismatch,
        Outcome.OUT_OF_RANGE: StatusCodes.BadOutOfRange,
        Outcome.CONFIG_ERROR: StatusCodes.BadConfigurationError,
        Outcome.NOT_CONNECTED: StatusCodes.BadNotConnected,
        Outcome.COMM_FAILURE: StatusCodes.BadNoCommunication,
        Outcome.DEVICE_FAILURE: StatusCodes.BadDeviceFailure,
    }
)


def variant_type(data_type: DataType) -> ua.VariantType:
    return ua.VariantType(VARIANT_TYPES[data_type])


def data_type_node(data_type: DataType) -> ua.NodeId:
    return standard(VARIANT_TYPES[data_type])


def access_level(access: Access) -> int:
    """AccessLevel bits CurrentRead and CurrentWrite (OPC UA Part 3)."""
    return (1 if access & Access.R else 0) | (2 if access & Access.W else 0)


def variant(data_type: DataType, value: ItemValue) -> ua.Variant:
    return ua.Variant(value, variant_type(data_type), is_array=isinstance(value, list))


def value_of(gateway: Gateway, row: int) -> ua.DataValue:
    """The live sample of a row with status and both times."""
    sample: Sample = gateway.table.sample(row)
    known, _, _, server = gateway.table.encoded(row)
    value = variant(gateway.table.data_type(row), sample.value) if known else None
    return data_value(value, sample.time, from_ticks(server), sample.status)


def data_value(value: ua.Variant | None, source: datetime, server: datetime, status: int = 0) -> ua.DataValue:
    """A DataValue with status and both times."""
    return ua.DataValue(
        value,
        ua.StatusCode(ua.UInt32(status)),
        source,  # type: ignore[arg-type]
        server,  # type: ignore[arg-type]
    )


def times_of(gateway: Gateway, row: int) -> tuple[datetime, datetime]:
    """Source and server time of a row."""
    _, _, source, server = gateway.table.encoded(row)
    return from_ticks(source), from_ticks(server)


def type_fits(wanted: DataType, given: ua.VariantType) -> bool:
    """Whether a value of that variant type may be written to an item of that type (OPC UA converts nothing)."""
    return given == variant_type(wanted)
