"""The top of the repository: metadata, constraints and the make targets agree with each other."""

from __future__ import annotations

import re
import subprocess
import tomllib
from importlib.metadata import distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import pcaccess

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
PINS = {
    canonicalize_name(line.partition("==")[0]): line.partition("==")[2]
    for line in (ROOT / "constraints.txt").read_text().splitlines()
    if not line.startswith("#")
}
REQUIREMENTS = [
    Requirement(text)
    for text in [*PROJECT["dependencies"], *(r for extra in PROJECT["optional-dependencies"].values() for r in extra)]
]


def test_constraints_hold_names_and_versions_only() -> None:
    lines = [line for line in (ROOT / "constraints.txt").read_text().splitlines() if not line.startswith("#")]
    assert [line for line in lines if not re.fullmatch(r"[A-Za-z0-9._-]+==[0-9][0-9a-z.]*", line)] == []


@pytest.mark.parametrize("requirement", REQUIREMENTS, ids=str)
def test_every_dependency_is_pinned_inside_its_range(requirement: Requirement) -> None:
    assert requirement.specifier.contains(PINS[canonicalize_name(requirement.name)])


def test_what_dependencies_need_themselves_is_pinned_too() -> None:
    def needs(name: str) -> set[str]:
        texts = distribution(name).requires or []
        requirements = [Requirement(text) for text in texts]
        return {canonicalize_name(r.name) for r in requirements if not r.marker or r.marker.evaluate({"extra": ""})}

    seen: set[str] = set()
    todo = {canonicalize_name(r.name) for r in REQUIREMENTS if not r.marker or r.marker.evaluate()}
    while todo:
        seen |= todo
        todo = {inner for name in todo for inner in needs(name)} - seen
    assert seen - PINS.keys() == set()


def test_no_file_names_a_package_index_or_somebody_s_folder() -> None:
    tracked = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    private = re.compile(rb"index[-_]url|(?<![\w.~/-])/(root|home|work)/")
    paths = [ROOT / name for name in tracked.split("\0") if name]
    assert [path for path in paths if path.is_file() and private.search(path.read_bytes())] == []


def test_every_make_target_is_in_the_help() -> None:
    targets = re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    shown = subprocess.run(["make", "-s", "help"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert re.findall(r"^  make ([a-z]+) ", shown, re.MULTILINE) == targets


def test_the_changelog_begins_with_what_is_unreleased_or_this_version() -> None:
    first = re.search(r"^## \[(.+?)\]", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert first is not None
    assert first[1] in ("Unreleased", pcaccess.__version__)
