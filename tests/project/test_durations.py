from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.project.durations import UNITS, DurationError, format_duration, parse_duration


@pytest.mark.parametrize(
    ("text", "seconds"),
    [("250ms", 0.25), ("1s", 1.0), ("2min", 120.0), ("1.5h", 5400.0), ("1 s", 1.0), ("10MIN", 600.0), ("1d", 86400.0)],
)
def test_a_duration_is_a_number_and_a_unit(text: str, seconds: float) -> None:
    assert parse_duration(text) == seconds


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("250", "no unit; write 250ms or 250s"),
        ("5m", "'m' is not a unit of time"),
        ("5sec", "'sec' is not a unit of time"),
        ("soon", "not a duration"),
        ("-1s", "not a duration"),
        ("", "not a duration"),
        ("1s 5ms", "not a duration"),
        ("٣s", "not a duration"),
    ],
)
def test_what_is_not_a_duration_says_why(text: str, why: str) -> None:
    with pytest.raises(DurationError, match=why):
        parse_duration(text)


@given(st.integers(1, 100_000), st.sampled_from(list(UNITS)))
def test_a_printed_duration_reads_back_the_same(number: int, unit: str) -> None:
    seconds = parse_duration(f"{number}{unit}")
    assert parse_duration(format_duration(seconds)) == pytest.approx(seconds, rel=1e-9)


@pytest.mark.parametrize(("seconds", "text"), [(0.25, "250ms"), (1, "1s"), (60, "1min"), (90, "90s"), (3600, "1h")])
def test_the_largest_unit_without_a_fraction_is_printed(seconds: float, text: str) -> None:
    assert format_duration(seconds) == text
