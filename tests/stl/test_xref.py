"""Cross reference: which address is read and written where."""

from __future__ import annotations

from pcaccess.stl.listing import reference_lines
from pcaccess.stl.reader import read_program
from pcaccess.stl.xref import Access, cross_reference

PROGRAM = """ORGANIZATION_BLOCK MAIN:OB1
BEGIN
Network 1
LD     Start
AN     I0.1
=      Q0.0
Network 2
LD     SM0.0
+I     VW0, VW2
MOVD   &VB100, AC1
MOVW   *AC1, VW0
TON    T37, VW2
CALL   Scale, AIW0, VW4, VD8
Network 3
LD     T37
R      T37, 1
END_ORGANIZATION_BLOCK
SUBROUTINE_BLOCK Scale:SBR0
VAR_INPUT
Raw:INT;
END_VAR
VAR_IN_OUT
Sum:INT;
END_VAR
VAR_OUTPUT
Value:REAL;
END_VAR
BEGIN
Network 1
LD     SM0.0
+I     #Raw, #Sum
END_SUBROUTINE_BLOCK
//SYMBOL_TABLE
//Start\tI0.0
//END_SYMBOL_TABLE
"""


def test_every_use_has_its_place_and_its_direction() -> None:
    uses = cross_reference(read_program(PROGRAM.encode()).unwrap())
    found = [(str(u.address), u.access, u.mnemonic, u.pou, u.network, u.span.line) for u in uses if u.pou == "OB1"]
    read, write, both = Access.READ, Access.WRITE, Access.BOTH
    assert found == [
        ("I0.0", read, "LD", "OB1", 1, 4),
        ("I0.1", read, "AN", "OB1", 1, 5),
        ("Q0.0", write, "=", "OB1", 1, 6),
        ("VW0", read, "+I", "OB1", 2, 9),
        ("VW0", write, "MOVW", "OB1", 2, 11),
        ("VW2", both, "+I", "OB1", 2, 9),
        ("VW2", read, "TON", "OB1", 2, 12),
        ("VW4", both, "CALL", "OB1", 2, 13),
        ("VD8", write, "CALL", "OB1", 2, 13),
        ("VB100", Access.ADDRESS, "MOVD", "OB1", 2, 10),
        ("SM0.0", read, "LD", "OB1", 2, 8),
        ("T37", both, "TON", "OB1", 2, 12),
        ("T37", read, "LD", "OB1", 3, 15),
        ("T37", write, "R", "OB1", 3, 16),
        ("AC1", write, "MOVD", "OB1", 2, 10),
        ("AC1", Access.POINTER, "MOVW", "OB1", 2, 11),
        ("AIW0", read, "CALL", "OB1", 2, 13),
    ]


def test_the_table_has_one_line_for_each_address() -> None:
    lines = list(reference_lines(read_program(PROGRAM.encode()).unwrap()))
    assert [" ".join(line.split()) for line in lines] == [
        "I0.0 OB1/1 (Start)",
        "I0.1 OB1/1",
        "Q0.0 OB1/1=",
        "VW0 OB1/2 OB1/2=",
        "VW2 OB1/2+ OB1/2",
        "VW4 OB1/2+",
        "VD8 OB1/2=",
        "VB100 OB1/2&",
        "SM0.0 OB1/2 SBR0/1",
        "LW0 in SBR0 SBR0/1",
        "LW2 in SBR0 SBR0/1+",
        "T37 OB1/2+ OB1/3 OB1/3=",
        "AC1 OB1/2= OB1/2*",
        "AIW0 OB1/2",
    ]
