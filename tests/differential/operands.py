"""Operands for generated programs, from the definitions: what an instruction accepts, out of small pools.

Pools are small so that instructions meet on the same bytes, and overlap each other (VW0, VW1, VD0) so that byte order
and width show. Constants stand on the borders of their types.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from pcaccess.s7200.address import Area
from pcaccess.s7200.types import DataType
from pcaccess.stl.define import OperandSpec, Special
from pcaccess.stl.wording import limits

FIRST_REAL: Final = 100
"""VD100 to VD116 hold sensible reals, VD200 to VD208 pointers, VW300 and up loop counters."""
POINTERS: Final = ("*VD200", "*VD204", "*VD208", "*AC1", "*AC2")
POINTED: Final = ("&VB0", "&VB101", "&MB0", "&VB10239", "&IB0", "&QB1", "&T37", "&C0", "&SMB1", "&AQW0", "&SB0")
TIMERS: Final[Mapping[str, tuple[int, ...]]] = {"TON": (32, 33, 37, 38), "TOF": (34, 39, 40), "TONR": (0, 1, 5)}
COUNTERS: Final[Mapping[str, tuple[int, ...]]] = {"CTU": (0, 1), "CTD": (2, 3), "CTUD": (4, 5)}

_BITS: Final = {
    Area.I: ("I0.0", "I0.1", "I0.2", "I0.7", "I1.0"),
    Area.Q: ("Q0.0", "Q0.1", "Q0.7", "Q1.0"),
    Area.M: ("M0.0", "M0.1", "M0.7", "M3.3"),
    Area.V: ("V0.0", "V0.7", "V1.3", "V101.0"),
    Area.SM: ("SM0.0", "SM0.1", "SM0.5", "SM1.0", "SM1.1", "SM1.2", "SM1.3", "SM4.3"),
    Area.S: ("S0.0", "S0.1", "S1.0"),
    Area.L: ("L0.0", "L0.1", "L2.5"),
    Area.T: tuple(f"T{n}" for n in (32, 33, 37, 39, 0, 5)),
    Area.C: tuple(f"C{n}" for n in (0, 2, 4)),
}
_BYTES: Final = {
    Area.I: ("IB0",),
    Area.Q: ("QB0",),
    Area.M: ("MB0", "MB3"),
    Area.V: ("VB0", "VB1", "VB3", "VB101"),
    Area.SM: ("SMB1", "SMB0"),
    Area.S: ("SB0",),
    Area.L: ("LB0", "LB2"),
    Area.AC: ("AC0", "AC1"),
}
_WORDS: Final = {
    Area.I: ("IW0",),
    Area.Q: ("QW0",),
    Area.M: ("MW0",),
    Area.V: ("VW0", "VW1", "VW2", "VW4", "VW101"),
    Area.SM: ("SMW22",),
    Area.S: ("SW0",),
    Area.L: ("LW1", "LW2"),
    Area.AC: ("AC0", "AC1", "AC3"),
    Area.T: ("T33", "T37", "T5"),
    Area.C: ("C0", "C2", "C4"),
    Area.AI: ("AIW0",),
    Area.AQ: ("AQW0",),
}
_DOUBLES: Final = {
    Area.I: ("ID0",),
    Area.Q: ("QD0",),
    Area.M: ("MD0",),
    Area.V: ("VD0", "VD1", "VD4", "VD100"),
    Area.L: ("LD0", "LD4"),
    Area.AC: ("AC0", "AC1", "AC2"),
    Area.HC: ("HC0",),
    Area.S: ("SD0",),
}
_REALS: Final = {
    Area.V: ("VD100", "VD104", "VD108", "VD112", "VD116", "VD0"),
    Area.M: ("MD0",),
    Area.AC: ("AC0", "AC3"),
    Area.L: ("LD4",),
}
_POOLS: Final[Mapping[DataType, Mapping[Area, tuple[str, ...]]]] = {
    DataType.BOOL: _BITS,
    DataType.BYTE: _BYTES,
    DataType.CHAR: _BYTES,
    DataType.INT: _WORDS,
    DataType.WORD: _WORDS,
    DataType.DINT: _DOUBLES,
    DataType.DWORD: _DOUBLES,
    DataType.REAL: _REALS,
    DataType.STRING: {Area.V: ("VB400", "VB440", "VB0"), Area.L: ("LB8",)},
}
_NUMBERS: Final = (0, 1, -1, 2, 3, 7, 8, 16, 64, 100, 255, 256, 32767, -32768, 65535, 40000, 2147483647, -2147483648)
_REAL_NUMBERS: Final = ("0.0", "1.0", "-2.5", "0.1", "2.5", "16777217.0", "3.402e38", "-1.5e-38", "1e-45", "1e9")
_SMALL: Final = 8
"""Counts stay small, so that blocks that are checked beforehand fit."""


def operand(spec: OperandSpec, mnemonic: str) -> SearchStrategy[str]:
    """Texts that ``spec`` accepts."""
    if spec.type is Special.TIMER:
        return st.sampled_from([f"T{n}" for n in TIMERS[mnemonic]])
    if spec.type is Special.COUNTER:
        return st.sampled_from([f"C{n}" for n in COUNTERS[mnemonic]])
    if isinstance(spec.type, Special):
        return st.sampled_from(sorted({spec.low or 0, (spec.low or 0) + 1, spec.high or 0})).map(str)
    choices = [text for text in direct(spec) for _ in range(3)] + list(constants(spec)) * 2
    if spec.pointer:
        choices += POINTERS
    if spec.address_of:
        choices += POINTED
    return st.sampled_from(choices)


def direct(spec: OperandSpec) -> list[str]:
    """Addresses in the areas that ``spec`` allows; what is written is no SM bit of the CPU's own."""
    assert isinstance(spec.type, DataType)
    pool = _POOLS[spec.type]
    areas = [area for area in pool if area in spec.areas and not (spec.direction.writes and area is Area.SM)]
    return [text for area in areas for text in pool[area]]


def constants(spec: OperandSpec) -> tuple[str, ...]:
    if not spec.constant or not isinstance(spec.type, DataType):
        return ()
    if spec.type is DataType.REAL:
        return _REAL_NUMBERS
    if spec.type is DataType.STRING:
        return ('"abc"', '"-12.5"', '"b"')
    low, high = limits(spec, spec.type)
    if spec.low is not None:
        low, high = max(low, -_SMALL), min(high, _SMALL)
    return tuple(str(n) for n in _NUMBERS if low <= n <= high)
