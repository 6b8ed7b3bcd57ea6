"""Items over REST, from outside."""

from __future__ import annotations

import csv
import io
import json
import math
from typing import Any

import pytest

from tests.web.conftest import PROJECT, Served

JSON = {"content-type": "application/json"}


async def test_items_are_listed_in_pages_in_the_order_of_the_project(web: Served) -> None:
    first = await web.json("/api/items?limit=3")
    second = await web.json("/api/items?limit=3&offset=3")
    assert [item["name"] for item in first["items"] + second["items"]] == [
        *("Level", "Fixed", "On"),
        *("Flow", "Text", "Three"),
    ]
    assert first["total"] == second["total"] == 8


@pytest.mark.parametrize(
    ("query", "names"),
    [
        ("filter=*.p.f*", ["Fixed", "Flow"]),
        ("filter=tank", ["Level"]),
        ("filter=LEV", ["Level"]),
        ("filter=MicroWin.?.O%3F", ["On"]),
        ("plc=microwin.away", ["Lost"]),
        ("plc=MicroWin&filter=lo", ["Flow", "Lost"]),
        ("filter=%5B", []),
        ("writable=1&filter=*.?i*", []),
        ("writable=1&filter=*.?e*", ["Level", "Text", "Secret"]),
    ],
)
async def test_items_are_found_by_pattern_part_and_plc(web: Served, query: str, names: list[str]) -> None:
    assert [item["name"] for item in (await web.json(f"/api/items?{query}"))["items"]] == names


async def test_an_item_tells_what_it_is_and_its_sample(web: Served) -> None:
    item = await web.json("/api/items/microwin.p.LEVEL")
    sample = item.pop("sample")
    assert item == {
        "id": "MicroWin.P.Level",
        "name": "Level",
        "plc": "MicroWin.P",
        "type": "INT",
        "count": 1,
        "access": "RW",
        "address": "VW0",
        "run_time_name": "MicroWin:2:0.0.0.0:0000:0000,VW0,INT,RW,100.000,0.0000000",
        "low": 0,
        "high": 100,
        "unit": "cm",
        "description": "Tank level",
    }
    assert sample == {
        "id": "MicroWin.P.Level",
        "value": 0,
        "type": "INT",
        "quality": 192,
        "quality_name": "GOOD",
        "status": "Good",
        "source_timestamp": "2026-01-02T03:04:05.000Z",
    }


async def test_a_misspelt_item_gets_the_nearest_one(web: Served) -> None:
    response = await web.get("/api/items/MicroWin.P.Levl")
    assert response.status_code == 404
    assert response.headers["content-type"] == "application/problem+json"
    assert response.json() == {
        "type": "urn:pcaccess:problem:unknown-item",
        "title": "there is no such item",
        "status": 404,
        "detail": "there is no item MicroWin.P.Levl; did you mean MicroWin.P.Level?",
        "id": "MicroWin.P.Levl",
        "nearest": "MicroWin.P.Level",
    }


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("Level", 42),
        ("Level", 42.0),
        ("On", True),
        ("On", 1),
        ("Flow", 0.1),
        ("Flow", "NaN"),
        ("Flow", "-Infinity"),
        ("Text", "Grüße"),
        ("Three", [1, 0.5, "Infinity"]),
    ],
)
async def test_what_is_written_as_json_is_read_again(web: Served, name: str, value: Any) -> None:
    response = await web.ask("PUT", f"/api/items/MicroWin.P.{name}/value", json=value)
    assert (response.status_code, response.json()) == (200, {"id": f"MicroWin.P.{name}", "status": "Good"})
    assert await web.value(f"MicroWin.P.{name}") == value
    await web.ask("PUT", f"/api/items/MicroWin.P.{name}/value", json={"value": value})
    assert await web.value(f"MicroWin.P.{name}") == value


