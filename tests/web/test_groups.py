"""Groups over REST, from outside."""

from __future__ import annotations

import csv
import io
from typing import Any

import pytest

from tests.web.conftest import PROJECT, Served


def lines(text: str) -> list[list[str]]:
    """Value and quality name of each line of a CSV."""
    return [[line[0].rpartition(".")[2], line[1], line[3]] for line in list(csv.reader(io.StringIO(text)))[1:]]


async def put(web: Served, name: str, value: Any) -> None:
    assert (await web.ask("PUT", f"/api/items/MicroWin.P.{name}/value", json=value)).status_code == 200


async def test_groups_are_listed_and_found_in_any_case(web: Served) -> None:
    (group,) = (await web.json("/api/groups"))["groups"]
    assert group == {
        "name": "Fast",
        "description": "",
        "update_rate_ms": 250,
        "active": True,
        "dead_band": 0,
        "items": ["MicroWin.P.Flow", "MicroWin.P.Level", "MicroWin.P.On"],
    }
    assert await web.json("/api/groups/fAST") == group
    for path in ("/api/groups/Slow", "/api/groups/Slow.csv", "/api/groups/Slow/samples"):
        assert (await web.get(path)).json()["detail"] == "there is no group Slow"


async def test_a_group_is_read_as_json_and_as_csv_in_its_order(web: Served) -> None:
    await put(web, "Level", 7)
    await put(web, "On", True)
    answer = await web.json("/api/groups/Fast/samples")
    assert [(one["id"], one["value"]) for one in answer["samples"]] == [
        *(("MicroWin.P.Flow", 0.0), ("MicroWin.P.Level", 7), ("MicroWin.P.On", True)),
    ]
    response = await web.get("/api/groups/fast.csv?tick=12345")
    assert response.headers["content-type"] == "text/csv; charset=utf-8"
    assert lines(response.text) == [["Flow", "0.0", "GOOD"], ["Level", "7", "GOOD"], ["On", "1", "GOOD"]]


async def test_an_inactive_group_is_out_of_service_unless_the_device_is_asked(web: Served) -> None:
    await put(web, "Level", 7)
    assert (await web.ask("PATCH", "/api/groups/Fast", json={"active": False})).json()["active"] is False
    cache = lines((await web.get("/api/groups/Fast.csv")).text)
    device = lines((await web.get("/api/groups/Fast.csv?source=device")).text)
    assert {line[2] for line in cache} == {"OUT_OF_SERVICE"}
    assert {line[2] for line in device} == {"GOOD"}
    await web.ask("PATCH", "/api/groups/Fast", json={"active": True})
    assert lines((await web.get("/api/groups/Fast.csv")).text) == device


async def test_the_dead_band_of_a_group_holds_small_changes_back(web: Served) -> None:
    await web.ask("PATCH", "/api/groups/Fast", json={"dead_band": 10})
    seen = []
    for value in (0, 10, 11, 20, 22):
        await put(web, "Level", value)
        answer = await web.json("/api/groups/Fast/samples")
        seen.append(answer["samples"][1]["value"])
    assert seen == [0, 0, 11, 11, 22]
    assert lines((await web.get("/api/groups/Fast.csv")).text)[1] == ["Level", "22", "GOOD"]


async def test_settings_are_changed_until_the_next_start(web: Served) -> None:
    wanted = {"update_rate_ms": 1000, "active": False, "dead_band": 2.5}
    changed = (await web.ask("PATCH", "/api/groups/Fast", json=wanted)).json()
    assert {name: changed[name] for name in wanted} == wanted
    group = web.gateway.group("Fast")
    assert group is not None
    assert (group.update_rate, group.active, group.dead_band) == (1.0, False, 2.5)


@pytest.mark.parametrize(
    "settings", [{"update_rate_ms": 0}, {"dead_band": 101}, {"active": 1}, {"name": "x"}, {"dead_band": True}, [], "x"]
)
async def test_settings_that_make_no_sense_change_nothing(web: Served, settings: Any) -> None:
    before = await web.json("/api/groups/Fast")
    assert (await web.ask("PATCH", "/api/groups/Fast", json=settings)).status_code == 400
    assert await web.json("/api/groups/Fast") == before


async def test_a_group_is_written_in_its_order_and_null_leaves_alone(web: Served) -> None:
    await put(web, "Level", 5)
    response = await web.ask("POST", "/api/groups/Fast/write", json={"values": [1.5, None, True]})
    assert (response.status_code, response.json()["failed"]) == (200, 0)
    assert [one["id"] for one in response.json()["results"]] == ["MicroWin.P.Flow", "MicroWin.P.On"]
    samples = (await web.json("/api/groups/Fast/samples"))["samples"]
    assert [one["value"] for one in samples] == [1.5, 5, True]
    some = await web.ask("POST", "/api/groups/Fast/write", json={"values": [2.5, 70000, None]})
    assert (some.status_code, some.json()["failed"]) == (207, 1)


@pytest.mark.parametrize("values", [[], [1, 2], [1, 2, True, 4], "x", None])
async def test_another_number_of_values_than_items_is_refused(web: Served, values: Any) -> None:
    response = await web.ask("POST", "/api/groups/Fast/write", json={"values": values})
    assert response.status_code == 400


async def test_items_that_went_and_hidden_ones_keep_their_places(web: Served) -> None:
    text = PROJECT.replace("MicroWin.P.On]", "MicroWin.P.Secret]")
    web.reload(text)
    assert lines((await web.get("/api/groups/Fast.csv")).text)[2] == ["Secret", "", "CONFIG_ERROR"]
    assert (await web.json("/api/groups/Fast/samples"))["samples"][2]["problem"] == "not-readable"
    await web.ask("PATCH", "/api/groups/Fast", json={"dead_band": 1})
    assert lines((await web.get("/api/groups/Fast.csv")).text)[2] == ["Secret", "", "CONFIG_ERROR"]
    assert (await web.get("/api/groups/Fast.csv?source=elsewhere")).status_code == 400
