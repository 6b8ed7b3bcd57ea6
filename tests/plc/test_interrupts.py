"""Interrupt queues: priority, order, overflow."""

from __future__ import annotations

import pytest

from pcaccess.plc.interrupts import Group, InterruptTable, group_of


def table(*events: int) -> InterruptTable:
    """Each event attached to the routine with its number, interrupts on."""
    interrupts = InterruptTable()
    for event in events:
        interrupts.attach(event, event)
    interrupts.enabled = True
    return interrupts


def taken(interrupts: InterruptTable) -> list[int]:
    found = []
    while (routine := interrupts.take()) is not None:
        found.append(routine)
    return found


def test_groups_go_before_each_other_and_within_one_the_first_comes_first() -> None:
    interrupts = table(10, 0, 8, 21, 2)
    for event in (21, 2, 10, 0, 8):
        interrupts.raise_event(event)
    assert taken(interrupts) == [8, 2, 0, 21, 10]


@pytest.mark.parametrize(
    ("event", "group"),
    [
        (8, Group.COMMUNICATION),
        (26, Group.COMMUNICATION),
        (0, Group.IO),
        (19, Group.IO),
        (33, Group.IO),
        (10, Group.TIMED),
        (22, Group.TIMED),
    ],
)
def test_every_event_has_its_group(event: int, group: Group) -> None:
    assert group_of(event) is group


def test_an_event_without_a_routine_is_nothing() -> None:
    interrupts = table()
    assert interrupts.raise_event(5) is None
    assert not interrupts.has_work


def test_a_full_queue_loses_the_event_and_says_so_until_it_is_empty() -> None:
    interrupts = table(10)
    lost = [interrupts.raise_event(10) for _ in range(10)]
    assert lost == [None] * 8 + [Group.TIMED] * 2
    assert interrupts.emptied() == frozenset()
    assert len(taken(interrupts)) == 8
    assert interrupts.emptied() == {Group.TIMED}
    assert interrupts.emptied() == frozenset()


def test_a_cpu_with_two_ports_queues_more_communication_events() -> None:
    interrupts = InterruptTable(communication_depth=8)
    interrupts.attach(8, 0)
    assert [interrupts.raise_event(8) for _ in range(9)] == [None] * 8 + [Group.COMMUNICATION]


def test_switched_off_events_wait() -> None:
    interrupts = table(0)
    interrupts.enabled = False
    interrupts.raise_event(0)
    assert (interrupts.has_work, interrupts.take()) == (False, None)
    interrupts.enabled = True
    assert interrupts.has_work
    assert taken(interrupts) == [0]


def test_a_detached_event_is_forgotten_even_when_it_waits() -> None:
    interrupts = table(0, 2)
    interrupts.raise_event(0)
    interrupts.raise_event(2)
    interrupts.detach(0)
    assert taken(interrupts) == [2]


def test_attaching_again_changes_the_routine() -> None:
    interrupts = table(0)
    interrupts.attach(0, 7)
    interrupts.raise_event(0)
    assert taken(interrupts) == [7]


def test_reset_forgets_everything() -> None:
    interrupts = table(0)
    interrupts.raise_event(0)
    interrupts.reset()
    interrupts.enabled = True
    assert interrupts.take() is None
    assert dict(interrupts.attached) == {}