@pytest.mark.parametrize(
    ("name", "text", "value", "shown"),
    [
        ("Level", "42", 42, "42"),
        ("Level", " -7 ", -7, "-7"),
        ("Level", "3.0", 3, "3"),
        ("On", "on", True, "1"),
        ("On", "0", False, "0"),
        ("Flow", "0.1", 0.1, "0.1"),
        ("Flow", "1e3", 1000.0, "1000.0"),
        ("Text", '=1,"x"', '=1,"x"', '=1,"x"'),
        ("Three", "1 2.5 -3", [1.0, 2.5, -3.0], "1.0 2.5 -3.0"),
    ],
)
@pytest.mark.parametrize("headers", [{"content-type": "text/plain"}, {}], ids=["text", "no type, as LibreOffice"])
async def test_a_value_can_be_plain_text(
    web: Served, name: str, text: str, value: Any, shown: str, headers: dict[str, str]
) -> None:
    path = f"/api/items/MicroWin.P.{name}/value"
    response = await web.ask("PUT", path, content=text.encode(), headers=headers)
    assert response.status_code == 200
    assert await web.value(f"MicroWin.P.{name}") == value
    assert (await web.get(path)).text == shown


@pytest.mark.parametrize(
    ("name", "value", "status", "detail"),
    [
        ("Level", 70000, 422, "MicroWin.P.Level: 70000 does not fit INT (-32768 to 32767)"),
        ("Level", 1.5, 422, "MicroWin.P.Level: INT takes a whole number, not 1.5"),
        ("Level", "5", 422, "MicroWin.P.Level takes a whole number from -32768 to 32767, not '5'"),
        ("Level", True, 422, "MicroWin.P.Level takes a whole number from -32768 to 32767, not True"),
        ("Level", None, 422, "MicroWin.P.Level takes a whole number from -32768 to 32767, not None"),
        ("Level", [1], 422, "MicroWin.P.Level takes a whole number from -32768 to 32767, not [1]"),
        ("On", 2, 422, "MicroWin.P.On takes true or false, not 2"),
        ("Flow", 1e39, 422, "MicroWin.P.Flow: the number is too large for a REAL"),
        ("Flow", "nan", 422, "MicroWin.P.Flow takes a number, not 'nan'"),
        ("Text", "x" * 21, 422, "MicroWin.P.Text: 21 characters do not fit into a STRING of 20"),
        ("Text", "€", 422, "MicroWin.P.Text: a PLC string has one byte per character; '€' does not fit"),
        ("Three", [1, 2], 422, "MicroWin.P.Three takes 3 values"),
        ("Three", 1, 422, "MicroWin.P.Three takes a list of 3 values"),
        ("Fixed", 1, 403, "MicroWin.P.Fixed is read-only"),
        ("None", 1, 404, "there is no item MicroWin.P.None"),
    ],
)
async def test_a_value_that_does_not_fit_is_refused_and_nothing_changes(
    web: Served, name: str, value: Any, status: int, detail: str
) -> None:
    before = await web.json("/api/items")
    body = json.dumps(value).encode()
    response = await web.ask("PUT", f"/api/items/MicroWin.P.{name}/value", content=body, headers=JSON)
    assert (response.status_code, response.json()["detail"]) == (status, detail)
    assert await web.json("/api/items") == before


@pytest.mark.parametrize("text", ["", "abc", "1,5", "1_000", "0x10", "1e400", "9" * 5000])
async def test_a_text_that_is_no_number_is_refused(web: Served, text: str) -> None:
    response = await web.ask("PUT", "/api/items/MicroWin.P.Flow/value", content=text.encode())
    assert response.status_code == 422
    assert len(response.json()["detail"]) < 200


async def test_a_plc_that_is_not_connected_does_not_take_values(web: Served) -> None:
    response = await web.ask("PUT", "/api/items/MicroWin.Away.Lost/value", json=1)
    assert (response.status_code, response.json()["opcua_status"]) == (503, "BadNotConnected")
    sample = (await web.json("/api/items/MicroWin.Away.Lost"))["sample"]
    assert (sample["quality"], sample["quality_name"], sample["status"]) == (8, "NOT_CONNECTED", "BadNotConnected")


async def test_many_are_read_in_order_with_what_cannot_be_read_in_its_place(web: Served) -> None:
    wanted = ["MicroWin.P.On", "Nope", "MicroWin.P.Secret", "microwin.p.level", "MicroWin.P.On"]
    answer = (await web.ask("POST", "/api/read", json={"items": wanted})).json()["samples"]
    assert [one["id"] for one in answer] == [*wanted[:3], "MicroWin.P.Level", "MicroWin.P.On"]
    assert [one.get("problem") for one in answer] == [None, "unknown-item", "not-readable", None, None]
    assert answer[2]["error"] == "MicroWin.P.Secret is write-only"


