"""Values to PLC memory as they came: the rules of ``writing`` hold because only items are taken that none applies to.

Units:    data are the bytes as they stand in PLC memory, big-endian; offsets are of ``pcaccess.s7200.memory``.
Errors:   what cannot be done so is None, with nothing written; :meth:`Gateway.write` does it then, value by value.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pcaccess.gateway.station import Station
from pcaccess.links.base import Outcome, RawBlock, RawWrite
from pcaccess.s7200.memory import MEMORY_SIZE
from pcaccess.s7200.types import DataType

if TYPE_CHECKING:
    from pcaccess.gateway.gateway import Gateway


@dataclass(slots=True)
class Columns:
    """Places of verbatim items (``writing.is_verbatim``), one after the other."""

    stations: NDArray[np.int32]
    """Equal numbers are equal PLCs."""
    types: NDArray[np.uint8]
    """Index into ``TYPES``."""
    offsets: NDArray[np.int64]
    bits: NDArray[np.uint8]


TYPES = tuple(DataType)


def write_blocks(
    columns: Columns,
    station_of: Callable[[int], Station],
    data_of: Callable[[NDArray[np.intp], DataType], NDArray[np.uint8]],
) -> list[tuple[NDArray[np.intp], Outcome]] | None:
    """Write all places of the columns; gives the outcome of those that were not done.

    ``data_of(positions, type)`` gives a row of bytes per position. None where a bit is written twice, so that the
    order matters, or a PLC has to be waited for.
    """
    by_station: dict[int, list[tuple[DataType, NDArray[np.intp]]]] = {}
    keys = columns.stations.astype(np.int64) * len(TYPES) + columns.types
    for key in np.flatnonzero(np.bincount(keys)).tolist():
        number, type_ = divmod(key, len(TYPES))
        by_station.setdefault(number, []).append((TYPES[type_], np.flatnonzero(keys == key)))
    for number, members in by_station.items():
        station = station_of(number)
        if not station.link.takes_blocks(station.name) or _overlap(columns, members):
            return None
    refused: list[tuple[NDArray[np.intp], Outcome]] = []
    for number, members in by_station.items():
        station = station_of(number)
        blocks = [RawBlock(t, columns.offsets[p], columns.bits[p], data_of(p, t)) for t, p in members]
        outcome = station.link.write_blocks(station.name, blocks)
        if outcome is not Outcome.DONE:
            refused += [(positions, outcome) for _, positions in members]
    return refused


def _overlap(columns: Columns, members: Sequence[tuple[DataType, NDArray[np.intp]]]) -> bool:
    """Whether a bit of one PLC is written twice."""
    written = np.zeros(MEMORY_SIZE, np.uint8)
    total = 0
    bits: NDArray[np.intp] | None = None
    for raw_type, positions in members:
        if raw_type is DataType.BOOL:
            bits = positions
            continue
        written[columns.offsets[positions][:, None] + np.arange(raw_type.size)] = 1
        total += raw_type.size * len(positions)
    if bits is not None:
        places = columns.offsets[bits] * 8 + columns.bits[bits]
        if written[columns.offsets[bits]].any() or len(np.unique(places)) != len(places):
            return True
    return int(written.sum(dtype=np.int64)) != total


def write_few(gateway: Gateway, writes: Sequence[tuple[int, bytes]]) -> list[Outcome] | None:
    """Write verbatim items in order, by row; None where a PLC has to be waited for."""
    batches: dict[Station, list[int]] = {}
    for n, (row, _) in enumerate(writes):
        batches.setdefault(gateway.station(row), []).append(n)
    if not all(station.link.is_prompt(station.name) for station in batches):
        return None
    outcomes = [Outcome.DONE] * len(writes)
    for station, members in batches.items():
        raw = []
        for n in members:
            row, data = writes[n]
            item = gateway.item(row)
            raw.append(RawWrite(item.item_id, item.address, item.raw_type, data))
        for n, outcome in zip(members, station.link.write_now(station.name, raw), strict=True):
            outcomes[n] = outcome
    return outcomes
