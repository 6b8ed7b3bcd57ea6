"""Both executions ask the CPU for the same, in the same order, and obey its answers."""

from __future__ import annotations

import pytest

from pcaccess.stl import ir, layout
from pcaccess.stl.builder import Builder
from pcaccess.stl.ir_values import IrType
from tests.differential.executions import COMPILED
from tests.differential.side_by_side import Pair, function, module

ATTENTION = bytes(layout.ATTENTION) + b"\1"
"""A memory in which polls have something to do."""
NAMES = ("poll", "out_of_budget", "fault")


def outer(b: Builder) -> None:
    b.store_at(0, b.const(IrType.U8, 1))
    b.emit(ir.CallPou(1))
    b.store_at(1, b.const(IrType.U8, 1))


def inner(b: Builder) -> None:
    b.emit(ir.Budget(5))
    b.emit(ir.Fault(b.const(IrType.I32, 6), 3))
    b.emit(ir.Poll(4))
    b.store_at(2, b.const(IrType.U8, 1))


@pytest.fixture(scope="module", params=COMPILED)
def pair(request: pytest.FixtureRequest) -> Pair:
    return Pair(module([function(outer), function(inner)]), COMPILED[request.param])


@pytest.mark.parametrize("unwinds", ["", *NAMES])
def test_what_the_cpu_says_is_obeyed(pair: Pair, unwinds: str) -> None:
    """fault answers nothing, so it cannot end anything."""
    asked = [("out_of_budget", (5,)), ("fault", (6, 3)), ("poll", (4,))]
    is_unwound = unwinds in ("poll", "out_of_budget")
    for recorder, executor in zip(pair.recorders, pair.executors, strict=True):
        recorder.calls.clear()
        recorder.answers = {unwinds: True}
        recorder.memory[: len(ATTENTION)] = ATTENTION
        assert executor.run(0) == is_unwound
        assert recorder.calls == (asked[:1] if unwinds == "out_of_budget" else asked)
        assert recorder.memory[:3] == (b"\1\0\0" if is_unwound else b"\1\1\1")


def test_a_poll_without_attention_is_not_asked(pair: Pair) -> None:
    for recorder in pair.recorders:
        recorder.calls.clear()
        recorder.answers = {}
    pair.run(b"")
    for recorder in pair.recorders:
        assert [name for name, _ in recorder.calls] == ["out_of_budget", "fault"]
