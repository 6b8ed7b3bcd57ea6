"""Timer numbers: the table of document 000."""

from __future__ import annotations

import pytest

from pcaccess.s7200.timers import ONE_MS_TIMERS, TEN_MS_TIMERS, is_retentive, resolution


@pytest.mark.parametrize(
    ("number", "milliseconds", "retentive"),
    [
        (0, 1, True),
        (1, 10, True),
        (4, 10, True),
        (5, 100, True),
        (31, 100, True),
        (32, 1, False),
        (33, 10, False),
        (36, 10, False),
        (37, 100, False),
        (63, 100, False),
        (64, 1, True),
        (65, 10, True),
        (68, 10, True),
        (69, 100, True),
        (95, 100, True),
        (96, 1, False),
        (97, 10, False),
        (100, 10, False),
        (101, 100, False),
        (255, 100, False),
    ],
)
def test_a_timer_number_fixes_resolution_and_kind(number: int, milliseconds: int, retentive: bool) -> None:
    assert (resolution(number), is_retentive(number)) == (milliseconds, retentive)


def test_there_are_four_1_ms_and_sixteen_10_ms_timers() -> None:
    assert (len(ONE_MS_TIMERS), len(TEN_MS_TIMERS)) == (4, 16)
