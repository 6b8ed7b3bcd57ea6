"""Laws that hold for all operands: instructions against each other and against Python's own arithmetic."""

from __future__ import annotations

import struct
from typing import Any

import pytest
from conformance import EXECUTORS
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.plc.cpu import Cpu
from pcaccess.s7200.address import Area, parse_address
from pcaccess.s7200.cpu import cpu_model
from pcaccess.s7200.memory import AREA_START, read_value, write_value
from pcaccess.s7200.types import DataType, Value
from tests.plc.conftest import program

BYTE, WORD, DWORD = DataType.BYTE, DataType.WORD, DataType.DWORD
INT, DINT, REAL, STRING = DataType.INT, DataType.DINT, DataType.REAL, DataType.STRING
words = st.integers(0, 0xFFFF)
doubles = st.integers(0, 0xFFFF_FFFF)
bytes_ = st.integers(0, 0xFF)
integers = st.integers(-0x8000, 0x7FFF)
reals = st.floats(width=32, allow_nan=False, allow_infinity=False)
texts = st.text(st.characters(min_codepoint=32, max_codepoint=255), max_size=40)


class Machine:
    """One program on one CPU, run again and again on other memory."""

    def __init__(self, text: str, executor: str) -> None:
        self.cpu = Cpu(cpu_model("CPU 224"), program(f"LD SM0.0\n{text}\n"), make_executor=EXECUTORS[executor])
        self.cpu.run(0.0)
        self.now = 0.0

    def run(self, **given: tuple[DataType, Value]) -> Any:
        for name, (kind, value) in given.items():
            write_value(self.cpu.memory, parse_address(name).as_type(kind), kind, value)
        self.now += 10
        self.cpu.scan(self.now)
        return self

    def get(self, name: str, kind: DataType) -> Any:
        return read_value(self.cpu.memory, parse_address(name).as_type(kind), kind)


@pytest.fixture(params=list(EXECUTORS))
def executor(request: pytest.FixtureRequest) -> str:
    return request.param


def test_left_then_right_is_the_value_without_its_upper_bits(executor: str) -> None:
    machine = Machine("SLD VD0, VB8\nSRD VD0, VB8", executor)

    @given(doubles, st.integers(0, 32))
    def law(value: int, count: int) -> None:
        machine.run(VD0=(DWORD, value), VB8=(BYTE, count))
        assert machine.get("VD0", DWORD) == (value & (0xFFFF_FFFF >> count) if count < 32 else 0)

    law()


@pytest.mark.parametrize(("letter", "kind"), [("B", BYTE), ("W", WORD), ("D", DWORD)])
def test_a_rotation_back_restores_the_value(executor: str, letter: str, kind: DataType) -> None:
    machine = Machine(f"RL{letter} V{letter}0, VB8\nRR{letter} V{letter}0, VB8", executor)

    @given(st.integers(0, kind.high), bytes_)
    def law(value: int, count: int) -> None:
        machine.run(**{f"V{letter}0": (kind, value), "VB8": (BYTE, count)})
        assert machine.get(f"V{letter}0", kind) == value

    law()


@pytest.mark.parametrize(("letter", "kind"), [("B", BYTE), ("W", WORD), ("D", DWORD)])
def test_a_rotation_is_two_shifts(executor: str, letter: str, kind: DataType) -> None:
    bits = kind.size * 8
    machine = Machine(f"RL{letter} V{letter}0, VB8", executor)

    @given(st.integers(0, kind.high), bytes_)
    def law(value: int, count: int) -> None:
        machine.run(**{f"V{letter}0": (kind, value), "VB8": (BYTE, count)})
        n = count % bits
        assert machine.get(f"V{letter}0", kind) == (value << n | value >> bits - n) & kind.high

    law()


@pytest.mark.parametrize(("suffix", "kind"), [("I", INT), ("D", DINT)])
def test_adding_and_subtracting_undo_each_other_or_change_nothing(executor: str, suffix: str, kind: DataType) -> None:
    letter = "W" if kind is INT else "D"
    machine = Machine(f"+{suffix} V{letter}0, V{letter}4\nAENO\n= M0.0\n-{suffix} V{letter}0, V{letter}4", executor)

    @given(st.integers(kind.low, kind.high), st.integers(kind.low, kind.high))
    def law(a: int, b: int) -> None:
        machine.run(**{f"V{letter}0": (kind, a), f"V{letter}4": (kind, b)})
        assert machine.get(f"V{letter}4", kind) == b
        assert machine.get("M0.0", DataType.BOOL) == (kind.low <= a + b <= kind.high)

    law()


def test_division_gives_quotient_and_remainder(executor: str) -> None:
    machine = Machine("DIV VW0, VD4\nMOVW VW4, VW12\nMUL VW0, VD4\nITD VW12, VD16\n+D VD16, VD4", executor)

    @given(integers, integers)
    def law(divisor: int, dividend: int) -> None:
        if divisor == 0 or (dividend, divisor) == (-0x8000, -1):
            return
        machine.run(VW0=(INT, divisor), VW6=(INT, dividend))
        assert machine.get("VD4", DINT) == dividend
        assert abs(machine.get("VW12", INT)) < abs(divisor)

    law()


