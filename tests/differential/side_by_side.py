"""Runs one IR module in the reference interpreter and another executor, each in a memory of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import MappingProxyType

from pcaccess.plc.executor import Executor, MakeExecutor
from pcaccess.plc.interpreter import Interpreter
from pcaccess.plc.peripherals import AbsentPeripherals
from pcaccess.stl import ir, layout
from pcaccess.stl.builder import Builder
from pcaccess.stl.runtime import OK, Outcome, Peripherals

BUFFER = bytes(layout.BUFFER_SIZE)


class Recorder:
    """A ``Runtime`` that writes down what it was asked."""

    def __init__(self) -> None:
        self.memory = bytearray(BUFFER)
        self.peripherals: Peripherals = AbsentPeripherals()
        self.calls: list[tuple[str, tuple[object, ...]]] = []
        self.answers: dict[str, bool] = {}
        self.hooks: dict[str, Callable[[], None]] = {}

    def _asked(self, name: str, *arguments: object) -> bool:
        self.calls.append((name, arguments))
        if name in self.hooks:
            self.hooks[name]()
        return self.answers.get(name, False)

    def fault(self, code: int, place: int) -> None:
        self._asked("fault", int(code), place)

    def poll(self, network: int) -> bool:
        return self._asked("poll", network)

    def out_of_budget(self, place: int) -> bool:
        return self._asked("out_of_budget", place)

    def request_stop(self) -> None:
        self._asked("request_stop")

    def reset_watchdog(self) -> None:
        self._asked("reset_watchdog")

    def attach(self, event: int, routine: int) -> Outcome:
        self._asked("attach", event, routine)
        return OK

    def detach(self, event: int) -> Outcome:
        self._asked("detach", event)
        return OK

    def enable_interrupts(self, on: bool) -> Outcome:
        self._asked("enable_interrupts", on)
        return OK

    def room(self, address: int) -> int:
        return 0


def module(functions: Sequence[ir.Function], pointers: Sequence[ir.PointerArea] = ()) -> ir.Module:
    """A module whose functions can all be run; function 0 is the main program."""
    return ir.Module(
        functions=tuple(functions),
        main=0,
        interrupts=MappingProxyType({n: n for n in range(1, len(functions))}),
        places=(),
        pointers=tuple(pointers),
        networks=1,
        edges=0,
    )


def function(body: Callable[[Builder], None]) -> ir.Function:
    b = Builder(body.__name__)
    body(b)
    b.terminate(ir.Return())
    return b.function


class Pair:
    """The interpreter and another executor of one module, with what each of their programs asked for."""

    def __init__(self, program: ir.Module, make: MakeExecutor) -> None:
        self.recorders = (Recorder(), Recorder())
        self.executors: tuple[Executor, Executor] = (
            Interpreter(program, self.recorders[0]),
            make(program, self.recorders[1]),
        )

    def run(self, memory: bytes, function: int = 0) -> tuple[bytes, bytes]:
        """Both memories after ``function`` ran on ``memory`` (filled up with zeros)."""
        for recorder, executor in zip(self.recorders, self.executors, strict=True):
            recorder.memory[:] = memory + bytes(len(BUFFER) - len(memory))
            executor.run(function)
        return bytes(self.recorders[0].memory), bytes(self.recorders[1].memory)
