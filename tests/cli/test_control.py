"""reload and plc status, start, stop, download: a running gateway obeys."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from pcaccess.cli.remote import Lost, connect
from pcaccess.gateway.projectfile import ProjectFile
from pcaccess.project.load import load_project
from tests.cli.conftest import Command, Outcome, invoke
from tests.gateways import start_gateway

pytestmark = pytest.mark.asyncio(loop_scope="module")

COPY = "ORGANIZATION_BLOCK MAIN:OB1\nBEGIN\nNetwork 1\nLD I0.0\n= Q0.0\nEND_ORGANIZATION_BLOCK\n"
PROJECT = """
links:
  - name: L
    type: soft
    plcs:
      - {name: Runs, address: 2, program: copy.awl, items: [{name: In, address: I0.0, type: BOOL, access: RW}]}
      - {name: Memory, address: 3, items: [{name: A, address: VW0}]}
"""


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def served(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[tuple[Path, str]]:
    """A project folder and the URL where it is served."""
    folder = tmp_path_factory.mktemp("project")
    (folder / "copy.awl").write_text(COPY)
    (folder / "items.yaml").write_text(PROJECT)
    async with start_gateway(PROJECT, base=folder) as running:
        # Not pcaccess.cli.serving: it would see a saved file by itself, now and then before the test asks for it.
        path = folder / "items.yaml"
        running.server.offer_reload(ProjectFile(running.gateway, path, load_project(path)).reload)
        yield folder, running.url


@pytest.fixture
def command(served: tuple[Path, str], monkeypatch: pytest.MonkeyPatch) -> Command:
    monkeypatch.setenv("PCACCESS_URL", served[1])

    async def run(*arguments: str) -> Outcome:
        return await asyncio.to_thread(invoke, *arguments)

    return run


async def test_status_shows_how_each_plc_is(command: Command) -> None:
    outcome = await command("plc", "status")
    assert outcome.code == 0
    assert outcome.lines[0] == "PLC       Connected  Mode  Scan Time  Errors"
    assert [line.split()[:3] for line in outcome.lines[1:]] == [["L.Runs", "yes", "RUN"], ["L.Memory", "yes", "STOP"]]


async def test_status_of_what_is_no_plc_is_told(command: Command) -> None:
    outcome = await command("plc", "status", "l.memory", "L.Runs.In", "L.Rums", "--json")
    assert outcome.code == 1
    assert json.loads(outcome.out) == [
        {"id": "L.Memory", "connected": True, "mode": "STOP", "scan_time": 0.0, "errors": 0}
    ]
    assert outcome.err.splitlines() == [
        "pcaccess: there is no PLC L.Runs.In; there are L.Runs, L.Memory; did you mean L.Runs?",
        "pcaccess: there is no PLC L.Rums; there are L.Runs, L.Memory; did you mean L.Runs?",
    ]


async def test_a_plc_is_stopped_and_started(command: Command) -> None:
    assert (await command("plc", "stop", "l.runs")).out == "L.Runs: STOP\n"
    assert (await command("plc", "start", "L.Runs")).out == "L.Runs: RUN\n"


@pytest.mark.parametrize(
    ("plc", "words"),
    [
        ("L.Memory", "L.Memory runs no program; only a soft-PLC with a program: does that"),
        ("L.Xyz", "there is no PLC L.Xyz; there are L.Runs, L.Memory"),
        ("L", "there is no PLC L; there are L.Runs, L.Memory"),
        ("L.Runs.In", "there is no PLC L.Runs.In; there are L.Runs, L.Memory; did you mean L.Runs?"),
        ("memory", "there is no PLC memory; there are L.Runs, L.Memory; did you mean L.Memory?"),
    ],
)
async def test_what_has_no_cpu_cannot_be_started(command: Command, plc: str, words: str) -> None:
    for command_line in (("start", plc), ("stop", plc), ("download", str(__file__), "--plc", plc)):
        outcome = await command("plc", *command_line)
        assert (outcome.code, outcome.out, outcome.err) == (1, "", f"pcaccess: {words}\n")


async def test_a_program_is_downloaded_and_runs(command: Command, served: tuple[Path, str]) -> None:
    folder, _ = served
    (folder / "inverse.awl").write_text(COPY.replace("LD I0.0", "LDN I0.0"))
    outcome = await command("plc", "download", str(folder / "inverse.awl"), "--plc", "L.Runs")
    assert (outcome.code, outcome.out) == (0, f"L.Runs: {folder / 'inverse.awl'} runs\n")
    while (await command("read", "2,Q0.0,BOOL", "--json")).out.find('"value": true') < 0:
        pass


async def test_a_plc_that_stops_at_once_was_not_started(command: Command, served: tuple[Path, str]) -> None:
    folder, _ = served
    (folder / "stops.awl").write_text(COPY.replace("= Q0.0", "LD SM0.0\nSTOP"))
    outcome = await command("plc", "download", str(folder / "stops.awl"), "--plc", "L.Runs")
    assert (outcome.code, outcome.out) == (1, f"L.Runs: {folder / 'stops.awl'} is taken; the PLC is in STOP\n")
    assert outcome.err == "pcaccess: L.Runs went to STOP; the log of pcaccess run says why\n"
    outcome = await command("plc", "start", "L.Runs")
    assert (outcome.code, outcome.out) == (1, "L.Runs: STOP\n")
    assert outcome.err == "pcaccess: L.Runs went back to STOP; the log of pcaccess run says why\n"
    (folder / "copy.awl").write_text(COPY)
    outcome = await command("plc", "download", str(folder / "copy.awl"), "--plc", "L.Runs", "--json")
    assert json.loads(outcome.out) == {"plc": "L.Runs", "accepted": True, "mode": "STOP", "problems": []}
    assert (outcome.code, outcome.err) == (0, "")
    assert (await command("plc", "start", "L.Runs")).out == "L.Runs: RUN\n"


async def test_a_program_with_errors_changes_nothing(command: Command, served: tuple[Path, str]) -> None:
    folder, _ = served
    (folder / "wrong.awl").write_text(COPY.replace("= Q0.0", "= Q0.9"))
    outcome = await command("plc", "download", str(folder / "wrong.awl"), "--plc", "L.Runs", "--json")
    told = json.loads(outcome.out)
    assert (outcome.code, told["plc"], told["accepted"]) == (1, "L.Runs", False)
    assert "wrong.awl:5:3" in told["problems"][0]


async def test_a_file_that_is_not_there_is_not_downloaded(command: Command) -> None:
    outcome = await command("plc", "download", "missing.awl", "--plc", "L.Runs")
    assert outcome.err == "pcaccess: missing.awl cannot be opened: No such file or directory\n"


async def test_a_changed_project_is_reloaded(command: Command, served: tuple[Path, str]) -> None:
    folder, _ = served
    (folder / "items.yaml").write_text(PROJECT.replace("{name: A,", "{name: B, address: VW2}, {name: A,"))
    outcome = await command("reload")
    assert (outcome.code, outcome.out) == (0, "1 item added\n")
    assert (await command("read", "L.Memory.B")).code == 0


async def test_a_broken_project_is_not_and_says_why(command: Command, served: tuple[Path, str]) -> None:
    folder, _ = served
    good = (folder / "items.yaml").read_text()
    (folder / "items.yaml").write_text(good.replace("VW0", "VX"))
    outcome = await command("reload")
    told = await command("reload", "--json")
    (folder / "items.yaml").write_text(good)
    assert (outcome.code, outcome.out) == (1, "")
    assert "items.yaml:7:" in outcome.err
    assert json.loads(told.out)["applied"] is False


async def test_answers_may_take_as_long_as_they_are_given(served: tuple[Path, str]) -> None:
    """A large program is compiled for longer than a server usually has for an answer."""
    async with connect(served[1]) as remote:
        (mode,) = await remote.read_values([remote.of_system("L.Runs/Mode")])
        assert mode.Value is not None
        remote.be_patient(1e-6)
        with pytest.raises(Lost, match="did not answer within 1e-06 s"):
            await remote.read_values([remote.of_system("L.Runs/Mode")])
        remote.be_patient(60)
