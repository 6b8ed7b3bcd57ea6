"""What an item may say, and what does not go together; all through the project file."""

from __future__ import annotations

import pytest

from pcaccess.problems import ProblemError
from pcaccess.project.access import Access
from pcaccess.project.load import load_text
from pcaccess.project.model import Item
from pcaccess.s7200.types import DataType

LINKS = {
    "soft": "{name: L, type: soft, plcs: [{name: P, cpu: CPU 224, items: [ITEM]}]}",
    "sim": "{name: L, type: sim, plcs: [{name: P, items: [ITEM]}]}",
    "opcua": "{name: L, type: opcua, endpoint: 'opc.tcp://h:4840', plcs: [{name: P, items: [ITEM]}]}",
    "ppi": "{name: L, type: ppi, port: COM1, plcs: [{name: P, address: 2, items: [ITEM]}]}",
    "modbus-rtu": "{name: L, type: modbus-rtu, port: COM1, plcs: [{name: P, items: [ITEM]}]}",
}


def text(item: str, link: str = "soft") -> str:
    return f"links: [{LINKS[link].replace('ITEM', '{name: A, ' + item + '}')}]"


def load(item: str, link: str = "soft") -> Item:
    return next(load_text(text(item, link)).project.all_items())


def told(item: str, link: str = "soft") -> list[str]:
    """Code and message of errors, or of warnings where there are no errors."""
    try:
        problems = list(load_text(text(item, link)).warnings)
    except ProblemError as error:
        problems = error.problems
    return [f"{problem.code} {problem.message}" for problem in problems if problem.code != "PRJ032"]


@pytest.mark.parametrize(
    ("item", "message"),
    [
        ("address: VW0, type: REAL", "PRJ019 VW0 is a word and cannot be REAL; it can be INT, WORD"),
        ("address: Q0.0, type: BYTE", "PRJ019 Q0.0 is a bit and cannot be BYTE; it can be BOOL"),
        ("address: MB0, type: STRING", "PRJ019 MB0 is a byte and cannot be STRING; it can be BYTE, CHAR"),
        ("address: VB8190, type: STRING, length: 5", "PRJ018 VB8190: a CPU 224 has VB0 to VB8191"),
        ("address: 'VW8190[2]'", "PRJ018 VW8190[2]: a CPU 224 has VB0 to VB8191"),
        ("address: 'VB0[2]', type: STRING", "PRJ025 VB0[2]: there are no arrays of STRING"),
        ("address: VW0, length: 5", "PRJ025 length belongs to a STRING; this is INT"),
        ("address: VW0, raw_type: INT", "PRJ025 raw_type belongs to a scaled item; this one has no scaling"),
        (
            "address: AIW0, type: INT, scaling: {raw: [0, 1], scaled: [0, 1]}",
            "PRJ025 a scaled item is REAL; the type in the PLC is raw_type: INT",
        ),
        ("address: 'AIW0[2]', scaling: {raw: [0, 1], scaled: [0, 1]}", "PRJ025 arrays cannot be scaled"),
        ("address: Q0.0, scaling: {raw: [0, 1], scaled: [0, 1]}", "PRJ024 a BOOL cannot be scaled"),
        ("address: AIW0, scaling: {raw: [0, 0], scaled: [0, 1]}", "PRJ024 both ends are the same"),
        ("address: AIW0, scaling: {raw: [0, 1], scaled: [5, 5]}", "PRJ024 both ends are the same"),
        (
            "address: AIW0, scaling: {raw: [0, 1], scaled: [0, 1]}, raw_type: REAL",
            "PRJ019 AIW0 is a word and cannot be REAL; it can be INT, WORD",
        ),
        ("address: VW0, high: 5", "PRJ022 high without low; a range has both ends"),
        ("address: VW0, low: 5", "PRJ022 low without high; a range has both ends"),
        ("address: VW0, low: 5, high: 5", "PRJ022 high and low are both 5"),
        ("address: Q0.0, low: 0, high: 1", "PRJ025 high and low belong to numbers; this is BOOL"),
        ("address: VW0, write_limits: clamp", "PRJ023 clamp needs high and low, and this item has none"),
        ("address: VW0, write_limits: forbid", "PRJ011 there are no write limits 'forbid'"),
        ("address: VW0, access: RWX", "PRJ011 there is no access 'RWX'"),
        (
            "address: HC0, access: W",
            "PRJ026 HC0: the hardware counts, a program can only read it; access is taken as R",
        ),
        ("address: SMW28, access: RW", "PRJ026 SMW28: SMB0 to SMB29 are read-only in an S7-200; access is taken as R"),
        ("address: SM0.5", "PRJ034 SM0.5: only a running CPU keeps it true, and this PLC has no program"),
    ],
)
def test_what_does_not_go_together_is_said(item: str, message: str) -> None:
    assert told(item) == [message]


