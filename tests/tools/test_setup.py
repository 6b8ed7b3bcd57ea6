"""tools/setup.sh in an empty clone, with stand-ins for python3, apt-get and their like: nothing is installed."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

SETUP = Path(__file__).parents[2] / "tools" / "setup.sh"
REAL = ("sh", "cat", "cksum", "dirname", "env", "rm", "sed", "mkdir", "cp", "chmod", "true")

# Answers every question about itself with yes; "-m venv" makes a copy of itself.
PYTHON = """#!/bin/sh
case "$*" in
    "-m venv .venv") mkdir -p .venv/bin; cp "$0" .venv/bin/python ;;
    *"-m pip install"*) echo "pip $*" >>log; exit "${PIP_EXIT:-0}" ;;
esac
"""


@dataclass
class Clone:
    """A clone that holds only what setup.sh reads, and a PATH that holds only stand-ins."""

    root: Path

    def command(self, name: str, script: str) -> None:
        path = self.root / "bin" / name
        path.write_text(script if script.startswith("#!") else f"#!/bin/sh\n{script}\n")
        path.chmod(0o755)

    def setup(self, need: str, **environment: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [self.root / "tools" / "setup.sh", need],
            env={"PATH": str(self.root / "bin"), **environment},
            capture_output=True,
            text=True,
            check=False,
        )

    def log(self) -> list[str]:
        """What was really asked for since the last call."""
        path = self.root / "log"
        lines = path.read_text().splitlines() if path.exists() else []
        path.unlink(missing_ok=True)
        return lines


@pytest.fixture
def clone(tmp_path: Path) -> Clone:
    for folder in ("bin", "tools"):
        (tmp_path / folder).mkdir()
    shutil.copy(SETUP, tmp_path / "tools" / "setup.sh")
    for name in ("pyproject.toml", "constraints.txt"):
        (tmp_path / name).write_text("first")
    (tmp_path / "tools" / "apt-packages.txt").write_text("# why\nbrowser\nnodejs node  # for a peer\n")
    for name in REAL:
        found = shutil.which(name)
        assert found is not None
        os.symlink(found, tmp_path / "bin" / name)
    clone = Clone(tmp_path)
    clone.command("python3", PYTHON)
    clone.command("dpkg-query", "exit 1")
    clone.command("apt-get", 'echo "apt-get $*" >>log')
    clone.command("sudo", "exit 1")
    clone.command("id", "echo 1000")
    return clone


def test_run_installs_the_product_and_asks_for_no_system_package(clone: Clone) -> None:
    assert clone.setup("run").returncode == 0
    (installed,) = clone.log()
    assert installed.startswith("pip -m pip install ")
    assert installed.endswith(" -c constraints.txt -e .")


def test_a_second_call_does_nothing(clone: Clone) -> None:
    clone.setup("run")
    clone.log()
    assert clone.setup("run").returncode == 0
    assert clone.log() == []


@pytest.mark.parametrize("name", ["pyproject.toml", "constraints.txt"])
def test_a_changed_requirement_installs_again(clone: Clone, name: str) -> None:
    clone.setup("run")
    clone.log()
    (clone.root / name).write_text("second")
    clone.setup("run")
    assert len(clone.log()) == 1


def test_an_installation_that_failed_is_tried_again(clone: Clone) -> None:
    assert clone.setup("run", PIP_EXIT="1").returncode != 0
    clone.log()
    clone.setup("run")
    assert len(clone.log()) == 1


def test_an_environment_for_tests_serves_a_run_too(clone: Clone) -> None:
    clone.command("id", "echo 0")
    clone.setup("test")
    assert clone.log()[-1].endswith("-e .[test]")
    clone.setup("run")
    assert clone.log() == []


def test_root_installs_missing_packages_only(clone: Clone) -> None:
    clone.command("id", "echo 0")
    clone.command("node", "")
    assert clone.setup("test").returncode == 0
    assert clone.log()[:2] == ["apt-get update -qq", "apt-get install -y -qq --no-install-recommends browser"]


def test_sudo_without_a_password_installs_them(clone: Clone) -> None:
    clone.command("sudo", 'shift; echo "sudo" >>log; exec "$@"')
    assert clone.setup("test").returncode == 0
    assert "apt-get install -y -qq --no-install-recommends browser nodejs" in clone.log()


def test_without_rights_the_apt_line_is_printed(clone: Clone) -> None:
    done = clone.setup("test")
    assert done.returncode == 1
    assert "sudo apt-get install -y --no-install-recommends browser nodejs\n" in done.stderr
    assert clone.log() == []


def test_installed_packages_are_left_alone(clone: Clone) -> None:
    clone.command("dpkg-query", "echo install ok installed")
    assert clone.setup("test").returncode == 0
    assert [line for line in clone.log() if line.startswith("apt-get")] == []


def test_a_python_without_venv_is_told_which_package_brings_it(clone: Clone) -> None:
    clone.command("python3", 'case "$*" in *ensurepip*) exit 1 ;; esac')
    done = clone.setup("run")
    assert done.returncode == 1
    assert "sudo apt-get install -y python3-venv" in done.stderr


def test_an_old_python_is_refused(clone: Clone) -> None:
    clone.command("python3", 'case "$*" in --version) echo Python 3.9.2 ;; *version_info*) exit 1 ;; esac')
    done = clone.setup("run")
    assert done.returncode == 1
    assert "Python 3.9.2 is too old" in done.stderr
