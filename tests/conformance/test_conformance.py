"""Every case of every table, on every execution."""

from __future__ import annotations

import pytest
from conformance import EXECUTORS, Case, compile_case, load_cases, run_case

from pcaccess.plc.cpu import Mode
from pcaccess.problems import ProblemError
from pcaccess.stl.errors import FatalError
from pcaccess.stl.ir_check import verify
from pcaccess.stl.lower import lower

CASES = [case for case in load_cases() if case.problem is None]
REFUSED = [case for case in load_cases() if case.problem is not None]


@pytest.mark.parametrize("executor", EXECUTORS)
@pytest.mark.parametrize("case", CASES, ids=str)
def test_case(case: Case, executor: str) -> None:
    seen = run_case(case, EXECUTORS[executor])
    fatal = case.stop if case.stop in {str(code) for code in FatalError} else None
    assert seen.differences == [], case.why
    assert sorted(set(seen.faults)) == [code for code in (case.fault or fatal,) if code is not None]
    assert seen.mode is (Mode.STOP if case.stop else Mode.RUN)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_the_ir_of_a_case_is_well_formed(case: Case) -> None:
    for function in lower(compile_case(case), case.model).functions:
        verify(function)


@pytest.mark.parametrize("case", REFUSED, ids=str)
def test_the_checker_refuses(case: Case) -> None:
    with pytest.raises(ProblemError) as refused:
        compile_case(case)
    assert [problem.code for problem in refused.value.problems if problem.is_error] == [case.problem]
