"""``pcaccess sheet`` as a process: making workbooks, collecting through trouble, what it says of mistakes."""

from __future__ import annotations

import json
import signal
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from openpyxl import load_workbook

from pcaccess.sheet.formulas import column_letters
from tests.sheet.conftest import EXAMPLE, PATIENCE, Gateway, done, pcaccess

PROJECT = ("--project", str(EXAMPLE / "items.yaml"))


def rows(book: Path, sheet: str = "Values") -> list[tuple[Any, ...]]:
    return list(load_workbook(book)[sheet].iter_rows(min_row=2, values_only=True))


# ---------------------------------------------------------------------- new, formulas


def test_the_same_project_makes_the_same_calc_book_byte_for_byte(tmp_path: Path) -> None:
    for name in ("a.ods", "b.ods"):
        assert done("sheet", "new", name, *PROJECT, folder=tmp_path)[0] == 0
    assert (tmp_path / "a.ods").read_bytes() == (tmp_path / "b.ods").read_bytes()


def test_a_calc_book_is_a_package_of_well_formed_parts(tmp_path: Path) -> None:
    assert done("sheet", "new", "a.ods", "--items", "*", *PROJECT, folder=tmp_path)[0] == 0
    with zipfile.ZipFile(tmp_path / "a.ods") as package:
        names = package.namelist()
        assert names[0] == "mimetype"
        assert package.infolist()[0].compress_type == zipfile.ZIP_STORED
        manifest = package.read("META-INF/manifest.xml").decode()
        for name in names[1:]:
            ElementTree.fromstring(package.read(name))
            assert name == "META-INF/manifest.xml" or f'full-path="{name}"' in manifest
        content = package.read("content.xml").decode()
    assert 'table:refresh-delay="PT00H00M01S"' in content
    assert "/api/items.csv?id=MicroWin.Mixer.Motor&amp;id=" in content
    assert content.count("form:button ") == 7


def test_an_existing_file_is_replaced_only_by_force(tmp_path: Path) -> None:
    (tmp_path / "a.ods").write_text("mine")
    code, _, err = done("sheet", "new", "a.ods", *PROJECT, folder=tmp_path)
    assert (code, err) == (1, "pcaccess: a.ods exists; name another file, or replace it with --force\n")
    assert (tmp_path / "a.ods").read_text() == "mine"
    (tmp_path / ".~lock.a.ods#").write_text(",anna,machine,,;")
    code, _, err = done("sheet", "new", "a.ods", "--force", *PROJECT, folder=tmp_path)
    assert (code, "is open in LibreOffice (anna)" in err) == (1, True)
    (tmp_path / ".~lock.a.ods#").unlink()
    assert done("sheet", "new", "a.ods", "--force", *PROJECT, folder=tmp_path)[0] == 0


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (("new", "a.xls"), 2, ".ods or .xlsx"),
        (("new", "a.ods", "--every", "500ms"), 2, "whole seconds"),
        (("new", "a.ods", "--group", "Slow"), 1, "there is no group Slow; there are Fast"),
        (("new", "a.ods", "--items", "Sim.Oven.Dor"), 1, "did you mean Sim.Oven.Door?"),
        (("new", "no/such/folder/a.ods"), 1, "cannot be written: No such file or directory"),
        (("formulas", "--for", "lotus"), 2, "expected calc or excel"),
    ],
)
def test_mistakes_are_told(tmp_path: Path, arguments: tuple[str, ...], code: int, said: str) -> None:
    ended, _, err = done("sheet", *arguments, *PROJECT, folder=tmp_path)
    assert (ended, said in " ".join(err.replace("│", " ").split())) == (code, True), err
    assert list(tmp_path.iterdir()) == []


def test_items_are_picked_on_the_terminal(tmp_path: Path) -> None:
    with pcaccess("sheet", "formulas", "--pick", *PROJECT, folder=tmp_path, stdin=-1) as process:
        out, _ = process.communicate("oven\n1 3\n\n", timeout=PATIENCE)
    assert [line.partition("\t")[0] for line in out.splitlines()] == ["Item", "Sim.Oven.Temperature", "Sim.Oven.Door"]


def test_an_excel_book_has_its_names_query_and_chart(tmp_path: Path) -> None:
    assert done("sheet", "new", "a.xlsx", *PROJECT, folder=tmp_path)[0] == 0
    book = load_workbook(tmp_path / "a.xlsx")
    assert book.sheetnames == ["Items", "Write", "Power Query", "Help"]
    assert book.defined_names["Gateway"].attr_text == "Items!$B$3"
    assert book["Items"]["B3"].value == "http://127.0.0.1:8080"
    query = "\n".join(str(cell.value) for cell in book["Power Query"]["A"] if cell.value)
    assert 'Web.Contents("http://127.0.0.1:8080/api/groups/Fast.csv")' in query
    assert len(book["Items"]._charts) == 1
    assert book["Items"]["B8"].value.startswith("=IFERROR(_xlfn.NUMBERVALUE(_xlfn.WEBSERVICE(Gateway&")


@pytest.mark.parametrize(("column", "letters"), [(1, "A"), (26, "Z"), (27, "AA"), (702, "ZZ"), (703, "AAA")])
def test_columns_have_letters(column: int, letters: str) -> None:
    assert column_letters(column) == letters


# ---------------------------------------------------------------------- collect


