"""Whole files: exports in several encodings, programs from books, files that are something else."""

from __future__ import annotations

from pathlib import Path

import pytest

from pcaccess.problems import ProblemError
from pcaccess.s7200.address import parse_address
from pcaccess.s7200.types import DataType
from pcaccess.stl.checker import load_program
from pcaccess.stl.program import Constant, Direct, Indirect, Instruction, Pou, PouKind, Program
from pcaccess.stl.reader import ReadResult, read_program

DATA = Path(__file__).parent.parent / "data" / "stl"


def read(text: str) -> ReadResult:
    return read_program(text.encode(), file="p.awl")


def codes(result: ReadResult) -> list[str]:
    return [f"{p.span.line}:{p.span.column} {p.code}" for p in result.problems]


def good(name: str) -> Program:
    """The program of a test file, which has not even a warning."""
    result = load_program(DATA / name)
    assert [str(problem) for problem in result.problems] == []
    return result.unwrap()


def outline(pou: Pou) -> list[str]:
    return [" ".join(i.mnemonic for i in network.instructions) for network in pou.networks]


def test_a_chinese_export_keeps_names_titles_comments_and_local_variables() -> None:
    program = good("packing_gbk.awl")
    assert program.encoding == "gbk"
    assert [(pou.block, pou.name) for pou in program.pous] == [
        ("OB1", "主程序"),
        ("SBR0", "延时"),
        ("INT0", "定时中断"),
    ]
    assert program.main.title == "程序注释 包装线"
    assert program.main.networks[0].comment == ("启动按钮 I0.0, 停止按钮 I0.1", "电机 Q0.0 自锁")
    delay = program.subroutine(0)
    assert delay is not None
    assert [(v.name, v.data_type, str(v.address)) for v in delay.variables] == [
        ("时间", DataType.INT, "LW0"),
        ("完成", DataType.BOOL, "L2.0"),
        ("剩余", DataType.INT, "LW3"),
        ("中间", DataType.INT, "LW5"),
    ]
    text = program.main.networks[3].instructions[1].operands[0]
    assert text.value.encode("latin-1").decode("gbk") == "温度高"  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("name", "encoding"),
    [("mixer_cp1252.awl", "cp1252"), ("mixer_utf8_bom.awl", "utf-8"), ("mixer_utf16.awl", "utf-16")],
)
def test_the_same_program_reads_the_same_in_every_encoding(name: str, encoding: str) -> None:
    program = good(name)
    assert program.encoding == encoding
    assert program == good("mixer_cp1252.awl")
    assert program.main.networks[0].title == "Rührer läuft, solange der Füllstand genügt"
    assert outline(program.main)[0] == "LD LPS A = LRD AN = LPP LDW>= ALD ="


def test_a_russian_export_is_read_in_its_code_page() -> None:
    program = good("pump_cp1251.awl")
    assert (program.main.name, program.main.networks[2].title) == ("ОСНОВНАЯ", "Сброс аварии")


def test_a_program_as_printed_in_a_book_needs_no_headers_commas_or_capitals() -> None:
    program = good("book_ascii.awl")
    assert [(pou.block, outline(pou)) for pou in program.pous] == [
        ("OB1", ["LD O AN =", "LD LPS CALL LPP AW>= =", "LD ATCH ENI"]),
        ("SBR0", ["", "LD MOVB MOVW LDW= MOVW"]),
        ("INT0", ["", "LD INCW"]),
    ]
    assert program.main.comment == ("Two lights and a motor, typed from a book",)


def test_symbols_and_data_beside_the_program_belong_to_it() -> None:
    program = good("ladder_ascii.awl")
    load, _, _, move = program.main.networks[2].instructions
    assert load.operands == (Direct(parse_address("I0.0"), load.span, "Motor on"),)
    assert move.operands[0].symbol == "Setpoint"  # type: ignore[union-attr]
    assert len(program.symbols) == 4
    memory = bytearray(200)
    program.data.write_to(memory)
    assert memory[0] == 0xFF
    assert memory[100:106] == b"\x00\x01\xff\xfe\xff\xff"
    assert memory[120:142] == b"TD\x00" + bytes(7) + b"\x05Ready" + bytes(4) + b"\x01\x2c"


