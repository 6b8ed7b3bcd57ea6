"""check and schema: what a user is told of a project file before it runs."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pytest
import yaml

from tests.cli.conftest import PLANT, invoke

ROOT = Path(__file__).parents[2]
WRONG = (
    "links:\n  - {name: L, type: soft, plcs: [{name: P, items: [{name: A, adress: VW0}, {name: B, address: VX}]}]}\n"
)
SWAPPED = "links: [{name: L, type: soft, plcs: [{name: P, items: [{name: A, address: VW0, low: 9, high: 1}]}]}]\n"


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where ``items.yaml`` is looked for."""
    monkeypatch.chdir(tmp_path)
    return tmp_path / "items.yaml"


def test_a_good_file_says_what_it_holds(project: Path) -> None:
    project.write_text(PLANT[: PLANT.index("      - name: Dead")] + PLANT[PLANT.index("groups:") :])
    outcome = invoke("check")
    assert (outcome.code, outcome.out) == (0, "items.yaml: 1 link, 2 PLCs, 10 items, 1 group; no problems\n")


def test_every_mistake_is_shown_at_once_with_its_place(project: Path) -> None:
    project.write_text(WRONG)
    outcome = invoke("check")
    places = [line.partition(" ")[0] for line in outcome.lines if line.startswith("items.yaml:2:")]
    assert outcome.code == 1
    assert places == ["items.yaml:2:62:", "items.yaml:2:95:"]
    assert "^" * len("adress") in outcome.out
    assert outcome.lines[-1] == "items.yaml: 2 errors"


def test_warnings_alone_are_no_failure(project: Path) -> None:
    project.write_text(SWAPPED)
    outcome = invoke("check")
    assert outcome.code == 0
    assert "warning PRJ021" in outcome.out
    assert outcome.lines[-1] == "items.yaml: 1 link, 1 PLC, 1 item; 1 warning"


def test_programs_get_every_file_and_problem(project: Path) -> None:
    project.write_text(PLANT)
    project.with_name("wrong.yaml").write_text(WRONG)
    outcome = invoke("check", "items.yaml", "wrong.yaml", "missing.yaml", "--json")
    good, wrong, missing = json.loads(outcome.out)
    assert outcome.code == 1
    assert (good["ok"], good["items"], [p["code"] for p in good["problems"]]) == (True, 11, ["PRJ033"])
    assert (wrong["ok"], len(wrong["problems"])) == (False, 2)
    assert wrong["problems"][0]["span"] == {"line": 2, "column": 62, "length": 6}
    assert missing["problems"][0]["message"] == "there is no such file"


@pytest.mark.parametrize(
    "content", ["", "\tlinks: []\n", "!!python/object/apply:os.system [id]\n", "a: [\n", "\x00\x01"]
)
def test_what_is_no_project_is_a_line_and_no_traceback(project: Path, content: str) -> None:
    project.write_text(content)
    outcome = invoke("check")
    assert outcome.code == 1
    assert outcome.lines[0].startswith(("items.yaml:1:", "items.yaml:2:"))


def test_a_large_file_needs_leave(project: Path) -> None:
    project.write_text(PLANT + "#" * 1_000_000)
    assert "files over 1,000,000 are refused, unless --max-size" in invoke("check", "--max-size", "1").out
    assert invoke("check", "--max-size", "2").code == 0


def test_the_schema_knows_the_sample_project(tmp_path: Path) -> None:
    written = tmp_path / "items.schema.json"
    assert invoke("schema", "-o", str(written)).out == ""
    schema = json.loads(written.read_text())
    assert json.loads(invoke("schema").out) == schema
    jsonschema.validate(yaml.safe_load((ROOT / "items.yaml").read_text()), schema)


def test_a_schema_that_cannot_be_written_is_no_traceback(tmp_path: Path) -> None:
    outcome = invoke("schema", "-o", str(tmp_path))
    assert (outcome.code, outcome.err) == (1, f"pcaccess: {tmp_path} cannot be written: Is a directory\n")
