"""Encoded NodeIds to rows in bulk: a dictionary with another inside."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.opcua.fast.shelves import BEHIND, MISSING, Shelves

names = st.binary(min_size=1, max_size=20)


def ask(shelves: Shelves, wanted: list[bytes]) -> list[int]:
    data, starts = b"", []
    for name in wanted:
        starts.append(len(data))
        data += name + BEHIND
    return shelves.rows(data, np.array(starts), np.array([len(name) for name in wanted])).tolist()


@given(st.dictionaries(names, st.integers(0, 1000), max_size=30), st.lists(names, min_size=1, max_size=30))
def test_shelves_are_a_dictionary(known: dict[bytes, int], others: list[bytes]) -> None:
    shelves = Shelves(100, 16)
    kept = {name: row for name, row in known.items() if len(name) <= 16}
    for name, row in known.items():
        shelves.learn(name, row)
    wanted = [*known, *others, *known]
    assert ask(shelves, wanted) == [kept.get(name, MISSING) for name in wanted]
    more = [name for name in others if len(name) <= 16 and name not in kept]
    for row, name in enumerate(more):
        shelves.learn(name, row)
        kept[name] = row
    assert ask(shelves, wanted) == [kept.get(name, MISSING) for name in wanted]


def test_hashes_that_are_all_the_same_cost_time_only(monkeypatch: pytest.MonkeyPatch) -> None:
    shelves = Shelves(100, 16)
    for row, name in enumerate([b"one", b"two", b"six"]):
        shelves.learn(name, row)
    (shelf,) = shelves._shelves.values()
    monkeypatch.setattr(shelf, "_hash", lambda words: np.zeros(len(words), np.uint64))
    assert ask(shelves, [b"one", b"two", b"six", b"ten"]) == [0, MISSING, MISSING, MISSING]


def test_names_that_differ_in_one_digit_have_hashes_of_their_own() -> None:
    shelves = Shelves(100_000, 100)
    known = [b"\x03\x02\x00Soft.P%02d.F%02d.I%02d" % (p, f, i) for p in range(10) for f in range(20) for i in range(99)]
    for row, name in enumerate(known):
        shelves.learn(name, row)
    assert ask(shelves, known) == list(range(len(known)))


def test_one_too_many_forgets_all_and_clear_does() -> None:
    shelves = Shelves(2, 16)
    for row, name in enumerate([b"a", b"b", b"c"]):
        shelves.learn(name, row)
    assert ask(shelves, [b"a", b"b", b"c"]) == [MISSING, MISSING, 2]
    shelves.clear()
    assert ask(shelves, [b"c"]) == [MISSING]
