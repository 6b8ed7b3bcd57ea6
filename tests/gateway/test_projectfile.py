"""Saving the project file under a running gateway."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.projectfile import ProjectFile
from pcaccess.project.load import load_project
from tests.clocks import HandClock

ONE = """
project: Test
links:
  - {name: L, type: soft, plcs: [{name: P, address: 2, items: [{name: A, address: VW0, type: INT}]}]}
"""
TWO = ONE.replace("{name: A,", "{name: B, address: VW2, type: INT}, {name: A,")
BROKEN = ONE.replace("VW0", "VX")


class Running:
    """A gateway and its file; ``look`` lets the watcher look at it twice."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.clock = HandClock()
        path.write_text(ONE)
        loaded = load_project(path)
        self.gateway = Gateway(loaded.project, self.clock)
        self.file = ProjectFile(self.gateway, path, loaded)

    async def save(self, text: str) -> None:
        """As editors do it: a new file takes the old one's name."""
        fresh = self.path.with_suffix(".new")
        fresh.write_text(text)
        fresh.replace(self.path)
        changed = asyncio.Event()
        self.gateway.on_structure(changed.set)
        await self.clock.advance(1.1)
        if text != BROKEN:
            await asyncio.wait_for(changed.wait(), 10)


@pytest.fixture
async def running(tmp_path: Path) -> AsyncIterator[Running]:
    made = Running(tmp_path / "items.yaml")
    task = asyncio.get_running_loop().create_task(made.file.run())
    await made.clock.settle()
    yield made
    task.cancel()


async def test_a_saved_file_is_applied(running: Running) -> None:
    assert running.gateway.find("L.P.B") is None
    await running.save(TWO)
    assert running.gateway.find("L.P.B") is not None


async def test_a_broken_file_changes_nothing_and_says_why(running: Running, caplog: pytest.LogCaptureFixture) -> None:
    running.path.write_text(BROKEN)
    reloaded = await running.file.reload()
    assert reloaded.applied is None
    assert [problem.span.line for problem in reloaded.problems] == [4]
    assert "goes on as before" in caplog.text
    assert running.gateway.find("L.P.A") is not None


async def test_a_broken_file_that_is_mended_is_applied(running: Running) -> None:
    await running.save(BROKEN)
    await running.save(TWO)
    assert running.gateway.find("L.P.B") is not None


async def test_a_saved_symbol_table_changes_the_program_beside_it(running: Running) -> None:
    (running.path.parent / "p.awl").write_text("LD SM0.0\nMOVW Start, VW0\n")
    table = running.path.with_name("p.sym")
    table.write_text("Start\t5\t\n")
    await running.save(ONE.replace("address: 2,", "address: 2, program: p.awl,"))
    five = running.gateway.programs.by_station["L.P"]
    table.write_text("Start\t1234\t\n")
    changed = asyncio.Event()
    running.gateway.on_structure(changed.set)
    await running.clock.advance(1.1)
    await asyncio.wait_for(changed.wait(), 10)
    assert running.gateway.programs.by_station["L.P"] != five


async def test_a_program_that_changed_is_told(running: Running) -> None:
    (running.path.parent / "p.awl").write_text("LD SM0.0\nMOVW 5, VW0\n")
    running.path.write_text(ONE.replace("address: 2,", "address: 2, program: p.awl,"))
    await running.file.reload()
    assert str(await running.file.reload()) == "nothing changed"
    (running.path.parent / "p.awl").write_text("LD SM0.0\nMOVW 6, VW0\n")
    assert str(await running.file.reload()) == "1 program changed"


async def test_a_file_that_is_gone_changes_nothing(running: Running) -> None:
    running.path.unlink()
    await running.clock.advance(5)
    assert running.gateway.find("L.P.A") is not None
