"""Rows come into the workbook, each once, whatever happens; and what else is in it stays."""

from __future__ import annotations

import io
import tracemalloc
import zipfile
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from openpyxl import Workbook, load_workbook

from pcaccess.s7200.types import DataType
from pcaccess.sheet.collect import append
from pcaccess.sheet.collect.journal import journal_of
from pcaccess.sheet.collect.records import EventRecord, RowRecord, Sample
from pcaccess.sheet.collect.store import BookIsOpen, Store, following_book, newest_book, open_store
from pcaccess.sheet.entries import Chosen, Entry, SheetError

NOW = datetime(2026, 1, 2, 3, 4, 5, 678000, UTC)
CHOSEN = Chosen(
    [
        Entry("L.P.Level", DataType.INT, unit="cm", description="=1+1"),
        Entry("L.P.Flow", DataType.REAL, low=0, high=100),
        Entry("L.P.Text", DataType.STRING),
    ]
)


@pytest.fixture
def book(tmp_path: Path) -> Path:
    return tmp_path / "book.xlsx"


def opened(book: Path, chosen: Chosen | None = CHOSEN, max_rows: int = 1000) -> Store:
    return open_store(book, chosen, "http://127.0.0.1:8080", NOW, max_rows)


def row(n: int, text: str = "") -> RowRecord:
    at = NOW + timedelta(seconds=n)
    return RowRecord(at, [Sample(n, 192, at), Sample(n / 4, 64, at), Sample(text or None, 24, None)])


def filled(book: Path, *numbers: int, max_rows: int = 1000) -> None:
    store = opened(book, max_rows=max_rows)
    for n in numbers:
        store.append(row(n))
    store.save()
    store.close()


def values(book: Path, sheet: str = "Values") -> list[tuple[Any, ...]]:
    """Rows below the titles."""
    workbook = load_workbook(book)
    return [line[1:] for line in workbook[sheet].iter_rows(min_row=2, values_only=True)]


def levels(book: Path) -> list[Any]:
    return [line[0] for line in values(book)]


def test_values_qualities_times_and_events_each_have_their_sheet(book: Path) -> None:
    store = opened(book)
    store.append(EventRecord(NOW, "began"))
    store.append(row(7, "grün"))
    assert store.save() == 1
    store.close()
    local = NOW.astimezone().replace(tzinfo=None)
    assert values(book) == [(7, 1.75, "grün")]
    assert values(book, "Qualities") == [(192, 64, 24)]
    assert values(book, "Time Stamps") == [(local + timedelta(seconds=7), local + timedelta(seconds=7), None)]
    assert values(book, "Runs") == [("began",)]
    workbook = load_workbook(book)
    assert workbook["Values"]["A2"].value == local + timedelta(seconds=7)
    assert workbook["Values"]["A2"].number_format == "yyyy-mm-dd hh:mm:ss.000"
    assert not journal_of(book).exists()


@pytest.mark.parametrize("text", ["=1+1", "a < b & c", "\x01bell", "_x0041_", " blanks ", "two\nlines", "x" * 40_000])
def test_any_text_arrives_as_a_text(book: Path, text: str) -> None:
    store = opened(book)
    store.append(row(1, text))
    store.save()
    store.close()
    cell = load_workbook(book)["Values"]["D2"]
    read = cell.value.replace("_x0001_", "\x01").replace("_x005F_", "_")
    assert (cell.data_type, read) == ("s", text[:32_767])


def test_numbers_that_excel_does_not_have_are_texts(book: Path) -> None:
    store = opened(book)
    store.append(RowRecord(NOW, [Sample("NaN", 192, NOW), Sample("-Infinity", 192, NOW), Sample(1, 192, NOW)]))
    store.save()
    store.close()
    assert values(book) == [("NaN", "-Infinity", 1)]


def test_later_rows_come_below(book: Path) -> None:
    filled(book, 1, 2)
    filled(book, 3)
    assert levels(book) == [1, 2, 3]


def test_a_full_workbook_is_followed_by_another(book: Path) -> None:
    filled(book, 1, 2, 3, 4, 5, max_rows=2)
    second, third = following_book(book), following_book(following_book(book))
    assert [path.name for path in (second, third)] == ["book-2.xlsx", "book-3.xlsx"]
    assert [levels(path) for path in (book, second, third)] == [[1, 2], [3, 4], [5]]
    filled(book, 6, 7, max_rows=2)
    assert newest_book(book).name == "book-4.xlsx"
    assert [levels(path) for path in (third, newest_book(book))] == [[5, 6], [7]]


def test_rows_left_in_the_journal_come_in_at_the_next_start(book: Path) -> None:
    filled(book, 1)
    crashed = opened(book)
    crashed.append(row(2))
    crashed.journal.close(remove=False)  # as a killed process leaves it
    filled(book, 3)
    assert levels(book) == [1, 2, 3]


def test_a_crash_between_saving_and_removing_the_journal_doubles_nothing(book: Path) -> None:
    crashed = opened(book)
    crashed.append(row(1))
    crashed.save()
    crashed.append(row(2))
    crashed.journal.close(remove=False)
    filled(book, 3)
    assert levels(book) == [1, 2, 3]


