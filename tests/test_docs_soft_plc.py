"""The project in docs/soft-plc.md is run as it stands there, and does what the page says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.gateways import Change, start_gateway

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "soft-plc.md").read_text(encoding="utf-8")


def project() -> str:
    found = re.search(r"^```yaml\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    assert found is not None
    return found[1]


@pytest.mark.timeout(120)
async def test_a_client_drives_the_crossing_while_it_runs() -> None:
    async with start_gateway(project(), base=ROOT) as running, running.client() as client:
        lights = {name: await client.subscribe(f"MicroWin.Crossing.{name}", 20) for name in ("Green", "Yellow", "Red")}
        await lights["Green"].until(Change(True))
        assert await client.put("ns=2;s=MicroWin.Crossing.TramComes", True) == "Good"
        await lights["Yellow"].until(Change(True))
        await lights["Green"].until(Change(False))
        assert await client.put("ns=2;s=MicroWin.Crossing.TramComes", False) == "Good"
        await lights["Red"].until(Change(True))
        assert await client.value("ns=2;s=MicroWin.Crossing.Yellow") is False
        assert await client.put("ns=2;s=MicroWin.Crossing.TramPassed", True) == "Good"
        await lights["Green"].until(Change(True))
        assert await client.value("ns=2;s=MicroWin.Crossing.Red") is False
