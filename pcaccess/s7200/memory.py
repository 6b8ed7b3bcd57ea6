"""Where everything lies in the one buffer that is a PLC's memory.

All areas of a CPU stand in one contiguous, big-endian buffer at offsets that are the same for every CPU model
(a smaller model just has less of an area it may use), so that images can be compared, copied and shared whole.

Units:    offsets and sizes in bytes.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from pcaccess.s7200.address import Address, Area, Width
from pcaccess.s7200.types import DataType, Value

_LAYOUT: Final = (
    (Area.I, 16),
    (Area.Q, 16),
    (Area.M, 32),
    (Area.S, 32),
    (Area.AI, 64),
    (Area.AQ, 64),
    (Area.L, 64),
    (Area.AC, 4 * 4),
    (Area.HC, 6 * 4),
    (Area.T, 256 * 2),
    (Area.C, 256 * 2),
    (Area.SM, 552),  # 550 bytes, rounded up so that what follows is aligned
    (Area.V, 10240),
)
_ORDER: Final = dict(_LAYOUT)


def _starts() -> dict[Area, int]:
    starts, at = {}, 0
    for area, size in _LAYOUT:
        starts[area] = at
        at += size
    return starts


AREA_START: Final = MappingProxyType(_starts())
"""First byte of each area; T and C here are their current values."""
AREA_BYTES: Final = MappingProxyType(_ORDER)
T_BITS: Final = AREA_START[Area.V] + 10240
"""32 bytes: bit n of byte n // 8 is timer n's bit."""
C_BITS: Final = T_BITS + 32
"""32 bytes: bit n of byte n // 8 is counter n's bit."""
MEMORY_SIZE: Final = C_BITS + 32

_ELEMENT: Final = {Area.T: 2, Area.C: 2, Area.HC: 4, Area.AC: 4}


def locate(address: Address) -> tuple[int, int]:
    """Offset of the (first) byte in the buffer, and the bit in it (0 where the width is not BIT).

    An accumulator used as a byte or word is its low-order end (document 003, accumulators).
    """
    area = address.area
    if address.width is Width.BIT and area in (Area.T, Area.C):
        base = T_BITS if area is Area.T else C_BITS
        return base + address.offset // 8, address.offset % 8
    start = AREA_START[area]
    if area.is_numbered:
        element = _ELEMENT[area]
        return start + address.offset * element + (element - address.width.size), 0
    return start + address.offset, address.bit


def read_value(memory: bytes | bytearray | memoryview, address: Address, data_type: DataType) -> Value:
    """One value (``address.count`` is not looked at). ``address`` must be ``as_type(data_type)``."""
    offset, bit = locate(address)
    if data_type is DataType.BOOL:
        return bool(memory[offset] >> bit & 1)
    return data_type.decode(memory, offset)


def write_value(
    memory: bytearray | memoryview, address: Address, data_type: DataType, value: Value, *, length: int = 254
) -> None:
    """Store one value; raises as :meth:`DataType.encode` does, before anything is changed."""
    offset, bit = locate(address)
    raw = data_type.encode(value, length=length)
    if data_type is DataType.BOOL:
        memory[offset] = memory[offset] & ~(1 << bit) | raw[0] << bit
    else:
        memory[offset : offset + len(raw)] = raw
