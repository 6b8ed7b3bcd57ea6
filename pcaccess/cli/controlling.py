"""Methods and states of a running gateway, asked for over OPC UA."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from asyncua import ua
from asyncua.ua.object_ids import ObjectIds
from asyncua.ua.status_codes import StatusCodes

from pcaccess.cli.failures import Failed
from pcaccess.cli.names import content
from pcaccess.cli.output import Cell, Column, Row
from pcaccess.cli.remote import Remote, connect, status_text
from pcaccess.problems import nearest_word

STATUS_COLUMNS: Final = (
    Column("PLC"),
    Column("Connected"),
    Column("Mode"),
    Column("Scan Time", right=True),
    Column("Errors", right=True),
)
PLCS_SHOWN: Final = 10
"""So many are named when a name is not one of them."""
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
        there = await _plcs(remote)
        states, errors = [], []
        for name in names or [remote.name(plc) for plc in there]:
            try:
                states.append(await _state(remote, _find(remote, name, there)))
            except NoSuchPlc as failed:
                errors.append(str(failed))
        return states, errors


async def _state(remote: Remote, plc: ua.NodeId) -> PlcState:
    nodes = [node for name in _STATES if (node := remote.belonging(plc, name)) is not None]
    connected, mode, scan_time, errors = map(content, await remote.read_values(nodes))
    return PlcState(remote.name(plc), bool(connected), str(mode), float(scan_time or 0), int(errors or 0))


async def switch(url: str, plc: str, method: str) -> tuple[str, str]:
    """Call ``Run`` or ``Stop`` of a PLC; its name as written, and the mode it is in then."""
    async with connect(url) as remote:
        node = _find(remote, plc, await _plcs(remote))
        await _call_plc(remote, node, method)
        state = await _state(remote, node)
        return state.item_id, state.mode


DOWNLOAD_PATIENCE: Final = 120.0
"""Seconds that checking and compiling a program may take on a small machine that has much to do."""


@dataclass(frozen=True, slots=True)
class Download:
    """What became of a program that a PLC was given."""

    plc: str
    """Its name as written."""
    accepted: bool
    problems: list[str]
    before: str
    """The PLC's mode."""
    mode: str

    def as_json(self) -> dict[str, Any]:
        return {"plc": self.plc, "accepted": self.accepted, "mode": self.mode, "problems": self.problems}


async def download(url: str, plc: str, name: str, program: bytes) -> Download:
    """Give a PLC a program."""
    async with connect(url) as remote:
        node = _find(remote, plc, await _plcs(remote))
        arguments = (ua.Variant(name, ua.VariantType.String), ua.Variant(program, ua.VariantType.ByteString))
        before = await _state(remote, node)
        remote.be_patient(DOWNLOAD_PATIENCE)
        accepted, problems = await _call_plc(remote, node, "Download", *arguments)
        after = await _state(remote, node)
        return Download(after.item_id, bool(accepted), list(problems or []), before.mode, after.mode)


class NoSuchPlc(Failed):
    """The name is not that of a PLC."""


async def _plcs(remote: Remote) -> list[ua.NodeId]:
    """Every PLC of the server, in its order."""
    if remote.items is None:
        raise Failed(f"{remote.url} is not pcaccess and has no PLCs")
    (links,) = await remote.children([remote.roots()])
    below = await remote.children([link.NodeId for link in links])
    return [child.NodeId for children in below for child in children if _is_plc(child)]


def _is_plc(child: ua.ReferenceDescription) -> bool:
    return bool(child.TypeDefinition.Identifier == ObjectIds.BaseObjectType)


def _find(remote: Remote, name: str, plcs: Sequence[ua.NodeId]) -> ua.NodeId:
    """The PLC of that name, in any case, or NodeId; raises NoSuchPlc."""
    by_name = {remote.name(plc).casefold(): plc for plc in plcs}
    wanted = remote.node(name)
    found = by_name.get(remote.name(wanted).casefold()) if wanted is not None else None
    if found is not None:
        return found
    names = [remote.name(plc) for plc in plcs]
    near = _meant(name, names)
    guess = f"; did you mean {near}?" if near else ""
    raise NoSuchPlc(f"there is no PLC {name}; {_there(names)}{guess}")


def _meant(name: str, plcs: Sequence[str]) -> str | None:
    """The PLC of an item, or one with a name like it, with its link or without."""
    folded = name.casefold()
    of_item = next((plc for plc in plcs if folded.startswith(f"{plc.casefold()}.")), None)
    leaves = {plc.rpartition(".")[2]: plc for plc in plcs}
    return of_item or nearest_word(name, plcs) or leaves.get(nearest_word(name.rpartition(".")[2], leaves) or "")


def _there(plcs: Sequence[str]) -> str:
    if not plcs:
        return "the project has none"
    shown = ", ".join(plcs[:PLCS_SHOWN])
    more = f" and {len(plcs) - PLCS_SHOWN} more" if len(plcs) > PLCS_SHOWN else ""
    return f"there {'is' if len(plcs) == 1 else 'are'} {shown}{more}"


async def _call_plc(remote: Remote, plc: ua.NodeId, method: str, *arguments: ua.Variant) -> list[Any]:
    place = remote.belonging(plc, method)
    assert place is not None, "found on a server of ours"
    try:
        return await _call(remote, plc, place, *arguments)
    except MethodFailed as failed:
        if failed.status in _NO_METHOD:
            raise Failed(f"{remote.name(plc)} runs no program; only a soft-PLC with a program: does that") from None
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
