"""A fixed part of what ``make fuzz`` does: mutated programs must not raise, hang or lose a listing."""

from __future__ import annotations

import random

import pytest
from fuzz_reader import complaint, mutant, seeds

from pcaccess.stl.checker import load_program

CORPUS = seeds()
PATIENCE = 20.0
"""Seconds; each takes about one here, and minutes when something is quadratic."""
CHAIN = b"SUBROUTINE_BLOCK S%d:SBR%d\nBEGIN\nNetwork 1\nLD I0.0\nCALL S%d\nEND_SUBROUTINE_BLOCK\n"


@pytest.mark.parametrize("start", range(0, 1000, 100))
def test_mutated_programs_break_no_promise(start: int) -> None:
    for seed in range(start, start + 100):
        wrong = complaint(mutant(random.Random(seed), CORPUS), slow=PATIENCE)
        assert wrong is None, f"seed {seed}: {wrong}"


def test_the_seeds_hold_programs_of_every_kind() -> None:
    results = [load_program(seed) for seed in CORPUS]
    assert sum(1 for result in results if result.ok) > 50
    assert sum(1 for result in results if not result.ok) > 50


@pytest.mark.parametrize(
    "data",
    [
        b"_BLOCK\n" * 20_000,
        b"LD a,\n" + b"b,\n" * 30_000,
        b"BEG X:OB1\n" * 10_000,
        b"LD I0.0\n" * 20_000,
        b"LD " + b"a " * 1900 + b"\n",
        b"LD I0.0," * 5_000,
        b"//" + b" " * 100_000 + b"x",
        b"SUBROUTINE_BLOCK " + b"x " * 1900 + b":SBR",
        b"".join(CHAIN % (n, n, n + 1) for n in range(2_000)),
        b"CALL SBR_0\n" * 20_000 + b"SBR 0\nCALL 0\n",
        b"LD I0.0\n//SYMBOL_TABLE\n" + b"//x\tQ0.0\n" * 10_000,
        b"LD I0.0\n//DATA_BLOCK\n" + b"//VB0 'aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa'\n" * 5_000,
        b"nonsense%d VB0\n" * 5_000,
        "// é".encode("cp1252") * 50_000,
    ],
    ids=range(14),
)  # fmt: skip
def test_hopeless_files_take_no_more_than_linear_time(data: bytes) -> None:
    assert complaint(data, slow=PATIENCE) is None
