"""Everything that can be wrong with a scenario, with its code. Each has a page in docs/problems."""

from __future__ import annotations

from typing import Final

from pcaccess.problems import Kind, Register

SCENARIO: Final = Register(
    {
        "SCN001": Kind("the scenario cannot be read"),
        "SCN002": Kind("an unknown key in a scenario"),
        "SCN003": Kind("a missing key in a scenario"),
        "SCN004": Kind("a wrong value in a scenario"),
        "SCN005": Kind("a place in a scenario that does not exist"),
        "SCN006": Kind("a value in a scenario that does not fit its place"),
        "SCN007": Kind("the program of a scenario cannot be opened"),
    }
)
