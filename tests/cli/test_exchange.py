"""import and export: projects of other tools, taken over and handed back."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pcaccess.project.load import load_project, load_text
from tests.cli.conftest import PLANT, invoke

SAMPLE = Path(__file__).parents[1] / "data" / "pca" / "sample.pca"
SYMBOLS = "Motor\tQ0.0\tContactor\nTemp\tVW10\t\nNothing\tnowhere\t\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the commands run; it holds ``items.yaml`` and a symbol table."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "items.yaml").write_text(PLANT)
    (tmp_path / "USER1.txt").write_text(SYMBOLS)
    return tmp_path


def test_a_pc_access_project_becomes_a_project_that_passes_check(folder: Path) -> None:
    outcome = invoke("import", str(SAMPLE), "-o", "new.yaml")
    assert outcome.code == 0
    assert outcome.lines[-1].startswith("new.yaml: ")
    assert invoke("check", "new.yaml").code == 0


def test_without_a_file_the_project_is_printed(folder: Path) -> None:
    outcome = invoke("import", str(SAMPLE))
    assert outcome.code == 0
    assert list(load_text(outcome.out).project.all_items())


def test_a_symbol_table_goes_where_it_is_told_and_says_what_is_left_out(folder: Path) -> None:
    outcome = invoke("import", "USER1.txt", "-o", "new.yaml", "--plc", "Press", "--link", "Line")
    ids = [item.item_id for item in load_project(folder / "new.yaml").project.all_items()]
    assert (outcome.code, ids) == (0, ["Line.Press.USER1.Motor", "Line.Press.USER1.Temp"])
    assert outcome.out == "new.yaml: 1 PLC, 1 folder, 2 items; 1 item left out\n"
    assert "USER1.txt:3:" in outcome.err


def test_programs_are_told_what_was_written(folder: Path) -> None:
    told = json.loads(invoke("import", "USER1.txt", "-o", "new.yaml", "--folder", "", "--json").out)
    assert told == {"file": "new.yaml", "kind": "symbols", "plcs": 1, "folders": 0, "items": 2, "left_out": 1}


def test_an_existing_project_is_not_replaced_without_leave(folder: Path) -> None:
    outcome = invoke("import", "USER1.txt", "-o", "items.yaml")
    assert (outcome.code, outcome.err) == (
        1,
        "pcaccess: items.yaml exists; name another file, or replace it with --force\n",
    )
    assert (folder / "items.yaml").read_text() == PLANT
    assert invoke("import", "USER1.txt", "-o", "items.yaml", "--force").code == 0
    assert (folder / "items.yaml").read_text() != PLANT


@pytest.mark.parametrize("content", [b"", b"\x00\x01\x02\x03", b"%PDF-1.4", b"no symbols here\n"])
def test_garbage_leaves_nothing_written(folder: Path, content: bytes) -> None:
    (folder / "garbage.txt").write_bytes(content)
    outcome = invoke("import", "garbage.txt", "-o", "new.yaml")
    assert (outcome.code, outcome.out) == (1, "")
    assert outcome.err.startswith("garbage.txt:1:1: PRJ001 ")
    assert not (folder / "new.yaml").exists()


def test_a_missing_source_is_told(folder: Path) -> None:
    outcome = invoke("import", "missing.pca")
    assert (outcome.code, outcome.err) == (1, "missing.pca:1:1: PRJ001 there is no such file\n")


@pytest.mark.parametrize("arguments", [("--kind", "xls"), ("--encoding", "klingon"), ("--json",)])
def test_import_used_wrongly_is_usage(folder: Path, arguments: tuple[str, ...]) -> None:
    assert invoke("import", "USER1.txt", *arguments).code == 2


def test_an_exported_table_is_imported_again(folder: Path) -> None:
    exported = invoke("export", "--plc", "microwin.newplc", "-o", "tags.csv", "--ours")
    assert (exported.code, exported.out) == (0, "tags.csv: 9 items\n")
    assert invoke("import", "tags.csv", "-o", "new.yaml").code == 0
    before = [item.run_time_name for item in load_text(PLANT).project.all_plcs().__next__().all_items()]
    after = [item.run_time_name for item in load_project(folder / "new.yaml").project.all_items()]
    assert sorted(after) == sorted(before)


def test_limits_that_kepware_does_not_have_are_mentioned(folder: Path) -> None:
    outcome = invoke("export", "--plc", "MicroWin.NewPLC")
    assert outcome.lines[0].startswith("Tag Name,Address,Data Type,")
    assert outcome.err == "MicroWin.NewPLC: the limits of 2 items are not in it; see --ours\n"


def test_a_folder_takes_a_table_for_each_plc(folder: Path) -> None:
    (folder / "tags").mkdir()
    assert invoke("export", "-o", "tags").code == 0
    assert sorted(path.name for path in (folder / "tags").iterdir()) == [
        "MicroWin.Away.csv",
        "MicroWin.Dead.csv",
        "MicroWin.NewPLC.csv",
    ]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "there are several PLCs; name one with --plc, or a folder with -o: MicroWin.NewPLC, "),
        (("--plc", "Nowhere"), "there is no PLC Nowhere; the project has MicroWin.NewPLC, "),
        (("--plc", "MicroWin.Away", "-o", "no/such/folder.csv"), "cannot be written: there is no folder no/such"),
    ],
)
def test_an_export_that_is_not_possible_says_why(folder: Path, arguments: tuple[str, ...], words: str) -> None:
    outcome = invoke("export", *arguments)
    assert (outcome.code, outcome.out) == (1, "")
    assert words in outcome.err


def test_a_warning_about_the_new_project_shows_the_new_project(folder: Path) -> None:
    (folder / "USER1.txt").write_text("Pulse\tSM0.5\t\n")
    outcome = invoke("import", "USER1.txt", "-o", "new.yaml")
    assert "new.yaml:16:40: warning PRJ034" in outcome.err
    assert "address: SM0.5" in outcome.err
    assert "items.yaml" not in outcome.err


@pytest.mark.parametrize(
    ("data", "shown"),
    [
        ("Temp\tVW10\t\nNothing\tnowhere\t\n".encode("utf-16"), "     2 | Nothing nowhere"),
        (b"\x00\x01\x00\x00Standard Jet DB\x00\x1b", None),
    ],
)
def test_the_line_of_a_source_is_shown_where_it_is_text(folder: Path, data: bytes, shown: str | None) -> None:
    (folder / "USER1.txt").write_bytes(data)
    outcome = invoke("import", "USER1.txt")
    assert (shown in outcome.err) if shown else len(outcome.err.splitlines()) == 1