def test_a_merge_needs_no_items(book: Path) -> None:
    crashed = opened(book)
    crashed.append(row(1))
    crashed.journal.close(remove=False)
    store = opened(book, None)
    assert store.save() == 1
    store.close()
    assert levels(book) == [1]


@pytest.mark.parametrize(
    ("mark", "who"),
    [
        (".~lock.book.xlsx#", "LibreOffice (anna)"),
        ("~$book.xlsx", "Excel (Anna)"),
    ],
)
def test_an_open_workbook_is_left_alone_until_it_is_closed(book: Path, mark: str, who: str) -> None:
    filled(book, 1)
    before = book.read_bytes()
    lock = book.with_name(mark)
    lock.write_bytes(b"\x04Anna" + b" " * 50 if "$" in mark else b",anna,machine,02.01.2026 03:04,file:///x;")
    store = opened(book)
    store.append(row(2))
    with pytest.raises(BookIsOpen) as caught:
        store.save()
    assert who in str(caught.value)
    assert mark in str(caught.value)
    assert book.read_bytes() == before
    lock.unlink()
    assert store.save() == 1
    store.close()
    assert levels(book) == [1, 2]


def test_a_read_only_workbook_says_so_and_stays(book: Path) -> None:
    filled(book, 1)
    book.chmod(0o444)
    store = opened(book)
    store.append(row(2))
    with pytest.raises(SheetError, match="is read-only"):
        store.save()
    store.close()
    assert levels(book) == [1]
    assert journal_of(book).exists()


def test_a_damaged_workbook_says_so_and_stays(book: Path) -> None:
    filled(book, *range(50))
    data = bytearray(book.read_bytes())
    with zipfile.ZipFile(book) as package:
        place = package.getinfo("xl/worksheets/sheet1.xml").header_offset + 200
    data[place : place + 20] = bytes(20)
    for damaged in (bytes(data), bytes(data[:-100]), b"PK, but no more", b""):
        book.write_bytes(damaged)
        with pytest.raises(SheetError, match=r"is damaged or no \.xlsx workbook"):
            opened(book)
        assert book.read_bytes() == damaged
    assert not journal_of(book).exists()


def test_a_workbook_of_somebody_else_is_left_alone(book: Path) -> None:
    Workbook().save(book)
    with pytest.raises(SheetError, match="was not made by `pcaccess sheet collect`"):
        opened(book)


def test_other_items_need_another_workbook(book: Path) -> None:
    filled(book, 1)
    with pytest.raises(SheetError, match=r"also L\.P\.New; not L\.P\.Flow, L\.P\.Text"):
        opened(book, Chosen([CHOSEN.entries[0], Entry("L.P.New", DataType.INT)]))


def test_a_fault_while_saving_leaves_the_workbook_and_no_litter(book: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    filled(book, 1)
    before = book.read_bytes()
    store = opened(book)
    store.append(row(2))

    def fail(*arguments: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(append, "_row_xml", fail)
    with pytest.raises(SheetError, match="No space left on device"):
        store.save()
    store.close()
    assert book.read_bytes() == before
    assert sorted(path.name for path in book.parent.iterdir()) == ["book.xlsx", "book.xlsx.journal"]


def test_what_a_user_added_stays_byte_for_byte(book: Path) -> None:
    filled(book, 1)
    workbook = load_workbook(book)
    workbook.create_sheet("Mine")["A1"] = "=SUM(Values!B:B)"
    workbook.save(book)
    with zipfile.ZipFile(book) as package, zipfile.ZipFile(buffer := io.BytesIO(), "w") as more:
        for info in package.infolist():
            more.writestr(info, package.read(info))
        more.writestr("xl/vbaProject.bin", b"\xd0\xcf\x11\xe0 whatever Excel put there")
    book.write_bytes(buffer.getvalue())
    had = {name: zipfile.ZipFile(book).read(name) for name in zipfile.ZipFile(book).namelist()}
    filled(book, 2)
    has = {name: zipfile.ZipFile(book).read(name) for name in zipfile.ZipFile(book).namelist()}
    changed = {name for name in had if had[name] != has[name]}
    assert had.keys() == has.keys()
    assert "xl/vbaProject.bin" not in changed
    assert changed == {"docProps/custom.xml", *(f"xl/worksheets/sheet{n}.xml" for n in (1, 3, 4))}
    assert levels(book) == [1, 2]


def test_saving_takes_no_more_memory_for_a_longer_workbook(book: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(append, "_CHUNK", 10_000)  # the workbooks of a test are short
    filled(book, *range(20))

    def peak() -> int:
        store = opened(book, max_rows=100_000)
        for n in range(2000):
            store.append(row(n))
        tracemalloc.start()
        store.save()
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        store.close()
        return most

    peak()
    first = peak()
    for _ in range(4):
        peak()
    assert peak() < first * 1.3


def test_programs_that_trust_the_size_of_a_sheet_see_the_new_rows(book: Path) -> None:
    filled(book, 1, 2, 3)
    workbook = load_workbook(book, read_only=True)
    assert workbook["Values"].calculate_dimension() == "A1:D4"
    assert len(list(workbook["Values"].iter_rows())) == 4
    workbook.close()
