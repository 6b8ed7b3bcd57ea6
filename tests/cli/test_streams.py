"""Standard output that is closed, full, or has lost its reader."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.cli.conftest import invoke

pytestmark = pytest.mark.skipif(os.name == "nt", reason="pipes and devices of POSIX")

ROOT = Path(__file__).parents[2]
PATIENCE = 60.0
"""Seconds that only a failing test waits."""
PROJECT = "links: [{name: L, type: soft, plcs: [{name: P, items: [{name: A, address: VW0}]}]}]\n"
PROGRAM = "Network 1\nLD SM0.5\n= Q0.0\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "items.yaml").write_text(PROJECT)
    (tmp_path / "blink.awl").write_text(PROGRAM)
    return tmp_path


@pytest.fixture
def no_reader() -> Iterator[int]:
    """The writing end of a pipe that nobody reads."""
    reading, writing = os.pipe()
    os.close(reading)
    yield writing
    os.close(writing)


def start(folder: Path, *arguments: str, **streams: Any) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "pcaccess", *arguments]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **streams}
    return subprocess.Popen(command, cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True, **streams)


def ended(process: subprocess.Popen[str]) -> tuple[int, str | None]:
    """Exit code and standard error."""
    try:
        _, err = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    return process.returncode, err


@pytest.mark.parametrize(
    "arguments",
    [
        ("--version",),
        ("check",),
        ("schema",),
        ("export",),
        ("plc", "list", "blink.awl"),
        ("plc", "run", "blink.awl"),
        ("plc", "run", "blink.awl", "--json"),
    ],
    ids=" ".join,
)
def test_without_a_reader_a_command_ends_without_a_word(
    folder: Path, no_reader: int, arguments: tuple[str, ...]
) -> None:
    assert ended(start(folder, *arguments, stdout=no_reader)) == (141, "")


def test_a_reader_who_has_seen_enough_ends_what_goes_on(folder: Path) -> None:
    process = start(folder, "plc", "run", "blink.awl", "--scan", "free", "--watch", "SMW22", "--json")
    assert process.stdout is not None
    assert process.stdout.readline().startswith('{"at": 0')
    process.stdout.close()
    assert process.stderr is not None
    assert (process.wait(PATIENCE), process.stderr.read()) == (141, "")


@pytest.mark.parametrize("form", ["", "--json"])
def test_a_server_goes_on_without_a_reader(folder: Path, no_reader: int, form: str) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        url = f"opc.tcp://127.0.0.1:{free.getsockname()[1]}/x"
    process = start(folder, "run", "--endpoint", url, "--web", "off", *form.split(), stdout=no_reader)
    while process.poll() is None and invoke("read", "L.P.A", "--url", url).code:
        pass
    assert invoke("read", "L.P.A", "--url", url).code == 0
    process.send_signal(signal.SIGTERM)
    assert ended(process) == (0, "")


@pytest.mark.parametrize("arguments", [("schema",), ("check",), ("plc", "list", "blink.awl")], ids=" ".join)
def test_a_full_disk_is_a_failure_that_is_told(folder: Path, arguments: tuple[str, ...]) -> None:
    with open("/dev/full", "w") as full:
        code, err = ended(start(folder, *arguments, stdout=full))
    assert (code, err) == (1, "pcaccess: standard output cannot be written: No space left on device\n")


def test_a_command_that_has_no_streams_does_its_work(folder: Path) -> None:
    line = f"{sys.executable} -m pcaccess export -o tags.csv >&- 2>&- && {sys.executable} -m pcaccess check a 2>&-"
    shell = subprocess.run(line, shell=True, cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False)
    assert shell.returncode == 1
    assert (folder / "tags.csv").exists()


def test_messages_that_nobody_reads_change_nothing(folder: Path, no_reader: int) -> None:
    assert ended(start(folder, "read", "L.P.A", "--url", "opc.tcp://127.0.0.1:1/x", stderr=no_reader))[0] == 1
