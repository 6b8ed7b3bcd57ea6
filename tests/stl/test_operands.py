"""Words to operands: every form, names with blanks, and what is said about the rest."""

from __future__ import annotations

import pytest

from pcaccess.s7200.address import Width, parse_address
from pcaccess.s7200.types import DataType
from pcaccess.stl.lexer import statement_of
from pcaccess.stl.operands import OperandReader, longest_name
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import (
    AddressOf,
    Constant,
    ConstantForm,
    Direct,
    Indirect,
    Operand,
    PouKind,
    PouReference,
    Section,
    Symbol,
    SymbolTable,
    Unresolved,
    Variable,
)

PROBLEMS = Collector("p.awl")
HERE = PROBLEMS.span(1, 1)


def direct(text: str, symbol: str | None = None, declared: DataType | None = None) -> Direct:
    return Direct(parse_address(text), HERE, symbol, declared)


def decimal(value: int, symbol: str | None = None) -> Constant:
    return Constant(value, ConstantForm.DECIMAL, str(value), HERE, None, symbol)


SYMBOLS = SymbolTable(
    [
        Symbol("Motor", parse_address("Q0.0"), "Q0.0", "", HERE),
        Symbol("Pump motor 2", parse_address("Q0.2"), "Q0.2", "", HERE),
        Symbol("Setpoint", decimal(1200), "1200", "", HERE),
        Symbol("Table", parse_address("VB100"), "VB100", "", HERE),
        Symbol("Pointer", parse_address("VD20"), "VD20", "", HERE),
        Symbol("Mixer", PouReference(PouKind.SBR, 4, "SBR4", HERE), "SBR4", "", HERE),
        Symbol("Empty", None, "", "", HERE),
        Symbol("Broken", None, "Q0.9", "", HERE),
    ]
)
POUS = {
    "main": PouReference(PouKind.MAIN, 1, "MAIN", HERE),
    "stop all": PouReference(PouKind.SBR, 7, "Stop all", HERE),
    "pulse": PouReference(PouKind.INT, 2, "Pulse", HERE),
}
VARIABLES = [
    Variable("Level", Section.IN, DataType.INT, parse_address("LW0"), "", HERE),
    Variable("Text", Section.IN, DataType.STRING, parse_address("LD4"), "", HERE),
    Variable("Where", Section.TEMP, DataType.DWORD, parse_address("LD8"), "", HERE),
]


def read(line: str) -> tuple[tuple[Operand, ...], list[str]]:
    problems = Collector("p.awl")
    statement, _ = statement_of(line, 1, ())
    assert statement is not None
    operands = OperandReader(problems, "utf-8", SYMBOLS, POUS, VARIABLES, longest_name(SYMBOLS, POUS)).read(statement)
    return operands, [f"{p.span.column}+{p.span.length} {p.code} {p.nearest or ''}".rstrip() for p in problems.problems]


