"""plc: programs checked, listed, tested and scanned from the command line."""

from __future__ import annotations

import io
import json
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import pytest
from rich.console import Console

from pcaccess.cli import scenarios
from pcaccess.cli.scanning import Place, Scanner, ScanTable, Status, parse_place, places_of, write_setting
from pcaccess.plc.errorlog import ErrorRecord
from pcaccess.plc.interpreter import Interpreter
from pcaccess.plc.llvm import machine
from pcaccess.s7200.cpu import cpu_model
from pcaccess.s7200.types import Value
from pcaccess.stl.checker import load_program
from tests.cli.conftest import invoke
from tests.clocks import HandClock

EXAMPLES = sorted((Path(__file__).parents[2] / "examples" / "stl").glob("*.awl"))
COPY = """ORGANIZATION_BLOCK MAIN:OB1
BEGIN
Network 1
LD I0.0
= Q0.0
Network 2
LD SM0.0
INCW VW10
END_ORGANIZATION_BLOCK
"""
WRONG = COPY.replace("INCW VW10", "+I VW0, VB10\nMOVW 70000, VW2\nBLINK Q0.1")
PASSES = "program: copy.awl\nsteps: [{at: 10ms, set: {I0.0: 1}, expect: {Q0.0: 1, VW10: 2}}]\n"
FAILS = "program: copy.awl\ntrace: [VW10]\nsteps: [{at: 0ms, expect: {Q0.0: 1}}, {at: 30ms, expect: {VW10: 4}}]\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the commands run; it holds ``copy.awl``."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "copy.awl").write_text(COPY)
    return tmp_path


