"""Simulated items: what each wave gives over time."""

from __future__ import annotations

import asyncio

import pytest

from pcaccess.gateway.gateway import Gateway
from pcaccess.items.quality import Limit, Quality
from pcaccess.links.base import Outcome
from pcaccess.project.load import load_text
from tests.clocks import HandClock

PROJECT = """
project: Test
links:
  - name: Sim
    type: sim
    plcs:
      - name: D
        items:
          - {name: Ramp, address: "RAMP(10s, 0, 100)", type: REAL}
          - {name: RampInt, address: "RAMP(10s, 0, 100)", type: INT}
          - {name: Sine, address: "SINE(10s, 0, 100)", type: REAL}
          - {name: Toggle, address: "TOGGLE(1s)", type: BOOL}
          - {name: Counter, address: "COUNTER(1s)", type: DINT}
          - {name: Wraps, address: "COUNTER(1s)", type: BYTE}
          - {name: Random, address: "RANDOM(1s, 10, 20)", type: REAL}
          - {name: Other, address: "RANDOM(1s, 10, 20)", type: REAL}
          - {name: Const, address: "CONST(7)", type: INT}
          - {name: Text, address: "CONST('abc')", type: STRING}
          - {name: Failed, address: "QUALITY(25, 3)", type: INT}
      - name: Away
        connected: false
        items: [{name: Ramp, address: "RAMP(10s, 0, 100)", type: REAL}]
"""


class Sim:
    """A gateway with one sim link and a clock moved by hand."""

    def __init__(self) -> None:
        self.clock = HandClock()
        self.gateway = Gateway(load_text(PROJECT).project, self.clock)
        self.gateway.show()

    def row(self, name: str) -> int:
        row = self.gateway.find(f"Sim.{name}")
        assert row is not None
        return row

    def at(self, seconds: float, name: str) -> object:
        self.clock.move(seconds - self.clock.monotonic())
        self.gateway.show()
        return self.gateway.sample(self.row(name)).value


@pytest.mark.parametrize(
    ("name", "at", "expected"),
    [
        ("D.Ramp", 0.0, 0.0),
        ("D.Ramp", 2.5, 25.0),
        ("D.Ramp", 12.5, 25.0),
        ("D.RampInt", 3.336, 33),
        ("D.Sine", 0.0, 50.0),
        ("D.Sine", 2.5, 100.0),
        ("D.Sine", 7.5, 0.0),
        ("D.Toggle", 0.5, False),
        ("D.Toggle", 1.5, True),
        ("D.Toggle", 2.5, False),
        ("D.Counter", 41.5, 41),
        ("D.Wraps", 257.5, 1),
        ("D.Const", 99.0, 7),
        ("D.Text", 99.0, "abc"),
    ],
)
def test_a_wave_has_its_value_at_its_time(name: str, at: float, expected: object) -> None:
    assert Sim().at(at, name) == (pytest.approx(expected, abs=1e-4) if isinstance(expected, float) else expected)


def test_random_values_change_each_period_stay_in_range_and_differ_between_items() -> None:
    sim = Sim()
    values = [sim.at(n + 0.5, "D.Random") for n in range(50)]
    assert all(10 <= v < 20 for v in values if isinstance(v, float))
    assert len(set(values)) == 50
    assert sim.at(50.1, "D.Random") == sim.at(50.9, "D.Random")
    assert sim.at(50.9, "D.Random") != sim.at(50.9, "D.Other")


def test_a_quality_item_has_the_quality_and_limit_it_is_told() -> None:
    sim = Sim()
    sample = sim.gateway.sample(sim.row("D.Failed"))
    assert (sample.value, sample.quality, sample.limit) == (3, Quality.COMM_FAILURE, Limit.LOW)


def test_items_of_a_plc_that_is_not_connected_do_not_move() -> None:
    sim = Sim()
    sim.at(5.0, "Away.Ramp")
    assert sim.gateway.sample(sim.row("Away.Ramp")).quality is Quality.NOT_CONNECTED


async def test_constants_can_be_written_and_keep_the_value() -> None:
    sim = Sim()
    outcomes = await sim.gateway.write([(sim.row("D.Const"), 9), (sim.row("D.Text"), "x"), (sim.row("D.Ramp"), 1.0)])
    assert outcomes == [Outcome.DONE, Outcome.DONE, Outcome.NOT_WRITABLE]
    assert (sim.at(50.0, "D.Const"), sim.at(50.0, "D.Text")) == (9, "x")


async def test_the_running_link_moves_its_items_every_tick() -> None:
    sim = Sim()
    async with asyncio.TaskGroup() as group:
        running = group.create_task(sim.gateway.run())
        await sim.clock.advance(2.55)
        sample = sim.gateway.sample(sim.row("D.Ramp"))
        assert sample.value == pytest.approx(25.0)
        assert (sim.clock.now() - sample.time).total_seconds() < 0.1
        running.cancel()