@pytest.mark.parametrize(
    ("line", "operands"),
    [
        ("MOVW vw2, LW4", [direct("VW2"), direct("LW4")]),
        ("LD VX0.3", [direct("V0.3")]),
        ("LD E0.1", [direct("I0.1")]),
        ("MOVB DB1.DBB7, AC0", [direct("VB7"), direct("AC0")]),
        ("MOVB 3 VB500", [decimal(3), direct("VB500")]),
        ("LDW= SMW68 +500", [direct("SMW68"), decimal(500)]),
        ("MOVW *AC1, *LD34", [Indirect(parse_address("AC1"), HERE), Indirect(parse_address("LD34"), HERE)]),
        ("MOVD &VB100 VD0", [AddressOf(parse_address("VB100"), HERE), direct("VD0")]),
        ("LD motor", [direct("Q0.0", "Motor")]),
        ("LD Pump  motor 2", [direct("Q0.2", "Pump motor 2")]),
        ("MOVW Setpoint VW0", [decimal(1200, "Setpoint"), direct("VW0")]),
        ("MOVB *Pointer, VB0", [Indirect(parse_address("VD20"), HERE, "*Pointer"), direct("VB0")]),
        ("MOVD &table, AC1", [AddressOf(parse_address("VB100"), HERE, "&Table"), direct("AC1")]),
        ("LD always_on", [direct("SM0.0", "Always_On")]),
        ("MOVB 16#F8 HSC0_Ctrl", [Constant(0xF8, ConstantForm.HEX, "", HERE), direct("SMB37", "HSC0_Ctrl")]),
        ("MOVW #level, VW0", [direct("LW0", "#Level", DataType.INT), direct("VW0")]),
        ("MOVW Level, VW0", [direct("LW0", "#Level", DataType.INT), direct("VW0")]),
        ("MOVB *#Where, VB0", [Indirect(parse_address("LD8"), HERE, "*#Where"), direct("VB0")]),
        ("SLEN #Text, VB0", [Indirect(parse_address("LD4"), HERE, "#Text"), direct("VB0")]),
        ("MOVW 'AB', VW0", [Constant(0x4142, ConstantForm.ASCII, "", HERE, Width.WORD), direct("VW0")]),
        ('SCPY "a b", VB0', [Constant("a b", ConstantForm.STRING, "", HERE), direct("VB0")]),
        ("MOVB ON, VB0", [Constant(1, ConstantForm.BOOL, "", HERE), direct("VB0")]),
        ("CALL SBR_3, VB0", [PouReference(PouKind.SBR, 3, "", HERE), direct("VB0")]),
        ("CALL 5", [PouReference(PouKind.SBR, 5, "", HERE)]),
        ("CALL stop all, 5", [PouReference(PouKind.SBR, 7, "", HERE), decimal(5)]),
        ("CALL Mixer", [PouReference(PouKind.SBR, 4, "", HERE)]),
        ("ATCH INT_0 10", [PouReference(PouKind.INT, 0, "", HERE), decimal(10)]),
        ("ATCH INT0, 19", [PouReference(PouKind.INT, 0, "", HERE), decimal(19)]),
        ("ATCH Pulse, 12", [PouReference(PouKind.INT, 2, "", HERE), decimal(12)]),
        ("ATCH 3 10", [PouReference(PouKind.INT, 3, "", HERE), decimal(10)]),
    ],
)
def test_operands_in_every_form(line: str, operands: list[Operand]) -> None:
    found, problems = read(line)
    assert problems == []
    assert list(found) == operands


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("LD I0.8", "4+4 STL031"),
        ("MOVW AIW1, VW0", "6+4 STL031"),
        ("MOVW VW0[3], VW0", "6+6 STL032"),
        ("BCDI ACO", "6+3 STL032 AC0"),
        ("LD IO.0", "4+4 STL032 I0.0"),
        ("LD VO.1", "4+4 STL032 V0.1"),
        ("LD Motr", "4+4 STL032 Motor"),
        ("LD no such name, VB0", "4+12 STL032"),
        ("LD Empty", "4+5 STL032"),
        ("MOVW #Levl, VW0", "6+5 STL033 #Level"),
        ("MOVB 'abc', VB0", "6+5 STL034"),
        ("MOVB 'a, VB0", "6+7 STL034"),
        ("MOVB 2#3, VB0", "6+3 STL034"),
        ("MOVB *AC0, VB0", "6+4 STL027"),
        ("MOVB *VW0, VB0", "6+4 STL027"),
        ("MOVB *Setpoint, VB0", "6+9 STL027"),
        ("MOVD &, VD0", "6+1 STL031"),
        ("MOVD &Nix, VD0", "7+3 STL032"),
        ("MOVB VB0，VB1", "6+7 STL031"),
        ("MOVB , VB1", "1+4 STL031"),
        ("CALL SBR3 .", "11+1 STL031"),
        ("CALL Puls", "6+4 STL080"),
        ("ATCH Puls, 10", "6+4 STL080 Pulse"),
    ],
)
def test_what_is_not_understood_is_reported_at_its_place(line: str, problem: str) -> None:
    operands, problems = read(line)
    assert problems == [problem]
    assert any(isinstance(operand, Unresolved) for operand in operands)


def test_a_symbol_whose_row_was_wrong_is_not_reported_again() -> None:
    assert read("LD Broken") == ((Unresolved("Broken", HERE),), [])


def test_words_that_mean_something_are_not_drawn_into_an_unknown_name() -> None:
    operands, problems = read("MOVB Inlet valve VB0 5")
    assert problems == ["6+11 STL032"]
    assert [type(operand) for operand in operands] == [Unresolved, Direct, Constant]
