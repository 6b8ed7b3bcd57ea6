"""OPC UA time: ticks of 100 ns since 1601."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone

from hypothesis import given
from hypothesis import strategies as st

from pcaccess.items.ticks import from_ticks, to_ticks

MIN = datetime(1601, 1, 1, tzinfo=UTC).replace(tzinfo=None)
MAX = datetime(9999, 12, 31, tzinfo=UTC).replace(tzinfo=None)


def test_the_era_begins_in_1601() -> None:
    assert to_ticks(datetime(1601, 1, 1, tzinfo=UTC)) == 0


def test_the_unix_epoch_is_where_part_6_puts_it() -> None:
    assert to_ticks(datetime(1970, 1, 1, tzinfo=UTC)) == 116_444_736_000_000_000


def test_another_time_zone_is_the_same_moment() -> None:
    cet = timezone(timedelta(hours=1))
    assert to_ticks(datetime(2026, 11, 22, 13, tzinfo=cet)) == to_ticks(datetime(2026, 11, 22, 12, tzinfo=UTC))


@given(st.datetimes(MIN, MAX, timezones=st.just(UTC)))
def test_a_moment_survives_to_the_microsecond(moment: datetime) -> None:
    assert from_ticks(to_ticks(moment)) == moment


@given(st.integers(0, to_ticks(MAX.replace(tzinfo=UTC))))
def test_ticks_are_rounded_down_to_the_microsecond(ticks: int) -> None:
    assert to_ticks(from_ticks(ticks)) == ticks - ticks % 10
