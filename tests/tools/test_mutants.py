"""The list of seeded faults is kept true, and tools/mutants.py says of each fault what became of it."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import faults
import mutants
import pytest
from faults.fault import Fault
from mutants import Campaign, Outcome, Stale, Unsound, faulty, run

SOURCE = '''"""Answers."""


def answer() -> int:
    return 42


def rounds() -> int:
    n = 3
    while n:
        n -= 1
    return n
'''
TESTS = """from pcaccess.answers import answer, rounds


def test_the_answer() -> None:
    assert answer() == 42


def test_a_loop_ends() -> None:
    assert rounds() == 0
"""


NAMED = "tests/test_answers.py -k answer"


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A clone of a very small project, whose tests need no plugins."""
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    for folder in ("pcaccess", "tests"):
        (tmp_path / folder).mkdir()
    (tmp_path / "pcaccess/answers.py").write_text(SOURCE)
    (tmp_path / "tests/test_answers.py").write_text(TESTS)
    return tmp_path


def fault(old: str, new: str, tests: str = NAMED) -> Fault:
    return Fault("some-fault", "something is wrong", "pcaccess/answers.py", old, new, tests)


def campaign(root: Path, patience: float = 60) -> Campaign:
    return Campaign(root, suite=("tests",), patience=patience)


# the list


@pytest.mark.parametrize("one", faults.ALL, ids=lambda one: one.name)
def test_the_text_of_a_fault_stands_in_its_file_once(one: Fault) -> None:
    """If not, the code has moved: say the same fault in its new words."""
    text = faulty(mutants.ROOT, one)
    assert text != (mutants.ROOT / one.file).read_text(encoding="utf-8")
    compile(text, one.file, "exec")


def test_a_fault_names_tests_that_exist() -> None:
    missing = [
        f"{one.name}: {word}"
        for one in faults.ALL
        for word in one.tests.split()
        if "/" in word and not (mutants.ROOT / word).exists()
    ]
    assert missing == []


def test_faults_have_names_of_their_own() -> None:
    assert [name for name, count in Counter(one.name for one in faults.ALL).items() if count > 1] == []


def test_faults_are_seeded_everywhere() -> None:
    per_file = Counter(one.file for one in faults.ALL)
    compiler = sum(n for file, n in per_file.items() if "llvm" in file or file.endswith("plc/compiler.py"))
    reference = per_file["pcaccess/plc/interpreter.py"] + per_file["pcaccess/stl/evaluate.py"]
    assert (compiler >= 30, reference >= 15, len(faults.ALL) >= 100) == (True, True, True)


# the runner


def test_what_a_test_sees_is_caught_and_what_none_sees_survives(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    chosen = [fault("return 42", "return 41"), fault("Answers.", "Questions.")]
    assert run(campaign(root), chosen, everything=True, workers=2, as_json=False) == 1
    out = capsys.readouterr().out
    assert "caught    some-fault                        tests/test_answers.py::test_the_answer  (" in out
    assert "SURVIVED: some-fault (pcaccess/answers.py): something is wrong\n1 of 2 faults caught in " in out
    assert (root / "pcaccess/answers.py").read_text() == SOURCE


def test_programs_get_an_object_for_each_fault(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(campaign(root), [fault("return 42", "return 41")], everything=False, workers=1, as_json=True) == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert (found["name"], found["outcome"], found["file"]) == ("some-fault", "caught", "pcaccess/answers.py")
    assert found["by"] == "tests/test_answers.py::test_the_answer"


@pytest.mark.parametrize(
    ("old", "new", "by"),
    [
        ("return n", "return n + 1", "tests/test_answers.py::test_a_loop_ends"),
        ("return 42", "import os; os.abort()", "tests/test_answers.py::test_the_answer: the process died of SIGABRT"),
        ("def answer", "def question", "tests/test_answers.py: cannot be collected"),
        ("n -= 1", "pass", "tests/test_answers.py::test_a_loop_ends: does not end"),
    ],
    ids=["only the whole suite sees it", "it kills the process", "it keeps tests from loading", "it hangs"],
)
def test_every_way_of_being_caught_is_told(root: Path, old: str, new: str, by: str) -> None:
    patient = campaign(root, patience=5 if new == "pass" else 60)
    for tests in ("tests", NAMED):
        patient.trust(tests)
    assert patient.try_out(fault(old, new)).by == by


@pytest.mark.parametrize(("old", "times"), [("return 43", 0), ("return ", 2)])
def test_a_fault_whose_text_has_moved_is_stale(root: Path, old: str, times: int) -> None:
    with pytest.raises(Stale, match=f"stands {times} times in pcaccess/answers.py"):
        faulty(root, fault(old, "x"))
    assert campaign(root).try_out(fault(old, "x")).outcome is Outcome.STALE


def test_tests_that_fail_without_a_fault_show_nothing(root: Path) -> None:
    (root / "tests/test_answers.py").write_text(TESTS.replace("== 42", "== 43"))
    with pytest.raises(Unsound, match=r"without any fault: tests/test_answers\.py::test_the_answer"):
        campaign(root).try_out(fault("return 42", "return 41"))


def test_tests_that_are_not_there_show_nothing(root: Path) -> None:
    with pytest.raises(Unsound, match="no tests to run"):
        campaign(root).try_out(fault("return 42", "return 41", "tests/test_answers.py -k unheard_of"))


def test_an_unknown_name_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        mutants.main(["--only", "no-such-fault"])
    assert "there is no fault no-such-fault" in capsys.readouterr().err