def test_box_calls_of_ladder_programs_use_the_scratch_bits_of_local_memory() -> None:
    call = good("ladder_ascii.awl").main.networks[0].instructions[-1]
    assert [str(o.address) for o in call.operands[1:] if isinstance(o, Direct)] == ["L63.7", "M0.1", "VB11"]


def test_pointers_are_read_from_accumulators_and_double_words() -> None:
    network = good("ladder_ascii.awl").main.networks[1]
    pointers = [str(o.pointer) for i in network.instructions for o in i.operands if isinstance(o, Indirect)]
    assert pointers == ["AC1", "AC1", "VD204"]


def test_a_program_of_the_smart_is_read_up_to_what_only_the_smart_has() -> None:
    result = load_program(DATA / "smart_utf8.awl")
    assert codes(result) == ["24:2 STL029"]
    assert result.program is not None
    assert [pou.name for pou in result.program.pous] == ["主程序", "PUT Go"]
    assert result.program.main.networks[0].comment == ("读取输入",)


def test_given_symbols_and_data_take_the_place_of_those_in_files() -> None:
    program = good("ladder_ascii.awl")
    source = (DATA / "ladder_ascii.awl").read_bytes()
    alone = read_program(source)
    assert {p.code for p in alone.problems} == {"STL032"}
    assert read_program(source, symbols=program.symbols, data_block=program.data).unwrap() == program


@pytest.mark.parametrize("text", ["", "\n\n  \r\n", "﻿"])
def test_an_empty_file_holds_no_program(text: str) -> None:
    result = read(text)
    assert (result.program, codes(result)) == (None, ["1:1 STL001"])


def test_a_file_of_comments_holds_no_program() -> None:
    result = read("\n  // only a comment\n")
    assert (result.program, codes(result)) == (None, ["2:3 STL001"])


def test_a_text_without_any_instruction_is_one_problem_and_not_a_thousand() -> None:
    result = read("Dear colleague,\nplease find attached\nthe program you asked for.\n" * 500)
    assert (result.program, codes(result)) == (None, ["1:1 STL002"])


@pytest.mark.parametrize("data", [b"GJK\x00R04.00", b"\x00\x01\x02" * 99, b"\x89PNG\r\n", b"<xml>", bytes(1000)])
def test_a_file_of_another_kind_is_one_problem_at_its_start(data: bytes) -> None:
    result = read_program(data)
    assert (result.program, codes(result)) == (None, ["1:1 STL002"])


S7_300 = """      U     E      0.0
      U(
      O     E      0.1
      )
      =     A      4.0
      L     MW    10
      T     DB10.DBW   2
      SPA   ende
ende: NOP   0
"""


def test_a_program_of_an_s7_300_is_one_problem_where_it_shows() -> None:
    result = read(S7_300)
    assert (result.program, codes(result)) == (None, ["1:7 STL003"])
    assert [str(span) for span, _ in result.problems[0].related] == ["p.awl:2:7", "p.awl:3:7", "p.awl:5:7"]


@pytest.mark.parametrize(
    "line",
    [
        'FUNCTION_BLOCK "Motor"',
        "ORGANIZATION_BLOCK OB 1",
        "FUNCTION FC1 : VOID",
        "DATA_BLOCK DB 5",
        "CALL FC 5",
        "L S5T#10S",
    ],
)
def test_one_line_that_only_an_s7_300_has_is_enough(line: str) -> None:
    assert [p.code for p in read(f"// source\n{line}\nA I0.0\n= Q0.0").problems] == ["STL003"]


def test_single_foreign_words_in_an_s7_200_program_are_explained_where_they_stand() -> None:
    foreign = "U E0.1\nUW>= VW0, 5\nZV C1, 10\nL MW0\nADD_I VW0, VW2\nGET VB0\nRETI\nMVW 1, VW0"
    result = read(f"LD I0.0\n{foreign}\nLD SM0.0\nMOVB 1, VB0")
    assert [(p.span.line, p.code, p.nearest) for p in result.problems] == [
        (2, "STL028", "A"),
        (3, "STL028", "AW>="),
        (4, "STL028", "CTU"),
        (5, "STL030", None),
        (6, "STL020", "+I"),
        (7, "STL029", "NETR"),
        (8, "STL020", None),
        (9, "STL020", "MOVW"),
    ]


