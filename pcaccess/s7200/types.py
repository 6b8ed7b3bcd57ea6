"""S7-200 data types and their big-endian codec.

Units:    sizes in bytes; a BOOL is one bit of a byte and has size 1 here.
Errors:   ``encode`` raises :class:`ValueRangeError` for a value the type cannot hold and
          :class:`ValueTypeError` for a value of the wrong kind; ``decode`` never fails on enough bytes.
Source:   System Manual, "Data types" (BYTE 0..255, INT -32768..32767, REAL IEEE 754 single, STRING with
          a length byte of at most 254); CHAR is a signed byte, as PC Access serves it.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import Enum
from typing import Final

Value = bool | int | float | str

MAX_STRING: Final = 254
"""Longest STRING in characters; the length byte stands before them."""

STRING_ENCODING: Final = "latin-1"
"""Every byte of a PLC string is one character, so that reading one back is lossless."""


_REAL_MAX: Final = (2 - 2**-23) * 2.0**127
"""Largest finite IEEE 754 single."""


class ValueTypeError(TypeError):
    """The value is of the wrong kind for the type, for example a text for an INT."""


class ValueRangeError(ValueError):
    """The value is of the right kind but does not fit the type."""


@dataclass(frozen=True, slots=True)
class _Codec:
    size: int
    format: str  # struct format, big-endian; empty for BOOL and STRING
    low: int = 0
    high: int = 0


class DataType(Enum):
    """Types an item can have. ``SINT`` in a project file is CHAR."""

    BOOL = _Codec(1, "", 0, 1)
    BYTE = _Codec(1, ">B", 0, 0xFF)
    CHAR = _Codec(1, ">b", -0x80, 0x7F)
    WORD = _Codec(2, ">H", 0, 0xFFFF)
    INT = _Codec(2, ">h", -0x8000, 0x7FFF)
    DWORD = _Codec(4, ">I", 0, 0xFFFF_FFFF)
    DINT = _Codec(4, ">i", -0x8000_0000, 0x7FFF_FFFF)
    REAL = _Codec(4, ">f")
    STRING = _Codec(1 + MAX_STRING, "")

    @property
    def size(self) -> int:
        """Bytes of one value; of a STRING the largest, length byte included."""
        return self.value.size

    @property
    def struct_format(self) -> str:
        """``struct`` format with byte order, empty for BOOL and STRING."""
        return self.value.format

    @property
    def is_integer(self) -> bool:
        return self not in (DataType.BOOL, DataType.REAL, DataType.STRING)

    @property
    def is_numeric(self) -> bool:
        """Integers and REAL: what dead bands and engineering limits make sense for."""
        return self not in (DataType.BOOL, DataType.STRING)

    @property
    def low(self) -> int:
        """Smallest value of an integer type; 0 for others."""
        return self.value.low

    @property
    def high(self) -> int:
        """Largest value of an integer type; 1 for BOOL, 0 for REAL and STRING."""
        return self.value.high

    @property
    def lowest(self) -> float:
        """Smallest number of a numeric type."""
        return -_REAL_MAX if self is DataType.REAL else self.low

    @property
    def highest(self) -> float:
        """Largest number of a numeric type."""
        return _REAL_MAX if self is DataType.REAL else self.high

    def encode(self, value: Value, *, length: int = MAX_STRING) -> bytes:
        """Bytes as they stand in PLC memory.

        A BOOL gives one byte 0 or 1. A STRING gives its length byte and characters and nothing behind them;
        ``length`` is the room it has in characters.
        """
        if self is DataType.STRING:
            if not isinstance(value, str):
                raise ValueTypeError(f"a STRING takes a text, not {value!r}")
            try:
                raw = value.encode(STRING_ENCODING)
            except UnicodeEncodeError as error:
                character = value[error.start]
                raise ValueRangeError(f"a PLC string has one byte per character; {character!r} does not fit") from None
            if len(raw) > length:
                raise ValueRangeError(f"{len(raw)} characters do not fit into a STRING of {length}")
            return bytes((len(raw),)) + raw
        if isinstance(value, str):
            raise ValueTypeError(f"{self.name} takes a number, not a text")
        if self is DataType.REAL:
            try:
                return struct.pack(">f", float(value))
            except OverflowError:
                raise ValueRangeError("the number is too large for a REAL") from None
        if isinstance(value, float) and not value.is_integer():
            raise ValueTypeError(f"{self.name} takes a whole number, not {value}")
        number = int(value)
        if not self.low <= number <= self.high:
            raise ValueRangeError(f"{number} does not fit {self.name} ({self.low} to {self.high})")
        return struct.pack(self.struct_format or ">B", number)

    def decode(self, data: bytes | bytearray | memoryview, offset: int = 0) -> Value:
        """Value of the bytes at ``offset``; a BOOL is bit 0 of its byte.

        A STRING whose length byte says more than ``data`` holds ends where the data end.
        """
        if self is DataType.BOOL:
            return bool(data[offset] & 1)
        if self is DataType.STRING:
            end = offset + 1 + min(data[offset], MAX_STRING)
            return bytes(data[offset + 1 : end]).decode(STRING_ENCODING)
        value: int | float = struct.unpack_from(self.struct_format, data, offset)[0]
        return value


DATA_TYPE_NAMES: Final = {**{t.name: t for t in DataType}, "SINT": DataType.CHAR}
"""Every name a project file or a run-time name may use, in capitals."""