async def test_the_same_request_has_new_values_after_every_change(web: Served) -> None:
    seen = []
    for value in (1, 2, 2, 3):
        await web.ask("PUT", "/api/items/MicroWin.P.Level/value", json=value)
        web.clock.move(1)
        answer = await web.ask("POST", "/api/read", json={"items": ["MicroWin.P.Level"]})
        (sample,) = answer.json()["samples"]
        seen.append((sample["value"], sample["source_timestamp"]))
    assert seen == [
        (1, "2026-01-02T03:04:06.000Z"),
        (2, "2026-01-02T03:04:07.000Z"),
        (2, "2026-01-02T03:04:08.000Z"),
        (3, "2026-01-02T03:04:09.000Z"),
    ]


async def test_the_same_request_follows_the_project_file(web: Served) -> None:
    async def read() -> list[Any]:
        answer = await web.ask("POST", "/api/read", json={"items": ["MicroWin.P.Level", "MicroWin.P.New"]})
        return [one.get("value", one.get("problem")) for one in answer.json()["samples"]]

    await web.ask("PUT", "/api/items/MicroWin.P.Level/value", json=5)
    assert await read() == [5, "unknown-item"]
    alone = PROJECT[: PROJECT.index("groups:")]
    web.reload(alone.replace("{name: Level, address: VW0", "{name: New, address: VW0"))
    assert await read() == ["unknown-item", 5]
    web.reload(alone.replace("{name: Level, address: VW0", "{name: Level, access: W, address: VW0"))
    assert await read() == ["not-readable", "unknown-item"]
    web.reload(alone)
    assert await read() == [5, "unknown-item"]


async def test_many_are_written_and_one_refusal_holds_up_no_other(web: Served) -> None:
    wanted = [
        {"id": "MicroWin.P.Level", "value": 7},
        {"id": "MicroWin.P.Fixed", "value": 7},
        {"id": "MicroWin.P.Flow", "value": "much"},
        {"id": "MicroWin.P.On", "value": True},
        {"id": "Nope", "value": 1},
        {"id": "MicroWin.Away.Lost", "value": 1},
        {"id": "MicroWin.P.Secret", "value": 1},
    ]
    response = await web.ask("POST", "/api/write", json={"items": wanted})
    assert response.status_code == 207
    answer = response.json()
    assert answer["failed"] == 4
    assert [one["status"] for one in answer["results"]] == [
        *("Good", "BadNotWritable", "BadTypeMismatch", "Good", "BadNodeIdUnknown", "BadNotConnected", "Good"),
    ]
    assert (await web.value("MicroWin.P.Level"), await web.value("MicroWin.P.On")) == (7, True)
    good = await web.ask("POST", "/api/write", json={"items": wanted[:1]})
    assert (good.status_code, good.json()["failed"]) == (200, 0)


async def test_a_run_time_name_is_an_item(web: Served) -> None:
    await web.ask("PUT", "/api/items/MicroWin.P.Level/value", json=258)
    assert await web.value("2,VB1,BYTE") == 2
    assert await web.value("MicroWin:2:0.0.0.0:0000:0000,VW0,INT,RW,100.000,0.0000000") == 258
    answer = await web.ask("POST", "/api/read", json={"items": ["2,VB0,byte"]})
    assert [one["value"] for one in answer.json()["samples"]] == [1]


async def test_a_dynamic_item_stays_while_the_same_request_names_it(web: Served) -> None:
    for _ in range(3):
        await web.ask("POST", "/api/read", json={"items": ["2,VB500,BYTE"]})
        web.clock.move(500)
        web.gateway.dynamic.sweep()
    assert len(web.gateway.dynamic) == 1
    web.clock.move(700)
    web.gateway.dynamic.sweep()
    assert len(web.gateway.dynamic) == 0


@pytest.mark.parametrize(
    ("body", "detail"),
    [
        (b"{", "the body is not JSON"),
        (b"[]", "expected an object with items and max_age"),
        (b"{}", "expected items, a list of item IDs"),
        (b'{"items": "x"}', "items is of the wrong kind: x"),
        (b'{"items": [1]}', "expected items, a list of item IDs"),
        (b'{"items": [], "x": 1}', "there is no member 'x' here; expected items, max_age"),
        (b'{"items": [], "max_age": "soon"}', "max_age: "),
        (b'{"items": [], "max_age": true}', "max_age is of the wrong kind: True"),
    ],
)
async def test_a_request_that_says_nothing_sensible_is_told_so(web: Served, body: bytes, detail: str) -> None:
    response = await web.ask("POST", "/api/read", content=body, headers=JSON)
    assert response.status_code == 400
    assert response.json()["detail"].startswith(detail)


