"""Values in and out of a gateway with memory-only PLCs."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from pcaccess.gateway.gateway import Gateway
from pcaccess.items.quality import Quality
from pcaccess.links.base import Outcome
from tests.clocks import HandClock

MakeGateway = Callable[[str], Gateway]

TWO_VIEWS = """
project: Test
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: P
        address: 2
        cpu: CPU 224
        items:
          - {name: Word, address: VW0, type: INT}
          - {name: Low, address: VB1, type: BYTE}
          - {name: Bit, address: V1.3, type: BOOL}
          - {name: Fixed, address: VW4, type: INT, access: R}
          - {name: Text, address: VB100, type: STRING, length: 5}
          - {name: Row, address: "VW20[3]", type: INT}
          - {name: Scaled, address: VW40, type: REAL, scaling: {raw: [0, 1000], scaled: [0, 10]}}
          - {name: Limited, address: VW50, type: INT, high: 100, low: -100, write_limits: refuse}
          - {name: Clamped, address: VW52, type: INT, high: 100, low: -100, write_limits: clamp}
          - {name: Between, address: VW54, type: INT, high: 10.5, low: 0.5, write_limits: clamp}
          - {name: Always, address: SM0.0, type: BOOL}
          - {name: Clock, address: SM0.5, type: BOOL}
          - {name: Timer, address: T37, type: INT}
          - {name: TimerBit, address: T37, type: BOOL}
      - name: Gone
        address: 3
        connected: false
        items:
          - {name: Word, address: VW0, type: INT}
