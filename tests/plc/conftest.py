"""Programs in a line, and CPUs that run them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from pcaccess.plc.cpu import Cpu
from pcaccess.s7200.address import parse_address
from pcaccess.s7200.cpu import cpu_model
from pcaccess.s7200.types import DataType, Value
from pcaccess.stl.checker import load_program
from pcaccess.stl.program import Program


def program(text: str) -> Program:
    return load_program(text.encode("latin-1"), cpu_model("CPU 224"), file="test.awl").unwrap()


class Bench:
    """A CPU in RUN, with addresses as text."""

    def __init__(self, text: str, **more: Any) -> None:
        self.cpu = Cpu(cpu_model("CPU 224"), program(text), **more)
        self.cpu.run(0.0)
        self.now = 0.0

    def scan(self, *, after: float = 0.0, load: float = 0.0) -> None:
        """One scan, ``after`` ms later than the one before."""
        self.now += after
        self.cpu.scan(self.now, load=load)

    def write(self, address: str, data_type: DataType, value: Value) -> None:
        self.cpu.write(parse_address(address), data_type, value)

    def bit(self, address: str) -> int:
        return int(self.cpu.read(parse_address(address), DataType.BOOL))

    def word(self, address: str) -> Value:
        return self.cpu.read(parse_address(address), DataType.INT)

    def byte(self, address: str) -> Value:
        return self.cpu.read(parse_address(address), DataType.BYTE)


@pytest.fixture
def bench() -> Callable[..., Bench]:
    return Bench
