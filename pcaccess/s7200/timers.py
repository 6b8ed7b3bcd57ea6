"""Which timer number is what: resolution and kind are fixed by the number.

Units:    milliseconds.
Source:   document 000, table of timer numbers; document 004, section 9.17.
"""

from __future__ import annotations

from typing import Final

TIMER_COUNT: Final = 256

_ONE_MS: Final = frozenset({0, 64, 32, 96})
_TEN_MS: Final = frozenset({*range(1, 5), *range(65, 69), *range(33, 37), *range(97, 101)})
_RETENTIVE: Final = frozenset({*range(32), *range(64, 96)})

ONE_MS_TIMERS: Final = tuple(sorted(_ONE_MS))
TEN_MS_TIMERS: Final = tuple(sorted(_TEN_MS))


def resolution(number: int) -> int:
    """1, 10 or 100 ms per count of timer ``number``."""
    if number in _ONE_MS:
        return 1
    return 10 if number in _TEN_MS else 100


def is_retentive(number: int) -> bool:
    """True for the numbers of TONR (T0..T31, T64..T95), False for those of TON and TOF."""
    return number in _RETENTIVE