"""


def row(gateway: Gateway, name: str) -> int:
    found = gateway.find(name)
    assert found is not None
    return found


def value(gateway: Gateway, name: str) -> object:
    return gateway.sample(row(gateway, name)).value


async def write(gateway: Gateway, name: str, new: object) -> Outcome:
    return (await gateway.write([(row(gateway, name), new)]))[0]  # type: ignore[list-item]


async def test_items_over_the_same_bytes_agree(gateway: MakeGateway) -> None:
    g = gateway(TWO_VIEWS)
    assert await write(g, "MicroWin.P.Word", 0x0108) is Outcome.DONE
    assert (value(g, "MicroWin.P.Low"), value(g, "MicroWin.P.Bit")) == (8, True)
    assert await write(g, "MicroWin.P.Bit", False) is Outcome.DONE
    assert value(g, "MicroWin.P.Word") == 0x0100
    assert await write(g, "MicroWin.P.Low", 7) is Outcome.DONE
    assert value(g, "MicroWin.P.Word") == 0x0107


async def test_ids_are_found_in_any_case_and_unknown_ones_are_not(gateway: MakeGateway) -> None:
    g = gateway(TWO_VIEWS)
    assert g.find("microwin.p.WORD") == g.find("MicroWin.P.Word")
    assert g.find("MicroWin.P.Nothing") is None


@pytest.mark.parametrize(
    ("name", "new", "expected"),
    [
        ("Fixed", 1, Outcome.NOT_WRITABLE),
        ("Word", "text", Outcome.TYPE_MISMATCH),
        ("Word", 1.5, Outcome.TYPE_MISMATCH),
        ("Word", 40000, Outcome.OUT_OF_RANGE),
        ("Word", [1], Outcome.TYPE_MISMATCH),
        ("Row", 1, Outcome.TYPE_MISMATCH),
        ("Row", [1, 2], Outcome.TYPE_MISMATCH),
        ("Row", [1, 2, 70000], Outcome.OUT_OF_RANGE),
        ("Text", "longer", Outcome.OUT_OF_RANGE),
        ("Text", "日", Outcome.OUT_OF_RANGE),
        ("Scaled", 400.0, Outcome.OUT_OF_RANGE),
        ("Scaled", float("nan"), Outcome.OUT_OF_RANGE),
        ("Limited", 101, Outcome.OUT_OF_RANGE),
    ],
)
async def test_a_write_that_cannot_be_is_refused_and_changes_nothing(
    gateway: MakeGateway, name: str, new: object, expected: Outcome
) -> None:
    g = gateway(TWO_VIEWS)
    before = value(g, f"MicroWin.P.{name}")
    assert await write(g, f"MicroWin.P.{name}", new) is expected
    assert value(g, f"MicroWin.P.{name}") == before


@pytest.mark.parametrize(
    ("name", "new", "reads"),
    [
        ("Text", "hello", "hello"),
        ("Text", "", ""),
        ("Row", [1, -2, 3], [1, -2, 3]),
        ("Scaled", 2.5, 2.5),
        ("Limited", -100, -100),
        ("Clamped", 5000, 100),
        ("Clamped", -5000, -100),
        ("Between", 5000, 10),
        ("Between", -5000, 1),
        ("Timer", 17, 17),
        ("TimerBit", True, True),
    ],
)
async def test_a_written_value_is_what_reads_back(gateway: MakeGateway, name: str, new: object, reads: object) -> None:
    g = gateway(TWO_VIEWS)
    assert await write(g, f"MicroWin.P.{name}", new) is Outcome.DONE
    assert value(g, f"MicroWin.P.{name}") == reads


async def test_a_scaled_write_lands_as_the_nearest_raw_number(gateway: MakeGateway) -> None:
    g = gateway(TWO_VIEWS.replace("- {name: Low,", "- {name: Raw, address: VW40, type: INT}\n          - {name: Low,"))
    await write(g, "MicroWin.P.Scaled", 2.4996)
    assert value(g, "MicroWin.P.Raw") == 250


async def test_a_plc_that_is_not_connected_shows_it_on_all_its_items_and_only_there(gateway: MakeGateway) -> None:
    g = gateway(TWO_VIEWS)
    assert g.sample(row(g, "MicroWin.Gone.Word")).quality is Quality.NOT_CONNECTED
    assert g.sample(row(g, "MicroWin.P.Word")).quality is Quality.GOOD
    assert await write(g, "MicroWin.Gone.Word", 5) is Outcome.NOT_CONNECTED
    assert (g.stations["MicroWin.Gone"].status.mode, g.stations["MicroWin.P"].status.mode) == ("UNKNOWN", "STOP")


async def test_special_memory_without_a_cpu_is_out_of_service_unless_memory_alone_makes_it_true(
    gateway: MakeGateway,
) -> None:
    g = gateway(TWO_VIEWS)
    assert g.sample(row(g, "MicroWin.P.Clock")).quality is Quality.OUT_OF_SERVICE
    always = g.sample(row(g, "MicroWin.P.Always"))
    assert (always.value, always.quality) == (True, Quality.GOOD)


async def test_a_read_of_plain_memory_is_as_old_as_the_question(gateway: MakeGateway, clock: HandClock) -> None:
    g = gateway(TWO_VIEWS)
    clock.move(60)
    await g.read([row(g, "MicroWin.P.Word"), row(g, "MicroWin.Gone.Word")])
    assert g.sample(row(g, "MicroWin.P.Word")).time == clock.now()
    assert (clock.now() - g.sample(row(g, "MicroWin.Gone.Word")).time).total_seconds() == 60


async def test_writes_of_one_request_go_to_their_plcs_and_are_answered_in_order(gateway: MakeGateway) -> None:
    g = gateway(TWO_VIEWS)
    names = ["MicroWin.P.Word", "MicroWin.Gone.Word", "MicroWin.P.Fixed", "MicroWin.P.Low"]
    outcomes = await g.write([(row(g, name), 9) for name in names])
    assert outcomes == [Outcome.DONE, Outcome.NOT_CONNECTED, Outcome.NOT_WRITABLE, Outcome.DONE]
    assert value(g, "MicroWin.P.Word") == 9


async def test_the_last_of_two_writes_to_one_item_stays(gateway: MakeGateway) -> None:
    g = gateway(TWO_VIEWS)
    word = row(g, "MicroWin.P.Word")
    assert await g.write([(word, 1), (word, 2)]) == [Outcome.DONE, Outcome.DONE]
    assert value(g, "MicroWin.P.Word") == 2
