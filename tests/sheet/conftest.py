"""A gateway as a process of its own, and LibreOffice without a screen."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, Final
from urllib.request import Request, urlopen

import pytest

ROOT: Final = Path(__file__).parents[2]
EXAMPLE: Final = ROOT / "examples" / "excel_client"
PATIENCE: Final = 120.0
"""Seconds that only a failing test waits."""
PROFILE: Final = """<?xml version="1.0" encoding="UTF-8"?>
<oor:items xmlns:oor="http://openoffice.org/2001/registry">
<item oor:path="/org.openoffice.Office.Common/Security/Scripting">
<prop oor:name="SecureURL" oor:op="fuse"><value><it>{folder}</it></value></prop></item>
<item oor:path="/org.openoffice.Office.Calc/Content/Update">
<prop oor:name="Link" oor:op="fuse"><value>0</value></prop></item>
</oor:items>
"""
"""Macros run, and links are updated, in one trusted folder; as a user sets it under Tools, Options, Security."""


def pcaccess(*arguments: str, folder: Path, **more: Any) -> subprocess.Popen[str]:
    """The command as a process, in a folder."""
    return subprocess.Popen(
        [sys.executable, "-m", "pcaccess", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), "NO_COLOR": "1"},
        text=True,
        encoding="utf-8",
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        **more,
    )


def done(*arguments: str, folder: Path, **more: Any) -> tuple[int, str, str]:
    """Exit code and output of a command that ends by itself."""
    with pcaccess(*arguments, folder=folder) as process:
        out, err = process.communicate(timeout=PATIENCE, **more)
    return process.returncode, out, err


class Gateway:
    """``pcaccess run`` of the example; can be stopped, and started again on the same port."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None
        self.url = "http://127.0.0.1:0"

    def start(self) -> None:
        web = self.url.removeprefix("http://")
        arguments = (
            "run",
            str(EXAMPLE / "items.yaml"),
            "--endpoint",
            "opc.tcp://127.0.0.1:0/x",
            "--web",
            web,
            "--json",
        )
        self._process = pcaccess(*arguments, folder=ROOT)
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line, self._process.communicate()[1]
        self.url = json.loads(line)["web"]

    def stop(self) -> None:
        if self._process is not None:
            self._process.send_signal(signal.SIGTERM)
            self._process.communicate(timeout=PATIENCE)
            self._process = None

    def value(self, item: str) -> str:
        """As the PLC has it."""
        with urlopen(f"{self.url}/api/items/{item}/value", timeout=PATIENCE) as answer:
            text: str = answer.read().decode()
            return text

    def write(self, item: str, text: str) -> None:
        headers = {"Content-Type": "text/plain"}
        with urlopen(Request(f"{self.url}/api/items/{item}/value", text.encode(), headers, method="PUT")):
            pass


@pytest.fixture(scope="module")
def gateway() -> Iterator[Gateway]:
    running = Gateway()
    running.start()
    try:
        yield running
    finally:
        running.stop()


def python_with_uno() -> str | None:
    """LibreOffice's bindings belong to the Python of the system."""
    for python in ("/usr/bin/python3", sys.executable):
        known = subprocess.run([python, "-c", "import uno"], capture_output=True, check=False)
        if known.returncode == 0:
            return python
    return None


class Office:
    """LibreOffice in a process group and with a profile of its own; ``trusted`` is the folder for workbooks."""

    def __init__(self, soffice: str, python: str, folder: Path) -> None:
        self.trusted = folder / "trusted"
        self.trusted.mkdir()
        profile = folder / "profile"
        (profile / "user").mkdir(parents=True)
        settings = PROFILE.format(folder=self.trusted.as_uri())
        (profile / "user" / "registrymodifications.xcu").write_text(settings, encoding="utf-8")
        pipe = f"pcaccess{uuid.uuid4().hex}"
        quiet = ("--headless", "--norestore", "--nologo", "--nofirststartwizard")
        place = (f"-env:UserInstallation={profile.as_uri()}", f"--accept=pipe,name={pipe};urp;")
        self._office = subprocess.Popen(
            [soffice, *quiet, *place], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
        )
        self._driver = subprocess.Popen(
            [python, str(Path(__file__).with_name("office_driver.py")), pipe],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._answer() == "ready"

    def __call__(self, command: str, *arguments: Any) -> Any:
        """See office_driver.py."""
        stdin: IO[str] | None = self._driver.stdin
        assert stdin is not None
        stdin.write(json.dumps([command, *arguments]) + "\n")
        stdin.flush()
        answer = self._answer()
        if isinstance(answer, dict) and "error" in answer:
            raise AssertionError(f"{command} {arguments}: {answer['error']}")
        return answer

    def _answer(self) -> Any:
        assert self._driver.stdout is not None
        watchdog = threading.Timer(2 * PATIENCE, self._driver.kill)
        watchdog.start()
        line = self._driver.stdout.readline()
        watchdog.cancel()
        assert line, "the driver of LibreOffice ended"
        return json.loads(line)

    def end(self) -> None:
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._driver.communicate(timeout=20)  # the end of its input ends the office
        self._driver.kill()
        try:
            self._office.wait(10)
        except subprocess.TimeoutExpired:
            os.killpg(self._office.pid, signal.SIGKILL)
            self._office.wait()


@pytest.fixture(scope="module")
def office(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Office]:
    soffice, python = shutil.which("soffice"), python_with_uno()
    if soffice is None or python is None:
        pytest.fail("LibreOffice Calc or its Python bindings are missing: see tools/apt-packages.txt")
    running = Office(soffice, python, tmp_path_factory.mktemp("office"))
    try:
        yield running
    finally:
        running.end()