@pytest.mark.parametrize(
    ("item", "messages"),
    [
        ("address: VW0, type: WORD, low: -6, high: 60000", ["PRJ037 low -6 is beyond what a WORD holds"]),
        (
            "address: VW0, low: 40000, high: 0",  # told where it stands, whichever way round
            [
                "PRJ021 high 0 is below low 40000; taken the other way round",
                "PRJ037 low 40000 is beyond what an INT holds",
            ],
        ),
        ("address: VB0, low: 0, high: 256", ["PRJ037 high 256 is beyond what a BYTE holds"]),
        ("address: VB0, type: CHAR, low: -129, high: 127", ["PRJ037 low -129 is beyond what a CHAR holds"]),
        ("address: VD0, low: -3e9, high: 2147483647", ["PRJ037 low -3e+09 is beyond what a DINT holds"]),
        (
            "address: VD0, type: DWORD, low: 0, high: 4294967296",
            ["PRJ037 high 4.2949673e+09 is beyond what a DWORD holds"],
        ),
        ("address: VD0, type: REAL, low: 0, high: 3.5e38", ["PRJ037 high 3.5e+38 is beyond what a REAL holds"]),
        ("address: VD0, type: REAL, low: -3.4e38, high: 3.4e38", []),
        (
            "address: VB0, low: 300, high: 400",
            ["PRJ037 low 300 is beyond what a BYTE holds", "PRJ037 high 400 is beyond what a BYTE holds"],
        ),
        (
            "address: VB0, low: 300, high: 400, write_limits: clamp",
            ["PRJ022 no BYTE lies between 300 and 400, so that nothing could be written"],
        ),
        (
            "address: VB0, low: 0.2, high: 0.8, write_limits: refuse",
            ["PRJ022 no BYTE lies between 0.2 and 0.8, so that nothing could be written"],
        ),
        ("address: VB0, low: 0.2, high: 1, write_limits: refuse", []),
        (
            "address: AIW0, scaling: {raw: [0, 40000], scaled: [0, 10]}",
            ["PRJ037 raw 40000 is beyond what an INT holds"],
        ),
        (
            "address: AIW0, scaling: {raw: [-1, 70000], scaled: [0, 4e38]}, raw_type: WORD",
            [
                "PRJ037 raw -1 is beyond what a WORD holds",
                "PRJ037 raw 70000 is beyond what a WORD holds",
                "PRJ037 scaled 4e+38 is beyond what a REAL holds",
            ],
        ),
        # a scaled item's limits are engineering values
        ("address: AIW0, scaling: {raw: [0, 32000], scaled: [0, 1e6]}, low: 0, high: 1e6", []),
    ],
)
def test_limits_beyond_the_type_are_said(item: str, messages: list[str]) -> None:
    assert sorted(told(item)) == sorted(messages)


def test_what_a_type_holds_is_told_and_which_type_would_do() -> None:
    (problem,) = load_text(text("address: AIW0, scaling: {raw: [0, 40000], scaled: [0, 10]}")).warnings
    assert problem.expected == "-32768 to 32767, or raw_type: WORD"


@pytest.mark.parametrize("item", ["address: SM0.0", "address: SMB30", "address: SMW28, access: R"])
def test_special_memory_that_memory_alone_keeps_true_is_no_warning(item: str) -> None:
    assert told(item) == []


@pytest.mark.parametrize(
    ("item", "link", "message"),
    [
        ("address: VW0", "sim", "PRJ030 'VW0' is not a simulated value; expected one of"),
        ("address: 'SINE(1s, 0, 1)', type: STRING", "sim", "PRJ019 SINE(1s, 0, 1): SINE gives numbers, not a STRING"),
        ("address: 'RAMP(1s, 0, 300)', type: BYTE", "sim", "PRJ019 RAMP(1s, 0, 300): 300 does not fit BYTE (0 to 255)"),
        ("address: 'SINE(1s, 0, 1)', access: RW", "sim", "PRJ026 SINE(1s, 0, 1) is what it is; access is taken as R"),
        ("address: 'ns=2;s=x'", "opcua", "PRJ009 the key 'type' is missing: nobody can tell"),
        ("address: ' ', type: INT", "opcua", "PRJ017 the address is empty"),
        ("address: LW0", "ppi", "PRJ034 LW0: L memory is not visible from outside"),
        ("address: AC0", "ppi", "PRJ034 AC0: an accumulator is not visible from outside"),
        ("address: MW0", "modbus-rtu", "PRJ034 MW0: Modbus reaches I, Q, AI and V only"),
    ],
)
def test_every_kind_of_link_has_its_own_addresses(item: str, link: str, message: str) -> None:
    (line,) = told(item, link)
    assert line.startswith(message)


