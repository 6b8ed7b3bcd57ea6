"""The checker: every rule from both sides. What each problem means is in docs/problems."""

from __future__ import annotations

import pytest

from pcaccess.problems import Problem
from pcaccess.s7200.cpu import cpu_model
from pcaccess.stl.checker import load_program


def problems_of(text: str, cpu: str = "CPU 226") -> list[Problem]:
    return list(load_program(text.encode(), cpu_model(cpu), file="p.awl").problems)


def found(text: str, cpu: str = "CPU 226") -> list[str]:
    return [f"{p.span.line}:{p.span.column} {p.code}" for p in problems_of(text, cpu)]


def operand(line: str, cpu: str = "CPU 226") -> list[str]:
    """What is wrong with one instruction, with the column."""
    return [f"{p.span.column} {p.code}" for p in problems_of(f"LD SM0.0\nLPS\nLRD\n{line}\nLPP\n= Q0.0", cpu)]


def block(header: str, *networks: str, variables: str = "") -> str:
    code = "\n".join(f"Network {number}\n{text}" for number, text in enumerate(networks, 1))
    return f"{header}\nTITLE=\n{variables}BEGIN\n{code}\nEND_{header.split()[0]}\n"


def main(*networks: str) -> str:
    return block("ORGANIZATION_BLOCK MAIN:OB1", *networks)


def subroutine(number: int, *networks: str, variables: str = "") -> str:
    return block(f"SUBROUTINE_BLOCK SBR_{number}:SBR{number}", *networks, variables=variables)


def interrupt(number: int, *networks: str) -> str:
    return block(f"INTERRUPT_BLOCK INT_{number}:INT{number}", *networks)


# -- operands


