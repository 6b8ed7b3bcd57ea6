"""browse, read, write: what a user types against a running gateway, and what comes back."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
from asyncua import ua

from pcaccess.items.quality import Quality
from tests.cli.conftest import Command
from tests.gateways import Change, RunningGateway

pytestmark = pytest.mark.asyncio(loop_scope="module")

PLC = "MicroWin.NewPLC"
STAMP = re.compile(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d\.\d{3}")


def shown(text: str) -> str:
    """Output with its times made alike."""
    return STAMP.sub("<time>                 ", text)


# -- browse --------------------------------------------------------------------------------------------------------


async def test_browse_shows_one_level(client: Command) -> None:
    assert (await client("browse")).out == (
        "Item ID   Type  Access  Address  Range  Unit  Description\nMicroWin  link\n"
    )


async def test_browse_begins_where_it_is_told(client: Command) -> None:
    assert (await client("browse", "microwin.newplc")).out.splitlines() == [
        "Item ID                      Type    Access  Address   Range      Unit  Description",
        "MicroWin.NewPLC.USR1         folder",
        "MicroWin.NewPLC.Motor        BOOL    RW      Q0.0                       Contactor",
        "MicroWin.NewPLC.Temperature  INT     RW      VW0       200..1000  °C",
        "MicroWin.NewPLC.Setpoint     INT     RW      VW200     0..100",
        "MicroWin.NewPLC.Level        REAL    RW      VD204",
        "MicroWin.NewPLC.Text         STRING  RW      VB300",
        "MicroWin.NewPLC.Row          INT     RW      VW400[3]",
        "MicroWin.NewPLC.Input        BOOL    R       I0.1",
        "MicroWin.NewPLC.Command      INT     W       VW600",
    ]


async def test_browse_goes_as_deep_as_it_is_told(client: Command) -> None:
    def ids(lines: list[str]) -> list[str]:
        return [line.split()[0] for line in lines[1:]]

    two = ids((await client("browse", "--depth", "2")).lines)
    everything = ids((await client("browse", "-r")).lines)
    assert two == ["MicroWin", PLC, "MicroWin.Away", "MicroWin.Dead"]
    assert [one for one in everything if one.startswith(f"{PLC}.USR1")] == [f"{PLC}.USR1", f"{PLC}.USR1.COUNTER_1"]


async def test_a_folder_that_comes_in_pieces_is_whole(client: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = await client("browse", "-r")
    monkeypatch.setattr("pcaccess.opcua.views.MAX_REFERENCES", 2)
    assert (await client("browse", "-r")).out == whole.out


async def test_a_folder_that_the_server_has_no_room_for_yet_is_asked_for_again(
    client: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = await client("browse", "-r")
    monkeypatch.setattr("pcaccess.opcua.views.MAX_REFERENCES_PER_REQUEST", 3)
    assert (await client("browse", "-r")).out == whole.out


async def test_browse_tells_programs_all_about_an_item(client: Command) -> None:
    (listed,) = json.loads((await client("browse", f"{PLC}.Temperature", "--json")).out)
    assert listed == {
        "id": f"{PLC}.Temperature",
        "kind": "item",
        "description": "",
        "type": "INT",
        "count": 1,
        "access": "RW",
        "address": "VW0",
        "run_time_name": "MicroWin:2:0.0.0.0:0000:0000,VW0,INT,RW,1000.000,200.000",
        "low": 200.0,
        "high": 1000.0,
        "unit": "°C",
    }


async def test_browse_all_shows_what_plcs_say_of_themselves(client: Command) -> None:
    outcome = await client("browse", "MicroWin.Dead", "--all", "--json")
    assert [one["id"] for one in json.loads(outcome.out)] == [
        "MicroWin.Dead.Value",
        "MicroWin.Dead/Connected",
        "MicroWin.Dead/Mode",
        "MicroWin.Dead/ScanTime",
        "MicroWin.Dead/Errors",
    ]


async def test_browse_of_nothing_names_the_nearest(client: Command) -> None:
    outcome = await client("browse", "MicroWin.NewPCL")
    assert (outcome.code, outcome.out) == (1, "")
    assert outcome.err == "pcaccess: there is no item MicroWin.NewPCL; did you mean MicroWin.NewPLC?\n"


# -- read ----------------------------------------------------------------------------------------------------------


async def test_read_shows_value_time_and_quality(client: Command, plant: RunningGateway) -> None:
    async with plant.client() as script:
        await script.write(f"{PLC}.Temperature", 250, ua.VariantType.Int16)
    outcome = await client("read", "microwin.newplc.temperature", "MicroWin.Dead.Value")
    assert outcome.code == 0
    assert shown(outcome.out) == (
        "Item ID                      Value  Time Stamp               Quality\n"
        "MicroWin.NewPLC.Temperature  250    <time>                   192 GOOD\n"
        "MicroWin.Dead.Value          0      <time>                     8 NOT_CONNECTED\n"
    )


async def test_read_gives_programs_a_sample_per_item(client: Command) -> None:
    dead, fixed = json.loads((await client("read", "MicroWin.Dead.Value", f"{PLC}.Input", "--json")).out)
    stamp = fixed.pop("source_timestamp")
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{6}Z", stamp)
    assert fixed == {
        "id": f"{PLC}.Input",
        "value": False,
        "type": "BOOL",
        "quality": 192,
        "quality_name": "GOOD",
        "status": "Good",
    }
    assert (dead["quality"], dead["quality_name"], dead["status"]) == (8, "NOT_CONNECTED", "BadNotConnected")


async def test_read_tells_qualities_apart_that_share_a_status(client: Command, plant: RunningGateway) -> None:
    plant.gateway.lost("MicroWin.Away", Quality.LAST_KNOWN)
    (sample,) = json.loads((await client("read", "MicroWin.Away.Value", "--json")).out)
    assert (sample["quality"], sample["status"]) == (20, "BadOutOfService")


async def test_read_takes_branches_patterns_and_run_time_names(client: Command) -> None:
    async def ids(*names: str) -> list[str]:
        return [one["id"] for one in json.loads((await client("read", *names, "--json")).out)]

    assert await ids("MicroWin.NewPLC.USR1") == [f"{PLC}.USR1.COUNTER_1"]
    assert await ids("*.te*") == [f"{PLC}.Temperature", f"{PLC}.Text"]
    assert await ids("MicroWin:2:0.0.0.0:0000:0000,VW0,INT,RW,1000.000,200.000") == [f"{PLC}.Temperature"]
    assert await ids("MicroWin.NewPLC/Mode") == ["MicroWin.NewPLC/Mode"]
    assert await ids(f"ns=2;s={PLC}.Motor") == [f"{PLC}.Motor"]


async def test_an_item_is_answered_as_often_as_it_is_named(client: Command) -> None:
    async def ids(*names: str) -> list[str]:
        return [line.split()[0] for line in (await client("read", *names)).lines[1:]]

    motor, counter = f"{PLC}.Motor", f"{PLC}.USR1.COUNTER_1"
    assert await ids(motor, motor.upper(), "2,Q0.0,BOOL,RW") == [motor] * 3
    assert await ids(f"{PLC}.USR1", counter) == [counter] * 2
    assert await ids(counter, f"{PLC}.USR1", "*COUNTER*") == [counter]


@pytest.mark.parametrize("name", [PLC, f"{PLC}.*", "*"])
async def test_of_a_branch_what_can_be_read_is_read(client: Command, name: str) -> None:
    outcome = await client("read", name)
    told = f"{PLC}.Command: BadNotReadable: the item can only be written\n"
    assert (outcome.code, outcome.err) == (0, told)
    assert [f"{PLC}.Motor" in outcome.out, f"{PLC}.Command" in outcome.out] == [True, False]
    command = next(o for o in json.loads((await client("read", name, "--json")).out) if o["id"] == f"{PLC}.Command")
    assert (command["value"], command["error"]) == (None, told.strip())


async def test_an_item_that_can_only_be_written_fails_where_it_is_named(client: Command) -> None:
    outcome = await client("read", PLC, f"{PLC}.Command")
    assert outcome.code == 1
    assert outcome.err.splitlines()[-1] == f"pcaccess: {PLC}.Command: BadNotReadable: the item can only be written"


async def test_one_unknown_item_does_not_stop_the_others(client: Command) -> None:
    outcome = await client("read", f"{PLC}.Temprature", f"{PLC}.Motor")
    assert outcome.code == 1
    assert [line.split()[0] for line in outcome.lines[1:]] == [f"{PLC}.Motor"]
    assert outcome.err == f"pcaccess: there is no item {PLC}.Temprature; did you mean {PLC}.Temperature?\n"


async def test_programs_get_an_answer_for_every_name(client: Command) -> None:
    outcome = await client("read", "Nowhere", f"{PLC}.Motor", "--json")
    unknown, motor = json.loads(outcome.out)
    assert outcome.code == 1
    assert (unknown["value"], unknown["quality"], unknown["status"]) == (None, 0, "BadNodeIdUnknown")
    assert unknown["error"] == "there is no item Nowhere"
    assert motor["status"] == "Good"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("MicroWin.NewPLX.Motor", "did you mean MicroWin.NewPLC.Motor?"),
        ("Temperature", "did you mean MicroWin.NewPLC.Temperature?"),
        ("MicroWin.NewPLC.COUNTER_1", "did you mean MicroWin.NewPLC.USR1.COUNTER_1?"),
        ("MicroWin.NewPLC.T*z", "no item matches MicroWin.NewPLC.T*z"),
        ("MicroWin.Nowhere.*", "there is no item MicroWin.Nowhere"),
        ("MicroWin.NewPLC.Command", "BadNotReadable: the item can only be written"),
        ("i=nonsense", "i=nonsense is no NodeId"),
        ("", "there is no item without a name"),
        ("2,VX,INT", "there is no item 2,VX,INT: "),
        ("2,VW0,FOO", "there is no item 2,VW0,FOO: "),
        ("9,VW0,INT", "there is no item 9,VW0,INT: no PLC here has that station and address"),
        ("x" * 5000, f"there is no item {'x' * 199}…\n"),
    ],
)
async def test_a_name_that_leads_nowhere_says_so(client: Command, name: str, words: str) -> None:
    outcome = await client("read", name)
    assert outcome.code == 1
    assert words in outcome.err


@pytest.mark.parametrize("command", [("write", f"{PLC}.*", "1"), ("browse", f"{PLC}.*")])
async def test_patterns_are_for_what_reads(client: Command, command: tuple[str, ...]) -> None:
    outcome = await client(*command)
    assert (outcome.code, outcome.out) == (1, "")
    assert outcome.err == f"pcaccess: there is no item {PLC}.*; patterns are for read and watch\n"


# -- write ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("item", "text", "value", "said"),
    [
        ("Motor", "true", True, "true"),
        ("Motor", "1", True, "true"),
        ("Temperature", "-12", -12, "-12"),
        ("Temperature", "16#FFFF", -1, "-1"),
        ("Level", "0.1", pytest.approx(0.1), "0.1"),
        ("Text", "a b", "a b", '"a b"'),
        ("Row", "1,-2,16#3", [1, -2, 3], "1,-2,3"),
    ],
)
async def test_write_converts_to_the_items_type(
    client: Command, plant: RunningGateway, item: str, text: str, value: Any, said: str
) -> None:
    outcome = await client("write", f"microwin.newplc.{item}", text)
    assert (outcome.code, outcome.out, outcome.err) == (0, f"{PLC}.{item} = {said}\n", "")
    row = plant.gateway.find(f"{PLC}.{item}")
    assert row is not None
    assert plant.gateway.sample(row).value == value


async def test_write_takes_pairs_and_equations(client: Command) -> None:
    pairs = await client("write", f"{PLC}.Motor", "true", f"{PLC}.Temperature", "-7")
    equations = await client("write", f"{PLC}.Motor=false", f"{PLC}.Text=-x=y")
    assert pairs.lines == [f"{PLC}.Motor = true", f"{PLC}.Temperature = -7"]
    assert equations.lines == [f"{PLC}.Motor = false", f'{PLC}.Text = "-x=y"']


@pytest.mark.parametrize(
    ("item", "value", "words"),
    [
        ("Input", "1", "BadNotWritable: the item can only be read"),
        (
            "Setpoint",
            "101",
            "BadOutOfRange: the value is outside what the item takes (its engineering range is 0 to 100)",
        ),
        ("Temperature", "abc", "'abc' is not a whole number: INT takes -32768 to 32767, or bits such as 16#FF"),
        ("Temperature", "32768", "32768 does not fit INT, which takes -32768 to 32767"),
        ("Text", "eleven char", "BadOutOfRange: the value is outside what the item takes: the text is too long for it"),
        ("Row", "1,2", "BadTypeMismatch: the value does not have the item's type"),
        ("Nowhere", "1", "there is no item MicroWin.NewPLC.Nowhere"),
        ("USR1", "1", "MicroWin.NewPLC.USR1 is no item; name one below it"),
    ],
)
async def test_what_cannot_be_written_says_why_and_the_others_are_written(
    client: Command, plant: RunningGateway, item: str, value: str, words: str
) -> None:
    outcome = await client("write", f"{PLC}.{item}", value, f"{PLC}.Level", "2.5")
    assert outcome.code == 1
    assert words in outcome.err
    assert outcome.out == f"{PLC}.Level = 2.5\n"
    async with plant.client() as script:
        assert await script.read(f"{PLC}.Level") == Change(2.5)


async def test_write_tells_programs_what_became_of_each(client: Command) -> None:
    outcome = await client("write", f"{PLC}.Motor=1", f"{PLC}.Input=1", "MicroWin.Dead.Value=1", "--json")
    motor, fixed, dead = json.loads(outcome.out)
    assert outcome.code == 1
    assert motor == {"id": f"{PLC}.Motor", "value": True, "type": "BOOL", "status": "Good"}
    assert (fixed["status"], dead["status"]) == ("BadNotWritable", "BadNotConnected")
    assert dead["error"] == "MicroWin.Dead.Value: BadNotConnected: the PLC is not connected"
