"""Diagnostics and metrics."""

from __future__ import annotations

import re

from tests.web.conftest import Served


def metrics(text: str) -> dict[str, float]:
    """Series of an exposition; fails on a line that is none (Prometheus text format 0.0.4)."""
    series: dict[str, float] = {}
    typed = set()
    for line in text.splitlines():
        if line.startswith("# TYPE "):
            name, kind = line.removeprefix("# TYPE ").split(" ")
            assert name not in typed
            assert kind in ("counter", "gauge")
            assert (kind == "counter") == name.endswith("_total")
            typed.add(name)
        elif not line.startswith("# HELP "):
            match = re.fullmatch(r'([a-z_]+)(\{(?:[a-z]+="(?:[^"\\\n]|\\.)*",?)*\})? (\S+)', line)
            assert match is not None, line
            assert match[1] in typed
            assert match[1] + (match[2] or "") not in series
            series[match[1] + (match[2] or "")] = float(match[3])
    assert text.endswith("\n")
    return series


async def test_metrics_tell_of_plcs_items_and_requests(web: Served) -> None:
    await web.get("/api/items")
    await web.get("/api/items/Nope")
    await web.ask("PUT", "/api/items/MicroWin.P.Level/value", json=5)
    series = metrics((await web.get("/metrics")).text)
    assert series['pcaccess_plc_connected{plc="MicroWin.P"}'] == 1
    assert series['pcaccess_plc_connected{plc="MicroWin.Away"}'] == 0
    assert series['pcaccess_items{quality="GOOD"}'] == 7
    assert series['pcaccess_items{quality="NOT_CONNECTED"}'] == 1
    assert series['pcaccess_web_requests_total{method="GET",path="/api/items",status="200"}'] == 1
    assert series['pcaccess_web_requests_total{method="GET",path="/api/items/{id}",status="404"}'] == 1
    assert series['pcaccess_web_writes_total{status="Good"}'] == 1
    assert series["pcaccess_start_time_seconds"] == 1767323045


async def test_metrics_can_carry_values_of_items(web: Served) -> None:
    for name, value in (("Level", 42), ("Flow", 0.1), ("On", True)):
        await web.ask("PUT", f"/api/items/MicroWin.P.{name}/value", json=value)
    series = metrics((await web.get("/metrics?group=fast&filter=*.lost")).text)
    values = {name: value for name, value in series.items() if name.startswith("pcaccess_item_value")}
    assert values == {
        'pcaccess_item_value{item="MicroWin.P.Flow"}': 0.1,
        'pcaccess_item_value{item="MicroWin.P.Level"}': 42,
        'pcaccess_item_value{item="MicroWin.P.On"}': 1,
        'pcaccess_item_value{item="MicroWin.Away.Lost"}': 0,
    }
    assert series['pcaccess_item_quality{item="MicroWin.Away.Lost"}'] == 8
    everything = metrics((await web.get("/metrics?filter=*")).text)
    assert not [name for name in everything if "Text" in name or "Three" in name or "Secret" in name]
    assert (await web.get("/metrics?group=none")).status_code == 404


async def test_what_is_not_finite_is_told_as_prometheus_does(web: Served) -> None:
    for value, shown in (("NaN", "NaN"), ("Infinity", "+Inf"), ("-Infinity", "-Inf")):
        await web.ask("PUT", "/api/items/MicroWin.P.Flow/value", json=value)
        assert (
            f'pcaccess_item_value{{item="MicroWin.P.Flow"}} {shown}\n' in (await web.get("/metrics?filter=flow")).text
        )


async def test_names_are_escaped_in_labels(web: Served) -> None:
    name = "MicroWin:2:0.0.0.0:0000:0000,VB700,BYTE,RW,0.0000000,0.0000000"
    await web.get("/api/items/2,VB700,BYTE")
    assert f'item="{name}"' in (await web.get("/metrics?filter=VB700")).text


async def test_diagnostics_tell_how_the_gateway_is_doing(web: Served) -> None:
    await web.get("/api/items")
    web.clock.move(12.5)
    found = await web.json("/api/diagnostics")
    assert (found["project"], found["started"], found["uptime_s"]) == ("Test", "2026-01-02T03:04:05.000Z", 12.5)
    assert found["plcs"][1] == {
        "plc": "MicroWin.Away",
        "link_type": "soft",
        "connected": False,
        "mode": "UNKNOWN",
        "scan_time_ms": 0.0,
        "items": 1,
    }
    assert found["qualities"] == {"GOOD": 7, "NOT_CONNECTED": 1}
    assert found["web"]["requests"] == {"200": 1}
    assert found["process"]["cpu_s"] > 0


async def test_counters_go_on_when_something_fails_inside(web: Served, monkeypatch) -> None:
    async def broken(*_: object) -> None:
        raise RuntimeError("a mistake of our own")

    monkeypatch.setattr(web.gateway, "read", broken)
    response = await web.get("/api/items")
    assert (response.status_code, response.json()["detail"]) == (500, "see the gateway's log")
    monkeypatch.undo()
    assert (await web.json("/api/diagnostics"))["web"]["requests"] == {"500": 1}
