"""Lines to blocks, networks and statements: exports, programs from books, and files that are cut off."""

from __future__ import annotations

import pytest

from pcaccess.stl.blocks import read_blocks
from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.problems import Collector
from pcaccess.stl.rawblocks import RawFile


def read(text: str) -> tuple[RawFile, list[str]]:
    problems = Collector("p.awl")
    file = read_blocks(text.split("\n"), problems, DEFINITIONS)
    return file, [f"{p.span.line}:{p.code}" for p in problems.problems]


def outline(file: RawFile) -> list[tuple[str, str, list[tuple[int, str]]]]:
    """Block, name, and its networks with the mnemonics in them."""
    return [
        (
            f"{block.kind.value}{block.number}",
            block.name,
            [(network.number, " ".join(s.mnemonic for s in network.statements)) for network in block.networks],
        )
        for block in file.blocks
    ]


EXPORT = """ORGANIZATION_BLOCK 主程序:OB1
TITLE=Title
// program comment
BEGIN
Network 1 // Start
// first line
// second line
LD     I0.0
// between
=      Q0.0 // lamp
// behind
Network 2
END_ORGANIZATION_BLOCK
SUBROUTINE_BLOCK Pump control:SBR3
TITLE=
BEGIN
Network 1
NOT
END_SUBROUTINE_BLOCK"""


def test_an_export_has_its_blocks_networks_and_comments() -> None:
    file, problems = read(EXPORT)
    assert problems == []
    assert outline(file) == [
        ("OB1", "主程序", [(1, "LD ="), (2, "")]),
        ("SBR3", "Pump control", [(1, "NOT")]),
    ]
    main = file.blocks[0]
    network = main.networks[0]
    assert (main.title, main.comment) == ("Title", ["program comment"])
    assert (network.title, network.comment) == ("Start", ["first line", "second line"])
    assert [s.before for s in network.statements] == [(), ("between",)]
    assert (network.statements[1].comment, network.after) == ("lamp", ["behind"])


@pytest.mark.parametrize(
    "header",
    ["organization_block MAIN:OB1", "  ORGANIZATION_BLOCK   MAIN : OB1 ;", "ORGANIZATION_BLOCK MAIN:OB1 // main"],
)
def test_headers_are_read_in_any_case_and_spacing(header: str) -> None:
    file, problems = read(f"{header}\nBEGIN\nNetwork 1\nLD I0.0\nEND_ORGANIZATION_BLOCK")
    assert problems == []
    assert outline(file) == [("OB1", "MAIN", [(1, "LD")])]


def test_a_block_is_known_by_what_follows_the_colon_whatever_its_keyword() -> None:
    file, problems = read("SUBRUTINA Bomba:SBR2\nBEGIN\nNetwork 1\nNOT\nEND_SUBRUTINA")
    assert problems == []
    assert outline(file) == [("SBR2", "Bomba", [(1, "NOT")])]


@pytest.mark.parametrize(
    ("header", "block"),
    [
        ("PROGRAM_BLOCK MAIN:OB1", "OB1"),
        ("SUBROUTINE_BLOCK Pulse:INT0", "INT0"),
        ("ORGANIZATION_BLOCK MAIN:OB2", "OB1"),
        ("SUBROUTINE_BLOCK Pump", "SBR0"),
        ("FUNCTION_BLOCK Pump:FB1", "SBR0"),
    ],
)
def test_a_wrong_header_is_reported_and_understood_as_far_as_possible(header: str, block: str) -> None:
    keyword = header.split()[0]
    file, problems = read(f"{header}\nBEGIN\nNetwork 1\nNOT\nEND_{keyword}")
    assert problems == ["1:STL005"]
    assert outline(file)[0][0] == block


def test_the_head_of_a_block_may_hold_plain_comment_lines() -> None:
    file, problems = read(EXPORT.replace("// program comment", "Press F1 for help and an example"))
    assert problems == []
    assert file.blocks[0].comment == ["Press F1 for help and an example"]


@pytest.mark.parametrize("lines", range(1, 13))
def test_an_export_that_is_cut_off_anywhere_says_so_at_its_last_line(lines: int) -> None:
    _, problems = read("\n".join(EXPORT.split("\n")[:lines]))
    assert problems == [f"{lines}:STL004"]


def test_a_block_that_is_not_closed_before_the_next_is_reported_there() -> None:
    file, problems = read(EXPORT.replace("END_ORGANIZATION_BLOCK\n", ""))
    assert problems == ["13:STL004"]
    assert len(file.blocks) == 2


def test_the_wrong_end_is_reported_and_closes_the_block() -> None:
    _, problems = read(EXPORT.replace("END_ORGANIZATION_BLOCK", "END_INTERRUPT_BLOCK"))
    assert problems == ["13:STL004"]


def test_an_open_variable_section_ends_where_the_code_begins() -> None:
    text = "ORGANIZATION_BLOCK MAIN:OB1\nVAR\na:INT;\nBEGIN\nNetwork 1\nNOT\nEND_ORGANIZATION_BLOCK"
    file, problems = read(text)
    assert problems == ["2:STL004"]
    assert [line for _, _, line in file.blocks[0].declarations] == ["a:INT;"]
    assert outline(file) == [("OB1", "MAIN", [(1, "NOT")])]


def test_text_between_blocks_is_reported_once() -> None:
    _, problems = read(EXPORT.replace("\nSUBROUTINE", "\nLD I0.0\n= Q0.1\nSUBROUTINE"))
    assert problems == ["14:STL007"]


def test_without_headers_everything_is_the_main_program() -> None:
    file, problems = read("// my program\nLD I0.0\n= Q0.0\nLD I0.1\n= Q0.1")
    assert problems == []
    assert outline(file) == [("OB1", "MAIN", [(1, "LD = LD =")])]
    assert file.blocks[0].comment == ["my program"]


