"""What belongs to a PLC in the address space: its state, and for one that runs a program the methods Run and Stop."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Iterator
from typing import Any, Final

from asyncua import ua
from asyncua.ua.object_ids import ObjectIds
from asyncua.ua.status_codes import StatusCodes

from pcaccess.gateway.download import DownloadError, download
from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.station import Station
from pcaccess.links.soft import SoftLink
from pcaccess.opcua.entry import Entry, Reference
from pcaccess.opcua.ids import SYSTEM, item_node, name_in, standard, system_node
from pcaccess.opcua.methods import Argument, Method, arguments_entry, method_entry, status
from pcaccess.opcua.values import data_value

_VARIABLES: Final[dict[str, tuple[ua.VariantType, Callable[[Station], Any], str]]] = {
    "Connected": (ua.VariantType.Boolean, lambda station: station.connected, "Whether the PLC answers"),
    "Mode": (ua.VariantType.String, lambda station: station.status.mode, "RUN, STOP or UNKNOWN"),
    "ScanTime": (ua.VariantType.Double, lambda station: station.status.scan_time, "Last scan in ms, 0: none"),
    "Errors": (ua.VariantType.UInt32, lambda station: station.status.errors, "Run-time errors since RUN"),
}


FIRST_SCAN: Final = 2.0
"""Seconds that Run waits for the first scan, at most."""
_PROGRAM: Final = (
    Argument("Name", ObjectIds.String, "Name of the program in messages"),
    Argument("Program", ObjectIds.ByteString, "The program as Micro/WIN exports it"),
)
_ACCEPTED: Final = (
    Argument("Accepted", ObjectIds.Boolean, "False: the program has errors and nothing changed"),
    Argument("Problems", ObjectIds.String, "Errors and warnings with file, line and column", is_array=True),
)


class PlcNodes:
    """Makes the nodes ``Link.PLC/Name`` of namespace 3 on demand."""

    def __init__(self, gateway: Gateway) -> None:
        self._gateway = gateway

    def names(self, plc: str) -> Iterator[str]:
        """Names of what a PLC has, variables first."""
        yield from _VARIABLES
        yield from (method.name for method in self._methods(plc))

    def find(self, plc: str, name: str) -> Entry | None:
        """The variable or method of that name, in any case; ``plc`` as written."""
        variable = next((v for v in _VARIABLES if v.casefold() == name.casefold()), None)
        if variable is not None:
            return self._variable(plc, variable)
        wanted, _, which = name.partition("/")
        method = next((m for m in self._methods(plc) if m.name.casefold() == wanted.casefold()), None)
        if method is None:
            return None
        if which:
            return arguments_entry(plc, method, which, self._gateway.clock)
        return method_entry(item_node(plc), plc, method)

    def _variable(self, plc: str, name: str) -> Entry:
        kind, read, description = _VARIABLES[name]

        def value() -> ua.DataValue:
            now = self._gateway.clock.now()
            return data_value(ua.Variant(read(self._gateway.stations[plc]), kind), now, now)

        def references() -> Iterator[Reference]:
            yield Reference(ObjectIds.HasComponent, item_node(plc), forward=False)

        return Entry(
            system_node(plc, name),
            name_in(name, SYSTEM),
            ua.NodeClass.Variable,
            ObjectIds.BaseDataVariableType,
            references,
            description,
            value=value,
            data_type=standard(kind.value),
        )

    def _methods(self, plc: str) -> tuple[Method, ...]:
        if not self._gateway.stations[plc].runs:
            return ()

        async def run() -> list[ua.Variant] | ua.StatusCode:
            return await self._switch(plc, running=True)

        async def stop() -> list[ua.Variant] | ua.StatusCode:
            return await self._switch(plc, running=False)

        async def take(name: ua.Variant, program: ua.Variant) -> list[ua.Variant] | ua.StatusCode:
            return await self._download(plc, name, program)

        return (
            Method("Run", "Put the CPU to RUN", (), (), run),
            Method("Stop", "Put the CPU to STOP; outputs go to their values for STOP", (), (), stop),
            Method("Download", "Run another program from the next scan on", _PROGRAM, _ACCEPTED, take),
        )

    async def _download(self, plc: str, name: ua.Variant, program: ua.Variant) -> list[ua.Variant] | ua.StatusCode:
        if not isinstance(name.Value, str) or not isinstance(program.Value, bytes):
            return status(StatusCodes.BadInvalidArgument)
        try:
            done = await download(self._gateway, plc, program.Value, name.Value)
        except DownloadError:
            return status(StatusCodes.BadNotSupported)
        return [
            ua.Variant(done.accepted, ua.VariantType.Boolean),
            ua.Variant(done.lines, ua.VariantType.String, is_array=True),
        ]

    async def _switch(self, plc: str, *, running: bool) -> ua.StatusCode:
        link = self._gateway.stations[plc].link
        cpu = link.scanning(plc) if isinstance(link, SoftLink) else None
        if cpu is None:
            return status(StatusCodes.BadNotSupported)
        if running:
            cpu.start()
            # Answered after the first scan, so that who asks for the mode next is not told RUN of a CPU that stops.
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(cpu.write(()), FIRST_SCAN)
        else:
            cpu.stop()
        return status(StatusCodes.Good)
