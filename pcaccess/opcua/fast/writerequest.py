"""What a Write request is made of, and one that was understood: rows, values, what is refused already.

Source:   OPC UA Part 4, 5.10.4 Write; Part 6, 5.2.2.16 Variant and 5.2.2.17 DataValue.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from asyncua.ua.status_codes import StatusCodes

COUNT: Final = struct.Struct("<i")
PLAIN: Final = b"\x0d\x00\x00\x00\xff\xff\xff\xff"
"""Value attribute, null index range: what stands between each NodeId and its DataValue in a plain request."""
CODECS: Final = MappingProxyType(
    {number: struct.Struct("<" + code) for number, code in enumerate("?bBhHiI", 1)} | {10: struct.Struct("<f")}
)
"""Variant types that an item can have as a single number or bit."""
HAS_STATUS: Final = 2
EXTRAS: Final = MappingProxyType(
    {
        mask: sum(size for bit, size in ((2, 4), (4, 8), (0x10, 2), (8, 8), (0x20, 2)) if mask & bit)
        for mask in range(0x01, 0x40, 2)
    }
)
"""Bytes behind the value of a DataValue, by its mask: status, source time, its picoseconds, server time, its."""
NO_DIAGNOSTICS: Final = COUNT.pack(-1)
DONE: Final = int(StatusCodes.Good)


@dataclass(slots=True)
class WriteRequest:
    """What each node is to get."""

    rows: list[int]
    """Per node its row, or a negative number where ``statuses`` has the answer."""
    types: list[int]
    """Variant types."""
    values: list[bytes]
    """As encoded, little-endian."""
    statuses: list[int]
    verbatim: bool
    """No rules apply to any of the values."""
    dynamic: list[int]