@pytest.mark.parametrize(
    "line",
    [
        "MOVB IB0, QB0",
        "MOVB AC0, VB1",
        "MOVW T37, VW0",
        "MOVW C1, AC0",
        "MOVW AIW0, AQW2",
        "MOVD HC0, VD0",
        "MOVD &VB100, AC1",
        "MOVD &T37, VD0",
        "MOVD &AIW2, VD0",
        "MOVW *AC1, *VD0",
        "MOVW 65535, VW0",
        "MOVW -32768, VW0",
        "MOVW 16#FFFF, VW0",
        "MOVW +100, VW0",
        "MOVW 'AB', VW0",
        "MOVB B#5, VB0",
        "MOVD 4294967295, VD0",
        "MOVD -2147483648, VD0",
        "MOVR 5, VD0",
        "MOVR -1.0E-3, VD0",
        "+I VW0, VW2",
        "S V0.0, 255",
        "R T37, 1",
        "R M8.0, VB0",
        "S V600.2, 1",
        "= T37",
        "= I0.0",
        "SI Q0.0, 128",
        "SHRB I0.0, V0.0, -64",
        "MOVB 5, SMB30",
        "BMW VW0, VW100, 255",
        'SCPY "text", VB0',
        "SCPY VB0, LB0",
        "TON T37, VW0",
        "TONR T5, AC0",
        "ENI",
        "NETR VB200, 1",
    ],
)
def test_what_the_manual_allows_is_allowed(line: str) -> None:
    assert operand(line) == []


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        # size
        ("+I VW0, VB10", "9 STL021"),
        ("MOVB VW0, VB0", "6 STL021"),
        ("MOVW VD0, VW0", "6 STL021"),
        ("MOVD T37, VD0", "6 STL021"),
        ("MOVB C1, VB0", "6 STL021"),
        ("A VB0", "3 STL021"),
        ("A AC0", "3 STL021"),
        ("= AC1", "3 STL021"),
        ("SLEN VW0, VB0", "6 STL021"),
        ("TON C1, 5", "5 STL021"),
        ("CTU T37, 5", "5 STL021"),
        ("TON VW0, 5", "5 STL021"),
        ("CALL VB0", "6 STL080"),
        ("CALL MAIN", "6 STL021"),
        # area
        ("MOVW VW0, AIW0", "11 STL022"),
        ("MOVW AQW0, VW0", "6 STL022"),
        ("MOVD VD0, HC0", "11 STL022"),
        ("+I 5, AQW0", "7 STL022"),
        ("S SM0.5, 1", "3 STL022"),
        ("MOVB 1, SMB29", "9 STL022"),
        ("=I M0.0", "4 STL022"),
        ("AI Q0.0", "4 STL022"),
        ("RI V0.0, 1", "4 STL022"),
        ("SCRT M0.0", "6 STL022"),
        ("SCPY VB0, MB0", "11 STL022"),
        ("FILL 0, AC0, 2", "9 STL022"),
        # number of operands
        ("MOVB VB0", "1 STL023"),
        ("+I VW0, VW2, VW4", "14 STL023"),
        ("NOT VB0", "5 STL023"),
        ("HDEF 0.0", "1 STL023"),
        # range of the CPU
        ("MOVB VB10240, VB0", "6 STL024"),
        ("MOVW VW10239, VW0", "6 STL024"),
        ("MOVD LD61, VD0", "6 STL024"),
        ("A I16.0", "3 STL024"),
        ("TON T256, 5", "5 STL024"),
        ("MOVD HC6, VD0", "6 STL024"),
        ("MOVW *VD10238, VW0", "6 STL024"),
        ("MOVD &VB10240, VD0", "6 STL024"),
        ("BMB VB0, VB10238, 3", "10 STL024"),
        ("S M31.7, 2", "3 STL024"),
        ("R T255, 2", "3 STL024"),
        # constants
        ("MOVB 256, VB0", "6 STL025"),
        ("MOVB -1, VB0", "6 STL025"),
        ("MOVB 'AB', VB0", "6 STL025"),
        ("MOVW 65536, VW0", "6 STL025"),
        ("MOVW -32769, VW0", "6 STL025"),
        ("MOVW 'A', VW0", "6 STL025"),
        ("MOVW DW#5, VW0", "6 STL025"),
        ("MOVW 1.5, VW0", "6 STL025"),
        ('MOVW "text", VW0', "6 STL025"),
        ("MOVW TRUE, VW0", "6 STL025"),
        ("MOVD 4294967296, VD0", "6 STL025"),
        ("MOVR 3.5E38, VD0", "6 STL025"),
        ("MOVR 16#3F800000, VD0", "6 STL025"),
        ("SCPY 'AB', VB0", "6 STL025"),
        (f'SCPY "{127 * "x"}", VB0', "6 STL025"),
        ("S Q0.0, 0", "9 STL025"),
        ("SI Q0.0, 129", "10 STL025"),
        ("LDS 9", "5 STL025"),
        ("HDEF 6, 0", "6 STL025"),
        ("PLS 2", "5 STL025"),
        ("DTCH 34", "6 STL025"),
        ("LBL 256", "5 STL025"),
        # constants where none can stand
        ("INCW 5", "6 STL026"),
        ("MOVW VW0, 100", "11 STL026"),
        ("A TRUE", "3 STL026"),
        ("TON 37, 5", "5 STL021"),
        # pointers
        ("A *AC1", "3 STL027"),
        ("= *VD0", "3 STL027"),
        ("MOVW &VB0, VW0", "6 STL027"),
        ("MOVD &V0.0, VD0", "6 STL027"),
        ("MOVD &AC1, VD0", "6 STL027"),
        ("MOVD &HC0, VD0", "6 STL027"),
        ("MOVD &LB0, VD0", "6 STL027"),
        ("MOVD VD0, &VB0", "11 STL027"),
        ("MOVR &VB0, VD0", "6 STL027"),
    ],
)
def test_everything_else_is_reported_at_the_operand(line: str, problem: str) -> None:
    assert operand(line) == [problem]


def test_a_message_names_operand_type_and_the_address_that_would_fit() -> None:
    (problem,) = problems_of("LD SM0.0\n+I VW0, VB10")
    assert problem.message == "operand 2 (OUT) of +I must be an INT; VB10 is a byte"
    assert problem.nearest == "VW10"


@pytest.mark.parametrize(("line", "codes"), [("SPA 5", ["STL023"]), ("SPA ende", ["STL023", "STL032"])])
def test_a_german_jump_is_no_port_address(line: str, codes: list[str]) -> None:
    problems = problems_of(f"LD SM0.0\n{line}")
    assert [problem.code for problem in problems] == codes
    assert (problems[0].nearest, problems[0].span.column) == ("JMP", 1)


