"""Methods and states of a running gateway, asked for over OPC UA."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from asyncua import ua
from asyncua.ua.object_ids import ObjectIds
from asyncua.ua.status_codes import StatusCodes

from pcaccess.cli.failures import Failed
from pcaccess.cli.names import Target, Unknown, content, resolve
from pcaccess.cli.output import Cell, Column, Row
from pcaccess.cli.remote import Remote, connect, status_text

STATUS_COLUMNS: Final = (
    Column("PLC"),
    Column("Connected"),
    Column("Mode"),
    Column("Scan Time", right=True),
    Column("Errors", right=True),
)
_STATES: Final = ("Connected", "Mode", "ScanTime", "Errors")


@dataclass(frozen=True, slots=True)
class PlcState:
    """How one PLC is."""

    item_id: str
    connected: bool
    mode: str
    scan_time: float
    """Milliseconds of the last scan, 0 where nothing scans."""
    errors: int
    """Run-time errors of its program since RUN."""

    def as_json(self) -> dict[str, Any]:
        return {
            "id": self.item_id,
            "connected": self.connected,
            "mode": self.mode,
            "scan_time": self.scan_time,
            "errors": self.errors,
        }

    def as_row(self) -> Row:
        """Cells of ``STATUS_COLUMNS``."""
        return (
            self.item_id,
            Cell("yes", "good") if self.connected else Cell("no", "bad"),
            self.mode,
            f"{self.scan_time:.3g} ms" if self.scan_time else "",
            Cell(str(self.errors), "bad") if self.errors else "0",
        )


async def reload(url: str) -> tuple[bool, str]:
    """Whether anything was applied, and a text for people."""
    async with connect(url) as remote:
        applied, message = await _call(remote, _of_gateway(remote, "Gateway"), _of_gateway(remote, "Gateway/Reload"))
        return bool(applied), str(message)


async def status(url: str, names: Sequence[str]) -> tuple[list[PlcState], list[str]]:
    """The states of PLCs, all without names; and what names led to none."""
    async with connect(url) as remote:
        if not names:
            (links,) = await remote.children([remote.roots()])
            below = await remote.children([link.NodeId for link in links])
            names = [remote.name(child.NodeId) for children in below for child in children if _is_plc(child)]
        states, errors = [], []
        for found in await resolve(remote, names):
            if isinstance(found, Unknown):
                errors.append(found.message)
                continue
            state = await _state(remote, found)
            if state is None:
                errors.append(f"{found.item_id} is no PLC")
            else:
                states.append(state)
        return states, errors


def _is_plc(child: ua.ReferenceDescription) -> bool:
    return bool(child.TypeDefinition.Identifier == ObjectIds.BaseObjectType)


async def _state(remote: Remote, plc: Target) -> PlcState | None:
    nodes = [node for name in _STATES if (node := remote.belonging(plc.node, name)) is not None]
    values = [content(value) for value in await remote.read_values(nodes)]
    if len(values) < len(_STATES) or values[0] is None:
        return None
    connected, mode, scan_time, errors = values
    return PlcState(plc.item_id, bool(connected), str(mode), float(scan_time or 0), int(errors or 0))


async def switch(url: str, plc: str, method: str) -> tuple[str, str]:
    """Call ``Run`` or ``Stop`` of a PLC; its name as written, and the mode it is in then."""
    async with connect(url) as remote:
        target = await _plc(remote, plc)
        await _call_plc(remote, target, method)
        state = await _state(remote, target)
        return target.item_id, state.mode if state is not None else "UNKNOWN"


async def download(url: str, plc: str, name: str, program: bytes) -> tuple[str, bool, list[str]]:
    """Give a PLC a program: the PLC's name as written, whether it was taken, and what is wrong with it."""
    async with connect(url) as remote:
        target = await _plc(remote, plc)
        arguments = (ua.Variant(name, ua.VariantType.String), ua.Variant(program, ua.VariantType.ByteString))
        accepted, problems = await _call_plc(remote, target, "Download", *arguments)
        return target.item_id, bool(accepted), list(problems or [])


async def _plc(remote: Remote, name: str) -> Target:
    (found,) = await resolve(remote, [name])
    if isinstance(found, Unknown):
        raise Failed(found.message)
    return found


async def _call_plc(remote: Remote, plc: Target, method: str, *arguments: ua.Variant) -> list[Any]:
    place = remote.belonging(plc.node, method)
    if place is None:
        raise Failed(f"{plc.item_id} is no PLC of pcaccess")
    try:
        return await _call(remote, plc.node, place, *arguments)
    except MethodFailed as failed:
        if failed.status in _NO_METHOD:
            raise Failed(f"{plc.item_id} runs no program; only a soft-PLC with a program: does that") from None
        raise


_NO_METHOD: Final = frozenset(
    {
        StatusCodes.BadMethodInvalid,
        StatusCodes.BadNodeIdInvalid,
        StatusCodes.BadNodeIdUnknown,
        StatusCodes.BadNotSupported,
    }
)
"""What servers answer when there is no such method (OPC UA Part 4, Call, and what is found in practice)."""


class MethodFailed(Failed):
    """The server refused the call."""

    def __init__(self, message: str, status: int) -> None:
        super().__init__(message)
        self.status = status


async def _call(remote: Remote, owner: ua.NodeId, method: ua.NodeId, *arguments: ua.Variant) -> list[Any]:
    result = await remote.call(owner, method, arguments)
    status = int(result.StatusCode.value)
    if status:
        raise MethodFailed(f"{remote.url} refused: {status_text(status)}", status)
    return [argument.Value for argument in result.OutputArguments or []]


def _of_gateway(remote: Remote, path: str) -> ua.NodeId:
    node = remote.of_system(path)
    if node is None:
        raise Failed(f"{remote.url} is not pcaccess")
    return node
