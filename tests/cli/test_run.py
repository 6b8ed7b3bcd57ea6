"""run as a process: what it prints, how it ends, what it says when it cannot begin."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import socket
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path
from urllib.request import urlopen

import pytest

from pcaccess.cli.serving import Addresses, serve
from pcaccess.clock import SystemClock
from pcaccess.gateway.programs import load_programs
from pcaccess.project.load import load_project
from tests.cli.conftest import invoke

ROOT = Path(__file__).parents[2]
PLANT = """
project: Small plant
links:
  - name: MicroWin
    type: soft
    plcs:
      - {name: NewPLC, cpu: CPU 224, items: [{name: Motor, address: Q0.0, type: BOOL, access: RW}]}
      - {name: Oven, cpu: CPU 222, items: [{name: T, address: VW0, high: 9, low: 1}, {name: P, address: VD4}]}
"""
PATIENCE = 60.0
"""Seconds that only a failing test waits."""
ANY_PORT = ("--endpoint", "opc.tcp://127.0.0.1:0/test", "--web", "off")


class Process:
    """``pcaccess`` with its output line by line; killed when it hangs."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "pcaccess", *arguments],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._watchdog = threading.Timer(PATIENCE, self._process.kill)
        self._watchdog.start()

    def line(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline()

    def send(self, number: int) -> None:
        self._process.send_signal(number)

    def end(self) -> tuple[int, str, str]:
        """Exit code, and what was printed since."""
        try:
            out, err = self._process.communicate()
        finally:
            self._watchdog.cancel()
        return self._process.returncode, out, err


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "items.yaml").write_text(PLANT)
    return tmp_path


def test_one_json_line_says_when_clients_may_come(folder: Path) -> None:
    process = Process(folder, "run", *ANY_PORT, "--json")
    ready = json.loads(process.line())
    url = ready.pop("url")
    assert ready == {
        "web": None,
        "project": "Small plant",
        "links": 1,
        "plcs": 2,
        "items": 3,
        "groups": 0,
        "warnings": 0,
    }
    assert invoke("read", "MicroWin.NewPLC.Motor", "--url", url).code == 0
    process.send(signal.SIGTERM)
    assert process.end() == (0, "", "")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)])
def test_a_signal_stops_it_in_order(folder: Path, number: int) -> None:
    process = Process(folder, "run", *ANY_PORT)
    lines = [process.line() for _ in range(5)]
    process.send(number)
    assert process.end() == (0, "", "")
    assert lines[0].endswith(": Small plant\n")
    assert lines[1].startswith("serving 1 link, 2 PLCs, 3 items at opc.tcp://127.0.0.1:")
    assert lines[2:] == [
        "  MicroWin.NewPLC: soft, CPU 224, 1 item\n",
        "  MicroWin.Oven: soft, CPU 222, 2 items\n",
        "Ctrl-C stops.\n",
    ]


def test_a_web_server_open_to_the_network_needs_the_words_in_the_project_file(folder: Path) -> None:
    process = Process(folder, "run", "--endpoint", ANY_PORT[1], "--web", "0.0.0.0:0")
    code, out, err = process.end()
    assert (code, out) == (1, "")
    assert "say so in the project file: server: web_clients: anyone may read" in err
    assert "Traceback" not in err


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="nohup of POSIX")
def test_it_outlives_its_terminal_under_nohup(folder: Path) -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        process = Process(folder, "run", *ANY_PORT, "--json")
    finally:
        signal.signal(signal.SIGHUP, before)
    url = json.loads(process.line())["url"]
    process.send(signal.SIGHUP)
    assert invoke("read", "MicroWin.NewPLC.Motor", "--url", url).code == 0
    process.send(signal.SIGTERM)
    assert process.end() == (0, "", "")


def test_clients_are_told_when_it_stops(folder: Path) -> None:
    process = Process(folder, "run", *ANY_PORT, "--json")
    url = json.loads(process.line())["url"]
    watching = Process(folder, "watch", "MicroWin.NewPLC.Motor", "--json", "--count", "2", "--url", url)
    assert json.loads(watching.line())["quality"] == 192
    process.send(signal.SIGTERM)
    assert json.loads(watching.line())["quality"] == 24
    assert process.end() == (0, "", "")
    code, _, err = watching.end()
    assert code == 0
    assert err == f"the connection to {url} was lost; trying again\n"


