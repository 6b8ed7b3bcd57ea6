"""Scenarios: reading, running, what they say."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

from pcaccess.plc.cpu import Mode
from pcaccess.plc.scenario import Scenario, load_scenario, parse_scenario
from pcaccess.plc.testrun import Outcome, is_worth_compiling, junit, run_scenario
from pcaccess.problems import ProblemError

FOLLOW = "LD I0.0\n= Q0.0\nLD SM0.0\nINCW VW0\nMOVW AIW0, VW2\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "follow.awl").write_text(FOLLOW)
    (tmp_path / "loop.awl").write_text("LBL 1\nLD SM0.0\nJMP 1\n")
    (tmp_path / "fault.awl").write_text("LD I0.0\nMOVB *AC1, VB0\n")
    (tmp_path / "stop.awl").write_text("LD I0.0\nSTOP\nLD SM0.0\n= Q0.0\n")
    (tmp_path / "named.awl").write_text("LD Start\n= Motor\n")
    (tmp_path / "named.sym").write_text("Start\tI0.0\t\nMotor\tQ0.0\t\n")
    return tmp_path


def read(folder: Path, steps: str, program: str = "follow.awl", **keys: str) -> Scenario:
    head = "".join(f"{key}: {value}\n" for key, value in {"program": program, **keys}.items())
    return parse_scenario(f"{head}steps:\n{steps}", "test.yaml", folder)


def run(folder: Path, steps: str, program: str = "follow.awl", **keys: str) -> Outcome:
    return run_scenario(read(folder, steps, program, **keys))


def failures(outcome: Outcome) -> list[str]:
    return [str(failure) for failure in outcome.failures]


def test_what_is_set_acts_before_the_scan_that_is_checked(folder: Path) -> None:
    assert run(folder, "  - {at: 100ms, set: {I0.0: 1}, expect: {Q0.0: 1, VW0: 11}}").passed


def test_a_failure_says_where_when_what(folder: Path) -> None:
    outcome = run(folder, "  - at: 100ms\n    expect: {Q0.0: 1}\n")
    assert failures(outcome) == ["test.yaml:4:14: at 100ms: Q0.0 is 0, expected 1"]
    assert outcome.as_json() == {
        "file": "test.yaml",
        "passed": False,
        "failures": [{"at": "100ms", "address": "Q0.0", "expected": 1, "actual": 0, "line": 4, "column": 14}],
    }


def test_each_failure_is_told_where_it_is_expected(folder: Path) -> None:
    steps = """
  - at: 0ms
    expect:
      VW0: 1
      VW2: 7
      Q0.0: {min: 1}
      mode: STOP
  - at: 10ms
    mode: STOP
    error: ["0006", "0091"]