COMPARES = "LDW=, LDW<>, LDW>, LDW<=, LDW< or LDW>="


@pytest.mark.parametrize(
    ("line", "nearest", "expected"),
    [
        # a family of one instruction per type, with the type's other names
        ("MOVDW VD0, VD4", "MOVD", "MOVB, MOVW, MOVD or MOVR"),
        ("MOV_REAL VD0, VD4", "MOVR", "MOVB, MOVW, MOVD or MOVR"),
        ("MOV VW0, VW2", "MOVW", "MOVB, MOVW, MOVD or MOVR"),
        ("MOVE 5, VB2", "MOVB", "MOVB, MOVW, MOVD or MOVR"),
        ("ADDD VD0, VD4", "+D", "+I, +D or +R"),
        ("+DI VD0, VD4", "+D", "+I, +D or +R"),
        ("ADD VW0, VW2", None, "+I, +D or +R"),
        ("SHLW VW0, 2", "SLW", "SLB, SLW or SLD"),
        ("UNDW VW0, VW2", "ANDW", "ANDB, ANDW or ANDD"),
        # words that mean bits or values
        ("AND I0.1", "A", "A for bits; ANDB, ANDW or ANDD for values"),
        ("OR VW0, VW2", "ORW", "ORB, ORW or ORD"),
        # compares
        ("LDNW= VW0, 5", "LDW<>", f"the opposite sign, as a compare is not negated: {COMPARES}"),
        ("LDDI> VD0, 5", "LDD>", "LDD=, LDD<>, LDD>, LDD<=, LDD< or LDD>="),
        ("LDW VW0 >= 5", "LDW>=", COMPARES),
        ("LDW != VW0, 5", "LDW<>", COMPARES),
        ("LDS> VB0, VB10", None, "LDS= or LDS<>"),
        ("FND VW0, 1, VW2", None, "FND=, FND<>, FND< or FND>"),
        ("FND>= VW0, 1, VW2", None, "FND=, FND<>, FND< or FND>"),
        # other makers and IEC 61131-3
        ("OUT Q0.0", "=", "=, which writes a bit"),
        ("SET Q0.0", "S", "S with a bit and how many: S Q0.0, 1"),
        ("MPS", "LPS", "LPS"),
        ("LDP I0.0", "EU", "EU detects a rising edge of what is loaded before it"),
        ("JMPC 5", "JMP", "JMP, which jumps while the top of the stack is 1"),
        # a blank that is missing
        ("LDNI0.1", "LDN I0.1", "a blank behind the instruction"),
        ("TONT37, 10", "TON T37", "a blank behind the instruction"),
    ],
)
def test_what_people_write_from_habit_is_known(line: str, nearest: str | None, expected: str) -> None:
    (problem,) = read(f"LD I0.0\n{line}\n= Q0.0").problems
    assert (problem.span.line, problem.span.column, problem.code) == (2, 1, "STL020")
    assert (problem.nearest, problem.expected) == (nearest, expected)


@pytest.mark.parametrize("line", ["and then the pump stops", "the pump is on"])
def test_a_comment_without_its_slashes_is_no_habit(line: str) -> None:
    (problem,) = read(f"LD I0.0\n{line}\n= Q0.0").problems
    assert problem.expected == "an S7-200 mnemonic; a comment starts with //"


def written(instruction: Instruction) -> str:
    operands = [o.text if isinstance(o, Constant) else str(o.address) for o in instruction.operands]  # type: ignore[union-attr]
    return " ".join((instruction.mnemonic, *operands))


