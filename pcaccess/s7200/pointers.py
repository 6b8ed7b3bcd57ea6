"""Pointers (``&VB100``): a double word with the area in its top byte and a byte offset in the other three.

The codes of S, SM, AI, AQ and V are those the S7-200 uses elsewhere; the others are our
choice, in the same row. No area has code 0, so a pointer that was never set is caught.

Source:   docs/decisions/2026-11-22-pointers.md; System Manual, Indirect addressing (which areas: no L, no HC,
          of T and C only the value).
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from pcaccess.s7200.address import Address, Area

AREA_CODES: Final = MappingProxyType(
    {
        Area.I: 1,
        Area.Q: 2,
        Area.M: 3,
        Area.S: 4,
        Area.SM: 5,
        Area.AI: 6,
        Area.AQ: 7,
        Area.V: 8,
        Area.T: 9,
        Area.C: 10,
    }
)
"""The areas a pointer can name."""


def pointer_to(address: Address) -> int:
    """The pointer that ``&address`` stands for; KeyError for an area that no pointer can name (L, HC, AC).

    A timer or counter counts two bytes for each element, so a program steps from one to the next by adding 2.
    """
    offset = address.offset * 2 if address.area in (Area.T, Area.C) else address.offset
    return AREA_CODES[address.area] << 24 | offset
