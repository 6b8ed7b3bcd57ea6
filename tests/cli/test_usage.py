"""Exit codes and messages of the command when it is used wrongly, or there is nothing to use it on."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import pcaccess
from tests.cli.conftest import invoke

ROOT = Path(__file__).parents[2]


def test_the_version_is_told() -> None:
    assert invoke("--version").out == f"pcaccess {pcaccess.__version__}\n"


def test_without_a_command_there_is_help() -> None:
    outcome = invoke()
    assert outcome.code == 2
    assert "Usage" in outcome.out + outcome.err


@pytest.mark.parametrize("command", ["run", "check", "schema", "browse", "read", "write", "watch"])
def test_every_command_has_help(command: str) -> None:
    outcome = invoke(command, "--help")
    assert (outcome.code, outcome.err) == (0, "")
    assert f"pcaccess {command}" in outcome.out.replace("root", "pcaccess")


@pytest.mark.parametrize(
    "arguments",
    [
        ("nonsense",),
        ("read",),
        ("check", "--nonsense"),
        ("watch", "--interval", "100"),
        ("watch", "--for", "0s"),
        ("watch", "--count", "0"),
        ("browse", "--depth", "0"),
        ("run", "--endpoint", "localhost:4840"),
        ("run", "--log-level", "loud"),
        ("run", "--web", "8080"),
        ("plc", "check", "a.awl", "--encoding", "base64"),
        ("plc", "check", "a.awl", "--encoding", "nonsense"),
        ("write",),
        ("write", "A.B.C"),
        ("write", "A.B.C", "1", "D.E.F"),
        ("write", "A.B.C", "--jsn"),
    ],
)
def test_wrong_usage_is_exit_code_2(arguments: tuple[str, ...]) -> None:
    outcome = invoke(*arguments)
    assert (outcome.code, outcome.out) == (2, "")
    assert "Usage" in outcome.err


def test_without_a_server_the_message_says_what_to_do(unused_port: int) -> None:
    outcome = invoke("read", "A.B.C", "--url", f"opc.tcp://127.0.0.1:{unused_port}/x")
    assert (outcome.code, outcome.out) == (1, "")
    assert outcome.err.startswith(f"pcaccess: no server at opc.tcp://127.0.0.1:{unused_port}/x (Connection refused); ")
    assert "start one with: pcaccess run" in outcome.err


@pytest.mark.parametrize("url", ["127.0.0.1:4840", "http://127.0.0.1:4840", "opc.tcp://127.0.0.1"])
def test_what_is_no_endpoint_is_usage(url: str) -> None:
    outcome = invoke("read", "A.B.C", "--url", url)
    assert outcome.code == 2
    assert "opc.tcp://HOST:PORT/PATH" in " ".join(outcome.err.split())


def test_help_imports_nothing_that_takes_long() -> None:
    code = "import sys, pcaccess.cli.main; print([m for m in ('asyncua', 'numpy', 'pydantic') if m in sys.modules])"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout == "[]\n"


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_while_modules_load_ends_without_a_word(tmp_path: Path) -> None:
    """A module that interrupts its own loading stands for a person who is quick."""
    (tmp_path / "typer.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n")
    env = {**os.environ, "PYTHONPATH": os.pathsep.join((str(tmp_path), str(ROOT)))}
    ended = subprocess.run(
        [sys.executable, "-m", "pcaccess", "--help"], env=env, capture_output=True, text=True, check=False
    )
    assert (ended.returncode, ended.stdout, ended.stderr) == (-signal.SIGINT, "", "")
