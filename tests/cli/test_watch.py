"""watch: changes as lines, as JSON, as a live table; limits; groups; a server that goes and comes back."""

from __future__ import annotations

import asyncio
import io
import json
import re
from collections.abc import Sequence
from contextlib import AsyncExitStack

import pytest
from asyncua import ua
from rich.console import Console

from pcaccess.cli.samples import Shown
from pcaccess.cli.views import LiveTable
from pcaccess.cli.watching import Wanted, watch
from pcaccess.clock import SystemClock
from pcaccess.items.quality import Quality
from tests.cli.conftest import PLANT, Command
from tests.gateways import PATIENCE, RunningGateway, start_gateway

pytestmark = pytest.mark.asyncio(loop_scope="module")

PLC = "MicroWin.NewPLC"


class Seen:
    """A view that can be waited for."""

    def __init__(self) -> None:
        self.items: list[str] = []
        self.interval = 0.0
        self.remarks: list[str] = []
        self.missing: list[tuple[str, bool]] = []
        self._samples: asyncio.Queue[Shown] = asyncio.Queue()

    def begin(self, items: Sequence[str], interval: float) -> None:
        self.items, self.interval = list(items), interval

    def show(self, samples: Sequence[Shown]) -> None:
        for sample in samples:
            self._samples.put_nowait(sample)

    def remark(self, text: str) -> None:
        self.remarks.append(text)

    def left_out(self, why: str, *, is_failure: bool) -> None:
        self.missing.append((why, is_failure))

    async def next(self) -> tuple[str, object, int]:
        sample = await asyncio.wait_for(self._samples.get(), PATIENCE)
        return sample.item_id, sample.value, sample.quality


class NoWaiting(SystemClock):
    """Attempts to reach a server again come at once."""

    async def sleep(self, seconds: float) -> None:
        await super().sleep(0.01)


# -- what is printed -----------------------------------------------------------------------------------------------


async def test_without_a_terminal_every_change_is_a_line(client: Command) -> None:
    outcome = await client("watch", f"{PLC}.Input", "MicroWin.Dead.*", "--count", "2")
    assert outcome.code == 0
    assert outcome.lines[0] == "Item ID                Value         Time Stamp               Quality"
    assert sorted(re.sub(r"\d{4}-.{19}", "<time>                 ", line) for line in outcome.lines[1:]) == [
        "MicroWin.Dead.Value    0             <time>                    8 NOT_CONNECTED",
        "MicroWin.NewPLC.Input  false         <time>                  192 GOOD",
    ]


async def test_programs_get_an_object_per_change(client: Command) -> None:
    outcome = await client("watch", f"{PLC}.Input", "--json", "--count", "1")
    (sample,) = map(json.loads, outcome.lines)
    assert list(sample) == ["id", "value", "type", "quality", "quality_name", "status", "source_timestamp"]
    assert (sample["id"], sample["value"], sample["quality"]) == (f"{PLC}.Input", False, 192)


async def test_a_terminal_shows_every_item_in_its_line(client: Command) -> None:
    screen = Console(file=io.StringIO(), force_terminal=True, width=100, height=30, color_system=None)
    table = LiveTable("opc.tcp://127.0.0.1:4840/x", screen)
    quality = Quality.GOOD
    sample = Shown("L.P.A", 5, 4, quality.code, quality.status(), "Good", None)
    with table:
        table.begin(["L.P.A", "L.P.B"], 0.1)
        table.show([sample])
    shown = screen.file.getvalue()  # type: ignore[attr-defined]
    last = [line.rstrip() for line in re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown).splitlines()][-4:]
    assert last == [
        "Item ID  Value  Time Stamp  Quality",
        "L.P.A    5                  192 GOOD",
        "L.P.B",
        "opc.tcp://127.0.0.1:4840/x, 2 items, every 100ms. Ctrl-C ends.",
    ]


async def test_a_table_too_long_for_the_screen_says_so() -> None:
    screen = Console(file=io.StringIO(), force_terminal=True, width=100, height=8, color_system=None)
    with LiveTable("opc.tcp://h:1", screen) as table:
        table.begin([f"L.P.A{n}" for n in range(10)], 1.0)
    shown = screen.file.getvalue()  # type: ignore[attr-defined]
    assert "6 more do not fit, name fewer" in shown
    assert "L.P.A3" in shown
    assert "L.P.A4" not in shown


# -- what is watched -----------------------------------------------------------------------------------------------


