"""The Calc workbook in LibreOffice without a screen, against a running gateway: collecting, stopping, writing, logging.

Buttons call macros; the tests call the same macros.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.cli.conftest import invoke
from tests.sheet.conftest import EXAMPLE, Gateway, Office

PROJECT = ("--project", str(EXAMPLE / "items.yaml"))
SETPOINT, SPEED, MOTOR, TEMPERATURE, PRESSURE, FLAME = range(7, 13)
"""Rows of the sheet Items."""


class Book:
    """A workbook that is open in Calc."""

    def __init__(self, office: Office, path: Path) -> None:
        self.office = office
        self.path = path
        assert office("open", str(path)), f"LibreOffice does not open {path}"

    def __call__(self, command: str, *arguments: Any) -> Any:
        return self.office(command, *arguments)

    def text(self, cell: str) -> str:
        shown: str = self("shown", f"{cell}:{cell.partition('.')[2]}")[0][0]
        return shown

    def until(self, cell: str, wanted: str) -> None:
        (row,) = self("wait", f"{cell}:{cell.partition('.')[2]}", [[wanted]])
        assert row == [wanted]

    def until_other(self, cell: str) -> str:
        area = f"{cell}:{cell.partition('.')[2]}"
        old = self("shown", area)
        new = self("wait_other", area, old)
        assert new != old, f"{cell} stays {old}"
        changed: str = new[0][0]
        return changed

    def rows(self) -> int:
        """In the log."""
        return int(self.text("Settings.B8"))

    def start(self) -> None:
        self("macro", "Collecting.StartCollecting")

    def stop(self) -> None:
        self("macro", "Collecting.StopCollecting")


@pytest.fixture
def book(office: Office, gateway: Gateway, tmp_path: Path) -> Iterator[Book]:
    path = office.trusted / f"{tmp_path.name}.ods"
    made = invoke("sheet", "new", str(path), "--group", "Fast", *PROJECT, "--url", gateway.url)
    assert made.code == 0, made.err
    opened = Book(office, path)
    assert opened("trusted"), "macros may not run in the trusted folder"
    try:
        yield opened
    finally:
        office("close")


def test_live_values_are_collected_logged_stopped_and_collected_again(book: Book, gateway: Gateway) -> None:
    gateway.write("MicroWin.Mixer.Setpoint", "41")
    book.start()
    book.until(f"Items.B{SETPOINT}", "41")
    book.until_other(f"Items.B{TEMPERATURE}")
    assert book.text("Items.A2") == f"Collecting every 1 s from {gateway.url}"
    gateway.write("MicroWin.Mixer.Setpoint", "42")
    book.until(f"Items.B{SETPOINT}", "42")
    first = book("shown", "Log.A2:M2")
    assert first[0][0][:2] == "20"
    assert first[0][2] == "192"
    book.stop()
    stopped = book.rows()
    assert stopped >= 2
    values = book("shown", "Items.B7:F12")
    book("pause", 2.5)
    assert (book.rows(), book("shown", "Items.B7:F12")) == (stopped, values)
    assert book.text("Items.A2").startswith("Stopped")
    book.start()
    book.until_other("Settings.B8")
    book.until_other(f"Items.B{TEMPERATURE}")
    assert book.rows() > stopped
    assert book("shown", "Log.A2:M2") == first


def test_bad_quality_is_shown_with_its_name_and_in_red(book: Book) -> None:
    book.start()
    book.until(f"Items.E{FLAME}", "SENSOR_FAILURE")
    assert book.text(f"Items.D{FLAME}") == "16"
    assert book.text(f"Items.D{SPEED}") == "192"


def test_values_are_written_and_refusals_say_why(book: Book, gateway: Gateway) -> None:
    gateway.write("MicroWin.Mixer.Setpoint", "1")
    book.start()
    book.until(f"Items.B{SETPOINT}", "1")
    assert [row[0].rpartition(".")[2] for row in book("shown", "Write.A7:A9")] == ["Setpoint", "Motor", ""]
    book("put", "Write.C7", 77)
    book("put", "Write.C8", "perhaps")
    book("macro", "Writing.WriteNewValues")
    assert gateway.value("MicroWin.Mixer.Setpoint") == "77"
    new, result = book("shown", "Write.C7:D7")[0]
    assert (new, result[:14]) == ("", "77 written at ")
    assert book("shown", "Write.C8:D8") == [["perhaps", "not written: takes true or false, not 'perhaps'"]]
    book.until("Write.B7", "77")
    book("put", "Write.C7", 70000)
    book("put", "Write.C8", 1)
    book("macro", "Writing.WriteNewValues")
    assert book.text("Write.D7") == "not written: 70000 does not fit INT (-32768 to 32767)"
    assert (gateway.value("MicroWin.Mixer.Setpoint"), gateway.value("MicroWin.Mixer.Motor")) == ("77", "1")
    # The program of the soft-PLC runs: with the motor on, the speed rises.
    book.until_other(f"Items.B{SPEED}")


def test_nothing_is_written_without_the_button(book: Book, gateway: Gateway) -> None:
    before = gateway.value("MicroWin.Mixer.Setpoint")
    book.start()
    book("put", "Write.C7", 13)
    book.until_other("Settings.B8")
    assert gateway.value("MicroWin.Mixer.Setpoint") == before


def test_a_gateway_that_goes_away_is_shown_logged_and_found_again(book: Book, gateway: Gateway) -> None:
    gateway.write("MicroWin.Mixer.Setpoint", "55")
    book.start()
    book.until(f"Items.B{SETPOINT}", "55")
    names = book("names")
    book.until_other("Settings.B8")
    gateway.stop()
    try:
        book.until(f"Items.E{SETPOINT}", "COMM_FAILURE")
        assert book("shown", f"Items.A{SETPOINT}:D{SETPOINT}") == [["MicroWin.Mixer.Setpoint", "55", "%", "24"]]
        assert "does not answer" in book.text("Items.A2")
        book.until_other("Settings.B8")
        last = 1 + book.rows()
        assert book("shown", f"Log.B{last}:C{last}") == [["55", "24"]]
        book("put", "Write.C7", 5)
        book("macro", "Writing.WriteNewValues")
        assert book.text("Write.D7") == "not written: the gateway does not answer: is pcaccess running?"
    finally:
        gateway.start()
    book.until(f"Items.E{SETPOINT}", "GOOD")
    book.until_other(f"Items.B{TEMPERATURE}")
    assert book("names") == names


def test_the_formula_wizard_puts_formulas_and_collects_their_items(book: Book) -> None:
    lines = book("macro", "Wizards.OpenWizard", "Formula wizard", "", False)
    assert len(lines) == 8
    assert lines[3] == "MicroWin.Mixer.Batch   STRING   Name of the batch"
    book.start()
    where = ["cell", "Help.D3"]
    items = ["Sim.Oven.Door", "Sim.Oven.Temperature"]
    assert book("macro", "Wizards.InsertFormulas", where, items, "HIVUQNT") == ""
    assert book("shown", "Help.D3:I3") == [["Item", "Value", "Unit", "Quality", "Quality name", "Time stamp"]]
    book.until("Help.G4", "192")
    door = book("shown", "Help.D4:H4")[0]
    assert (door[0], door[1] in "01", door[3:]) == ("Sim.Oven.Door", True, ["192", "GOOD"])
    oven = book("shown", "Help.D5:I5")[0]
    assert (oven[0], oven[2], oven[3]) == ("Sim.Oven.Temperature", "°C", "192")
    assert oven[5].startswith("20")
    # What is there already is not overwritten.
    assert "Choose an empty place" in book("macro", "Wizards.InsertFormulas", where, items, "HV")
    # The new item is logged too, in columns of its own.
    book.until("Log.N1", "Sim.Oven.Door")
    book.until_other("Settings.B8")
    assert book.text(f"Log.O{book.rows() + 1}") == "192"


def test_the_write_wizard_adds_write_cells(book: Book, gateway: Gateway) -> None:
    assert book("macro", "Wizards.OpenWizard", "Write wizard", "", True) == [
        "MicroWin.Mixer.Motor   BOOL   Motor on",
        "MicroWin.Mixer.Setpoint   INT   %   Wanted speed",
        "MicroWin.Mixer.Batch   STRING   Name of the batch",
    ]
    book.start()
    assert book("macro", "Wizards.AddWriteRows", ["MicroWin.Mixer.Batch", "microwin.mixer.motor"]) == ""
    assert book("shown", "Write.A9:A10") == [["MicroWin.Mixer.Batch"], [""]]
    book("put", "Write.C9", "Grün & süß, 1+1")
    book("macro", "Writing.WriteNewValues")
    assert gateway.value("MicroWin.Mixer.Batch") == "Grün & süß, 1+1"
    book.until("Write.B9", "Grün & süß, 1+1")
    assert "there is no such item" in book("macro", "Wizards.AddWriteRows", ["MicroWin.Mixer.Nix"])


def test_the_chart_shows_the_last_rows_of_the_log(book: Book, gateway: Gateway) -> None:
    gateway.write("MicroWin.Mixer.Setpoint", "33")
    book.start()
    book.until(f"Items.B{SETPOINT}", "33")
    book.until_other("Settings.B8")
    assert book("charts", "Chart") == 1
    assert book("shown", "Chart.A34:C34") == [["Time", "Setpoint [%]", "Speed [%]"]]
    book.stop()
    last = book("shown", "Chart.A154:B154")[0]
    logged = book("shown", f"Log.A{book.rows() + 1}:B{book.rows() + 1}")[0]
    assert (last[0], last[1]) == (logged[0][11:], logged[1])
    assert book.text("Chart.B35") == "#N/A"  # before the first row: a gap


def test_what_was_logged_and_stopped_stays_when_the_book_is_opened_again(book: Book) -> None:
    book.start()
    book.until_other("Settings.B8")
    book.stop()
    rows, first = book.rows(), book("shown", "Log.A2:M2")
    book("save")
    book("close")
    assert book("open", str(book.path))
    assert book.rows() == rows
    assert book("shown", "Log.A2:M2") == first
    assert book("links")[0][1] == 0
    book.start()
    book.until_other("Settings.B8")
    book("macro", "Collecting.EmptyLog")
    assert book.text("Log.B1") == "MicroWin.Mixer.Setpoint"


def test_where_the_user_does_not_trust_nothing_runs_and_the_book_says_what_to_permit(
    office: Office, gateway: Gateway, tmp_path: Path
) -> None:
    path = tmp_path / "elsewhere.ods"
    assert invoke("sheet", "new", str(path), *PROJECT, "--url", gateway.url).code == 0
    book = Book(office, path)
    try:
        assert not book("trusted")
        assert book.text("Items.A2").startswith("No data yet: permit that links are updated")
    finally:
        office("close")


def test_webservice_cells_of_an_excel_workbook_ask_again_when_the_tick_changes(
    office: Office, gateway: Gateway, tmp_path: Path
) -> None:
    path = office.trusted / "tick.xlsx"
    assert invoke("sheet", "new", str(path), *PROJECT, "--url", gateway.url).code == 0
    gateway.write("MicroWin.Mixer.Setpoint", "11")
    book = Book(office, path)
    try:
        book("put", "Items.B4", 1)
        book.until("Items.B8", "11")
        gateway.write("MicroWin.Mixer.Setpoint", "12")
        book("calculate")
        assert book.text("Items.B8") == "11"
        book("put", "Items.B4", 2)
        book.until("Items.B8", "12")
        assert book("shown", "Items.C8:E8") == [["%", "192", "GOOD"]]
        assert book("shown", "Items.D13:E13") == [["16", "SENSOR_FAILURE"]]
        book("put", "Write.B5", 70000)
        book("put", "Write.B6", 1)
        book.until("Write.C6", "ok")
        assert "70000 does not fit INT" in book.text("Write.C5")
        assert book.text("Write.D6") == "pcaccess write MicroWin.Mixer.Motor 1"
    finally:
        office("close")