@pytest.fixture
def no_llvmlite(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A machine for which there is no llvmlite."""
    monkeypatch.setitem(sys.modules, "llvmlite", None)
    machine._binding.cache_clear()
    yield
    machine._binding.cache_clear()


# -- check ---------------------------------------------------------------------------------------------------------


def test_a_good_program_says_how_large_it_is(folder: Path) -> None:
    outcome = invoke("plc", "check", "copy.awl")
    assert (outcome.code, outcome.out) == (0, "copy.awl: 1 block, 2 networks, 4 instructions; no problems\n")


def test_mistakes_come_all_at_once_with_block_and_network(folder: Path) -> None:
    (folder / "wrong.awl").write_text(WRONG)
    outcome = invoke("plc", "check", "wrong.awl", "copy.awl")
    heads = [line for line in outcome.lines if line.startswith("wrong.awl:") and not line.startswith("wrong.awl: ")]
    assert outcome.code == 1
    assert [int(head.split(":")[1]) for head in heads] == [8, 9, 10]
    assert all("MAIN (OB1), network 2" in head for head in heads)
    assert "^^^^" in outcome.out
    assert outcome.lines[-1].startswith("copy.awl: 1 block")


def test_programs_get_problems_and_size(folder: Path) -> None:
    (folder / "wrong.awl").write_text(WRONG)
    good, wrong = json.loads(invoke("plc", "check", "copy.awl", "wrong.awl", "--json").out)
    assert good == {
        "file": "copy.awl",
        "ok": True,
        "encoding": "ascii",
        "blocks": 1,
        "networks": 2,
        "instructions": 4,
        "problems": [],
    }
    assert (wrong["ok"], [problem["span"]["line"] for problem in wrong["problems"]]) == (False, [8, 9, 10])


def test_the_cpu_decides_which_addresses_exist(folder: Path) -> None:
    (folder / "far.awl").write_text(COPY.replace("VW10", "VW5000"))
    assert invoke("plc", "check", "far.awl", "--cpu", "226XM").code == 0
    assert "a CPU 222 has VB0 to VB2047" in invoke("plc", "check", "far.awl", "--cpu", "cpu 222").out


def test_carets_stand_right_in_every_code_page(folder: Path) -> None:
    (folder / "russian.awl").write_bytes(COPY.replace("INCW VW10", "INCW VX10 // насос").encode("cp1251"))
    outcome = invoke("plc", "check", "russian.awl")
    source, carets = outcome.lines[1:3]
    assert "насос" in source
    assert carets.index("^") == source.index("VX10")


def test_a_forced_encoding_is_used(folder: Path) -> None:
    (folder / "german.awl").write_bytes(COPY.replace("Network 1", "Network 1 // Öl").encode("cp1252"))
    (checked,) = json.loads(invoke("plc", "check", "german.awl", "--encoding", "cp1252", "--json").out)
    assert checked["encoding"] == "cp1252"


@pytest.mark.parametrize("content", [b"", b"\x00\x01\x02", b"PK\x03\x04", b"just some words\n", b"L MW 10\nT MW 12\n"])
def test_what_is_no_program_is_told(folder: Path, content: bytes) -> None:
    (folder / "what.awl").write_bytes(content)
    outcome = invoke("plc", "check", "what.awl")
    assert outcome.code == 1
    assert outcome.lines[0].startswith("what.awl:")


@pytest.mark.parametrize("command", [("check",), ("list",), ("run",)])
def test_a_missing_file_is_told(folder: Path, command: tuple[str, ...]) -> None:
    outcome = invoke("plc", *command, "missing.awl")
    told = "missing.awl:1:1: STL001 the file cannot be opened: No such file or directory\n"
    assert outcome.code == 1
    assert (outcome.out + outcome.err).startswith(told)


def test_a_missing_file_does_not_stop_the_others(folder: Path) -> None:
    outcome = invoke("plc", "check", "missing.awl", ".", "copy.awl", "--json")
    assert outcome.code == 1
    assert [one["ok"] for one in json.loads(outcome.out)] == [False, False, True]


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="a device of POSIX")
def test_a_file_without_an_end_is_told() -> None:
    outcome = invoke("plc", "check", "/dev/zero")
    assert outcome.lines[0] == "/dev/zero:1:1: STL002 the file has more than 16,777,216 bytes; no program is so large"


@pytest.mark.parametrize("arguments", [("--cpu", "CPU 315"), ("--encoding", "klingon")])
def test_an_unknown_cpu_or_encoding_is_usage(folder: Path, arguments: tuple[str, str]) -> None:
    assert invoke("plc", "check", "copy.awl", *arguments).code == 2


# -- list ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_a_listing_is_the_program_again(folder: Path, example: Path) -> None:
    assert invoke("plc", "list", str(example), "-o", "again.awl").code == 0
    assert load_program(folder / "again.awl").unwrap() == load_program(example).unwrap()


def test_a_listing_ends_with_the_cross_reference(folder: Path) -> None:
    assert "//Q0.0   OB1/1=\n" in invoke("plc", "list", "copy.awl").out
    assert "CROSS_REFERENCE" not in invoke("plc", "list", "copy.awl", "--no-references").out


def test_the_program_is_not_replaced_by_its_listing(folder: Path) -> None:
    assert invoke("plc", "list", "copy.awl", "-o", "copy.awl").code == 1
    assert (folder / "copy.awl").read_text() == COPY


def test_mistakes_that_only_checking_finds_do_not_stop_the_listing(folder: Path) -> None:
    (folder / "wrong.awl").write_text(COPY.replace("INCW VW10", "+I VW0, VB10"))
    outcome = invoke("plc", "list", "wrong.awl")
    assert outcome.code == 0
    assert "+I     VW0, VB10" in outcome.out
    assert "STL021" in outcome.err


# -- scenario ------------------------------------------------------------------------------------------------------


def test_a_scenario_that_passes_says_so(folder: Path) -> None:
    (folder / "passes.yaml").write_text(PASSES)
    outcome = invoke("plc", "scenario", "passes.yaml")
    assert (outcome.code, outcome.out) == (0, "passes.yaml: passed, 2 scans\n")


def test_a_scenario_that_is_worth_it_is_compiled_and_says_so(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scenarios, "is_worth_compiling", lambda _: True)
    (folder / "passes.yaml").write_text(PASSES)
    outcome = invoke("plc", "scenario", "passes.yaml")
    assert (outcome.code, outcome.out) == (0, "passes.yaml: passed, 2 scans (compiled)\n")


@pytest.mark.parametrize(("execution", "how"), [("compiled", " (compiled)"), ("interpreter", "")])
def test_a_scenario_runs_as_it_is_told_to(folder: Path, execution: str, how: str) -> None:
    (folder / "passes.yaml").write_text(PASSES)
    outcome = invoke("plc", "scenario", "passes.yaml", "--execution", execution)
    assert (outcome.code, outcome.out, outcome.err) == (0, f"passes.yaml: passed, 2 scans{how}\n", "")


@pytest.mark.usefixtures("no_llvmlite")
def test_scenarios_that_would_be_compiled_say_once_why_they_are_not(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scenarios, "is_worth_compiling", lambda _: True)
    (folder / "passes.yaml").write_text(PASSES)
    outcome = invoke("plc", "scenario", "passes.yaml", "passes.yaml")
    assert outcome.lines == ["passes.yaml: passed, 2 scans"] * 2 + ["2 scenarios, all passed"]
    assert outcome.err.count("in the interpreter, which is much slower: llvmlite is not installed (") == 1


@pytest.mark.usefixtures("no_llvmlite")
def test_scenarios_that_are_not_worth_compiling_need_no_compiler(folder: Path) -> None:
    (folder / "passes.yaml").write_text(PASSES)
    assert invoke("plc", "scenario", "passes.yaml").err == ""


def test_every_difference_is_told_and_the_others_run(folder: Path) -> None:
    (folder / "passes.yaml").write_text(PASSES)
    (folder / "fails.yaml").write_text(FAILS)
    outcome = invoke("plc", "scenario", "fails.yaml", "passes.yaml")
    assert outcome.code == 1
    assert outcome.lines == [
        "fails.yaml: FAILED, 1 not as expected",
        "  fails.yaml:3:28: at 0ms: Q0.0 is 0, expected 1",
        "passes.yaml: passed, 2 scans",
        "2 scenarios, 1 failed",
    ]


def test_programs_get_failures_and_traces(folder: Path) -> None:
    (folder / "fails.yaml").write_text(FAILS)
    (outcome,) = json.loads(invoke("plc", "scenario", "fails.yaml", "--json").out)
    assert outcome == {
        "file": "fails.yaml",
        "passed": False,
        "failures": [{"at": "0ms", "address": "Q0.0", "expected": 1, "actual": 0, "line": 3, "column": 28}],
        "trace": [{"at": "0ms", "values": {"VW10": 1}}, {"at": "30ms", "values": {"VW10": 4}}],
    }


def test_a_scenario_that_cannot_be_read_says_why_and_the_others_run(folder: Path) -> None:
    (folder / "passes.yaml").write_text(PASSES)
    (folder / "broken.yaml").write_text("program: copy.awl\nsteps: [{at: soon}]\n")
    outcome = invoke("plc", "scenario", "broken.yaml", "missing.yaml", "passes.yaml")
    assert outcome.code == 1
    assert outcome.lines[0].startswith("broken.yaml:2:14: SCN004 ")
    assert "broken.yaml: cannot be run, 1 error" in outcome.lines
    assert outcome.lines[-2:] == ["passes.yaml: passed, 2 scans", "3 scenarios, 2 failed"]


def test_a_run_time_error_that_no_step_names_is_told(folder: Path) -> None:
    (folder / "pointer.awl").write_text(COPY.replace("INCW VW10", "MOVW *AC1, VW10"))
    (folder / "pointer.yaml").write_text("program: pointer.awl\nsteps: [{at: 20ms, expect: {Q0.0: 0}}]\n")
    outcome = invoke("plc", "scenario", "pointer.yaml")
    assert (outcome.code, outcome.lines[0]) == (0, "pointer.yaml: passed, 3 scans")
    assert outcome.lines[1].startswith("  pointer.awl:8:1: 0006 ")


def test_junit_has_a_case_for_each_file(folder: Path) -> None:
    for name, text in (("passes", PASSES), ("fails", FAILS), ("broken", "steps: 1\n")):
        (folder / f"{name}.yaml").write_text(text)
    invoke("plc", "scenario", "passes.yaml", "fails.yaml", "broken.yaml", "--junit", "out.xml")
    suite = Xml.parse(folder / "out.xml").getroot()
    assert {key: suite.get(key) for key in ("tests", "failures", "errors")} == {
        "tests": "3",
        "failures": "1",
        "errors": "1",
    }
    assert {case.get("name"): [child.tag for child in case] for case in suite} == {
        "passes.yaml": [],
        "fails.yaml": ["failure"],
        "broken.yaml": ["error"],
    }


# -- run -----------------------------------------------------------------------------------------------------------


class Recorder:
    """Keeps what it is shown."""

    def __init__(self) -> None:
        self.seen: list[tuple[int, str, Value]] = []
        self.errors: list[str] = []

    def show(self, at: float, changes: Sequence[tuple[Place, Value]], status: Status) -> None:
        self.seen += [(round(at), place.name, value) for place, value in changes]

    def error(self, record: ErrorRecord) -> None:
        self.errors.append(str(record))


def program_of(text: str) -> Any:
    return load_program(text.encode(), file="test.awl").unwrap()


async def scanned(text: str, places: Sequence[str], *settings: str, seconds: float = 0.05) -> tuple[Scanner, Recorder]:
    """Run a program every 10 ms on a clock moved by hand."""
    import asyncio

    model, program, clock, seen = cpu_model(), program_of(text), HandClock(), Recorder()
    scanner = Scanner(model, program, clock, Interpreter)
    for setting in settings:
        write_setting(scanner.cpu, setting, program, model)
    chosen = [parse_place(place, program, model) for place in places]
    async with asyncio.TaskGroup() as tasks:
        running = tasks.create_task(scanner.run(chosen, seen, 0.01, seconds))
        while not running.done():
            await clock.advance(0.01)
    return scanner, seen


async def test_scans_follow_each_other_and_changes_are_shown() -> None:
    scanner, seen = await scanned(COPY, ["Q0.0", "VW10"], "I0.0=1")
    assert seen.seen == [(0, "Q0.0", True), *((10 * n, "VW10", n + 1) for n in range(5))]
    assert (scanner.status.mode, scanner.status.scans) == ("RUN", 5)


async def test_a_real_that_is_no_number_is_shown_once() -> None:
    _, seen = await scanned("LD SM0.1\nMOVD 16#7FC00000, VD20\n", ["VD20:REAL"])
    assert [(at, name) for at, name, _ in seen.seen] == [(0, "VD20")]


async def test_a_run_time_error_is_told_once_and_does_not_stop() -> None:
    scanner, seen = await scanned(COPY.replace("INCW VW10", "MOVW *AC1, VW10"), [])
    assert [error.split()[0] for error in seen.errors] == ["test.awl:8:1:"]
    assert scanner.status.mode == "RUN"


@pytest.mark.parametrize(
    ("text", "name", "kind"),
    [
        ("q0.0", "Q0.0", "BOOL"),
        ("VW10", "VW10", "INT"),
        ("VW10:word", "VW10", "WORD"),
        ("VD20:REAL", "VD20", "REAL"),
        ("T37", "T37", "INT"),
        ("T37.bit", "T37.bit", "BOOL"),
    ],
)
def test_a_place_has_a_type(text: str, name: str, kind: str) -> None:
    place = parse_place(text, program_of(COPY), cpu_model())
    assert (place.name, place.type.name) == (name, kind)


def test_the_places_of_a_program_are_what_it_names() -> None:
    program = program_of(COPY.replace("LD I0.0", "LD T37\nA SM0.0"))
    assert [place.name for place in places_of(program)] == ["Q0.0", "VW10", "T37", "T37.bit"]


def test_lines_have_time_address_and_value(folder: Path) -> None:
    outcome = invoke("plc", "run", "copy.awl", "--watch", "Q0.0", "--set", "I0.0=1", "--for", "30ms")
    assert (outcome.code, outcome.lines) == (0, ["      ms  Address  Value", "       0  Q0.0     1"])
    assert re.fullmatch(r"RUN, \d+ scans?, last \S+ ms, longest \S+ ms \(.+\)\n", outcome.err)


@pytest.mark.usefixtures("no_llvmlite")
def test_without_a_compiler_the_interpreter_runs_and_says_why(folder: Path) -> None:
    outcome = invoke("plc", "run", "copy.awl", "--watch", "Q0.0", "--for", "1ms")
    assert outcome.code == 0
    assert outcome.err.startswith("Programs run in the interpreter, which is much slower: llvmlite is not installed (")
    assert outcome.err.count("interpreter,") == 1
    assert outcome.err.endswith(" (interpreter)\n")


@pytest.mark.parametrize("execution", ["compiled", "interpreter"])
def test_the_execution_can_be_chosen(folder: Path, execution: str) -> None:
    outcome = invoke("plc", "run", "copy.awl", "--watch", "VW10", "--for", "1ms", "--execution", execution)
    assert (outcome.code, outcome.lines[1]) == (0, "       0  VW10     1")
    assert outcome.err.endswith(f" ({execution})\n")


@pytest.mark.usefixtures("no_llvmlite")
@pytest.mark.parametrize("command", [("run", "copy.awl"), ("scenario", "passes.yaml")])
def test_a_compiler_that_is_asked_for_must_be_there(folder: Path, command: tuple[str, str]) -> None:
    (folder / "passes.yaml").write_text(PASSES)
    outcome = invoke("plc", *command, "--execution", "compiled")
    assert (outcome.code, outcome.out) == (1, "")
    assert "programs cannot be compiled here: llvmlite is not installed (" in outcome.err


def test_symbols_are_shown_and_can_be_watched(folder: Path) -> None:
    (folder / "copy.sym").write_text("Lamp\tQ0.0\tover the door\n")
    outcome = invoke("plc", "run", "copy.awl", "--watch", "lamp,VW10", "--for", "1ms", "--scan", "free")
    assert outcome.lines[:2] == ["      ms  Address  Symbol  Value", "       0  Q0.0     Lamp    0"]


def test_programs_get_an_object_per_change(folder: Path) -> None:
    outcome = invoke("plc", "run", "copy.awl", "--watch", "Q0.0", "--for", "1ms", "--json")
    assert [json.loads(line) for line in outcome.lines] == [
        {"at": 0, "address": "Q0.0", "symbol": None, "value": False}
    ]


def test_a_wrong_program_does_not_run(folder: Path) -> None:
    (folder / "wrong.awl").write_text(WRONG)
    outcome = invoke("plc", "run", "wrong.awl")
    assert (outcome.code, outcome.out) == (1, "")
    assert "STL021" in outcome.err


def test_a_fatal_error_ends_it_with_exit_code_1(folder: Path) -> None:
    (folder / "endless.awl").write_text(COPY.replace("INCW VW10", "LBL 1\nJMP 1"))
    outcome = invoke("plc", "run", "endless.awl", "--watch", "Q0.0", "--for", "20s")
    assert outcome.code == 1
    assert "pcaccess: the CPU stopped: endless.awl:9:1: 0003 scan watchdog" in outcome.err


@pytest.mark.parametrize(
    "arguments",
    [
        ("--watch", "X1"),
        ("--watch", "VW10:DATE"),
        ("--set", "I0.0"),
        ("--set", "I0.0=2"),
        ("--scan", "10"),
        ("--for", "x"),
    ],
)
def test_run_used_wrongly_is_usage(folder: Path, arguments: tuple[str, str]) -> None:
    outcome = invoke("plc", "run", "copy.awl", *arguments)
    assert (outcome.code, outcome.out) == (2, "")


def test_a_terminal_shows_a_table() -> None:
    screen = Console(file=io.StringIO(), force_terminal=True, width=100, height=20, color_system=None)
    program = program_of(COPY)
    places = [parse_place(text, program, cpu_model()) for text in ("Q0.0", "VW10", "VD20:REAL")]
    with ScanTable("copy.awl on a CPU 226 (interpreter)", places, screen) as table:
        table.show(0.0, list(zip(places, (True, -2, 0.5), strict=True)), Status("RUN", 12, 0.5, 2.0))
    shown = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", screen.file.getvalue())  # type: ignore[attr-defined]
    assert [line.rstrip() for line in shown.splitlines()[-5:]] == [
        "Address  Symbol  Value      Hex",
        "Q0.0                 1",
        "VW10                -2  16#FFFE",
        "VD20               0.5",
        "copy.awl on a CPU 226 (interpreter): RUN, 12 scans, last 0.5 ms, longest 2 ms. Ctrl-C ends.",
    ]
