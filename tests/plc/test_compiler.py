"""Compiled code and its surroundings: what it asks Python for, what ends it, when it is optimised, what replaces it."""

from __future__ import annotations

import logging
import mmap
import threading
from collections.abc import Callable
from typing import Any

import pytest

from pcaccess.plc import compiler
from pcaccess.plc.compiler import Compiled, make_executor, why_unavailable
from pcaccess.plc.interpreter import Interpreter
from pcaccess.plc.llvm import machine
from pcaccess.stl import ir, layout
from pcaccess.stl.builder import Builder
from pcaccess.stl.ir_values import IrType
from pcaccess.stl.runtime import Runtime
from tests.clocks import HandClock
from tests.differential.side_by_side import Recorder, function, module

Body = Callable[[Builder], None]


def program(*bodies: Body, **options: Any) -> tuple[Compiled, Recorder]:
    recorder = Recorder()
    return Compiled(module([function(body) for body in bodies]), recorder, optimise=False, **options), recorder


def mark(b: Builder, at: int = 0) -> None:
    b.store_at(at, b.const(IrType.U8, 1))


# what compiled code asks for


def test_a_poll_asks_only_when_there_is_something_to_do() -> None:
    executor, recorder = program(lambda b: b.emit(ir.Poll(7)))
    executor.run(0)
    assert recorder.calls == []
    recorder.memory[layout.ATTENTION] = 1
    executor.run(0)
    assert recorder.calls == [("poll", (7,))]


def test_a_poll_that_unwinds_ends_every_function_around_it() -> None:
    def inner(b: Builder) -> None:
        b.emit(ir.Poll(-1))
        mark(b, 0)

    def outer(b: Builder) -> None:
        b.emit(ir.CallPou(1))
        mark(b, 1)

    executor, recorder = program(outer, inner)
    recorder.memory[layout.ATTENTION] = 1
    recorder.answers["poll"] = True
    assert executor.run(0)
    assert recorder.memory[:2] == b"\0\0"
    recorder.answers["poll"] = False
    assert not executor.run(0)
    assert recorder.memory[:2] == b"\1\1"


def endless(b: Builder) -> None:
    loop = b.new_block()
    b.jump(loop)
    b.start(loop)
    b.emit(ir.Budget(7))
    b.jump(loop)
    b.start(b.new_block())


def test_the_budget_ends_an_endless_loop() -> None:
    executor, recorder = program(endless)
    recorder.memory[layout.BUDGET : layout.BUDGET + 4] = (1000).to_bytes(4, "big")
    recorder.answers["out_of_budget"] = True
    assert executor.run(0)
    assert recorder.calls == [("out_of_budget", (7,))]
    assert recorder.memory[layout.BUDGET : layout.BUDGET + 4] == bytes(4)


def test_a_loop_goes_on_when_the_budget_is_filled_again() -> None:
    executor, recorder = program(endless)
    fillings = iter((5, 5, 0))

    def fill() -> None:
        more = next(fillings)
        recorder.answers["out_of_budget"] = more == 0
        recorder.memory[layout.BUDGET : layout.BUDGET + 4] = more.to_bytes(4, "big")

    recorder.hooks["out_of_budget"] = fill
    assert executor.run(0)
    assert len(recorder.calls) == 3


def test_a_fault_says_code_and_place_and_the_program_goes_on() -> None:
    def body(b: Builder) -> None:
        b.place = 12
        b.emit(ir.Fault(b.load_at(IrType.I32, 8), 12))
        mark(b)

    executor, recorder = program(body)
    recorder.memory[8:12] = (6).to_bytes(4, "big")
    executor.run(0)
    assert recorder.calls == [("fault", (6, 12))]
    assert recorder.memory[0] == 1


def test_arguments_and_results_of_cold_instructions_keep_their_values() -> None:
    seen: list[tuple[object, ...]] = []

    def keep(_: Runtime, name: str, *arguments: float) -> float:
        seen.append((name, *arguments))
        return -2.5

    def body(b: Builder) -> None:
        kinds = (IrType.I8, IrType.U8, IrType.I16, IrType.U16, IrType.I32, IrType.U32)
        loads = [b.load_at(kind, 0) for kind in kinds]
        real, bit = b.load_at(IrType.F32, 4), b.load_bit(0, 7)
        wide = b.convert(loads[-1], IrType.U64)
        out = b.call(
            keep, *loads, real, b.convert(real, IrType.F64), bit, b.shl(wide, 32), static=("x",), result=IrType.F32
        )
        assert out is not None
        b.store_at(8, out)

    executor, recorder = program(body)
    recorder.memory[0:8] = bytes.fromhex("FFFEFDFC 3FC00000")
    executor.run(0)
    assert seen == [("x", -1, 255, -2, 0xFFFE, -0x10204, 0xFFFEFDFC, 1.5, 1.5, 1, 0xFFFEFDFC << 32)]
    assert recorder.memory[8:12] == bytes.fromhex("C0200000")


