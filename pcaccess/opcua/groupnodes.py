"""Groups in the address space: ``ns=3;s=Groups/Fast`` with its settings and the methods SyncRead and SyncWrite.

Source:   docs/architecture.md, groups; OPC UA Part 5, MethodType (InputArguments, OutputArguments).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final

from asyncua import ua
from asyncua.ua.object_ids import ObjectIds
from asyncua.ua.status_codes import StatusCodes

from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.groups import Group, Source
from pcaccess.items.quality import Quality
from pcaccess.opcua.entry import Entry, Reference
from pcaccess.opcua.ids import SYSTEM, item_node, name_in, standard, system_node
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
            return self._setting(group, parts[2]) or self._method(group, parts[2])
        return self._arguments(group, parts[2], parts[3]) if len(parts) == 4 else None

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
            for name in (*_SETTINGS, *_METHODS):
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

    def _method(self, group: Group, name: str) -> Entry | None:
        found = next((m for m in _METHODS if m.casefold() == name.casefold()), None)
        if found is None:
            return None
        path = f"{ROOT}/{group.name}"
        call = self._sync_read if found == "SyncRead" else self._sync_write

        async def run(_parent: ua.NodeId, *arguments: ua.Variant) -> Any:
            return await call(group, arguments)

        def references() -> Iterator[Reference]:
            yield Reference(ObjectIds.HasComponent, system_node(ROOT, group.name), forward=False)
            for which in ("InputArguments", "OutputArguments"):
                yield Reference(ObjectIds.HasProperty, system_node(f"{path}/{found}", which))

        return Entry(system_node(path, found), name_in(found, SYSTEM), ua.NodeClass.Method, 0, references, call=run)

    def _arguments(self, group: Group, method: str, which: str) -> Entry | None:
        found = next((m for m in _METHODS if m.casefold() == method.casefold()), None)
        if found is None or which not in ("InputArguments", "OutputArguments"):
            return None
        owner = f"{ROOT}/{group.name}/{found}"
        arguments = _METHODS[found][which == "OutputArguments"]

        def value() -> ua.DataValue:
            now = self._gateway.clock.now()
            return data_value(
                ua.Variant([_argument(*a) for a in arguments], ua.VariantType.ExtensionObject, is_array=True), now, now
            )

        def references() -> Iterator[Reference]:
            yield Reference(ObjectIds.HasProperty, system_node(f"{ROOT}/{group.name}", found), forward=False)

        return Entry(
            system_node(owner, which),
            name_in(which, 0),
            ua.NodeClass.Variable,
            ObjectIds.PropertyType,
            references,
            value=value,
            data_type=standard(ObjectIds.Argument),
            array=len(arguments),
        )

    # ------------------------------------------------------------------ methods

    async def _sync_read(self, group: Group, arguments: Sequence[ua.Variant]) -> Any:
        if len(arguments) > 1:
            return ua.StatusCode(ua.UInt32(StatusCodes.BadTooManyArguments))
        try:
            source = Source(int(arguments[0].Value)) if arguments else Source.CACHE
        except (TypeError, ValueError):
            return ua.StatusCode(ua.UInt32(StatusCodes.BadInvalidArgument))
        values, qualities, times, errors = [], [], [], []
        now = self._gateway.clock.now()
        for row, sample in zip(group.rows(), await group.read(source), strict=True):
            if sample is None or row is None:
                values.append(ua.Variant(None, ua.VariantType.Null))
                qualities.append(Quality.CONFIG_ERROR.code)
                times.append(now)
                status = StatusCodes.BadNodeIdUnknown if row is None else StatusCodes.BadNotReadable
                errors.append(ua.StatusCode(ua.UInt32(status)))
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

    async def _sync_write(self, group: Group, arguments: Sequence[ua.Variant]) -> Any:
        if len(arguments) != 1:
            missing = StatusCodes.BadArgumentsMissing if not arguments else StatusCodes.BadTooManyArguments
            return ua.StatusCode(ua.UInt32(missing))
        values = arguments[0].Value
        if not isinstance(values, list) or len(values) != len(group.items):
            return ua.StatusCode(ua.UInt32(StatusCodes.BadInvalidArgument))
        given = [v if isinstance(v, ua.Variant) else ua.Variant(v, arguments[0].VariantType) for v in values]
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
            ua.StatusCode(ua.UInt32(WRITE_STATUS[outcome] if error is None else error))
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

_Argument = tuple[str, int, bool, str]
_METHODS: Final[dict[str, tuple[tuple[_Argument, ...], tuple[_Argument, ...]]]] = {
    "SyncRead": (
        (("Source", ObjectIds.Int32, False, "1: cache, 2: device"),),
        (
            ("Values", ObjectIds.BaseDataType, True, "In the order of the group's items"),
            ("Qualities", ObjectIds.UInt16, True, "OPC DA quality codes, 192 is good"),
            ("TimeStamps", ObjectIds.DateTime, True, "Time of the last successful read"),
            ("Errors", ObjectIds.StatusCode, True, "0 is good"),
        ),
    ),
    "SyncWrite": (
        (("Values", ObjectIds.BaseDataType, True, "In the order of the group's items; null leaves an item alone"),),
        (("Errors", ObjectIds.StatusCode, True, "0 is good"),),
    ),
}
"""Input and output arguments: name, data type, whether it is an array, description."""


def _argument(name: str, data_type: int, is_array: bool, description: str) -> ua.Argument:
    return ua.Argument(
        Name=ua.String(name),
        DataType=standard(data_type),
        ValueRank=ua.Int32(1 if is_array else -1),
        ArrayDimensions=[ua.UInt32(0)] if is_array else [],
        Description=ua.LocalizedText(ua.String(description)),
    )