def test_real_arithmetic_is_that_of_ieee_754_single_precision(executor: str) -> None:
    machine = Machine("MOVR VD0, VD8\n*R VD4, VD8\nAENO\n= M0.0", executor)

    @given(reals, reals)
    def law(a: float, b: float) -> None:
        machine.run(VD0=(REAL, a), VD4=(REAL, b), VD8=(REAL, 0.0))
        try:
            (exact,) = struct.unpack(">f", struct.pack(">f", a * b))
        except OverflowError:
            assert not machine.get("M0.0", DataType.BOOL)
            return
        assert machine.get("VD8", REAL) == exact

    law()


def test_bcd_there_and_back_is_the_number(executor: str) -> None:
    machine = Machine("IBCD VW0\nBCDI VW0", executor)

    @given(st.integers(0, 9999))
    def law(number: int) -> None:
        machine.run(VW0=(WORD, number))
        assert machine.get("VW0", WORD) == number

    law()


def test_encode_undoes_decode(executor: str) -> None:
    machine = Machine("DECO VB0, VW2\nENCO VW2, VB4", executor)

    @given(bytes_)
    def law(number: int) -> None:
        machine.run(VB0=(BYTE, number))
        assert machine.get("VB4", BYTE) == number & 0xF

    law()


def test_swapping_twice_and_inverting_twice_change_nothing(executor: str) -> None:
    machine = Machine("SWAP VW0\nINVW VW0\nSWAP VW0\nINVW VW0", executor)

    @given(words)
    def law(number: int) -> None:
        machine.run(VW0=(WORD, number))
        assert machine.get("VW0", WORD) == number

    law()


def test_hex_to_ascii_and_back_is_the_same(executor: str) -> None:
    machine = Machine("HTA VB0, VB100, 8\nATH VB100, VB200, 8", executor)

    @given(doubles)
    def law(number: int) -> None:
        machine.run(VD0=(DWORD, number))
        assert machine.get("VD200", DWORD) == number

    law()


def test_what_is_put_into_a_table_comes_out_in_order(executor: str) -> None:
    machine = Machine(
        "MOVW 3, VW100\nMOVW 0, VW102\nATT VW0, VW100\nATT VW2, VW100\nATT VW4, VW100\n"
        "LIFO VW100, VW10\nFIFO VW100, VW12\nFIFO VW100, VW14",
        executor,
    )

    @given(integers, integers, integers)
    def law(a: int, b: int, c: int) -> None:
        machine.run(VW0=(INT, a), VW2=(INT, b), VW4=(INT, c))
        assert [machine.get(name, INT) for name in ("VW10", "VW12", "VW14", "VW102")] == [c, a, b, 0]

    law()


def test_the_parts_of_a_string_make_the_string(executor: str) -> None:
    machine = Machine(
        "SLEN VB0, VB90\nSSCPY VB0, 1, VB91, VB100\nMOVB VB91, VB92\nINCB VB92\nSSCPY VB0, VB92, 255, VB200\n"
        "SCAT VB200, VB100",
        executor,
    )

    @given(texts, st.integers(0, 255))
    def law(text: str, at: int) -> None:
        if not text:
            return
        at %= len(text)
        machine.run(VB0=(STRING, text), VB91=(BYTE, at))
        assert machine.get("VB100", STRING) == text
        assert machine.get("VB90", BYTE) == len(text)

    law()


def test_what_lps_pushes_lpp_gives_back(executor: str) -> None:
    cpu = Cpu(
        cpu_model("CPU 224"),
        program("LD I0.0\nLPS\nA I0.1\nLPS\nO I0.2\n= Q0.2\nLPP\n= Q0.1\nLPP\n= Q0.0\n"),
        make_executor=EXECUTORS[executor],
    )
    cpu.run(0.0)
    for inputs in range(8):
        cpu.set_inputs(bytes((inputs,)))
        cpu.scan(10.0 * inputs)
        a, b, c = inputs & 1, inputs >> 1 & 1, inputs >> 2 & 1
        assert cpu.outputs[0] == a | (a & b) << 1 | (a & b | c) << 2


@pytest.mark.parametrize("sign", ["=", "<>", ">=", "<=", ">", "<"])
def test_a_compare_and_its_opposite_never_agree(executor: str, sign: str) -> None:
    opposite = {"=": "<>", "<>": "=", ">=": "<", "<": ">=", "<=": ">", ">": "<="}[sign]
    machine = Machine(f"LDW{sign} VW0, VW2\n= M0.0\nLDW{opposite} VW0, VW2\n= M0.1", executor)

    @given(integers, integers)
    def law(a: int, b: int) -> None:
        machine.run(VW0=(INT, a), VW2=(INT, b))
        assert machine.get("M0.0", DataType.BOOL) != machine.get("M0.1", DataType.BOOL)

    law()


def test_a_block_move_is_what_python_does_with_slices(executor: str) -> None:
    machine = Machine("BMB *AC1, *AC2, VB100", executor)

    @given(st.binary(min_size=40, max_size=40), st.integers(0, 19), st.integers(0, 19), st.integers(1, 20))
    def law(data: bytes, source: int, to: int, count: int) -> None:
        v = AREA_START[Area.V]
        machine.cpu.memory[v : v + 40] = data
        machine.run(AC1=(DWORD, 0x0800_0000 + source), AC2=(DWORD, 0x0800_0000 + to), VB100=(BYTE, count))
        expected = bytearray(data)
        expected[to : to + count] = data[source : source + count]
        assert bytes(machine.cpu.memory[v : v + 40]) == bytes(expected)

    law()