def test_several_mistakes_of_one_item_are_told_together() -> None:
    assert [line[:6] for line in told("address: VW0, type: FLOAT, access: X, high: 1, write_limits: no")] == [
        "PRJ011",
        "PRJ011",
        "PRJ022",
        "PRJ011",
    ]


def test_a_scaling_of_the_wrong_kind_is_one_mistake_and_not_two() -> None:
    assert told("address: AIW0, type: REAL, raw_type: INT, scaling: yes") == ["PRJ010 scaling: 'yes'"]


@pytest.mark.parametrize(
    ("scaling", "message"),
    [
        ("{raw: [0, 1]}", "PRJ009 the key 'scaled' is missing"),
        ("{raw: [0], scaled: [0, 1]}", "PRJ010 raw: 1 numbers"),
        ("{raw: [0, 1, 2], scaled: [0, 1]}", "PRJ010 raw: 3 numbers"),
        ("{raw: [0, x], scaled: [0, 1]}", "PRJ010 'x'"),
        ("{raw: [0, 1], scaled: [0, .inf]}", "PRJ010 '.inf'"),
        ("{raw: [0, 1], scaled: [0, 1], clip: true}", "PRJ008 unknown key 'clip'"),
        ("{raw: [0, 1], scaled: [0, 1], clamp: maybe}", "PRJ010 clamp: 'maybe'"),
    ],
)
def test_a_scaling_that_is_not_complete_is_one_mistake(scaling: str, message: str) -> None:
    assert told(f"address: AIW0, scaling: {scaling}") == [message]


def test_a_limit_of_the_wrong_kind_is_one_mistake_and_not_two() -> None:
    assert told("address: VW0, high: much, low: 1, write_limits: refuse") == ["PRJ010 high: 'much'"]


@pytest.mark.parametrize(
    ("item", "data_type", "raw_type"),
    [
        ("address: VB0", "REAL", "CHAR"),
        ("address: VD0", "REAL", "DINT"),
        ("address: VD0, raw_type: real", "REAL", "REAL"),
        ("address: VW0, raw_type: WORD, type: REAL", "REAL", "WORD"),
        ("address: C5", "REAL", "INT"),
    ],
)
def test_the_type_in_the_plc_of_a_scaled_item_is_signed_unless_it_says_otherwise(
    item: str, data_type: str, raw_type: str
) -> None:
    found = load(f"{item}, scaling: {{raw: [0, 1], scaled: [0, 1]}}")
    assert (found.data_type, found.raw_type) == (DataType[data_type], DataType[raw_type])


def test_a_string_has_room_for_254_characters_unless_it_says_otherwise() -> None:
    assert load("address: VB0, type: STRING").length == 254
    assert load("address: VB0, type: STRING, length: 32").length == 32
    assert load("address: VW0").length == 0


def test_a_timer_served_as_bool_is_its_bit() -> None:
    assert str(load("address: T37, type: BOOL").address) == "T37"
    assert load("address: T37, type: BOOL").address != load("address: T37").address


def test_a_simulated_constant_can_be_written_and_a_wave_cannot() -> None:
    assert load("address: CONST(5)", "sim").access is Access.RW
    assert load("address: TOGGLE(1s)", "sim").access is Access.R


def test_items_of_a_sort_share_what_they_have_in_common() -> None:
    both = "address: VW0, low: 0, high: 5, unit: bar, scaling: {raw: [0, 10], scaled: [0, 5]}"
    rest = f"{{name: B, {both}}}, {{name: C, address: VW0}}"
    a, b, c = load_text(text(f"{both}}}, {rest[:-1]}")).project.all_items()
    assert a.traits is b.traits
    assert (a.low, a.high, a.unit, a.data_type, a.raw_type) == (0, 5, "bar", DataType.REAL, DataType.INT)
    assert (c.low, c.unit, c.data_type, c.scaling) == (None, "", DataType.INT, None)
