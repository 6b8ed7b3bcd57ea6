"""Whether an item can be read, written or both, spelled as PC Access spells it."""

from __future__ import annotations

from enum import Flag
from typing import Final


class Access(Flag):
    """Printed ``R``, ``W`` or ``RW``."""

    R = 1
    W = 2
    RW = 3

    def __str__(self) -> str:
        return _TEXT[self.value]


_TEXT: Final = {0: "", 1: "R", 2: "W", 3: "RW"}
ACCESS_NAMES: Final = {"R": Access.R, "W": Access.W, "RW": Access.RW}
"""Every spelling a project file or a run-time name may use, in capitals."""
