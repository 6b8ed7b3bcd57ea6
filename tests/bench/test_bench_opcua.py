"""The OPC UA benchmark runs and says what it found; what the figures are is the benchmark's own matter."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
BENCH = ROOT / "bench" / "opcua.py"


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(BENCH), *arguments]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)


@pytest.fixture(scope="module")
def short_run() -> tuple[dict[str, Any], int]:
    """Ours beside stock asyncua, a moment each: what it printed, and its exit code."""
    options = "--json --servers ours,stock --seconds 0.2 --rounds 1 --items 200 --memory-items 0"
    done = run(*options.split())
    assert done.stdout, done.stderr
    return json.loads(done.stdout), done.returncode


def test_every_workload_has_a_figure_for_every_server(short_run: tuple[dict[str, Any], int]) -> None:
    found, _ = short_run
    assert found["missing"] == []
    figures = {**found["rates"], **found["latencies"]}
    assert len(figures) == 10
    assert {row: set(cells) for row, cells in figures.items()} == {row: {"ours", "stock"} for row in figures}
    assert all(value > 0 for cells in figures.values() for value in cells.values())


def test_a_target_holds_when_its_ratio_says_so(short_run: tuple[dict[str, Any], int]) -> None:
    targets = short_run[0]["targets"]
    assert len(targets) == 5  # memory was left out
    for target in targets:
        assert set(target) == {"name", "value", "target", "holds"}
        least = float(target["target"].removeprefix(">= "))
        assert target["holds"] is (target["value"] >= least) or abs(target["value"] - least) < 0.001  # it is rounded


def test_exit_code_is_good_only_when_all_targets_hold(short_run: tuple[dict[str, Any], int]) -> None:
    found, code = short_run
    assert code == (0 if all(target["holds"] for target in found["targets"]) else 1)


def test_an_unknown_server_is_a_usage_mistake_that_names_those_there_are() -> None:
    done = run("--servers", "ours,milo")
    assert done.returncode == 2
    assert "milo: there are ours, stock, node-opcua, open62541" in done.stderr