def test_old_programs_divide_themselves_by_mend_sbr_and_int() -> None:
    text = """NETWORK 1 //start
LD I0.0
CALL 0
NETWORK 2
MEND
NETWORK 3 // pump
SBR 0
NETWORK 4
LD SM0.0
NETWORK 5
RET
INT 5
LD SM0.0
RETI"""
    file, problems = read(text)
    assert problems == []
    assert outline(file) == [
        ("OB1", "MAIN", [(1, "LD CALL")]),
        ("SBR0", "SBR_0", [(3, ""), (4, "LD")]),
        ("INT5", "INT_5", [(1, "LD")]),
    ]
    assert file.blocks[1].networks[0].title == "pump"


def test_instructions_behind_the_end_are_reported_once() -> None:
    _, problems = read("LD I0.0\n= Q0.0\nMEND\nLD I0.1\n= Q0.1")
    assert problems == ["4:STL015"]


@pytest.mark.parametrize(
    ("comment", "block"),
    [
        ("// SBR 0", "SBR0"),
        ("//SBR0, count the bottles", "SBR0"),
        ("// Subroutine 0", "SBR0"),
        ("// ** INT_3 **", "INT3"),
        ("// Interrupt 3", "INT3"),
        ("//Interrupt routine 3: pulses", "INT3"),
    ],
)
def test_a_comment_above_network_1_starts_a_block_as_in_books(comment: str, block: str) -> None:
    file, problems = read(f"//Main\nNETWORK 1\nLD I0.0\n= Q0.0\n{comment}\nNETWORK1\nLD SM0.0")
    assert problems == ["5:STL010"]
    assert [name for name, _, _ in outline(file)] == ["OB1", block]


def test_a_comment_starts_a_block_that_was_called_when_a_load_follows() -> None:
    file, problems = read("NETWORK 1\nLD I0.0\nCALL SBR0\n// SBR0, stop the drive\n// second line\nLD SM0.0\n= Q0.0")
    assert problems == ["4:STL010"]
    assert outline(file)[1] == ("SBR0", "SBR_0", [(1, "LD =")])


@pytest.mark.parametrize("comment", ["// SBR0 is called here", "// calls SBR 0", "// SBR 0 stops the drive"])
def test_a_comment_that_only_mentions_a_subroutine_starts_nothing(comment: str) -> None:
    file, problems = read(f"NETWORK 1\nLD I0.0\n{comment}\nCALL SBR0\n")
    assert problems == []
    assert len(file.blocks) == 1


def test_network_numbers_that_start_again_are_reported() -> None:
    file, problems = read("NETWORK 1\nNOT\nNETWORK 2\nNOT\nNETWORK 1\nNOT")
    assert problems == ["5:STL009"]
    assert [number for number, _ in outline(file)[0][2]] == [1, 2, 1]


@pytest.mark.parametrize(
    ("line", "number", "title"),
    [
        ("NETWORK", 1, ""),
        ("network 7//Title", 7, "Title"),
        ("Network1 // a // b", 1, "a // b"),
        ("\tNetwork 3 ", 3, ""),
        ("NETWORK 4\t//10 ms timer", 4, "10 ms timer"),
    ],
)
def test_network_headers_in_every_spelling(line: str, number: int, title: str) -> None:
    file, problems = read(f"{line}\nNOT")
    network = file.blocks[0].networks[0]
    assert (problems, network.number, network.title) == ([], number, title)


def test_operands_go_on_after_a_comma_at_the_end_of_a_line() -> None:
    file, problems = read("CALL USS, I0.0, I0.1, // first half\nQ0.1, Q0.2 // second half\nNOT")
    statement, following = file.blocks[0].networks[0].statements
    assert problems == []
    assert [piece[0].text for piece in statement.pieces] == ["USS", "I0.0", "I0.1", "Q0.1", "Q0.2"]
    assert [piece[0].line for piece in statement.pieces] == [1, 1, 1, 2, 2]
    assert statement.comment == "first half second half"
    assert following.mnemonic == "NOT"


def test_an_instruction_after_a_stray_comma_is_not_swallowed() -> None:
    file, _ = read("LD I0.0,\n= Q0.0")
    assert outline(file)[0][2] == [(1, "LD =")]


def test_semicolons_end_instructions() -> None:
    file, problems = read("LD I0.0; A I0.1; // both\n= Q0.0;")
    statements = file.blocks[0].networks[0].statements
    assert problems == []
    assert [(s.mnemonic, s.column, s.comment) for s in statements] == [("LD", 1, ""), ("A", 10, "both"), ("=", 1, "")]


def test_other_text_behind_a_semicolon_is_taken_for_a_comment_and_reported() -> None:
    file, problems = read("LD I0.0 ; start button")
    assert problems == ["1:STL035"]
    assert file.blocks[0].networks[0].statements[0].comment == "start button"


def test_symbols_and_data_may_follow_as_comments() -> None:
    symbols = "//SYMBOL_TABLE\n//Motor\tQ0.0\n//END_SYMBOL_TABLE"
    data = "//DATA_BLOCK\n//VB0 5\n//END_DATA_BLOCK"
    file, problems = read(f"{EXPORT}\n{symbols}\n{data}")
    assert problems == []
    assert file.symbols == [(21, 2, "Motor\tQ0.0")]
    assert file.data == [(24, 2, "VB0 5")]


def test_a_line_longer_than_any_program_has_is_no_instruction() -> None:
    _, problems = read("LD I0.0\n" + "A " * 3000)
    assert problems == ["2:STL020"]
