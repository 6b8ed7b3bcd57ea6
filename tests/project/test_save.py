"""A project file is replaced by a whole and valid one or not at all."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from pcaccess.problems import ProblemError
from pcaccess.project.save import replace_file, save_project


def test_a_valid_project_takes_the_place_of_the_old_one_and_keeps_its_mode(tmp_path: Path) -> None:
    path = tmp_path / "items.yaml"
    path.write_text("links: []\n")
    path.chmod(0o640)
    assert save_project(path, "project: new\nlinks: []\n").project.name == "new"
    assert path.read_text() == "project: new\nlinks: []\n"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert list(tmp_path.iterdir()) == [path]


def test_an_invalid_project_leaves_the_old_one(tmp_path: Path) -> None:
    path = tmp_path / "items.yaml"
    path.write_text("links: []\n")
    with pytest.raises(ProblemError):
        save_project(path, "linsk: []\n")
    assert path.read_text() == "links: []\n"
    assert list(tmp_path.iterdir()) == [path]


def test_files_that_the_project_names_are_looked_for_beside_it(tmp_path: Path) -> None:
    text = "links: [{name: L, type: soft, plcs: [{name: P, items_from: tags.csv}]}]\n"
    with pytest.raises(ProblemError, match=r"there is no file tags\.csv"):
        save_project(tmp_path / "items.yaml", text)
    assert list(tmp_path.iterdir()) == []


def test_behind_a_link_the_file_that_is_meant_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "real.yaml").write_text("links: []\n")
    (tmp_path / "items.yaml").symlink_to("real.yaml")
    save_project(tmp_path / "items.yaml", "project: new\nlinks: []\n")
    assert (tmp_path / "items.yaml").is_symlink()
    assert "new" in (tmp_path / "real.yaml").read_text()


def test_what_cannot_be_written_leaves_nothing_behind(tmp_path: Path) -> None:
    (tmp_path / "items.yaml").mkdir()
    with pytest.raises(OSError, match="irectory"):
        replace_file(tmp_path / "items.yaml", "x")
    assert [path.name for path in tmp_path.iterdir()] == ["items.yaml"]