def test_collecting_makes_a_workbook_and_goes_on_with_it(tmp_path: Path, gateway: Gateway) -> None:
    where = ("--url", gateway.url, "--every", "50ms", "--for", "200ms")
    code, out, err = done("sheet", "collect", "log.xlsx", "--group", "Fast", "--json", *where, folder=tmp_path)
    assert code == 0, err
    assert json.loads(out) | {"missed": 0} == {"files": ["log.xlsx"], "rows": 4, "items": 6, "missed": 0}
    code, out, err = done("sheet", "collect", "log.xlsx", *where, folder=tmp_path)
    assert (code, out) == (0, "log.xlsx: 4 rows of 6 items\n"), err
    collected = rows(tmp_path / "log.xlsx")
    assert len(collected) == 8
    assert [row[0] for row in collected] == sorted({row[0] for row in collected})
    assert {row[6] for row in rows(tmp_path / "log.xlsx", "Qualities")} == {16}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["log.xlsx"]


def test_ctrl_c_saves(tmp_path: Path, gateway: Gateway) -> None:
    with pcaccess("sheet", "collect", "log.xlsx", "--every", "50ms", "--url", gateway.url, folder=tmp_path) as process:
        assert process.stderr is not None
        assert process.stderr.readline().startswith("began: 6 items")
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    assert f"{len(rows(tmp_path / 'log.xlsx'))} row" in out


def test_a_killed_collector_leaves_its_rows_and_merge_brings_them_in(tmp_path: Path, gateway: Gateway) -> None:
    journal = tmp_path / "log.xlsx.journal"
    with pcaccess("sheet", "collect", "log.xlsx", "--every", "20ms", "--url", gateway.url, folder=tmp_path) as process:
        while not journal.exists() or journal.read_bytes().count(b"\n") < 6:
            assert process.poll() is None
        process.kill()
        process.communicate(timeout=PATIENCE)
    kept = sum(line.endswith(b"]]]\n") for line in journal.read_bytes().splitlines(keepends=True))
    code, out, err = done("sheet", "merge", "log.xlsx", folder=tmp_path)
    assert (code, out) == (0, f"log.xlsx: {kept} rows\n"), err
    assert len(rows(tmp_path / "log.xlsx")) == kept
    assert not journal.exists()
    code, _, err = done("sheet", "merge", "log.xlsx", folder=tmp_path)
    assert (code, err) == (1, "pcaccess: there is no log.xlsx.journal: nothing waits for log.xlsx\n")


def test_a_gateway_that_goes_and_comes_back_does_not_end_it(tmp_path: Path, gateway: Gateway) -> None:
    arguments = ("sheet", "collect", "log.xlsx", "--every", "100ms", "--url", gateway.url)
    with pcaccess(*arguments, folder=tmp_path) as process:
        assert process.stderr is not None
        assert "began" in process.stderr.readline()
        gateway.stop()
        assert "rows have quality 24 (COMM_FAILURE) meanwhile" in process.stderr.readline()
        gateway.start()
        assert "the gateway answers again after" in process.stderr.readline()
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=PATIENCE)
    codes = [row[1] for row in rows(tmp_path / "log.xlsx", "Qualities")]
    assert codes[0] == codes[-1] == 192
    assert 24 in codes
    assert rows(tmp_path / "log.xlsx", "Runs")[0][1].startswith("began: ")


def test_two_cannot_collect_into_one_workbook(tmp_path: Path, gateway: Gateway) -> None:
    with pcaccess("sheet", "collect", "log.xlsx", "--url", gateway.url, folder=tmp_path) as process:
        assert process.stderr is not None
        assert "began" in process.stderr.readline()
        code, _, err = done("sheet", "collect", "log.xlsx", "--url", gateway.url, folder=tmp_path)
        assert (code, "another pcaccess is collecting into log.xlsx" in err) == (1, True)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=PATIENCE)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--items", "MicroWin.Mixer.Nix"), "there is no item MicroWin.Mixer.Nix; did you mean MicroWin.Mixer."),
        (("--items", "Nix*"), "no item fits Nix*"),
        (("--group", "Slow"), "there is no group Slow"),
    ],
)
def test_unknown_items_are_told_before_anything_is_made(
    tmp_path: Path, gateway: Gateway, arguments: tuple[str, ...], said: str
) -> None:
    code, _, err = done("sheet", "collect", "log.xlsx", "--url", gateway.url, *arguments, folder=tmp_path)
    assert (code, said in err) == (1, True), err
    assert list(tmp_path.iterdir()) == []


def test_without_a_gateway_it_says_what_to_start(tmp_path: Path, gateway: Gateway) -> None:
    code, _, err = done("sheet", "collect", "log.xlsx", "--url", "http://127.0.0.1:1", folder=tmp_path)
    assert (code, "is `pcaccess run` running there?" in err) == (1, True)
    code, _, err = done("sheet", "collect", "log.xlsx", "--url", "opc.tcp://127.0.0.1:4840", folder=tmp_path)
    assert (code, "is the OPC UA endpoint; spreadsheets use the web server" in err) == (1, True)
    assert list(tmp_path.iterdir()) == []


def test_the_project_file_says_where_the_gateway_is(tmp_path: Path) -> None:
    (tmp_path / "items.yaml").write_text("server: {web: off}\nlinks: []\n")
    code, _, err = done("sheet", "collect", "log.xlsx", folder=tmp_path)
    assert (code, "server: web: off" in err) == (1, True)
    (tmp_path / "items.yaml").write_text("server: {web: '127.0.0.1:1'}\nlinks: []\n")
    code, _, err = done("sheet", "collect", "log.xlsx", folder=tmp_path)
    assert (code, "http://127.0.0.1:1 does not answer" in err) == (1, True)
