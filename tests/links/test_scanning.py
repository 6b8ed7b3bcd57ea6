"""A soft-PLC that runs a program: whoever writes to it or gives it a program gets an answer, whatever happens."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from pcaccess.gateway.download import Downloaded, download
from pcaccess.links.base import Outcome, RawWrite
from pcaccess.s7200.address import parse_address
from pcaccess.s7200.types import DataType
from tests.gateways import RunningGateway, start_gateway
from tests.opcua.test_programs import plant
from tests.plc.conftest import program

WRITE = RawWrite("", parse_address("VW0"), DataType.INT, b"\x00\x07")
STATION = "MicroWin.NewPLC"


def fail(*_: object, **__: object) -> None:
    raise ZeroDivisionError


async def write(running: RunningGateway) -> list[Outcome]:
    async with asyncio.timeout(40):
        return await running.gateway.driver("MicroWin").write(STATION, [WRITE])


async def test_a_cpu_that_failed_answers_writes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that were waiting, and those that come later: nobody scans any more."""
    async with start_gateway(plant(tmp_path)) as running:
        assert await write(running) == [Outcome.DONE]
        scanning = running.gateway.driver("MicroWin").scanning(STATION)
        monkeypatch.setattr(scanning.cpu, "scan", fail)
        assert await write(running) == [Outcome.DEVICE_FAILURE]
        assert await write(running) == [Outcome.DEVICE_FAILURE]


async def give(running: RunningGateway, text: str) -> Downloaded:
    async with asyncio.timeout(40):
        return await download(running.gateway, STATION, text.encode(), "new.awl")


async def test_a_cpu_that_failed_is_in_stop_and_runs_again_when_it_is_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with start_gateway(plant(tmp_path)) as running:
        assert await write(running) == [Outcome.DONE]
        scanning = running.gateway.driver("MicroWin").scanning(STATION)
        with monkeypatch.context() as broken:
            broken.setattr(scanning.cpu, "scan", fail)
            assert await write(running) == [Outcome.DEVICE_FAILURE]
        assert scanning.status().mode == "STOP"
        scanning.start()
        assert await write(running) == [Outcome.DONE]
        assert scanning.status().mode == "RUN"


async def test_another_program_mends_a_cpu_that_failed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async with start_gateway(plant(tmp_path)) as running:
        scanning = running.gateway.driver("MicroWin").scanning(STATION)
        with monkeypatch.context() as broken:
            broken.setattr(scanning.cpu, "scan", fail)
            done = await give(running, "LD SM0.0\nINCW VW100\n")
            assert (done.accepted, done.lines) == (
                False,
                ["new.awl: the CPU failed with it; the log of pcaccess run says more"],
            )
        assert (await give(running, "LD SM0.0\nINCW VW100\n")).accepted
        assert await write(running) == [Outcome.DONE]


async def test_a_program_that_is_overtaken_says_so(tmp_path: Path) -> None:
    async with start_gateway(plant(tmp_path)) as running:
        scanning = running.gateway.driver("MicroWin").scanning(STATION)
        first = scanning.exchange(program("LD SM0.0\nINCW VW100\n"))
        second = scanning.exchange(program("LD SM0.0\nINCW VW102\n"))
        async with asyncio.timeout(40):
            assert await first == "another program came before this one was compiled"
            assert await second == ""


async def test_a_program_that_cannot_be_compiled_says_so_and_the_old_one_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Our own mistake, if it ever happens."""
    async with start_gateway(plant(tmp_path)) as running:
        scanning = running.gateway.driver("MicroWin").scanning(STATION)
        monkeypatch.setattr(scanning.cpu, "prepare", fail)
        done = await give(running, "LD SM0.0\nINCW VW100\n")
        assert (done.accepted, done.lines) == (
            False,
            ["new.awl: it cannot be compiled; the log of pcaccess run says why"],
        )
        assert await write(running) == [Outcome.DONE]


async def test_of_two_programs_given_at_once_the_later_one_runs_in_the_end(tmp_path: Path) -> None:
    large = "LD SM0.0\nMOVW 1, VW100\n" + "INCW VW102\n" * 500
    async with start_gateway(plant(tmp_path)) as running:
        scanning = running.gateway.driver("MicroWin").scanning(STATION)
        both = await asyncio.gather(give(running, large), give(running, "LD SM0.0\nMOVW 2, VW100\n"))
        assert [done.accepted for done in both] == [True, True]
        assert await write(running) == [Outcome.DONE]
        assert scanning.cpu.read(parse_address("VW100"), DataType.INT) == 2
