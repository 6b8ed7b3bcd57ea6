"""Every quality through a real client: StatusCode, limit bits and the Quality property."""

from __future__ import annotations

import pytest

from pcaccess.items.quality import Limit, Quality, from_status
from tests.gateways import start_gateway

_SIM = "\n".join(
    f'          - {{name: {q.name}, address: "QUALITY({q.code}, 7)", type: INT}}\n'
    f'          - {{name: {q.name}_LOW, address: "QUALITY({q.code + 1}, 7)", type: INT}}'
    for q in Quality
)
PROJECT = f"""
project: Test
links:
  - name: Sim
    type: sim
    plcs:
      - name: D
        items:
{_SIM}
"""


async def test_each_quality_arrives_with_its_value_status_and_code() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        for quality in Quality:
            for name, limit in ((quality.name, Limit.NONE), (f"{quality.name}_LOW", Limit.LOW)):
                read = await client.read_value(f"ns=2;s=Sim.D.{name}")
                assert read.StatusCode is not None
                assert read.StatusCode.value == quality.status(limit)
                assert read.Value is not None, "a bad status keeps the value"
                assert read.Value.Value == 7
                assert read.SourceTimestamp is not None
                assert await client.value(f"ns=3;s=Sim.D.{name}/Quality") == quality.code


async def test_a_subscription_reports_each_quality() -> None:
    async with start_gateway(PROJECT) as running, running.client() as client:
        for quality in Quality:
            changes = await client.subscribe(f"ns=2;s=Sim.D.{quality.name}")
            reported = await changes.next()
            assert (reported.value, reported.quality.status()) == (7, quality.status())


@pytest.mark.parametrize("quality", Quality)
def test_status_codes_lead_back_to_the_quality(quality: Quality) -> None:
    back, limit = from_status(quality.status(Limit.HIGH))
    assert limit is Limit.HIGH
    # LAST_KNOWN and OUT_OF_SERVICE share a StatusCode
    assert back is (Quality.OUT_OF_SERVICE if quality is Quality.LAST_KNOWN else quality)