def test_a_smaller_cpu_has_less_memory() -> None:
    assert operand("MOVB VB2048, VB0", "CPU 222") == ["6 STL024"]
    assert operand("MOVW AIW0, VW0", "CPU 221") == ["6 STL024"]


def test_an_operand_that_was_wrong_once_is_reported_each_time() -> None:
    assert found("LD SM0.0\nMOVB VW0, VB0\nMOVB VW0, VB0") == ["2:6 STL021", "3:6 STL021"]


# -- what a CPU model lacks


@pytest.mark.parametrize(
    ("line", "cpu", "problems"),
    [
        ("HSC 1", "CPU 222", ["5 STL036"]),
        ("HSC 3", "CPU 222", []),
        ("HDEF 2, 10", "CPU 221", ["6 STL036"]),
        ("HSC 1", "CPU 224", []),
        ("XMT VB100, 1", "CPU 224", ["12 STL036"]),
        ("XMT VB100, 1", "CPU 224XP", []),
        ("DTCH 24", "CPU 224", ["6 STL036"]),
        ("DTCH 24", "CPU 226", []),
        ("DTCH 16", "CPU 222", ["6 STL036"]),
        ("DTCH 12", "CPU 222", []),
    ],
)
def test_small_models_lack_counters_ports_and_events(line: str, cpu: str, problems: list[str]) -> None:
    assert operand(line, cpu) == problems


def test_only_the_226xm_has_more_than_64_subroutines() -> None:
    text = main("LD I0.0\nCALL SBR_64") + subroutine(64, "LD I0.1\n= Q0.0")
    assert found(text) == ["8:1 STL036"]
    assert found(text, "CPU 226XM") == []


# -- logic stack


@pytest.mark.parametrize(
    ("network", "problems"),
    [
        ("LD I0.0\nLD I0.1\nOLD\n= Q0.0", []),
        ("LD I0.0\nOLD\n= Q0.0", ["2:1 STL050"]),
        ("LD I0.0\nCTU C1, 5", ["2:1 STL050"]),
        ("LD I0.0\nLD I0.1\nCTUD C1, 5", ["3:1 STL050"]),
        ("A I0.0\n= Q0.0", ["1:1 STL052"]),
        ("= Q0.0", ["1:1 STL052"]),
        ("MOVB 1, VB0\nMOVB 2, VB1", ["1:1 STL052"]),
        ("LBL 1\nNOP 5", []),
        ("LD I0.0\nLPS\n= Q0.0\nLRD\n= Q0.1\nLPP\n= Q0.2", []),
        ("LD I0.0\nLPS\nLPS\n= Q0.0\nLPP\n= Q0.1\nLPP\n= Q0.2", []),
        ("LD I0.0\nLPS\n= Q0.0", ["2:1 STL053"]),
        ("LD I0.0\nLPP\n= Q0.0", ["2:1 STL053"]),
        ("LD I0.0\nLRD\n= Q0.0", ["2:1 STL053"]),
        ("LD I0.0\nLDS 0\nALD\n= Q0.0", []),
        ("LD I0.0\nLDS 3\n= Q0.0", ["2:1 STL050"]),
        ("LD I0.0\n= Q0.0\nLD I0.1\nLD I0.2\nALD\n= Q0.1", []),
        ("LD I0.0\nEU\nLDN I0.1\nCTU C1, 5", []),
    ],
)
def test_the_logic_stack_of_a_network(network: str, problems: list[str]) -> None:
    assert found(network) == problems


def test_values_that_a_rung_leaves_behind_hurt_nobody() -> None:
    rungs = "".join(f"LD I{n % 16}.0\n= Q{n % 16}.{n // 16}\n" for n in range(40))
    assert found(rungs) == []


@pytest.mark.parametrize("loads", [2, 9])
def test_nine_values_fit_on_the_stack(loads: int) -> None:
    assert found("LD I0.0\n" * loads + "ALD\n" * (loads - 1) + "= Q0.0") == []


def test_the_instruction_that_needs_a_lost_value_is_reported() -> None:
    (problem,) = problems_of("LD I0.0\n" * 10 + "ALD\n" * 9 + "= Q0.0")
    assert (problem.code, problem.span.line, problem.related[0][0].line) == ("STL051", 19, 10)


