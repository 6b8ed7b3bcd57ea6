"""Groups: reading and writing all items at once."""

from __future__ import annotations

from collections.abc import Callable

from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.groups import Group, Source
from pcaccess.items.quality import Quality
from pcaccess.links.base import Outcome

MakeGateway = Callable[[str], Gateway]

PROJECT = """
project: Test
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: P
        address: 2
        items:
          - {name: A, address: VW0, type: INT, high: 100, low: 0}
          - {name: B, address: VW2, type: INT}
          - {name: C, address: VW4, type: INT, access: R}
groups:
  - {name: Fast, update_rate: 250ms, active: true, dead_band: 10, items: [MicroWin.P.B, MicroWin.P.A, MicroWin.P.C]}
"""


def fast(gateway: Gateway) -> Group:
    group = gateway.group("FAST")
    assert group is not None
    return group


async def values(group: Group, source: Source = Source.DEVICE) -> list[object]:
    return [sample.value if sample else None for sample in await group.read(source)]


async def test_a_group_reads_and_writes_in_the_order_of_its_items(gateway: MakeGateway) -> None:
    group = fast(gateway(PROJECT))
    assert await group.write([1, 2, 3]) == [Outcome.DONE, Outcome.DONE, Outcome.NOT_WRITABLE]
    assert await values(group) == [1, 2, 0]
    assert await group.write([None, 5, None]) == [Outcome.DONE, Outcome.DONE, Outcome.DONE]
    assert await values(group) == [1, 5, 0]


async def test_the_cache_moves_only_beyond_the_dead_band(gateway: MakeGateway) -> None:
    group = fast(gateway(PROJECT))
    seen = []
    for number in (0, 10, 11, 20, 1):
        await group.write([number, number, None])
        seen.append(await values(group, Source.CACHE))
    # 10 % of 0..100; B has no engineering range, so every change of it shows
    assert seen == [[0, 0, 0], [10, 0, 0], [11, 11, 0], [20, 11, 0], [1, 11, 0]]


async def test_the_cache_of_an_inactive_group_is_out_of_service_and_the_device_is_not(gateway: MakeGateway) -> None:
    group = fast(gateway(PROJECT))
    group.active = False
    assert [s.quality for s in await group.read(Source.CACHE) if s] == [Quality.OUT_OF_SERVICE] * 3
    assert [s.quality for s in await group.read(Source.DEVICE) if s] == [Quality.GOOD] * 3
