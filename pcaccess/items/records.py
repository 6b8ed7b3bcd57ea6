"""Records: encoded OPC UA DataValues as NumPy structured types, one layout per item type.

A record *is* what goes on the wire with both timestamps: encoding mask, variant type, value, StatusCode,
SourceTimestamp, ServerTimestamp. Source only is the record without its last 8 bytes, Neither without the last 16;
the mask is rewritten on the copy that goes out.

Source:   OPC UA Part 6, DataValue and Variant encodings (all little-endian).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pcaccess.items.varianttypes import VARIANT_TYPES
from pcaccess.s7200.types import DataType

MASK_VALUE: Final = 0x01
MASK_STATUS: Final = 0x02
MASK_SOURCE: Final = 0x04
MASK_SERVER: Final = 0x08
MASK_ALL: Final = MASK_VALUE | MASK_STATUS | MASK_SOURCE | MASK_SERVER


@dataclass(frozen=True, slots=True)
class Kind:
    """How one data type stands in the table: its variant type and the record layout.

    ``value_format`` is empty for what has no fixed size (strings and arrays): such rows keep their encoded variant
    as a Python ``bytes`` beside the record.
    """

    index: int
    variant_type: int
    value_format: str

    @property
    def dtype(self) -> np.dtype[Any]:
        value = [("type", "u1"), ("value", self.value_format)] if self.value_format else []
        return np.dtype([("mask", "u1"), *value, ("status", "<u4"), ("source", "<i8"), ("server", "<i8")])


_FORMATS: Final = {
    DataType.BOOL: "u1",
    DataType.CHAR: "i1",
    DataType.BYTE: "u1",
    DataType.INT: "<i2",
    DataType.WORD: "<u2",
    DataType.DINT: "<i4",
    DataType.DWORD: "<u4",
    DataType.REAL: "<f4",
}
KINDS: Final = MappingProxyType(
    {t: Kind(index, VARIANT_TYPES[t], text) for index, (t, text) in enumerate(_FORMATS.items())}
)
OBJECT_KIND: Final = Kind(len(KINDS), 0, "")
"""Strings and arrays."""
ALL_KINDS: Final = (*KINDS.values(), OBJECT_KIND)
LAYOUTS: Final = tuple(
    struct.Struct("<BB" + np.dtype(kind.value_format).char + "Iqq" if kind.value_format else "<BIqq")
    for kind in ALL_KINDS
)
"""The same layouts for one record at a time, by kind index."""
NULL_VARIANT: Final = b"\x00"
