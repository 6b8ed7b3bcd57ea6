"""The shared program objects: equality, look-ups, words for messages."""

from __future__ import annotations

from pcaccess.problems import Span
from pcaccess.s7200.address import parse_address
from pcaccess.s7200.types import DataType
from pcaccess.stl.program import (
    DataBlock,
    DataRow,
    Direct,
    Network,
    Pou,
    PouKind,
    Program,
    Section,
    Symbol,
    SymbolTable,
    Variable,
)

HERE = Span("a.awl", 1, 1)
THERE = Span("b.awl", 9, 4)


def pou(kind: PouKind, number: int, name: str, variables: tuple[Variable, ...] = ()) -> Pou:
    return Pou(kind, number, name, "", (), variables, (), HERE)


def test_the_place_of_an_operand_takes_no_part_in_comparing() -> None:
    assert Direct(parse_address("VW2"), HERE) == Direct(parse_address("vw2"), THERE)
    assert Direct(parse_address("VW2"), HERE) != Direct(parse_address("VW4"), HERE)


def test_pous_are_found_by_kind_and_number() -> None:
    program = Program((pou(PouKind.SBR, 3, "Pump"), pou(PouKind.MAIN, 1, "MAIN"), pou(PouKind.INT, 3, "INT_3")))
    assert program.main.name == "MAIN"
    assert program.subroutine(3) is program.pous[0]
    assert program.interrupt(3) is program.pous[2]
    assert program.subroutine(4) is None


def test_a_pou_tells_where_something_is_in_the_users_words() -> None:
    network = Network(3, "", (), (), HERE)
    assert pou(PouKind.MAIN, 1, "PRINCIPAL").where(network) == "PRINCIPAL (OB1), network 3"
    assert pou(PouKind.SBR, 0, "SBR0").where() == "SBR0"


def test_call_parameters_come_in_the_order_in_then_in_out_then_out() -> None:
    def variable(name: str, section: Section) -> Variable:
        return Variable(name, section, DataType.BYTE, parse_address("LB0"), "", HERE)

    declared = (variable("o", Section.OUT), variable("t", Section.TEMP), variable("i", Section.IN))
    assert [v.name for v in pou(PouKind.SBR, 0, "S", declared).parameters] == ["i", "o"]


def test_symbols_are_found_without_regard_to_case_and_by_address() -> None:
    table = SymbolTable([Symbol("Motor 1", parse_address("Q0.0"), "Q0.0", "", HERE)])
    found = table.find("MOTOR 1")
    assert found is not None
    assert found.name == table.name_of(parse_address("Q0.0")) == "Motor 1"
    assert table.find("Motor") is None


def test_data_rows_beyond_v_memory_are_left_out() -> None:
    memory = bytearray(4)
    DataBlock((DataRow(1, b"\x05", "VB1 5", HERE), DataRow(3, b"\x01\x02", "VW3 258", HERE))).write_to(memory)
    assert memory == b"\x00\x05\x00\x00"
