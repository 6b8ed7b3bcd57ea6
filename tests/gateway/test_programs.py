"""The programs of a project, read before anything runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from pcaccess.gateway.programs import load_programs
from pcaccess.problems import ProblemError
from pcaccess.project.load import load_text

PROJECT = """
links:
  - name: L
    type: soft
    plcs:
      - {name: A, address: 2, cpu: CPU 226, program: shared.awl, items: []}
      - {name: B, address: 3, cpu: CPU 226, program: shared.awl, items: []}
      - {name: C, address: 4, cpu: CPU 221, program: shared.awl, items: []}
"""


def test_plcs_may_share_a_program(tmp_path: Path) -> None:
    (tmp_path / "shared.awl").write_text("LD I0.0\n= Q0.0\n")
    programs = load_programs(load_text(PROJECT, base=tmp_path).project)
    assert set(programs.by_station) == {"L.A", "L.B", "L.C"}


@pytest.mark.parametrize(
    ("text", "codes"),
    [("LD I0.0\nBLINK Q0.0\n", ["STL020"]), ("LD SM0.0\nMOVW 1, VW5000\n", ["STL024"])],
    ids=["on every CPU", "on the small CPU"],
)
def test_a_mistake_of_a_shared_program_is_told_once(tmp_path: Path, text: str, codes: list[str]) -> None:
    (tmp_path / "shared.awl").write_text(text)
    with pytest.raises(ProblemError) as wrong:
        load_programs(load_text(PROJECT, base=tmp_path).project)
    assert [problem.code for problem in wrong.value.problems] == codes
