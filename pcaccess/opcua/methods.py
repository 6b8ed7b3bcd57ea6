"""Method nodes: one definition gives the method, its argument lists and the check of what a client passes.

Source:   OPC UA Part 3, 5.7 Methods; Part 4, 5.11 Call (status codes for wrong arguments).
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from dataclasses import dataclass
from typing import Any, Final

from asyncua import ua
from asyncua.ua.object_ids import ObjectIds
from asyncua.ua.status_codes import StatusCodes

from pcaccess.clock import Clock
from pcaccess.opcua.entry import Entry, Reference
from pcaccess.opcua.ids import SYSTEM, name_in, standard, system_node
from pcaccess.opcua.values import data_value


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument of a method; ``data_type`` is a standard NodeId's number."""

    name: str
    data_type: int
    description: str
    is_array: bool = False

    def encoded(self) -> ua.Argument:
        return ua.Argument(
            Name=ua.String(self.name),
            DataType=standard(self.data_type),
            ValueRank=ua.Int32(1 if self.is_array else -1),
            ArrayDimensions=[ua.UInt32(0)] if self.is_array else [],
            Description=ua.LocalizedText(ua.String(self.description)),
        )


@dataclass(frozen=True, slots=True)
class Method:
    """A method of an object. ``run`` gets the input variants and gives output variants or a StatusCode."""

    name: str
    description: str
    inputs: tuple[Argument, ...]
    outputs: tuple[Argument, ...]
    run: Callable[..., Awaitable[list[ua.Variant] | ua.StatusCode]]


_LISTS: Final = ("InputArguments", "OutputArguments")


def method_entry(owner: ua.NodeId, path: str, method: Method) -> Entry:
    """The method node of an object; ``path`` is the object's name in our system namespace."""

    async def call(_parent: ua.NodeId, *arguments: ua.Variant) -> Any:
        if len(arguments) < len(method.inputs):
            return status(StatusCodes.BadArgumentsMissing)
        if len(arguments) > len(method.inputs):
            return status(StatusCodes.BadTooManyArguments)
        return await method.run(*arguments)

    def references() -> Iterator[Reference]:
        yield Reference(ObjectIds.HasComponent, owner, forward=False)
        for which, arguments in zip(_LISTS, (method.inputs, method.outputs), strict=True):
            if arguments:
                yield Reference(ObjectIds.HasProperty, system_node(f"{path}/{method.name}", which))

    return Entry(
        system_node(path, method.name),
        name_in(method.name, SYSTEM),
        ua.NodeClass.Method,
        0,
        references,
        method.description,
        call=call,
    )


def arguments_entry(path: str, method: Method, which: str, clock: Clock) -> Entry | None:
    """The property with a method's input or output arguments."""
    found = next((name for name in _LISTS if name.casefold() == which.casefold()), None)
    arguments = method.inputs if found == _LISTS[0] else method.outputs
    if found is None or not arguments:
        return None

    def value() -> ua.DataValue:
        now = clock.now()
        content = [argument.encoded() for argument in arguments]
        return data_value(ua.Variant(content, ua.VariantType.ExtensionObject, is_array=True), now, now)

    def references() -> Iterator[Reference]:
        yield Reference(ObjectIds.HasProperty, system_node(path, method.name), forward=False)

    return Entry(
        system_node(f"{path}/{method.name}", found),
        name_in(found, 0),
        ua.NodeClass.Variable,
        ObjectIds.PropertyType,
        references,
        value=value,
        data_type=standard(ObjectIds.Argument),
        array=len(arguments),
    )


def status(code: int) -> ua.StatusCode:
    return ua.StatusCode(ua.UInt32(code))