def test_each_network_starts_with_an_empty_stack() -> None:
    assert found("NETWORK 1\nLD I0.0\nLD I0.1\n= Q0.0\nNETWORK 2\nALD\n= Q0.1") == ["6:1 STL050"]


def test_an_unknown_instruction_ends_the_check_of_the_stack_there() -> None:
    assert found("LD I0.0\nULD\nULD\n= Q0.0") == ["2:1 STL028", "3:1 STL028"]


# -- structure


@pytest.mark.parametrize(
    ("program", "problems"),
    [
        (main("LD I0.0\nFOR VW0, 1, 3", "LD SM0.0\nINCW VW2", "NEXT"), []),
        (main("LD I0.0\nFOR VW0, 1, 3"), ["6:1 STL054"]),
        (main("NEXT"), ["5:1 STL054"]),
        (main("LSCR S0.0", "LD I0.0\nFOR VW0, 1, 3", "SCRE", "NEXT"), ["12:1 STL054"]),
        (main("LD I0.0\nJMP 5", "LD I0.1\n= Q0.0", "LBL 5"), []),
        (main("LBL 5", "LD I0.0\nJMP 5"), []),
        (main("LD I0.0\nJMP 5"), ["6:5 STL056"]),
        (main("LD I0.0\nJMP 5", "LBL 5", "LBL 5"), ["10:1 STL057"]),
        (main("LD I0.0\nCALL SBR_0", "LBL 1") + subroutine(0, "LD I0.0\nJMP 1"), ["15:5 STL056"]),
        (main("LSCR S0.0", "LD I0.0\nJMP 1", "LBL 1", "SCRE"), []),
        (main("LSCR S0.0", "LD I0.0\nJMP 1", "SCRE", "LBL 1"), ["8:1 STL058"]),
        (main("LD I0.0\nJMP 1", "LSCR S0.0", "LBL 1", "SCRE"), ["6:1 STL058"]),
        (main("LSCR S0.0", "LD I0.0\nSCRT S0.1", "SCRE", "LSCR S0.1", "SCRE"), []),
        (main("LSCR S0.0", "LSCR S0.1", "SCRE"), ["7:1 STL059"]),
        (main("SCRE"), ["5:1 STL059"]),
        (main("LSCR S0.0"), ["5:1 STL059"]),
        (main("LSCR S0.0", "SCRE", "LSCR S0.0", "SCRE"), ["9:6 STL059"]),
        (main("LD I0.0\nCSCRE"), ["6:1 STL059"]),
        (main("LSCR S0.0", "LD I0.0\nCSCRE", "LD I0.1\nEND", "SCRE"), ["11:1 STL060"]),
        (main("LD I0.0\nEND", "LD I0.1\nSTOP"), []),
        (main("LD I0.0\nCRET"), ["6:1 STL060"]),
        (main("LD I0.0\nCRETI"), ["6:1 STL060"]),
        (main("LD I0.0\nCALL SBR_0") + subroutine(0, "LD I0.1\nCRET", "LD I0.0\nEND"), ["16:1 STL060"]),
        (main("LD I0.0\nATCH INT_0, 10") + interrupt(0, "LD I0.1\nCRETI", "LD I0.0\nDISI"), ["16:1 STL060"]),
        (main("LD I0.0\nA I0.1"), ["6:1 STL061"]),
        (main("", "LD I0.0\n= Q0.0"), []),
    ],
)
def test_loops_jumps_segments_and_places(program: str, problems: list[str]) -> None:
    assert found(program) == problems


def test_eight_loops_can_be_nested() -> None:
    def loops(count: int) -> str:
        return "LD I0.0\n" + "".join(f"FOR VW{n}, 1, 2\n" for n in range(0, 2 * count, 2)) + "NEXT\n" * count

    assert found(loops(8)) == []
    assert found(loops(9)) == ["10:1 STL055"]


def test_a_program_has_at_most_256_edges() -> None:
    assert found("LD I0.0\n" + "EU\n" * 256 + "= Q0.0") == []
    assert found("LD I0.0\n" + "EU\n" * 300 + "= Q0.0") == ["258:1 STL062"]


# -- timers, counters, coils


