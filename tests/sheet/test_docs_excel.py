"""The commands of docs/excel.md and of the example's README do what is shown; everything they point to is there."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path

import pytest

from pcaccess.sheet.collect.workbook import TREND as COLLECTED
from pcaccess.sheet.ods.sheets import LOG_ROWS, TREND
from tests.sheet.conftest import EXAMPLE, ROOT, Gateway, done

PAGES = [ROOT / "docs" / "excel.md", EXAMPLE / "README.md"]


def sessions(page: Path) -> list[tuple[str, list[str]]]:
    """Commands and what they print."""
    found = []
    for block in re.findall(r"^ *```console\n(.*?)^ *```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL):
        command, *shown = [line.strip(" ") for line in block.splitlines()]
        found.append((command.removeprefix("$ "), shown))
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_commands_print_what_is_shown(
    page: Path, gateway: Gateway, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PCACCESS_WEB", gateway.url)
    folder = tmp_path
    os.symlink(ROOT / "examples", folder / "examples")
    (folder / "items.yaml").symlink_to(EXAMPLE / "items.yaml")
    ran = 0
    for command, shown in sessions(page):
        program, *arguments = shlex.split(command)
        assert program == "pcaccess"
        if arguments[0] == "run":
            assert not arguments[1:] or (ROOT / arguments[1]).exists()
            continue
        code, out, err = done(*arguments, folder=folder)
        assert code == 0, err
        assert [line.rstrip() for line in out.replace(gateway.url, "http://127.0.0.1:8080").splitlines()] == shown
        ran += 1
    assert ran >= 2


def test_the_numbers_are_those_of_the_program() -> None:
    page = PAGES[0].read_text(encoding="utf-8")
    assert f"ends at {LOG_ROWS:,} rows" in page
    assert f"shows the last {TREND}" in page
    assert f"the last\n{COLLECTED} rows" in page


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pictures_and_links_are_there(page: Path) -> None:
    targets = re.findall(r"\]\((?!https?:)([^)#]+)", page.read_text(encoding="utf-8"))
    assert targets
    assert [target for target in targets if not (page.parent / target).exists()] == []