def test_a_port_in_use_says_which_and_what_to_do(folder: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        outcome = Process(folder, "run", "--endpoint", f"opc.tcp://127.0.0.1:{port}/x").end()
    assert outcome == (
        1,
        "",
        f"pcaccess: port {port} on 127.0.0.1 is in use; stop the other program or choose another port under server: "
        "endpoint: in the project file\n",
    )


def test_the_web_server_comes_with_it(folder: Path) -> None:
    process = Process(folder, "run", *ANY_PORT[:2], "--web", "127.0.0.1:0")
    lines = [process.line() for _ in range(3)]
    url = lines[2].removeprefix("and at ").strip()
    with urlopen(f"{url}/api/items/MicroWin.NewPLC.Motor/value", timeout=PATIENCE) as answer:
        assert answer.read() == b"0"
    process.send(signal.SIGTERM)
    code, _, err = process.end()
    assert (code, err) == (0, "")


def test_a_web_port_in_use_is_fatal_only_where_somebody_chose_it(folder: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        message = f"port {port} on 127.0.0.1 is in use; stop the other program, or choose another port"
        code, out, err = Process(folder, "run", *ANY_PORT[:2], "--web", f"127.0.0.1:{port}").end()
        assert (code, out) == (1, "")
        assert err.startswith(f"pcaccess: {message}")
        (folder / "items.yaml").write_text(f"server: {{web: '127.0.0.1:{port}'}}\n{PLANT}")
        code, out, err = Process(folder, "run", *ANY_PORT[:2]).end()
        assert (code, out) == (1, "")
        assert err.startswith(f"pcaccess: {message}")


async def test_without_a_free_usual_port_everything_else_is_served(folder: Path) -> None:
    loaded = load_project(folder / "items.yaml")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        place = f"127.0.0.1:{taken.getsockname()[1]}"
        usual = replace(loaded.project.server, web=place)
        assert not usual.web_is_wished
        stop = asyncio.Event()
        places: list[Addresses] = []

        def ready(addresses: Addresses) -> None:
            places.append(addresses)
            stop.set()

        moved = replace(loaded, project=replace(loaded.project, server=usual))
        programs = load_programs(loaded.project)
        await serve(moved, programs, folder / "items.yaml", SystemClock(), stop, ready, "opc.tcp://127.0.0.1:0/x")
    assert places[0].web is None
    assert "is in use" in places[0].why_no_web


def test_an_endpoint_open_to_the_network_is_refused(folder: Path) -> None:
    code, out, err = Process(folder, "run", "--endpoint", "opc.tcp://0.0.0.0:0/x").end()
    assert (code, out) == (1, "")
    assert "only this machine may connect" in err
    assert "Traceback" not in err


def test_a_wrong_project_shows_every_mistake_and_does_not_begin(folder: Path) -> None:
    (folder / "items.yaml").write_text(PLANT.replace("Q0.0", "VX").replace("CPU 222", "CPU 225"))
    code, out, err = Process(folder, "run", *ANY_PORT).end()
    assert (code, out) == (1, "")
    places = [line.partition(" ")[0] for line in err.splitlines() if line.startswith("items.yaml:")]
    assert places == ["items.yaml:7:69:", "items.yaml:8:27:"]
    assert "^" in err
    assert "Traceback" not in err


def test_warnings_are_shown_and_it_runs(folder: Path) -> None:
    (folder / "items.yaml").write_text(PLANT.replace("high: 9, low: 1", "high: 1, low: 9"))
    process = Process(folder, "run", *ANY_PORT, "--json")
    assert json.loads(process.line())["warnings"] == 1
    process.send(signal.SIGTERM)
    code, _, err = process.end()
    assert code == 0
    assert "PRJ021" in err


def test_a_saved_file_is_applied_while_it_runs_and_told(folder: Path) -> None:
    process = Process(folder, "run", *ANY_PORT, "--json")
    url = json.loads(process.line())["url"]
    watching = Process(folder, "watch", "MicroWin.NewPLC.Motor", "--json", "--url", url)
    watching.line()
    (folder / "items.yaml").write_text(
        PLANT.replace("items: [{name: Motor,", "items: [{name: Extra, address: VW10}, {name: Motor,")
    )
    while invoke("read", "MicroWin.NewPLC.Extra", "--url", url).code:
        pass
    watching.send(signal.SIGINT)
    assert watching.end() == (0, "", "")
    process.send(signal.SIGTERM)
    code, _, err = process.end()
    assert code == 0
    assert "items.yaml applied: 1 item added" in err