@pytest.mark.parametrize(("kind", "answer"), [(IrType.I32, -7), (IrType.U8, 200), (IrType.I1, True), (IrType.F64, 0.1)])
def test_every_kind_of_result_arrives(kind: IrType, answer: float) -> None:
    def body(b: Builder) -> None:
        out = b.call(lambda _: answer, result=kind)
        assert out is not None
        equal = b.eq(out, answer)
        b.store_bit(0, 0, equal)

    executor, recorder = program(body)
    executor.run(0)
    assert recorder.memory[0] == 1


# exceptions


class Broken(Exception):
    pass


def fails(_: Runtime) -> None:
    raise Broken


def test_an_exception_of_a_cold_instruction_comes_out_where_the_code_was_run() -> None:
    def body(b: Builder) -> None:
        mark(b, 0)
        b.call(fails)
        mark(b, 1)

    executor, recorder = program(body)
    with pytest.raises(Broken):
        executor.run(0)
    assert recorder.memory[:2] == b"\1\0"


def test_code_runs_again_after_an_exception() -> None:
    answers = iter([True, False])

    def sometimes(_: Runtime) -> None:
        if next(answers):
            raise Broken

    def body(b: Builder) -> None:
        b.call(sometimes)
        mark(b)

    executor, recorder = program(body)
    with pytest.raises(Broken):
        executor.run(0)
    executor.run(0)
    assert recorder.memory[0] == 1


@pytest.mark.parametrize("asked", ["poll", "out_of_budget", "fault"])
def test_an_exception_of_the_cpu_comes_out_too(asked: str) -> None:
    operations = {"poll": ir.Poll(0), "out_of_budget": ir.Budget(7)}

    def body(b: Builder) -> None:
        b.emit(operations.get(asked) or ir.Fault(b.const(IrType.I32, 6), 0))
        mark(b)

    def fail() -> None:
        raise Broken

    executor, recorder = program(body)
    recorder.memory[layout.ATTENTION] = 1
    recorder.hooks[asked] = fail
    with pytest.raises(Broken):
        executor.run(0)
    assert recorder.memory[0] == 0


def test_an_exception_in_an_interrupt_routine_ends_what_it_interrupted() -> None:
    def main(b: Builder) -> None:
        b.emit(ir.Poll(0))
        mark(b)

    executor, recorder = program(main, lambda b: b.call(fails) and None)
    recorder.memory[layout.ATTENTION] = 1
    recorder.hooks["poll"] = lambda: executor.run(1) and None
    with pytest.raises(Broken):
        executor.run(0)
    assert recorder.memory[0] == 0


# running


def test_an_interrupt_routine_runs_within_the_program() -> None:
    def main(b: Builder) -> None:
        kept = b.load_at(IrType.U8, 0)
        b.emit(ir.Poll(0))
        b.store_at(2, kept)

    def routine(b: Builder) -> None:
        b.store_at(0, b.const(IrType.U8, 9))

    executor, recorder = program(main, routine)
    recorder.memory[0] = 4
    recorder.memory[layout.ATTENTION] = 1
    recorder.hooks["poll"] = lambda: executor.run(1) and None
    executor.run(0)
    assert recorder.memory[0] == 9
    assert recorder.memory[2] == 4


def test_a_scan_does_not_hold_the_interpreter_lock() -> None:
    """The loop ends because another thread writes a byte; with the lock it would end by its budget."""

    def wait(b: Builder) -> None:
        loop, after = b.new_block(), b.new_block()
        b.jump(loop)
        b.start(loop)
        b.emit(ir.Budget(7))
        b.branch(b.load_bit(0, 0), after, loop)
        b.start(after)

    executor, recorder = program(wait)
    recorder.memory[layout.BUDGET : layout.BUDGET + 4] = b"\xff" * 4
    recorder.answers["out_of_budget"] = True
    scanning = threading.Thread(target=executor.run, args=(0,))
    scanning.start()
    recorder.memory[0] = 1
    scanning.join()
    assert recorder.calls == []


def test_the_memory_can_be_a_map_that_processes_share() -> None:
    recorder = Recorder()
    shared = mmap.mmap(-1, layout.BUFFER_SIZE)
    recorder.memory = memoryview(shared)  # type: ignore[assignment]
    Compiled(module([function(mark)]), recorder, optimise=False).run(0)
    assert shared[0] == 1