"""
    outcome = run(folder, steps)
    assert [(failure.address, failure.span.line, failure.span.column) for failure in outcome.failures] == [
        ("VW2", 7, 7),
        ("Q0.0", 8, 7),
        ("mode", 9, 7),
        ("mode", 11, 5),
        ("error", 12, 13),
        ("error", 12, 21),
    ]


def test_limits_are_told_as_limits(folder: Path) -> None:
    outcome = run(folder, "  - {at: 0ms, expect: {VW0: {min: 5}, VD8: {near: 1.5, tol: 0.5}, mode: STOP}}")
    found = [(failure["expected"], failure["actual"]) for failure in outcome.as_json()["failures"]]
    assert found == [({"min": 5.0}, 1), ({"min": 1.0, "max": 2.0}, 0.0), ("STOP", "RUN")]


def test_steps_run_in_the_order_of_their_times(folder: Path) -> None:
    steps = "  - {at: 50ms, expect: {VW0: 6}}\n  - {at: 20ms, expect: {VW0: 3}}\n"
    assert run(folder, steps).passed


def test_steps_of_one_scan_share_it(folder: Path) -> None:
    steps = "  - {at: 20ms, set: {I0.0: 1}}\n  - {at: 20ms, expect: {VW0: 3, Q0.0: 1}}\n"
    assert run(folder, steps).passed


def test_a_step_between_scans_acts_at_the_next_one(folder: Path) -> None:
    assert run(folder, "  - {at: 15ms, set: {I0.0: 1}, expect: {Q0.0: 1, VW0: 3}}").passed


def test_the_scan_time_can_be_told(folder: Path) -> None:
    assert run(folder, "  - {at: 100ms, expect: {VW0: 3}}", scan="50ms").passed


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("VW10: -5", "VW10: -5"),
        ("VW10: -5", "VW10: 65531"),
        ("VW10: 16#FFFF", "VW10: -1"),
        ("VB10: 255", "VB10: -1"),
        ("VD10: 2#101", "VD10: 5"),
        ("VD10: 1.5", "VD10: 1.5"),
        ("VD10: 0.1", "VD10: 0.1"),
        ("VD10: 12.505", "VD10: {near: 12.5, tol: 0.01}"),
        ("VD10: 12.505", "VD10: {min: 12.5, max: 12.6}"),
        ("VW10: 7", "VW10: {min: 7}"),
        ("VW10: 7", "VW10: {max: 7}"),
        ("VW10: 65535", "VW10: {min: 60000, max: 65535}"),
        ('VB10: "text"', 'VB10: "text"'),
        ("V10.3: true", "VB10: 8"),
        ("T37: 5", "T37: 5"),
        ("C1: -3", "C1: -3"),
        ("T37.bit: 1", "T37.bit: 1"),
        ("AIW0: -32000", "VW2: -32000"),
        ("I1.5: 1", "IB1: 32"),
    ],
)
def test_what_is_written_is_found(folder: Path, given: str, expected: str) -> None:
    outcome = run(folder, f"  - {{at: 0ms, set: {{{given}}}, expect: {{{expected}}}}}")
    assert failures(outcome) == []


@pytest.mark.parametrize(
    "expected", ["VW10: 8", "VW10: {min: 8}", "VW10: {max: 6}", "VD20: {near: 1.0, tol: 0.1}", 'VB30: "x"', "I0.0: 1"]
)
def test_what_is_not_there_fails(folder: Path, expected: str) -> None:
    assert not run(folder, f"  - {{at: 0ms, set: {{VW10: 7}}, expect: {{{expected}}}}}").passed


def test_symbols_of_the_program_are_places(folder: Path) -> None:
    assert run(folder, "  - {at: 0ms, set: {Start: 1}, expect: {Motor: 1}}", "named.awl").passed


def test_data_is_in_v_memory_from_the_beginning(folder: Path) -> None:
    text = "|\n  VW10 1, 2\n  VB20 'TD'"
    assert run(folder, "  - {at: 0ms, expect: {VW12: 2, VB20: 84}}", data=text).passed


def test_the_switch_stops_before_the_scan(folder: Path) -> None:
    steps = (
        "  - {at: 0ms, set: {I0.0: 1}, expect: {Q0.0: 1}}\n"
        "  - {at: 50ms, mode: STOP, expect: {Q0.0: 0, VW0: 5, mode: STOP}}\n"
        "  - {at: 100ms, mode: RUN, expect: {Q0.0: 1, VW0: 6, mode: RUN}}\n"
    )
    assert failures(run(folder, steps)) == []


def test_an_expected_mode_is_not_the_switch(folder: Path) -> None:
    steps = "  - {at: 0ms, expect: {mode: RUN}}\n  - {at: 10ms, set: {I0.0: 1}, expect: {mode: STOP, Q0.0: 0}}\n"
    assert run(folder, steps, "stop.awl").passed
    assert failures(run(folder, "  - {at: 0ms, expect: {mode: STOP}}", "stop.awl")) == [
        "test.yaml:3:24: at 0ms: mode is RUN, expected STOP"
    ]


def test_an_expected_error_passes_and_a_missing_one_fails(folder: Path) -> None:
    assert run(folder, '  - {at: 10ms, set: {I0.0: 1}, error: "0006"}', "fault.awl").passed
    outcome = run(folder, '  - {at: 10ms, error: "0006"}', "fault.awl")
    assert failures(outcome) == ["test.yaml:3:23: at 10ms: error is none, expected 0006"]


def test_beside_an_error_the_mode_is_expected(folder: Path) -> None:
    assert run(folder, '  - {at: 0ms, error: "0003", mode: STOP}', "loop.awl").passed


def test_a_fatal_error_that_no_step_names_fails(folder: Path) -> None:
    outcome = run(folder, "  - {at: 0ms}", "loop.awl")
    assert [failure.address for failure in outcome.failures] == ["error"]


def test_other_errors_are_told_and_do_not_fail(folder: Path) -> None:
    outcome = run(folder, "  - {at: 0ms, set: {I0.0: 1}}", "fault.awl")
    assert outcome.passed
    assert [str(record.code) for record in outcome.unexpected] == ["0006"]


def test_the_trace_has_the_values_after_every_step(folder: Path) -> None:
    outcome = run(folder, "  - {at: 0ms}\n  - {at: 1s, set: {I0.0: 1}}\n", trace="[Q0.0, VW0]")
    assert outcome.as_json()["trace"] == [
        {"at": "0ms", "values": {"Q0.0": 0, "VW0": 1}},
        {"at": "1s", "values": {"Q0.0": 1, "VW0": 101}},
    ]


def test_a_traced_place_may_have_a_type(folder: Path) -> None:
    steps = '  - {at: 0ms, set: {VD20: 1.5, VB30: "hi"}}'
    outcome = run(folder, steps, trace="[VD20:REAL, VB30:string, VD20:DINT]")
    assert outcome.as_json()["trace"][0]["values"] == {"VD20:REAL": 1.5, "VB30:string": "hi", "VD20:DINT": 0x3FC00000}


@pytest.mark.parametrize("place", ["VW20:REAL", "VD20:FLOAT", "VD20:"])
def test_a_traced_place_has_a_type_that_fits(folder: Path, place: str) -> None:
    with pytest.raises(ProblemError, match="SCN005"):
        read(folder, "  - {at: 0ms}", trace=f'["{place}"]')


def test_scan_load_spreads_over_the_networks(folder: Path) -> None:
    (folder / "late.awl").write_text("NETWORK 1\nLD SM0.0\nTON T32, 3\nNETWORK 2\nLD T32\n= Q0.0\n")
    assert run(folder, "  - {at: 0ms, expect: {Q0.0: 0}}", "late.awl", scan_load="4ms").passed
    assert run(folder, "  - {at: 0ms, expect: {Q0.0: 1}}", "late.awl", scan_load="6ms").passed


@pytest.mark.parametrize(
    ("steps", "code"),
    [
        ("  - {at: 10, expect: {Q0.0: 1}}", "SCN004"),
        ("  - {at: 10ms, expect: {Q0.9: 1}}", "SCN005"),
        ("  - {at: 10ms, expect: {'VB0[3]': 1}}", "SCN005"),
        ("  - {at: 10ms, expect: {VW0: 70000}}", "SCN006"),
        ("  - {at: 10ms, expect: {VW0: 1.5}}", "SCN006"),
        ("  - {at: 10ms, expect: {VW0: {}}}", "SCN006"),
        ("  - {at: 10ms, expect: {VW0: {near: 1.0}}}", "SCN006"),
        ("  - {at: 10ms, expect: {VW0: [1]}}", "SCN004"),
        ("  - {at: 10ms, set: {Q0.0: 2}}", "SCN006"),
        ("  - {at: 10ms, set: {Q0.0: {min: 0}}}", "SCN004"),
        ('  - {at: 10ms, set: {VW0: "text"}}', "SCN006"),
        ("  - {at: 10ms, set: {Q0.0: maybe}}", "SCN006"),
        ("  - {at: 10ms, mode: PAUSE}", "SCN004"),
        ('  - {at: 10ms, error: "1234"}', "SCN004"),
        ("  - {at: 10ms, trace: [Q0.0]}", "SCN002"),
        ("  - 10ms", "SCN004"),
    ],
)
def test_mistakes_are_found_before_anything_runs(folder: Path, steps: str, code: str) -> None:
    with pytest.raises(ProblemError) as refused:
        read(folder, steps)
    assert [problem.code for problem in refused.value.problems] == [code]


def test_all_mistakes_come_at_once(folder: Path) -> None:
    with pytest.raises(ProblemError) as refused:
        read(folder, "  - {at: 10, expect: {Q0.9: 1, VW0: 70000}}", cpu="CPU 999", scan="fast")
    assert len(refused.value.problems) == 5


def test_mistakes_of_the_program_are_told_as_its_own(folder: Path) -> None:
    (folder / "wrong.awl").write_text("LD I0.0\n+I VB0, VW2\n")
    with pytest.raises(ProblemError) as refused:
        read(folder, "  - {at: 0ms}", "wrong.awl")
    assert [(Path(p.span.file).name, p.span.line) for p in refused.value.problems] == [("wrong.awl", 2)]


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"[1, 2]", b"- a", b"text", b"!!python/object:os.system {}"])
def test_a_file_that_is_no_scenario_is_told_so(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "bad.yaml"
    path.write_bytes(content)
    with pytest.raises(ProblemError) as refused:
        load_scenario(path)
    assert all(problem.code.startswith("SCN") for problem in refused.value.problems)


def test_a_file_that_is_not_there_is_told_so(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match="no such file"):
        load_scenario(tmp_path / "none.yaml")


def test_what_the_interpreter_would_need_long_for_is_worth_compiling(folder: Path) -> None:
    """A program of 5 instructions is compiled in half a second, in which the interpreter scans it 300,000 times."""
    steps = "  - {{at: {}, expect: {{Q0.0: 0}}}}"
    assert not is_worth_compiling(read(folder, steps.format("10min")))
    assert is_worth_compiling(read(folder, steps.format("10min"), scan="1ms"))
    (folder / "follow.awl").write_text(FOLLOW * 100)
    assert not is_worth_compiling(read(folder, steps.format("1s")))
    assert is_worth_compiling(read(folder, steps.format("10min")))


def test_junit_counts_and_names_failures(folder: Path) -> None:
    good = run(folder, "  - {at: 0ms, expect: {Q0.0: 0}}")
    bad = run(folder, "  - {at: 0ms, expect: {Q0.0: 1}}")
    suite = ElementTree.fromstring(junit([good, bad]))
    assert (suite.get("tests"), suite.get("failures")) == ("2", "1")
    assert [case.find("failure") is None for case in suite] == [True, False]


def test_a_text_that_cannot_be_printed_does_not_break_junit(folder: Path) -> None:
    bad = run(folder, '  - {at: 0ms, expect: {VB400: "abc"}}', data='"VB400 3,1,65,0"')
    assert failures(bad) == ['test.yaml:4:24: at 0ms: VB400 is "$01A$00", expected "abc"']
    suite = ElementTree.fromstring(junit([bad]))
    assert failures(bad) == [failure.text for failure in suite.iter("failure")]


@pytest.mark.parametrize(("dword", "told"), [("7FC00000", "NaN"), ("7F800000", "Infinity"), ("FF800000", "-Infinity")])
def test_what_json_has_no_number_for_is_a_text(folder: Path, dword: str, told: str) -> None:
    bad = run(folder, f"  - {{at: 0ms, set: {{VD20: 16#{dword}}}, expect: {{VD20: 1.5}}}}")
    assert f'"actual": "{told}"' in json.dumps(bad.as_json()["failures"], allow_nan=False)


def test_mode_names_are_those_of_the_cpu() -> None:
    assert set(Mode.__members__) == {"RUN", "STOP"}