async def test_changes_come_as_they_happen(plant: RunningGateway) -> None:
    seen = Seen()
    async with asyncio.TaskGroup() as tasks, plant.client() as script:
        watching = tasks.create_task(watch(plant.url, Wanted([f"{PLC}.Level"]), seen, SystemClock(), []))
        assert (await seen.next())[0] == f"{PLC}.Level"
        await script.write(f"{PLC}.Level", 1.5, ua.VariantType.Float)
        assert await seen.next() == (f"{PLC}.Level", 1.5, 192)
        plant.gateway.lost(PLC, Quality.OUT_OF_SERVICE)
        assert await seen.next() == (f"{PLC}.Level", 1.5, 28)
        plant.gateway.show()
        assert await seen.next() == (f"{PLC}.Level", 1.5, 192)
        watching.cancel()


async def test_everything_is_watched_when_nothing_is_named(plant: RunningGateway) -> None:
    seen = Seen()
    failures: list[str] = []
    await watch(plant.url, Wanted(count=10), seen, SystemClock(), failures)
    assert f"{PLC}.USR1.COUNTER_1" in seen.items
    assert f"{PLC}.Command" not in seen.items
    assert seen.missing == [(f"{PLC}.Command: BadNotReadable: the item can only be written", False)]
    assert failures == []


async def test_an_item_in_a_group_and_named_is_watched_once(plant: RunningGateway) -> None:
    seen = Seen()
    await watch(plant.url, Wanted([f"{PLC}.Motor", PLC.lower()], group="Fast", count=1), seen, SystemClock(), [])
    assert seen.items.count(f"{PLC}.Motor") == 1
    assert len(seen.items) == len(set(seen.items)) == 8


async def test_what_cannot_be_watched_is_told_while_the_rest_is(plant: RunningGateway) -> None:
    """Ctrl-C ends watching as a rule: what is told only at the end would never be."""
    seen = Seen()
    failures: list[str] = []
    wanted = Wanted([f"{PLC}.Motor", f"{PLC}.Command", f"{PLC}.Nothing"])
    async with asyncio.TaskGroup() as tasks:
        watching = tasks.create_task(watch(plant.url, wanted, seen, SystemClock(), failures))
        assert (await seen.next())[0] == f"{PLC}.Motor"
        watching.cancel()
    assert [is_failure for _, is_failure in seen.missing] == [True, True]
    assert [why for why, _ in seen.missing] == failures
    assert failures[0].startswith(f"there is no item {PLC}.Nothing")
    assert failures[1] == f"{PLC}.Command: BadNotReadable: the item can only be written"


async def test_a_group_is_watched_at_its_rate(plant: RunningGateway) -> None:
    seen = Seen()
    await watch(plant.url, Wanted(group="fast", count=1), seen, SystemClock(), [])
    assert (seen.items, seen.interval) == ([f"{PLC}.Motor", f"{PLC}.Level"], 0.25)


async def test_an_unknown_group_names_those_there_are(client: Command) -> None:
    outcome = await client("watch", "--group", "Slow")
    assert (outcome.code, outcome.err) == (1, "pcaccess: there is no group Slow; there are Fast\n")


async def test_an_unknown_item_does_not_stop_the_others(client: Command) -> None:
    outcome = await client("watch", f"{PLC}.Motr", f"{PLC}.Motor", "--count", "1")
    assert outcome.code == 1
    assert len(outcome.lines) == 2
    assert outcome.err == f"pcaccess: there is no item {PLC}.Motr; did you mean {PLC}.Motor?\n"


@pytest.mark.parametrize("name", ["Motr", "Command"])
@pytest.mark.parametrize("form", [(), ("--json",)])
async def test_nothing_to_watch_ends_at_once(client: Command, name: str, form: tuple[str, ...]) -> None:
    outcome = await client("watch", f"{PLC}.{name}", *form)
    assert outcome.code == 1
    assert len(outcome.lines) <= 1  # the heading
    assert outcome.err.startswith("pcaccess: ")


async def test_watching_ends_in_time(client: Command) -> None:
    outcome = await client("watch", f"{PLC}.Input", "--for", "200ms", "--json")
    assert (outcome.code, outcome.err) == (0, "")
    assert len(outcome.lines) <= 1  # the value at the beginning, if the machine was quick enough


# -- a server that goes away ---------------------------------------------------------------------------------------


async def test_a_lost_server_shows_as_comm_failure_and_comes_back() -> None:
    seen = Seen()
    async with AsyncExitStack() as stack:
        tasks = await stack.enter_async_context(asyncio.TaskGroup())
        first = await stack.enter_async_context(start_gateway(PLANT))
        watching = tasks.create_task(watch(first.url, Wanted([f"{PLC}.Motor"]), seen, NoWaiting(), []))
        assert await seen.next() == (f"{PLC}.Motor", False, 192)
        await first.server.stop()
        assert await seen.next() == (f"{PLC}.Motor", False, Quality.COMM_FAILURE.code)
        assert "trying again" in seen.remarks[-1]
        await stack.enter_async_context(start_gateway(PLANT, port=first.server.port))
        assert await seen.next() == (f"{PLC}.Motor", False, 192)
        assert seen.remarks[-1] == ""
        watching.cancel()
