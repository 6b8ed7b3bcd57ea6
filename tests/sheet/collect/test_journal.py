"""The journal keeps what a crash would lose."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from pcaccess.sheet.collect.journal import Journal, open_journal
from pcaccess.sheet.collect.records import EventRecord, Record, RowRecord, Sample
from pcaccess.sheet.entries import SheetError

START = datetime(2026, 1, 2, 3, 4, 5, 678000, UTC)
ITEMS = ["L.P.Ä", "L.P.Text"]
RECORDS: list[Record] = [
    EventRecord(START, "began"),
    RowRecord(START, [Sample(-1.5, 192, START), Sample('two\nlines "quoted" ä€ \x01', 192, START)]),
    RowRecord(START + timedelta(seconds=1), [Sample(None, 24, None), Sample("", 4, START)]),
]


def written(path: Path) -> Journal:
    journal = open_journal(path, ITEMS)
    for record in RECORDS:
        journal.append(record)
    return journal


def everything(journal: Journal) -> list[Record]:
    return list(journal.records(journal.begin, journal.end))


def test_what_was_appended_is_read_back(tmp_path: Path) -> None:
    journal = written(tmp_path / "j")
    assert everything(journal) == RECORDS
    journal.close(remove=True)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("lost", [1, 10, 60])
def test_a_record_that_a_crash_cut_off_is_dropped_and_the_others_stay(tmp_path: Path, lost: int) -> None:
    path = tmp_path / "j"
    written(path).close(remove=False)
    path.write_bytes(path.read_bytes()[:-lost])
    journal = open_journal(path, ITEMS)
    assert everything(journal) == RECORDS[:2]
    journal.append(RECORDS[2])
    assert everything(journal) == RECORDS
    journal.close(remove=True)


def test_an_empty_or_cut_off_head_is_begun_anew(tmp_path: Path) -> None:
    path = tmp_path / "j"
    path.write_bytes(b'["pcaccess jour')
    journal = open_journal(path, ITEMS)
    assert everything(journal) == []
    journal.close(remove=True)


def test_a_journal_is_found_again_with_its_name(tmp_path: Path) -> None:
    journal = written(tmp_path / "j")
    journal.close(remove=False)
    again = open_journal(tmp_path / "j", None)
    assert (again.name, again.items) == (journal.name, ITEMS)
    again.close(remove=True)


def test_rows_of_other_items_are_not_mixed_in(tmp_path: Path) -> None:
    written(tmp_path / "book.xlsx.journal").close(remove=False)
    with pytest.raises(SheetError, match=r"other items .*pcaccess sheet merge book\.xlsx$"):
        open_journal(tmp_path / "book.xlsx.journal", ["L.P.Other"])


def test_a_second_collector_is_refused(tmp_path: Path) -> None:
    journal = written(tmp_path / "book.xlsx.journal")
    with pytest.raises(SheetError, match=r"another pcaccess is collecting into book\.xlsx"):
        open_journal(tmp_path / "book.xlsx.journal", ITEMS)
    journal.close(remove=True)


def test_a_file_that_is_no_journal_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "j"
    path.write_text("my notes\n")
    with pytest.raises(SheetError, match="is not a journal of pcaccess"):
        open_journal(path, ITEMS)
    assert path.read_text() == "my notes\n"