@pytest.mark.parametrize(
    ("second", "problems"),
    [
        ("TON T38, 5", []),
        ("TON T37, 5", ["4:5 STL071"]),
        ("TOF T37, 5", ["4:5 STL070"]),
        ("TONR T37, 5", ["4:6 STL073"]),
        ("TONR T31, 5", []),
        ("TONR T64, 5", []),
        ("TON T31, 5", ["4:5 STL073"]),
        ("TOF T95, 5", ["4:5 STL073"]),
        ("TOF T96, 5", []),
        ("= Q0.0", []),
        ("= Q0.1", ["4:3 STL072"]),
        ("=I Q0.1", ["4:4 STL072"]),
        ("S Q0.1, 1", []),
    ],
)
def test_one_timer_and_one_coil_for_each(second: str, problems: list[str]) -> None:
    assert found(f"LD I0.0\nTON T37, 100\n= Q0.1\n{second}") == problems


def test_a_counter_belongs_to_one_instruction() -> None:
    assert found("LD I0.0\nLD I0.1\nCTU C1, 5\nLD I0.2\nLD I0.3\nCTD C1, 5") == ["6:5 STL071"]


def test_a_coil_of_another_block_counts_too() -> None:
    text = main("LD I0.0\n= M0.0", "LD I0.1\nCALL SBR_0") + subroutine(0, "LD I0.2\n= M0.0")
    (problem,) = problems_of(text)
    assert (problem.code, problem.related[0][1]) == ("STL072", "in MAIN (OB1), network 1")


def test_scratch_bits_and_segments_may_repeat_a_coil() -> None:
    assert found("LD I0.0\n= L60.0\nLD I0.1\n= L60.0") == []
    assert found(main("LSCR S0.0", "LD SM0.0\n= Q0.0", "SCRE", "LSCR S0.1", "LD SM0.0\n= Q0.0", "SCRE")) == []


# -- calls

SCALE = subroutine(
    0,
    "LD #Go\nMOVW #Raw, #Value",
    variables="VAR_INPUT\nGo:BOOL;\nRaw:INT;\nWhere:DWORD;\nEND_VAR\nVAR_IN_OUT\nSum:DINT;\nEND_VAR\nVAR_OUTPUT\nValue:INT;\nEND_VAR\n",
)


@pytest.mark.parametrize(
    ("parameters", "problems"),
    [
        ("I0.0, AIW0, &VB0, VD0, VW10", []),
        ("L63.7, *AC1, VD4, *VD8, AC0", []),
        ("M0.0, +100, 16#FF, LD0, T37", []),
        ("I0.0, AIW0, &VB0, VD0", ["6:6 STL081"]),
        ("I0.0, AIW0, &VB0, VD0, VW10, VB0", ["6:42 STL081"]),
        ("IB0, AIW0, &VB0, VD0, VW10", ["6:13 STL082"]),
        ("I0.0, VD0, &VB0, VD0, VW10", ["6:19 STL082"]),
        ("I0.0, AIW0, &VB0, VD0, VB10", ["6:36 STL082"]),
        ("1, AIW0, &VB0, VD0, VW10", ["6:13 STL026"]),
        ("I0.0, 70000, &VB0, VD0, VW10", ["6:19 STL025"]),
        ("I0.0, &VB0, &VB0, VD0, VW10", ["6:19 STL027"]),
        ("I0.0, AIW0, &VB0, 5, VW10", ["6:31 STL026"]),
        ("I0.0, AIW0, &VB0, VD0, 5", ["6:36 STL026"]),
        ("I0.0, AIW0, &VB0, VD0, AIW2", ["6:36 STL022"]),
        ("I0.0, AIW0, &VB0, HC0, VW10", ["6:31 STL022"]),
        ("I0.0, AIW0, Nix, VD0, VW10", ["6:25 STL032"]),
    ],
)
def test_parameters_have_the_number_and_types_of_their_declaration(parameters: str, problems: list[str]) -> None:
    assert found(main(f"LD SM0.0\nCALL SBR_0, {parameters}") + SCALE) == problems


