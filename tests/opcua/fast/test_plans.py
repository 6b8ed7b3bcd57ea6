"""The memory of plans has bounds, and forgets what was used longest ago."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import given
from hypothesis import strategies as st

from pcaccess.opcua.fast.plans import SMALL_PLAN, Plans


@dataclass
class Sized:
    size: int = 10


def test_the_plan_used_longest_ago_goes_first() -> None:
    plans = Plans[Sized](most=3)
    for name in (b"a", b"b", b"c"):
        plans.offer(name, Sized())
    assert plans.get(b"a") is not None
    assert plans.get(b"a") is not None
    plans.offer(b"d", Sized())
    assert [name for name in (b"a", b"b", b"c", b"d") if plans.get(name)] == [b"a", b"c", b"d"]


def test_a_large_plan_is_kept_from_its_second_time_on() -> None:
    plans = Plans[Sized]()
    large = Sized(SMALL_PLAN)
    plans.offer(b"large", large)
    assert plans.get(b"large") is None
    plans.offer(b"large", large)
    assert plans.get(b"large") is large


def test_one_plan_never_takes_much_of_the_room() -> None:
    plans = Plans[Sized](most_bytes=80_000)
    for _ in range(2):
        plans.offer(b"huge", Sized(10_001))
    assert plans.get(b"huge") is None


@given(
    st.lists(
        st.tuples(st.sampled_from(["offer", "get", "drop"]), st.integers(0, 30), st.integers(0, 4_000)), max_size=80
    )
)
def test_there_are_never_more_plans_or_bytes_than_allowed(steps: list[tuple[str, int, int]]) -> None:
    plans, model = Plans[Sized](most=10, most_bytes=40_000), dict[bytes, Sized]()
    for what, number, size in steps:
        name = b"request %d" % number
        if what == "offer":
            model[name] = Sized(size)
            plans.offer(name, model[name])
            assert plans.get(name) is model[name]
        elif what == "drop":
            model.pop(name, None)
            plans.drop(name)
        found = plans.get(name)
        assert found is None or found is model[name]
        assert len(plans) <= 10
        assert plans.bytes <= 40_000
        assert plans.bytes == sum(len(key) + plan.size for key, plan in plans._plans.items())
