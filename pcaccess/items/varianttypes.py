"""S7-200 data types as OPC UA built-in types. Apart from the records, so that clients need no NumPy."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from pcaccess.s7200.types import DataType

VARIANT_TYPES: Final = MappingProxyType(
    {
        DataType.BOOL: 1,
        DataType.CHAR: 2,
        DataType.BYTE: 3,
        DataType.INT: 4,
        DataType.WORD: 5,
        DataType.DINT: 6,
        DataType.DWORD: 7,
        DataType.REAL: 10,
        DataType.STRING: 12,
    }
)
"""OPC UA built-in type numbers (Part 6, table of built-in types)."""
