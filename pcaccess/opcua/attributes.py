"""Read and Write of our nodes, where asyncua's own attribute service would ignore what the request says.

Mended here (OPC UA Part 4, 5.10.2 Read and 5.10.4 Write): TimestampsToReturn, MaxAge (a Read may wait for a device),
IndexRange, write access of items, values kept under a bad status.
"""

from __future__ import annotations

import dataclasses
from typing import Any

from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.crypto.permission_rules import User, UserRole
from asyncua.server.address_space import AddressSpace, AttributeService
from asyncua.ua.attribute_ids import AttributeIds
from asyncua.ua.status_codes import StatusCodes

from pcaccess.gateway.gateway import Gateway
from pcaccess.items.sample import ItemValue
from pcaccess.links.base import Outcome
from pcaccess.opcua.ids import ITEMS, SYSTEM, standard
from pcaccess.opcua.ranges import RangeError, put_range, take_range
from pcaccess.opcua.space import Space
from pcaccess.opcua.values import WRITE_STATUS, type_fits, value_of
from pcaccess.project.model import Access

_SERVER = User(role=UserRole.Admin)
"""Who writes when no session does: the server itself."""
_SERVER_TIMES = (ua.TimestampsToReturn.Server, ua.TimestampsToReturn.Both)
_SOURCE_TIMES = (ua.TimestampsToReturn.Source, ua.TimestampsToReturn.Both)


class ItemAttributes(AttributeService):
    """asyncua's attribute service with our items in front."""

    def __init__(self, aspace: AddressSpace, space: Space, gateway: Gateway) -> None:
        super().__init__(aspace)
        self._space = space
        self._gateway = gateway

    # ------------------------------------------------------------------ Read

    async def read_items(self, params: ua.ReadParameters) -> list[ua.DataValue]:
        """The Read service; waits where an item's sample is older than the request allows."""
        if params.MaxAge < 0:
            raise ServiceError(StatusCodes.BadMaxAgeInvalid)
        if params.TimestampsToReturn not in tuple(ua.TimestampsToReturn)[:4]:
            raise ServiceError(StatusCodes.BadTimestampsToReturnInvalid)
        if not params.NodesToRead:
            raise ServiceError(StatusCodes.BadNothingToDo)
        rows = [row for wanted in params.NodesToRead if (row := self._space.row(wanted.NodeId)) is not None]
        await self._gateway.read(rows, params.MaxAge / 1000)
        return [with_times(self._read(wanted), params.TimestampsToReturn) for wanted in params.NodesToRead]

    def _read(self, wanted: ua.ReadValueId) -> ua.DataValue:
        row = self._space.row(wanted.NodeId) if wanted.AttributeId == AttributeIds.Value else None
        if row is not None:
            if not self._gateway.item(row).access & Access.R:
                return bad(StatusCodes.BadNotReadable)
            value = value_of(self._gateway, row)
        else:
            value = self._aspace.read_attribute_value(wanted.NodeId, wanted.AttributeId)
        if wanted.IndexRange:
            try:
                return take_range(value, str(wanted.IndexRange))
            except RangeError as error:
                return bad(error.status)
        return value

    # ------------------------------------------------------------------ Write

    async def write(self, params: ua.WriteParameters, user: User = _SERVER) -> list[ua.StatusCode]:
        """The Write service; an item's write is answered when its PLC has taken it."""
        results: list[ua.StatusCode | None] = [None] * len(params.NodesToWrite)
        pending: list[tuple[int, int, ItemValue]] = []
        for n, write in enumerate(params.NodesToWrite):
            if write.NodeId.NamespaceIndex not in (ITEMS, SYSTEM):
                results[n] = (await super().write(ua.WriteParameters(NodesToWrite=[write]), user))[0]
                continue
            checked = self._check_write(write)
            if isinstance(checked, int):
                results[n] = ua.StatusCode(ua.UInt32(checked))
            else:
                pending.append((n, *checked))
        outcomes = await self._gateway.write([(row, value) for _, row, value in pending])
        for (n, _, _), outcome in zip(pending, outcomes, strict=True):
            results[n] = ua.StatusCode(ua.UInt32(WRITE_STATUS[outcome]))
        return [result or ua.StatusCode(ua.UInt32(StatusCodes.BadInternalError)) for result in results]

    def _write_setting(self, write: ua.WriteValue) -> int:
        """What is not an item: a group's rate, for example."""
        entry = self._space.find(write.NodeId)
        if entry is None:
            return StatusCodes.BadNodeIdUnknown
        if write.AttributeId != AttributeIds.Value or entry.write is None or write.IndexRange:
            return StatusCodes.BadNotWritable
        given = write.Value.Value
        if given is None or given.is_array or standard(given.VariantType.value) != entry.data_type:
            return StatusCodes.BadTypeMismatch
        return entry.write(given.Value)

    def _check_write(self, write: ua.WriteValue) -> int | tuple[int, ItemValue]:
        """Row and value to write, or the status that refuses it."""
        row = self._space.row(write.NodeId)
        if row is None:
            return self._write_setting(write)
        if write.AttributeId != AttributeIds.Value:
            known = write.AttributeId in AttributeIds.__members__.values()
            return StatusCodes.BadNotWritable if known else StatusCodes.BadAttributeIdInvalid
        item = self._gateway.item(row)
        if not item.access & Access.W:
            return WRITE_STATUS[Outcome.NOT_WRITABLE]
        value = write.Value
        if value.Value is None or value.Value.Value is None:
            return StatusCodes.BadTypeMismatch
        if value.StatusCode is not None and value.StatusCode.value != StatusCodes.Good:
            # A PLC keeps no quality (Part 4, 5.10.4). Time stamps are not kept either, but common clients always
            # send one, so those are not refused.
            return StatusCodes.BadWriteNotSupported
        if not type_fits(item.data_type, value.Value.VariantType):
            return StatusCodes.BadTypeMismatch
        content: Any = value.Value.Value
        if write.IndexRange:
            try:
                content = put_range(self._gateway.table.sample(row).value, str(write.IndexRange), content)
            except RangeError as error:
                return error.status
        if isinstance(content, list) != (item.count > 1):
            return StatusCodes.BadTypeMismatch
        return row, content


def bad(status: int) -> ua.DataValue:
    return ua.DataValue(None, ua.StatusCode(ua.UInt32(status)))


def with_times(value: ua.DataValue, wanted: ua.TimestampsToReturn) -> ua.DataValue:
    """The value with just the times a request asked for (OPC UA Part 4, 7.40 TimestampsToReturn)."""
    source = value.SourceTimestamp if wanted in _SOURCE_TIMES else None
    server = value.ServerTimestamp if wanted in _SERVER_TIMES else None
    if source is value.SourceTimestamp and server is value.ServerTimestamp:
        return value
    return dataclasses.replace(
        value,
        SourceTimestamp=source,
        ServerTimestamp=server,
        SourcePicoseconds=value.SourcePicoseconds if source else None,
        ServerPicoseconds=value.ServerPicoseconds if server else None,
    )
