"""Run-time names that nobody configured."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest

from pcaccess.gateway.gateway import Gateway
from pcaccess.items.quality import Quality
from pcaccess.links.base import Outcome
from tests.clocks import HandClock

MakeGateway = Callable[[str], Gateway]

PROJECT = """
project: Test
dynamic_items: {access: RW, max: 3, idle: 10min}
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: P
        address: 2
        cpu: CPU 222
        items:
          - {name: Temperature, address: VW0, type: INT, access: RW, high: 1000, low: 200}
          - {name: Fixed, address: VW10, type: INT, access: R}
          - {name: FixedBit, address: M0.1, type: BOOL, access: R}
          - {name: Pressure, address: VW20, type: REAL, scaling: {raw: [0, 100], scaled: [0, 1]}}
  - name: Other
    type: soft
    plcs: [{name: Q, address: 3, connected: false}]
"""


async def test_the_run_time_name_of_an_item_is_the_same_item(gateway: MakeGateway) -> None:
    g = gateway(PROJECT)
    for name in ("Temperature", "Fixed", "FixedBit", "Pressure"):
        row = g.find(f"MicroWin.P.{name}")
        assert row is not None
        assert g.find(g.item(row).run_time_name) == row
        assert g.find(g.item(row).run_time_name.upper()) == row
        assert g.find(g.item(row).run_time_name.removeprefix("MicroWin:")) == row
    assert g.find("2,vw0,int") == g.find("MicroWin.P.Temperature")
    assert len(g.dynamic) == 0


async def test_a_new_name_makes_an_item_that_works_at_once(gateway: MakeGateway) -> None:
    g = gateway(PROJECT)
    row = g.find("2,QB0,byte")
    assert row is not None
    assert (g.sample(row).value, g.sample(row).quality) == (0, Quality.GOOD)
    assert await g.write([(row, 255)]) == [Outcome.DONE]
    bit = g.find("MicroWin:2:0.0.0.0:0000:0000,Q0.7,BOOL")
    assert bit is not None
    assert g.sample(bit).value is True


async def test_the_same_name_in_another_spelling_is_the_same_item(gateway: MakeGateway) -> None:
    g = gateway(PROJECT)
    row = g.find("2,QB0,BYTE")
    assert g.find("microwin:2:0.0.0.0:0000:0000,qb0,byte,rw") == row
    assert g.find("2,QB0") == row
    assert len(g.dynamic) == 1


async def test_a_dynamic_item_of_a_plc_that_is_away_says_so(gateway: MakeGateway) -> None:
    g = gateway(PROJECT)
    row = g.find("3,VW0,INT")
    assert row is not None
    assert g.sample(row).quality is Quality.NOT_CONNECTED


@pytest.mark.parametrize(
    "name",
    [
        "2,VW0,BOOL",
        "9,VW0,INT",
        "2,VB5000,BYTE",
        "Nowhere:2:0.0.0.0:0000:0000,VW0,INT",
        "2,FOO,INT",
        ",,,",
        "2,VW0,INT,X",
    ],
)
async def test_nonsense_stays_unknown(gateway: MakeGateway, name: str) -> None:
    g = gateway(PROJECT)
    assert g.find(name) is None
    assert len(g.dynamic) == 0


@pytest.mark.parametrize(
    ("name", "outcome"),
    [
        ("2,VB10,BYTE", Outcome.NOT_WRITABLE),
        ("2,VD8,DINT", Outcome.NOT_WRITABLE),
        ("2,VW12,INT", Outcome.DONE),
        ("2,MB0,BYTE", Outcome.NOT_WRITABLE),
        ("2,M0.1,BOOL,RW", Outcome.NOT_WRITABLE),
        ("2,M0.2,BOOL", Outcome.DONE),
        ("2,VW30,INT,R", Outcome.NOT_WRITABLE),
    ],
)
async def test_a_dynamic_name_has_no_more_access_than_the_item_it_covers(
    gateway: MakeGateway, name: str, outcome: Outcome
) -> None:
    g = gateway(PROJECT)
    row = g.find(name)
    assert row is not None
    assert await g.write([(row, 1)]) == [outcome]


async def test_the_project_may_make_dynamic_items_read_only(gateway: MakeGateway) -> None:
    g = gateway(PROJECT.replace("access: RW, max: 3", "access: R, max: 3"))
    row = g.find("2,QB0,BYTE")
    assert row is not None
    assert await g.write([(row, 1)]) == [Outcome.NOT_WRITABLE]


async def test_a_short_name_that_fits_two_links_is_unknown_and_the_log_names_both(
    gateway: MakeGateway, caplog: pytest.LogCaptureFixture
) -> None:
    g = gateway(PROJECT.replace("address: 3", "address: 2"))
    assert g.find("2,QB0,BYTE") is None
    assert "MicroWin.P and Other.Q" in caplog.text
    assert g.find("MicroWin:2,QB0,BYTE") is not None


async def test_idle_items_go_and_used_or_watched_ones_stay(gateway: MakeGateway, clock: HandClock) -> None:
    g = gateway(PROJECT)
    _, used, watched = (g.find(name) for name in ("2,QB0,BYTE", "2,QB1,BYTE", "2,QB2,BYTE"))
    assert watched is not None
    g.dynamic.hold(lambda: [watched])
    clock.move(599)
    assert g.find("2,QB1,BYTE") == used
    clock.move(2)
    g.dynamic.sweep()
    assert len(g.dynamic) == 2
    assert g.table.find("2,QB0,BYTE") is None
    assert g.find("2,QB0,BYTE") is not None  # named again, made again


async def test_beyond_the_bound_no_more_are_made_until_some_are_idle(gateway: MakeGateway, clock: HandClock) -> None:
    g = gateway(PROJECT)
    assert None not in [g.find(f"2,QB{n},BYTE") for n in range(3)]
    assert g.find("2,QB3,BYTE") is None
    clock.move(601)
    assert g.find("2,QB3,BYTE") is not None
    assert len(g.dynamic) == 1


async def test_the_running_gateway_sweeps_by_itself(gateway: MakeGateway, clock: HandClock) -> None:
    g = gateway(PROJECT)
    assert g.find("2,QB0,BYTE") is not None
    async with asyncio.TaskGroup() as group:
        running = group.create_task(g.run())
        await clock.advance(700)
        assert len(g.dynamic) == 0
        running.cancel()


async def test_the_root_of_pc_access_is_any_link_where_no_link_has_its_name(gateway: MakeGateway) -> None:
    g = gateway(PROJECT)
    assert g.find("MWSMART:2:0.0.0.0:0201:0201,VW0,INT,RW") == g.find("MicroWin.P.Temperature")
    assert g.find("MicroWin:3,VW0,INT") is None, "a link is called MicroWin, and it has no station 3"


async def test_a_name_that_fits_two_links_is_told_once_and_not_with_every_request(
    gateway: MakeGateway, caplog: pytest.LogCaptureFixture
) -> None:
    g = gateway(PROJECT.replace("address: 3", "address: 2"))
    for _ in range(3):
        assert g.find("2,VW0,INT") is None
    (told,) = caplog.messages
    assert told == "2,VW0,INT fits MicroWin.P and Other.Q; put the link's name in front"