@pytest.mark.parametrize(
    "query", ["limit=1001", "limit=-1", "limit=x", "offset=%D9%A1", "nonsense=1", "samples=2", f"filter={'x' * 201}"]
)
async def test_a_wrong_parameter_is_refused_and_not_ignored(web: Served, query: str) -> None:
    assert (await web.get(f"/api/items?{query}")).status_code == 400


async def test_too_many_items_are_refused(web: Served) -> None:
    names = ["MicroWin.P.Level"] * 20_001
    assert (await web.ask("POST", "/api/read", json={"items": names})).status_code == 413
    writes = [{"id": name, "value": 1} for name in names]
    assert (await web.ask("POST", "/api/write", json={"items": writes})).status_code == 400


async def test_csv_of_items_by_name_and_by_pattern(web: Served) -> None:
    await web.ask("PUT", "/api/items/MicroWin.P.Flow/value", json=2.5)
    by_name = await web.get("/api/items.csv?id=MicroWin.P.On&id=microwin.p.flow&tick=17")
    lines = list(csv.reader(io.StringIO(by_name.text)))
    assert lines[0] == ["Item ID", "Value", "Quality", "Quality Name", "Time Stamp"]
    assert [line[:4] for line in lines[1:]] == [
        ["MicroWin.P.On", "0", "192", "GOOD"],
        ["MicroWin.P.Flow", "2.5", "192", "GOOD"],
    ]
    by_pattern = await web.get("/api/items.csv?filter=*.f*")
    assert [line[0] for line in csv.reader(io.StringIO(by_pattern.text))][1:] == ["MicroWin.P.Fixed", "MicroWin.P.Flow"]


async def test_csv_has_a_line_for_an_item_that_is_gone(web: Served) -> None:
    text = (await web.get("/api/items.csv?id=Nope&id=MicroWin.P.Level&id=MicroWin.P.Secret")).text
    assert [line[:4] for line in csv.reader(io.StringIO(text))][1:] == [
        ["Nope", "", "4", "CONFIG_ERROR"],
        ["MicroWin.P.Level", "0", "192", "GOOD"],
        ["MicroWin.P.Secret", "", "4", "CONFIG_ERROR"],
    ]


async def test_write_only_items_are_not_shown(web: Served) -> None:
    item = await web.json("/api/items/MicroWin.P.Secret")
    assert item["sample"] is None
    assert (await web.get("/api/items/MicroWin.P.Secret/value")).status_code == 403
    shown = (await web.get("/api/items.csv?plc=MicroWin.P")).text
    assert "Secret" not in shown


async def test_bare_texts_for_spreadsheets(web: Served) -> None:
    assert (await web.get("/api/items/MicroWin.P.Level/quality?tick=1")).text == "192"
    assert (await web.get("/api/items/MicroWin.Away.Lost/quality")).text == "8"
    assert (await web.get("/api/items/MicroWin.P.Secret/quality")).status_code == 403


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("Level", "42", "ok"),
        ("Level", "70000", "MicroWin.P.Level: 70000 does not fit INT (-32768 to 32767)"),
        ("Level", "", "MicroWin.P.Level takes a whole number from -32768 to 32767, not ''"),
        ("Fixed", "1", "MicroWin.P.Fixed is read-only"),
        ("On", "on", "ok"),
    ],
)
async def test_a_value_can_be_checked_without_writing_it(web: Served, name: str, value: str, said: str) -> None:
    before = await web.json("/api/items")
    assert (await web.get(f"/api/items/MicroWin.P.{name}/check", params={"value": value})).text == said
    assert await web.json("/api/items") == before


async def test_nan_survives_csv_and_text(web: Served) -> None:
    await web.ask("PUT", "/api/items/MicroWin.P.Flow/value", json="NaN")
    assert (await web.get("/api/items/MicroWin.P.Flow/value")).text == "NaN"
    assert math.isnan(float((await web.get("/api/items.csv?id=MicroWin.P.Flow")).text.split(",")[5]))
