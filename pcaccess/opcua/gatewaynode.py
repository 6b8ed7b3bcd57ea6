"""The gateway itself in the address space: ``ns=3;s=Gateway`` with the method Reload."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from typing import Final, Protocol

from asyncua import ua
from asyncua.ua.object_ids import ObjectIds
from asyncua.ua.status_codes import StatusCodes

from pcaccess.gateway.gateway import Gateway
from pcaccess.opcua.entry import Entry, Reference
from pcaccess.opcua.ids import SYSTEM, name_in, standard, system_node
from pcaccess.opcua.methods import Argument, Method, arguments_entry, method_entry, status

ROOT: Final = "Gateway"


class ReloadResult(Protocol):
    """What a reload gives: whether anything was applied, and a text for people."""

    @property
    def applied(self) -> object | None: ...


Reload = Callable[[], Awaitable[ReloadResult]]


def gateway_node() -> ua.NodeId:
    return ua.NodeId(ua.String(ROOT), ua.Int16(SYSTEM))


class GatewayNodes:
    """Makes the gateway's own nodes on demand."""

    def __init__(self, gateway: Gateway) -> None:
        self._gateway = gateway
        self.reload: Reload | None = None
        """Set by whoever knows the project file."""
        self._method = Method(
            "Reload",
            "Read the project file again and apply it when it is valid",
            (),
            (
                Argument("Applied", ObjectIds.Boolean, "False: the file has errors and nothing changed"),
                Argument("Message", ObjectIds.String, "What changed, or the errors, one a line"),
            ),
            self._reload,
        )

    def find(self, path: str) -> Entry | None:
        """The node of ``Gateway``, ``Gateway/Reload`` ..., in any case."""
        parts = path.casefold().split("/")
        if parts[0] != ROOT.casefold() or (len(parts) > 1 and parts[1] != "reload"):
            return None
        if len(parts) == 1:
            return self._root()
        if len(parts) == 2:
            return method_entry(gateway_node(), ROOT, self._method)
        return arguments_entry(ROOT, self._method, parts[2], self._gateway.clock) if len(parts) == 3 else None

    def _root(self) -> Entry:
        def references() -> Iterator[Reference]:
            yield Reference(ObjectIds.Organizes, standard(ObjectIds.ObjectsFolder), forward=False)
            yield Reference(ObjectIds.HasComponent, system_node(ROOT, self._method.name))

        return Entry(
            gateway_node(),
            name_in(ROOT, SYSTEM),
            ua.NodeClass.Object,
            ObjectIds.BaseObjectType,
            references,
            self._gateway.project.name,
        )

    async def _reload(self) -> list[ua.Variant] | ua.StatusCode:
        if self.reload is None:
            return status(StatusCodes.BadNotSupported)
        result = await self.reload()
        return [
            ua.Variant(result.applied is not None, ua.VariantType.Boolean),
            ua.Variant(str(result), ua.VariantType.String),
        ]
