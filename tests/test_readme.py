"""The session in README.md is what a user sees: its commands are run against the sample project, outputs compared.

A ``console`` block is what a shell shows: ``$ command`` is run, the lines below it are its output. ``watch`` goes on
while the next blocks are done; a block that does not begin with a command is what it shows next, and ``^C`` ends it.
Times differ and are compared as a pattern only.
"""

from __future__ import annotations

import os
import re
import shlex
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest

ROOT: Final = Path(__file__).parent.parent
README: Final = (ROOT / "README.md").read_text(encoding="utf-8")
PATIENCE: Final = 100.0
"""Seconds after which a command is taken to hang; only a failing test waits so long."""
INTERRUPT: Final = "^C"
SAMPLE_ENDPOINT: Final = "opc.tcp://127.0.0.1:4840/pcaccess"

_STAMP: Final = re.compile(r"(\d{4}-\d\d-\d\d[T ])?\d\d:\d\d:\d\d[.:]\d{3,6}(Z|[+-]\d\d:\d\d)?")


def blocks(text: str) -> list[list[str]]:
    """The lines of each console block."""
    found = re.findall(r"^```console\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [block.splitlines() for block in found]


def comparable(line: str) -> str:
    """Times become a word, trailing blanks go."""
    return _STAMP.sub("<time>", line).rstrip()


def argv(command: str) -> list[str]:
    program, *arguments = shlex.split(command)
    assert program == "pcaccess", f"the session may only use pcaccess, not {program}"
    return [sys.executable, "-m", "pcaccess", *arguments]


class Running:
    """A command that runs in ``folder``, and its output line by line."""

    def __init__(self, command: str, folder: Path) -> None:
        self._said = command
        self._process = subprocess.Popen(
            argv(command),
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1", "NO_COLOR": "1"},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
        )
        self._watchdog = threading.Timer(PATIENCE, self._process.kill)
        self._watchdog.start()

    def __str__(self) -> str:
        return self._said

    def next_line(self) -> list[str]:
        """One line as soon as it is there; none when the command has ended."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        return [line.rstrip("\n")] if line else []

    def interrupt(self) -> None:
        self._process.send_signal(signal.SIGINT)

    def rest(self) -> tuple[list[str], int]:
        """The lines until the command ends, and its exit code."""
        output, _ = self._process.communicate()
        self._watchdog.cancel()
        return output.splitlines(), self._process.returncode


@pytest.fixture
def plant(tmp_path: Path) -> Iterator[Path]:
    """A folder with what the session uses of the clone; its sample project is served, on a free port."""
    for name in ("examples", "tests"):
        (tmp_path / name).symlink_to(ROOT / name)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    project = (ROOT / "items.yaml").read_text(encoding="utf-8")
    assert SAMPLE_ENDPOINT in project
    endpoint = SAMPLE_ENDPOINT.replace("4840", str(port))
    (tmp_path / "items.yaml").write_text(project.replace(SAMPLE_ENDPOINT, endpoint), encoding="utf-8")
    server = Running("pcaccess run", tmp_path)
    said: list[str] = []
    while not (said and endpoint in said[-1]):
        line = server.next_line()
        assert line, f"pcaccess run ended: {said}"
        said += line
    yield tmp_path
    server.interrupt()
    assert server.rest()[1] == 0


class Shells:
    """Commands of a session: one at a time, and beside it the one that watches."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._command: Running | None = None
        self._watch: Running | None = None

    def do(self, block: list[str]) -> list[str]:
        """What really appears where the block shows something."""
        shown = []
        self._command = self._watch
        for line in block:
            if line.startswith("$ "):
                shown += [*self._finish(), line]
                self._start(line.removeprefix("$ "))
            elif line == INTERRUPT and self._command is not None:
                self._command.interrupt()
                shown.append(line)
                self._watch = None
            elif self._command is not None:
                shown += self._command.next_line()
        return [*shown, *self._finish()]

    def _start(self, command: str) -> None:
        self._command = Running(command, self._folder)
        if shlex.split(command)[1] == "watch":
            assert self._watch is None
            self._watch = self._command

    def _finish(self) -> list[str]:
        """What the command still prints, unless it is the one that goes on."""
        if self._command is None or self._command is self._watch:
            return []
        rest, code = self._command.rest()
        assert code == 0, f"{self._command}: exit code {code}, {rest}"
        return rest

    def close(self) -> None:
        assert self._watch is None, "the session leaves a watch running: ^C is missing"


def test_the_session_shows_what_the_commands_print(plant: Path) -> None:
    shells = Shells(plant)
    for block in blocks(README):
        shown = shells.do(block)
        assert [comparable(line) for line in shown] == [comparable(line) for line in block]
    shells.close()


def test_the_session_reads_writes_browses_and_watches() -> None:
    commands = {line.split()[2] for block in blocks(README) for line in block if line.startswith("$ ")}
    assert commands >= {"browse", "read", "write", "watch"}


def test_only_two_commands_stand_before_the_session() -> None:
    before = README.partition("```console")[0]
    assert re.findall(r"^(make \w+)", before, re.MULTILINE) == ["make run", "make test"]


@pytest.mark.parametrize("page", sorted(ROOT.glob("*.md")) + sorted((ROOT / "docs").rglob("*.md")), ids=str)
def test_links_between_our_pages_lead_somewhere(page: Path) -> None:
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    targets = re.findall(r"\]\((?!https?:)([^)#]+)", text)
    assert [target for target in targets if not (page.parent / target).exists()] == []
