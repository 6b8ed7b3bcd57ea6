"""Samples and items as OPC UA types."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from asyncua import ua

from pcaccess.gateway.gateway import Gateway
from pcaccess.items.records import VARIANT_TYPES
from pcaccess.items.sample import ItemValue, Sample
from pcaccess.items.ticks import from_ticks
from pcaccess.links.base import Outcome
from pcaccess.project.model import Access, Item
from pcaccess.s7200.types import DataType

WRITE_STATUS: Final = MappingProxyType(
    {
        Outcome.DONE: ua.StatusCodes.Good,
        Outcome.NOT_WRITABLE: ua.StatusCodes.BadNotWritable,
        Outcome.TYPE_MISMATCH: ua.StatusCodes.BadTypeMismatch,
        Outcome.OUT_OF_RANGE: ua.StatusCodes.BadOutOfRange,
        Outcome.CONFIG_ERROR: ua.StatusCodes.BadConfigurationError,
        Outcome.NOT_CONNECTED: ua.StatusCodes.BadNotConnected,
        Outcome.COMM_FAILURE: ua.StatusCodes.BadNoCommunication,
        Outcome.DEVICE_FAILURE: ua.StatusCodes.BadDeviceFailure,
    }
)


def variant_type(data_type: DataType) -> ua.VariantType:
    return ua.VariantType(VARIANT_TYPES[data_type])


def data_type_node(data_type: DataType) -> ua.NodeId:
    return ua.NodeId(VARIANT_TYPES[data_type], 0)


def access_level(access: Access) -> int:
    """AccessLevel bits CurrentRead and CurrentWrite (OPC UA Part 3)."""
    return (1 if access & Access.R else 0) | (2 if access & Access.W else 0)


def count_of(item: Item) -> int:
    """Elements of an array item, 1 for a single value."""
    return 1 if isinstance(item.address, str) else item.address.count


def variant(data_type: DataType, value: ItemValue) -> ua.Variant:
    return ua.Variant(value, variant_type(data_type), is_array=isinstance(value, list))


def value_of(gateway: Gateway, row: int) -> ua.DataValue:
    """The live sample of a row with status and both times."""
    sample: Sample = gateway.table.sample(row)
    known, _, _, server = gateway.table.encoded(row)
    return ua.DataValue(
        variant(gateway.table.data_type(row), sample.value) if known else None,
        ua.StatusCode(ua.UInt32(sample.status)),
        sample.time,
        from_ticks(server),
    )
