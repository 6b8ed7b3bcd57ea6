"""The example programs do what their scenarios say."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from conformance import EXECUTORS

from pcaccess.plc.scenario import load_scenario
from pcaccess.plc.testrun import run_scenario

EXAMPLES = Path(__file__).parent.parent.parent / "examples"
SCENARIOS = sorted(path for path in EXAMPLES.glob("**/*.yaml") if path.with_suffix(".awl").is_file())


@pytest.mark.parametrize("executor", EXECUTORS)
@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
def test_scenario(path: Path, executor: str) -> None:
    outcome = run_scenario(load_scenario(path), make_executor=EXECUTORS[executor])
    assert [str(failure) for failure in outcome.failures] == []
    assert outcome.unexpected == ()


def test_every_example_program_has_a_scenario() -> None:
    programs = set(EXAMPLES.glob("**/*.awl"))
    assert programs == {path.with_suffix(".awl") for path in SCENARIOS}


def test_every_pitfall_is_told_and_has_its_program() -> None:
    page = (EXAMPLES.parent / "docs" / "pitfalls.md").read_text(encoding="utf-8")
    programs = {path.stem for path in (EXAMPLES / "pitfalls").glob("*.awl")}
    told = {word for line in page.splitlines() if line.startswith("Program") for word in re.findall(r"`(\w+)`", line)}
    assert told == programs
