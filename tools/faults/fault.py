"""What a seeded fault is."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Fault:
    """One wrong place in one file."""

    name: str
    what: str
    """What goes wrong with it."""
    file: str
    """From the root of the clone."""
    old: str
    """Stands in the file exactly once."""
    new: str
    tests: str
    """What is tried first, as pytest takes it; some seconds, and likely to find it."""


OPERATIONS = "tests/differential/test_operations.py"
"""Every IR operation, in both executions."""
PROGRAMS = "tests/differential/test_programs.py"
"""Generated programs, in all executions."""


def table(name: str) -> str:
    """The cases of ``tests/conformance/NAME.yaml``, in both executions."""
    return f"tests/conformance/test_conformance.py -k {name}-"