@pytest.mark.parametrize(
    ("line", "places", "instructions"),
    [
        ("LD I0.0 O I0.1", [9], ["LD I0.0", "O I0.1"]),
        ("LD I0.0 = Q0.0", [9], ["LD I0.0", "= Q0.0"]),
        ("LD I0.0 eu = Q0.0", [9, 12], ["LD I0.0", "EU", "= Q0.0"]),
        ("LD I0.0, O I0.1", [10], ["LD I0.0", "O I0.1"]),
        ("LD I0.0 ON I0.1", [9], ["LD I0.0", "ON I0.1"]),
        ("NOT = Q0.0", [5], ["NOT", "= Q0.0"]),
        ("MOVB 3, VB500 MOVB 4, VB501", [15], ["MOVB 3 VB500", "MOVB 4 VB501"]),
        ("LD I0.0 LDW>= VW0, 5 // both", [9], ["LD I0.0", "LDW>= VW0 5"]),
    ],
)
def test_each_of_several_instructions_on_a_line_is_read(line: str, places: list[int], instructions: list[str]) -> None:
    result = read(line)
    assert codes(result) == [f"1:{column} STL037" for column in places]
    assert result.program is not None
    assert list(map(written, result.program.main.networks[0].instructions)) == instructions


def test_an_unknown_name_with_an_instruction_in_it_stays_a_name() -> None:
    (problem,) = read("LD Valve S\n= Q0.0").problems
    assert (problem.code, problem.message) == ("STL032", "there is no symbol 'Valve S'")


def test_two_blocks_of_one_number_or_name_are_reported_and_the_first_stays() -> None:
    block = "SUBROUTINE_BLOCK {}\nBEGIN\nNetwork 1\nNOT\nEND_SUBROUTINE_BLOCK\n"
    result = read("".join(block.format(name) for name in ("Pump:SBR0", "Valve:SBR0", "PUMP:SBR1")))
    assert codes(result) == ["6:1 STL006", "11:1 STL006"]
    assert result.program is not None
    assert [pou.block for pou in result.program.pous] == ["SBR0", "SBR1"]


def test_blocks_may_be_called_before_they_are_read() -> None:
    result = read(
        "ORGANIZATION_BLOCK MAIN:OB1\nBEGIN\nNetwork 1\nLD I0.0\nCALL Pump control\nEND_ORGANIZATION_BLOCK\n"
        "SUBROUTINE_BLOCK Pump control:SBR9\nBEGIN\nNetwork 1\nLD I0.1\n= Q0.0\nEND_SUBROUTINE_BLOCK"
    )
    called = result.unwrap().main.networks[0].instructions[1].operands[0]
    assert (called.kind, called.number) == (PouKind.SBR, 9)  # type: ignore[union-attr]


def test_a_comma_too_many_is_an_operand_too_few() -> None:
    assert codes(read("LD I0.0,\n= Q0.0")) == ["1:1 STL031"]


def test_problems_name_the_block_and_the_network() -> None:
    (problem,) = read("NETWORK 1\nLD I0.0\n= Q0.0\nNETWORK 2\nLD I0.9\n= Q0.1").problems
    assert problem.where == "MAIN (OB1), network 2"


def test_unwrap_raises_everything_that_is_wrong() -> None:
    with pytest.raises(ProblemError) as error:
        read("LD I0.9\n= Q0.9").unwrap()
    assert [problem.span.line for problem in error.value.problems] == [1, 2]


def test_warnings_do_not_stop_a_program() -> None:
    result = read("LD I0.0 ; start\n= Q0.0")
    assert [problem.code for problem in result.problems] == ["STL035"]
    assert result.unwrap().main.networks[0].instructions[0].comment == "start"


def test_more_problems_than_anybody_reads_are_counted() -> None:
    result = read("LD I0.9\n" * 1500 + "= Q0.0")
    assert (len(result.problems), result.left_out) == (1000, 500)


def test_an_encoding_can_be_forced() -> None:
    data = "LD I0.0 // Größe\n= Q0.0".encode("cp1252")
    result = read_program(data, encoding="cp1251")
    assert result.unwrap().main.networks[0].instructions[0].comment == "GrцЯe"


def test_a_forced_encoding_is_that_of_the_files_beside_too(tmp_path: Path) -> None:
    (tmp_path / "p.awl").write_bytes("LD Größe\n= Q0.0".encode("cp1252"))
    (tmp_path / "p.sym").write_bytes("Größe\tI0.0".encode("cp1252"))
    program = read_program(tmp_path / "p.awl", encoding="cp1251").unwrap()
    assert program.symbols.names() == ["GrцЯe"]
