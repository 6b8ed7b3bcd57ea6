"""The command, run in this process beside a gateway, or as a process of its own."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest
import pytest_asyncio
from typer.testing import CliRunner

from pcaccess.cli.main import app
from tests.gateways import RunningGateway, start_gateway

PLANT = """
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: NewPLC
        cpu: CPU 224
        description: The press
        items:
          - {name: Motor, address: Q0.0, type: BOOL, access: RW, description: Contactor}
          - {name: Temperature, address: VW0, type: INT, access: RW, high: 1000, low: 200, unit: °C}
          - {name: Setpoint, address: VW200, type: INT, access: RW, high: 100, low: 0, write_limits: refuse}
          - {name: Level, address: VD204, type: REAL, access: RW}
          - {name: Text, address: VB300, type: STRING, length: 10, access: RW}
          - {name: Row, address: "VW400[3]", type: INT, access: RW}
          - {name: Input, address: I0.1, type: BOOL, access: R}
          - {name: Command, address: VW600, type: INT, access: W}
        folders:
          - {name: USR1, items: [{name: COUNTER_1, address: VW700, type: INT, access: RW}]}
      - {name: Away, items: [{name: Value, address: VW0, type: INT}]}
      - name: Dead
        connected: false
        items: [{name: Value, address: VW0, type: INT, access: RW}]
groups:
  - {name: Fast, update_rate: 250ms, items: [MicroWin.NewPLC.Motor, MicroWin.NewPLC.Level]}
"""


@dataclass(frozen=True)
class Outcome:
    """What a command printed and how it ended."""

    code: int
    out: str
    err: str

    @property
    def lines(self) -> list[str]:
        return self.out.splitlines()


def invoke(*arguments: str) -> Outcome:
    """Run the command in this thread."""
    result = CliRunner().invoke(app, arguments)
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return Outcome(result.exit_code, result.stdout, result.stderr)


Command = Callable[..., Awaitable[Outcome]]


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def plant() -> AsyncIterator[RunningGateway]:
    """The project ``PLANT``, served to all tests of a module (a server takes a second to start).

    Tests that use it run in the module's loop, and change nothing that another of them looks at.
    """
    async with start_gateway(PLANT) as running:
        yield running


@pytest.fixture
def client(plant: RunningGateway, monkeypatch: pytest.MonkeyPatch) -> Command:
    """A client command against ``plant``, in a thread of its own as it has an event loop of its own."""
    monkeypatch.setenv("PCACCESS_URL", plant.url)

    async def run(*arguments: Any) -> Outcome:
        return await asyncio.to_thread(invoke, *map(str, arguments))

    return run


@pytest.fixture
def unused_port() -> Iterator[int]:
    """A port of the loopback that nobody listens on: it is bound for the test, and no more."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        yield taken.getsockname()[1]
