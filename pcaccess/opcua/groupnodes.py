"""Groups in the address space: ``ns=3;s=Groups/Fast`` with its settings and the methods SyncRead and SyncWrite.

Source:   docs/architecture.md, groups; OPC UA Part 5, MethodType (InputArguments, OutputArguments).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Final

from asyncua import ua
from asyncua.ua.object_ids import ObjectIds
from asyncua.ua.status_codes import StatusCodes

from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.groups import Group, Source
from pcaccess.items.quality import Quality
from pcaccess.opcua.entry import Entry, Reference
from pcaccess.opcua.ids import SYSTEM, item_node, name_in, standard, system_node
from pcaccess.opcua.methods import Argument, Method, arguments_entry, method_entry, status
from pcaccess.opcua.values import WRITE_STATUS, data_value, type_fits, variant

ROOT: Final = "Groups"


def root_node() -> ua.NodeId:
    """The object that all groups hang under."""
    return ua.NodeId(ua.String(ROOT), ua.Int16(SYSTEM))


class GroupNodes:
    """Makes the nodes of groups on demand."""

    def __init__(self, gateway: Gateway) -> None:
        self._gateway = gateway

    def find(self, path: str) -> Entry | None:
        """The node of ``Groups``, ``Groups/Fast``, ``Groups/Fast/UpdateRate`` ..., in any case."""
        parts = path.split("/")
        if parts[0].casefold() != ROOT.casefold():
            return None
        if len(parts) == 1:
            return self._root()
        group = self._gateway.group(parts[1])
        if group is None:
            return None
        if len(parts) == 2:
            return self._group(group)
        if len(parts) == 3:
            entry = self._setting(group, parts[2])
            method = self._method(group, parts[2])
            return method_entry(system_node(ROOT, group.name), f"{ROOT}/{group.name}", method) if method else entry
        method = self._method(group, parts[2]) if len(parts) == 4 else None
        return arguments_entry(f"{ROOT}/{group.name}", method, parts[3], self._gateway.clock) if method else None

    def _root(self) -> Entry:
        def references() -> Iterator[Reference]:
            yield Reference(ObjectIds.Organizes, standard(ObjectIds.ObjectsFolder), forward=False)
            for group in self._gateway.groups:
                yield Reference(ObjectIds.Organizes, system_node(ROOT, group.name))

        return Entry(
            root_node(), name_in(ROOT, SYSTEM), ua.NodeClass.Object, ObjectIds.FolderType, references, "Groups of items"
        )

    def _group(self, group: Group) -> Entry:
        path = f"{ROOT}/{group.name}"

        def references() -> Iterator[Reference]:
            yield Reference(ObjectIds.Organizes, root_node(), forward=False)
            for item_id in group.items:
                yield Reference(ObjectIds.Organizes, item_node(item_id))
            for name in (*_SETTINGS, *(m.name for m in self._methods(group))):
                yield Reference(ObjectIds.HasComponent, system_node(path, name))

        return Entry(
            system_node(ROOT, group.name),
            name_in(group.name, SYSTEM),
            ua.NodeClass.Object,
            ObjectIds.FolderType,
            references,
            group.config.description,
        )

    def _setting(self, group: Group, name: str) -> Entry | None:
        found = next((s for s in _SETTINGS if s.casefold() == name.casefold()), None)
        if found is None:
            return None
        kind, read, write = _SETTINGS[found]

        def value() -> ua.DataValue:
            now = self._gateway.clock.now()
            return data_value(ua.Variant(read(group), kind), now, now)

        def references() -> Iterator[Reference]:
            yield Reference(ObjectIds.HasComponent, system_node(ROOT, group.name), forward=False)

        return Entry(
            system_node(f"{ROOT}/{group.name}", found),
            name_in(found, SYSTEM),
            ua.NodeClass.Variable,
            ObjectIds.BaseDataVariableType,
            references,
            value=value,
            data_type=standard(kind.value),
            access=3,
            write=lambda new: write(group, new),
        )

    def _methods(self, group: Group) -> tuple[Method, ...]:
        async def read(source: ua.Variant) -> list[ua.Variant] | ua.StatusCode:
            return await self._sync_read(group, source)

        async def write(values: ua.Variant) -> list[ua.Variant] | ua.StatusCode:
            return await self._sync_write(group, values)

        return (
            Method("SyncRead", "Read all items of the group at once", _READ_INPUTS, _READ_OUTPUTS, read),
            Method("SyncWrite", "Write all items of the group at once", _WRITE_INPUTS, _WRITE_OUTPUTS, write),
        )

    def _method(self, group: Group, name: str) -> Method | None:
        return next((m for m in self._methods(group) if m.name.casefold() == name.casefold()), None)

    # ------------------------------------------------------------------ methods

    async def _sync_read(self, group: Group, wanted: ua.Variant) -> list[ua.Variant] | ua.StatusCode:
        try:
            source = Source(wanted.Value)
        except ValueError:
            return status(StatusCodes.BadInvalidArgument)
        values, qualities, times, errors = [], [], [], []
        now = self._gateway.clock.now()
        for row, sample in zip(group.rows(), await group.read(source), strict=True):
            if sample is None or row is None:
                values.append(ua.Variant(None, ua.VariantType.Null))
                qualities.append(Quality.CONFIG_ERROR.code)
                times.append(now)
                code = StatusCodes.BadNodeIdUnknown if row is None else StatusCodes.BadNotReadable
                errors.append(status(code))
            else:
                values.append(variant(self._gateway.table.data_type(row), sample.value))
                qualities.append(sample.quality.code)
                times.append(sample.time)
                errors.append(ua.StatusCode())
        kinds = ua.VariantType
        return [
            ua.Variant(values, kinds.Variant, is_array=True),
            ua.Variant(qualities, kinds.UInt16, is_array=True),
            ua.Variant(times, kinds.DateTime, is_array=True),
            ua.Variant(errors, kinds.StatusCode, is_array=True),
        ]

    async def _sync_write(self, group: Group, argument: ua.Variant) -> list[ua.Variant] | ua.StatusCode:
        values = argument.Value
        if not isinstance(values, list) or len(values) != len(group.items):
            return status(StatusCodes.BadInvalidArgument)
        given = [v if isinstance(v, ua.Variant) else ua.Variant(v, argument.VariantType) for v in values]
        wanted: list[Any] = []
        errors: list[int | None] = []
        for row, value in zip(group.rows(), given, strict=True):
            # Null leaves its item alone, so that one call can write some of a group.
            fits = row is None or value.Value is None
            fits = fits or type_fits(self._gateway.table.data_type(row or 0), value.VariantType)
            wanted.append(value.Value if fits else None)
            errors.append(None if fits else StatusCodes.BadTypeMismatch)
        outcomes = await group.write(wanted)
        statuses = [
            status(WRITE_STATUS[outcome] if error is None else error)
            for outcome, error in zip(outcomes, errors, strict=True)
        ]
        return [ua.Variant(statuses, ua.VariantType.StatusCode, is_array=True)]


def _set_rate(group: Group, milliseconds: float) -> int:
    if not 0 < milliseconds <= 86_400_000:
        return StatusCodes.BadOutOfRange
    group.update_rate = milliseconds / 1000
    return StatusCodes.Good


def _set_active(group: Group, active: bool) -> int:
    group.active = active
    return StatusCodes.Good


def _set_dead_band(group: Group, percent: float) -> int:
    if not 0 <= percent <= 100:
        return StatusCodes.BadOutOfRange
    group.dead_band = percent
    return StatusCodes.Good


_Setting = tuple[ua.VariantType, Callable[[Group], Any], Callable[[Group, Any], int]]
_SETTINGS: Final[dict[str, _Setting]] = {
    "UpdateRate": (ua.VariantType.Double, lambda group: group.update_rate * 1000, _set_rate),
    "IsActive": (ua.VariantType.Boolean, lambda group: group.active, _set_active),
    "DeadBand": (ua.VariantType.Double, lambda group: float(group.dead_band), _set_dead_band),
}
"""UpdateRate in milliseconds, DeadBand in percent of the engineering range; all can be written."""

_READ_INPUTS: Final = (Argument("Source", ObjectIds.Int32, "1: cache, 2: device"),)
_READ_OUTPUTS: Final = (
    Argument("Values", ObjectIds.BaseDataType, "In the order of the group's items", is_array=True),
    Argument("Qualities", ObjectIds.UInt16, "OPC DA quality codes, 192 is good", is_array=True),
    Argument("TimeStamps", ObjectIds.DateTime, "Time of the last successful read", is_array=True),
    Argument("Errors", ObjectIds.StatusCode, "0 is good", is_array=True),
)
_WRITE_INPUTS: Final = (
    Argument(
        "Values", ObjectIds.BaseDataType, "In the order of the group's items; null leaves an item alone", is_array=True
    ),
)
_WRITE_OUTPUTS: Final = (Argument("Errors", ObjectIds.StatusCode, "0 is good", is_array=True),)
