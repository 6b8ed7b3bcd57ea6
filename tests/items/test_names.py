"""Names of rows: any case finds them, none comes twice."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.items import names as module
from pcaccess.items.names import FEW, Names

texts = st.text(st.sampled_from("aAbBßSsİi"), min_size=1, max_size=4)


class Book:
    """Names, and what was written for each row."""

    def __init__(self) -> None:
        self.written: dict[int, str] = {}
        self.names = Names(self.written.__getitem__)

    def add(self, names: Sequence[str], rows: Sequence[int]) -> None:
        self.names.check(names)
        self.written.update(zip(rows, names, strict=True))
        self.names.add(names, rows)


@given(st.lists(st.tuples(st.booleans(), st.lists(texts, max_size=4)), max_size=8), st.lists(texts, max_size=20))
def test_names_are_a_dictionary_of_folded_texts(batches: list[tuple[bool, list[str]]], asked: list[str]) -> None:
    """With the plainest of all implementations beside it; long batches take the other way in."""
    book, model, written, next_row = Book(), dict[str, int](), list[str](), 0
    for is_long, batch in batches:
        wanted = batch + ([f"filler {next_row} {n}" for n in range(FEW + 1)] if is_long else [])
        folded = [name.casefold() for name in wanted]
        rows = list(range(next_row, next_row + len(wanted)))
        next_row += len(wanted)
        if len(set(folded)) < len(folded) or model.keys() & set(folded):
            with pytest.raises(KeyError):
                book.names.check(wanted)
            continue
        book.add(wanted, rows)
        model.update(zip(folded, rows, strict=True))
        written += wanted
    for name in [*written, *(w.swapcase() for w in written), *asked]:
        assert book.names.find(name) == model.get(name.casefold())


def test_removed_names_are_free_again() -> None:
    book = Book()
    book.add([f"Item{n}" for n in range(200)], range(200))
    book.add(["Single"], [200])
    book.names.add_alias("2,VW0,INT", 5)
    assert book.names.find("ITEM7") == 7
    book.names.remove([5, 7, 200])
    assert [book.names.find(n) for n in ("Item5", "ITEM7", "single", "2,vw0,int", "item6")] == [None] * 4 + [6]
    book.add([f"ITEM{n}" for n in (5, 7)], [300, 301])
    assert (book.names.find("item5"), book.names.find("Item7")) == (300, 301)


def test_an_alias_never_takes_a_name_away() -> None:
    book = Book()
    book.add(["A", "B"], [0, 1])
    book.names.add_alias("a", 1)
    book.names.add_alias("other", 1)
    book.names.add_alias("OTHER", 0)
    assert (book.names.find("a"), book.names.find("Other")) == (0, 1)
    with pytest.raises(KeyError):
        book.names.check(["Other"])


def test_equal_hashes_are_told_apart() -> None:
    class Same(str):
        def casefold(self) -> str:
            return Same(super().casefold())

        def __hash__(self) -> int:
            return 1

        def __eq__(self, other: object) -> bool:
            return str.__eq__(self, other)

    book = Book()
    book.add([Same(f"Item{n}") for n in range(FEW + 1)], range(FEW + 1))
    assert [book.names.find(Same(f"ITEM{n}")) for n in (0, 7, FEW)] == [0, 7, FEW]
    assert book.names.find(Same("nothing")) is None


def test_many_batches_are_found_wherever_they_went() -> None:
    book = Book()
    for batch in range(20):
        book.add([f"B{batch}.Item{n}" for n in range(100)], range(batch * 100, batch * 100 + 100))
    assert [book.names.find(f"b{batch}.ITEM7") for batch in range(20)] == [batch * 100 + 7 for batch in range(20)]
    book.names.remove(range(500, 700))
    assert [book.names.find(f"b{batch}.ITEM7") for batch in (4, 5, 6, 7)] == [407, None, None, 707]


def test_what_was_asked_is_remembered_within_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_ASKED", 10)
    book = Book()
    book.add([f"Item{n}" for n in range(100)], range(100))
    for n in range(100):
        assert book.names.find(f"ITEM{n}") == n
        assert len(book.names._asked) <= 10