def test_a_wrong_parameter_is_named() -> None:
    (problem,) = problems_of(main("LD SM0.0\nCALL SBR_0, I0.0, VB0, &VB0, VD0, VW0") + SCALE)
    assert problem.message == "parameter Raw (IN) of SBR_0 must be an INT; VB0 is a byte"


def test_a_string_parameter_takes_where_a_text_lies() -> None:
    text = subroutine(0, "LD SM0.0\nSCPY #Text, VB0", variables="VAR_INPUT\nText:STRING;\nEND_VAR\n")
    assert found(main("LD SM0.0\nCALL SBR_0, VB20\nCALL SBR_0, *AC1") + text) == []
    assert found(main("LD SM0.0\nCALL SBR_0, VD20") + text) == ["6:13 STL082"]
    assert found(main("LD SM0.0\nCALL SBR_0, LB20") + text) == ["6:13 STL022"]
    (problem,) = problems_of(main('LD SM0.0\nCALL SBR_0, "abc"') + text)
    assert (problem.code, problem.span.column) == ("STL026", 13)
    assert problem.message == 'parameter Text (IN) of SBR_0 is passed as the address of a text, and "abc" has none'
    assert problem.expected == 'where it lies in V memory: VB0, say, with VB0 "abc" in the data block'


def test_a_string_parameter_is_passed_on() -> None:
    variables = "VAR_INPUT\nText:STRING;\nEND_VAR\n"
    inner = subroutine(1, "LD SM0.0\nSCPY #Text, VB0", variables=variables)
    assert (
        found(
            main("LD SM0.0\nCALL SBR_0, VB20")
            + subroutine(0, "LD SM0.0\nCALL SBR_1, #Text", variables=variables)
            + inner
        )
        == []
    )


def test_targets_of_call_and_atch_must_exist() -> None:
    assert found("LD I0.0\nCALL SBR_3\nATCH INT_2, 10") == ["2:6 STL080", "3:6 STL080"]
    assert found(main("LD I0.0\nCALL INT_0") + interrupt(0, "LD I0.0\n= Q0.0")) == ["6:6 STL021"]


def chain(depth: int) -> str:
    """MAIN calls SBR_0 calls SBR_1 … ``depth`` calls in all."""
    blocks = [main("LD I0.0\nCALL SBR_0")]
    blocks += [subroutine(n, f"LD I0.0\nCALL SBR_{n + 1}") for n in range(depth - 1)]
    return "".join([*blocks, subroutine(depth - 1, "LD I0.0\n= Q0.0")])


def test_eight_calls_can_be_nested() -> None:
    assert found(chain(8)) == []
    (problem,) = problems_of(chain(9))
    assert (problem.code, problem.where) == ("STL084", "SBR_7 (SBR7), network 1")


def test_a_subroutine_of_an_interrupt_calls_no_other() -> None:
    text = chain(2) + interrupt(0, "LD SM0.0\nCALL SBR_0")
    assert [code.split()[1] for code in found(text)] == ["STL084"]
    assert found(chain(2) + interrupt(0, "LD SM0.0\nCALL SBR_1")) == []


def test_recursion_is_a_warning_at_each_call_of_the_circle() -> None:
    text = main("LD I0.0\nCALL SBR_0") + subroutine(0, "LD I0.0\nCALL SBR_1") + subroutine(1, "LD I0.0\nCALL SBR_0")
    assert [(p.code, p.is_error, p.where) for p in problems_of(text)] == [
        ("STL083", False, "SBR_0 (SBR0), network 1"),
        ("STL083", False, "SBR_1 (SBR1), network 1"),
    ]


def test_a_program_without_a_main_program_is_reported() -> None:
    assert found(subroutine(0, "LD I0.0\n= Q0.0")) == ["1:1 STL085"]


def test_a_data_block_beyond_the_cpu_is_reported() -> None:
    text = "LD I0.0\n= Q0.0\n//DATA_BLOCK\n//VB5000 1\n//END_DATA_BLOCK"
    assert found(text, "CPU 222") == ["4:3 STL048"]
    assert found(text) == []


def test_warnings_never_crowd_out_an_error() -> None:
    text = "LD I0.0\n= Q0.0\n" + "LD I0.0\n= Q0.0\n" * 1200 + "LD VB0\n= Q0.1"
    assert [p.code for p in problems_of(text) if p.is_error] == ["STL021"]
