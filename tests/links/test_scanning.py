"""A soft-PLC that runs a program: whoever writes to it gets an answer."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from pcaccess.links.base import Outcome, RawWrite
from pcaccess.s7200.address import parse_address
from pcaccess.s7200.types import DataType
from tests.gateways import RunningGateway, start_gateway
from tests.opcua.test_programs import plant

WRITE = RawWrite("", parse_address("VW0"), DataType.INT, b"\x00\x07")
STATION = "MicroWin.NewPLC"


async def write(running: RunningGateway) -> list[Outcome]:
    async with asyncio.timeout(40):
        return await running.gateway.driver("MicroWin").write(STATION, [WRITE])


async def test_a_cpu_that_failed_answers_writes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that were waiting, and those that come later: nobody scans any more."""
    async with start_gateway(plant(tmp_path)) as running:
        assert await write(running) == [Outcome.DONE]
        scanning = running.gateway.driver("MicroWin").scanning(STATION)
        monkeypatch.setattr(scanning, "scan", lambda: 1 / 0)
        assert await write(running) == [Outcome.DEVICE_FAILURE]
        assert await write(running) == [Outcome.DEVICE_FAILURE]