def test_frames_of_local_memory_never_leave_the_buffer() -> None:
    """A damaged depth costs values, not the process."""

    def body(b: Builder) -> None:
        b.emit(ir.PushFrame())

    recorder = Recorder()
    around = bytearray(layout.BUFFER_SIZE + 256 * layout.FRAME_SIZE)
    recorder.memory = memoryview(around)[: layout.BUFFER_SIZE]  # type: ignore[assignment]
    recorder.memory[: layout.CALL_DEPTH + 1] = b"\xff" * (layout.CALL_DEPTH + 1)
    Compiled(module([function(body)]), recorder, optimise=False).run(0)
    assert recorder.memory[layout.CALL_DEPTH] == 0
    assert not any(around[layout.BUFFER_SIZE :])


# optimising


def test_better_code_is_taken_over_at_the_next_scan_and_does_the_same() -> None:
    def count(b: Builder) -> None:
        b.store_at(0, b.add(b.load_at(IrType.I16, 0), 1))

    executor, recorder = program(count)
    executor.run(0)
    executor.start_optimising()
    executor.run(0)
    executor.finish_optimising()
    assert executor.name == "compiled, optimised"
    executor.run(0)
    assert recorder.memory[:2] == b"\0\3"


class FakeOptimiser:
    """Has what the real one would make, as soon as it is told to."""

    made: list[FakeOptimiser]

    def __init__(self, text: str) -> None:
        self.code = machine.object_code(text, machine.Tier.QUICK)
        self.is_running = True
        self.failure: RuntimeError | None = None
        self.cancelled = False
        FakeOptimiser.made.append(self)

    def wait(self) -> None:
        self.is_running = False

    def result(self) -> bytes:
        if self.failure:
            raise self.failure
        return self.code

    def cancel(self) -> None:
        self.cancelled = True


@pytest.fixture
def optimisers(monkeypatch: pytest.MonkeyPatch) -> list[FakeOptimiser]:
    FakeOptimiser.made = []
    monkeypatch.setattr(compiler, "Optimiser", FakeOptimiser)
    return FakeOptimiser.made


class SlowScans(HandClock):
    """Every question for the time takes some."""

    def __init__(self, seconds: float) -> None:
        super().__init__()
        self._seconds = seconds

    def monotonic(self) -> float:
        self.move(self._seconds)
        return super().monotonic()


def scans_until_optimising(optimisers: list[FakeOptimiser], seconds: float) -> int:
    executor = Compiled(module([function(mark)]), Recorder(), clock=SlowScans(seconds))
    for number in range(100_000):
        executor.run(0)
        if optimisers:
            return number
    return -1


def test_a_program_is_optimised_when_scanning_has_cost_as_much_as_optimising_would(
    optimisers: list[FakeOptimiser],
) -> None:
    slow = scans_until_optimising(optimisers, 0.010)
    optimisers.clear()
    fast = scans_until_optimising(optimisers, 0.001)
    assert 30 < slow < 200
    assert fast > 5 * slow


def test_code_changes_between_scans_only(optimisers: list[FakeOptimiser]) -> None:
    executor, recorder = program(lambda b: b.emit(ir.Poll(0)), mark)
    executor.start_optimising()
    names = []

    def interrupt() -> None:
        optimisers[0].wait()
        executor.run(1)
        names.append(executor.name)

    recorder.hooks["poll"] = interrupt
    recorder.memory[layout.ATTENTION] = 1
    executor.run(0)
    executor.run(0)
    assert names == ["compiled", "compiled, optimised"]


def test_a_failed_optimisation_leaves_the_program_as_it_is(
    optimisers: list[FakeOptimiser], caplog: pytest.LogCaptureFixture
) -> None:
    executor, recorder = program(mark)
    executor.start_optimising()
    optimisers[0].failure = RuntimeError("optimising ended with -9")
    optimisers[0].wait()
    executor.run(0)
    assert executor.name == "compiled"
    assert recorder.memory[0] == 1
    assert "optimising ended with -9" in caplog.text


def test_closing_gives_up_the_background_work(optimisers: list[FakeOptimiser]) -> None:
    executor, _ = program(mark)
    executor.start_optimising()
    executor.close()
    assert optimisers[0].cancelled


# where there is no compiler


@pytest.fixture
def no_llvm(monkeypatch: pytest.MonkeyPatch) -> None:
    def unavailable() -> None:
        raise machine.Unavailable("llvmlite is not installed (mips)")

    monkeypatch.setattr(machine, "_binding", unavailable)


@pytest.mark.usefixtures("no_llvm")
def test_without_llvm_the_interpreter_runs_and_the_log_says_why(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        executor = make_executor(module([function(mark)]), Recorder())
    assert isinstance(executor, Interpreter)
    assert "llvmlite is not installed (mips)" in caplog.text
    assert why_unavailable() == "llvmlite is not installed (mips)"


def test_with_llvm_programs_are_compiled() -> None:
    assert make_executor(module([function(mark)]), Recorder()).name == "compiled"
    assert why_unavailable() is None
