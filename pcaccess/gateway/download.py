"""A new program for a soft-PLC that runs: checked beside the old one, taken between two scans, memory kept.

The project file is not touched: the next start runs what ``program:`` names.
"""

from __future__ import annotations

import asyncio
import logging
from dataclasses import dataclass

from pcaccess.collector import paused
from pcaccess.gateway.gateway import Gateway
from pcaccess.links.soft import SoftLink
from pcaccess.problems import Problem
from pcaccess.s7200.cpu import CpuModel
from pcaccess.stl.checker import load_program
from pcaccess.stl.reader import ReadResult

log = logging.getLogger(__name__)


class DownloadError(Exception):
    """The PLC cannot take a program at all; the message says why."""


@dataclass(frozen=True, slots=True)
class Downloaded:
    """``accepted`` is False when there are errors, or ``why`` says something; then the old program goes on."""

    accepted: bool
    problems: tuple[Problem, ...]
    why: str = ""

    @property
    def lines(self) -> list[str]:
        """For people."""
        return [*map(str, self.problems), *([self.why] if self.why else [])]


async def download(gateway: Gateway, plc: str, data: bytes, name: str) -> Downloaded:
    """Give the PLC ``Link.PLC`` the program in ``data``; ``name`` stands for it in messages."""
    station = gateway.stations.get(plc)
    link = station.link if station is not None else None
    cpu = link.scanning(plc) if isinstance(link, SoftLink) else None
    if station is None or cpu is None:
        raise DownloadError(f"{plc} runs no program; only a soft PLC with a 'program:' takes one")
    async with cpu.giving:
        result = await asyncio.to_thread(_load, data, station.plc.cpu, name)
        if not result.ok:
            return Downloaded(False, result.problems)
        why = await cpu.exchange(result.unwrap())
    if why:
        return Downloaded(False, result.problems, f"{name}: {why}")
    log.info("%s: program %s downloaded", plc, name)
    return Downloaded(True, result.problems)


def _load(data: bytes, cpu: CpuModel, name: str) -> ReadResult:
    """In another thread; a collection would stop all of them for as long as it takes."""
    with paused():
        return load_program(data, cpu, file=name)
