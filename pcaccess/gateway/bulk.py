"""Many numbers to many items at once: the rules of ``writing`` hold because only items are taken that none applies to.

A plan is made once for a list of rows and can be used while these rows mean the same items.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pcaccess.gateway.station import Station
from pcaccess.gateway.writing import is_verbatim
from pcaccess.links.base import Outcome, RawBlock
from pcaccess.s7200.address import Address
from pcaccess.s7200.memory import MEMORY_SIZE, locate
from pcaccess.s7200.types import DataType

if TYPE_CHECKING:
    from pcaccess.gateway.gateway import Gateway


@dataclass(slots=True)
class Target:
    """Rows of one type of one PLC, and which places of the request they have."""

    raw_type: DataType
    positions: NDArray[np.int64]
    offsets: NDArray[np.int64]
    bits: NDArray[np.uint8]


class BulkPlan:
    """Where the values of a request go. Use :func:`plan_bulk`."""

    def __init__(self, stations: dict[Station, list[Target]]) -> None:
        self._stations = stations

    @property
    def targets(self) -> list[Target]:
        """In the order that :meth:`write` takes their data in."""
        return [target for targets in self._stations.values() for target in targets]

    def write(self, data: Sequence[NDArray[np.uint8]]) -> list[Outcome] | None:
        """Per target the bytes of its values, big-endian; gives the outcome of each target.

        None, with nothing written, where a PLC has to be waited for by now.
        """
        if not all(station.link.takes_blocks(station.name) for station in self._stations):
            return None
        outcomes: list[Outcome] = []
        rest = iter(data)
        for station, targets in self._stations.items():
            blocks = [RawBlock(t.raw_type, t.offsets, t.bits, next(rest)) for t in targets]
            outcomes += [station.link.write_blocks(station.name, blocks)] * len(targets)
        return outcomes


def plan_bulk(gateway: Gateway, rows: Sequence[int]) -> BulkPlan | None:
    """A plan for these rows; None where one of them has rules to keep, a byte is written twice, or a PLC is slow.

    Then :meth:`Gateway.write` does it, value by value.
    """
    members: dict[Station, dict[DataType, list[tuple[int, int, int]]]] = {}
    for position, row in enumerate(rows):
        item = gateway.item(row)
        if not is_verbatim(item) or not isinstance(item.address, Address):
            return None
        offset, bit = locate(item.address)
        by_type = members.setdefault(gateway.station(row), {})
        by_type.setdefault(item.raw_type, []).append((position, offset, bit))
    stations: dict[Station, list[Target]] = {}
    for station, by_type in members.items():
        if not station.link.takes_blocks(station.name):
            return None
        stations[station] = [_target(raw_type, places) for raw_type, places in by_type.items()]
        if _overlap(stations[station]):
            return None
    return BulkPlan(stations)


def _target(raw_type: DataType, places: list[tuple[int, int, int]]) -> Target:
    columns = np.array(places, np.int64).T
    return Target(raw_type, columns[0], columns[1], columns[2].astype(np.uint8))


def _overlap(targets: list[Target]) -> bool:
    """Whether a bit is written twice, so that the order of the writes matters."""
    written = np.zeros(MEMORY_SIZE, np.uint8)
    total = 0
    for target in targets:
        if target.raw_type is DataType.BOOL:
            np.bitwise_or.at(written, target.offsets, np.left_shift(np.uint8(1), target.bits))
            total += len(target.offsets)
        else:
            written[target.offsets[:, None] + np.arange(target.raw_type.size)] = 0xFF
            total += 8 * target.raw_type.size * len(target.offsets)
    return int(np.unpackbits(written).sum()) != total
