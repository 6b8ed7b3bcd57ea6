"""The address grammar: every area, every spelling, and what is said about what is no address."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.s7200.address import Address, AddressError, Area, Width, parse_address
from pcaccess.s7200.types import DataType

BYTE_AREAS = [Area.I, Area.Q, Area.V, Area.M, Area.SM, Area.S, Area.L]


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("I0.7", Address(Area.I, 0, Width.BIT, 7)),
        ("QB1", Address(Area.Q, 1, Width.BYTE)),
        ("VW100", Address(Area.V, 100, Width.WORD)),
        ("MD4", Address(Area.M, 4, Width.DWORD)),
        ("SM0.5", Address(Area.SM, 0, Width.BIT, 5)),
        ("SMB28", Address(Area.SM, 28, Width.BYTE)),
        ("S3.1", Address(Area.S, 3, Width.BIT, 1)),
        ("SB3", Address(Area.S, 3, Width.BYTE)),
        ("LW60", Address(Area.L, 60, Width.WORD)),
        ("T37", Address(Area.T, 37, Width.WORD)),
        ("C5", Address(Area.C, 5, Width.WORD)),
        ("HC0", Address(Area.HC, 0, Width.DWORD)),
        ("AC3", Address(Area.AC, 3, Width.DWORD)),
        ("AIW4", Address(Area.AI, 4, Width.WORD)),
        ("AQW2", Address(Area.AQ, 2, Width.WORD)),
        ("VW0[10]", Address(Area.V, 0, Width.WORD, 0, 10)),
        ("V0.3[5]", Address(Area.V, 0, Width.BIT, 3, 5)),
        ("T0[256]", Address(Area.T, 0, Width.WORD, 0, 256)),
    ],
)
def test_every_area_has_its_form(text: str, address: Address) -> None:
    assert parse_address(text) == address
    assert str(address) == text


@pytest.mark.parametrize(
    ("text", "usual"),
    [
        (" vw100 ", "VW100"),
        ("VX0.1", "V0.1"),
        ("ix0.1", "I0.1"),
        ("V00100.03", "V100.3"),
        ("DB1.DBX2.3", "V2.3"),
        ("db1.dbb2", "VB2"),
        ("DB1.DBW2", "VW2"),
        ("DB1.DBD2[2]", "VD2[2]"),
        ("E0.0", "I0.0"),
        ("EB1", "IB1"),
        ("A0.0", "Q0.0"),
        ("AW2", "QW2"),
        ("AD4", "QD4"),
        ("AEW2", "AIW2"),
        ("AAW2", "AQW2"),
        ("Z5", "C5"),
        ("HZ0", "HC0"),
        ("AC0", "AC0"),
    ],
)
def test_other_spellings_mean_the_same_place(text: str, usual: str) -> None:
    assert str(parse_address(text)) == usual


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "the address is empty"),
        ("X0.0", "'X0.0' is not an address; expected an S7-200 address such as"),
        ("V", "is not an address"),
        ("V0", "V0: bit or width missing; write V0.0, VB0, VW0 or VD0"),
        ("V0.8", "V0.8: a byte has bits 0 to 7"),
        ("VW0.1", "VW0.1: only a bit has a '.'; for that bit write V0.1"),
        ("T37.0", "T37.0: T takes only a number, for example T37"),
        ("CW5", "CW5: C takes only a number, for example C5"),
        ("AC0.1", "AC0.1: AC takes only a number"),
        ("AI0", "AI0: analog values are words; write AIW0"),
        ("ai4", "write AIW4"),
        ("AIW3", "AIW3: analog words have even addresses, for example AIW2 or AIW4"),
        ("AIW0.1", "AIW0.1: analog values are words"),
        ("DB2.DBW0", "DB2.DBW0: an S7-200 has only data block 1"),
        ("DB1.DBW0.1", "only a bit has a '.'"),
        ("DB1.DBX0", "bit or width missing"),
        ("VW0[0]", "VW0[0]: an array has at least one element"),
        ("VW-1", "is not an address"),
        ("V٣.0", "is not an address"),
        ("V0." + "9" * 5000, "is not an address"),
        ("VB1234567", "is not an address"),
    ],
)
def test_what_is_no_address_says_why(text: str, said: str) -> None:
    with pytest.raises(AddressError) as caught:
        parse_address(text)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("text", "types"),
    [
        ("V0.0", "BOOL"),
        ("VB0", "BYTE CHAR STRING"),
        ("LB0", "BYTE CHAR STRING"),
        ("MB0", "BYTE CHAR"),
        ("IW0", "INT WORD"),
        ("QD0", "DINT DWORD REAL"),
        ("T0", "INT WORD BOOL"),
        ("C0", "INT WORD BOOL"),
        ("HC0", "DINT DWORD"),
        ("AC0", "DINT DWORD REAL INT WORD BYTE CHAR"),
        ("AIW0", "INT WORD"),
    ],
)
def test_the_types_an_address_can_have_begin_with_the_usual_one(text: str, types: str) -> None:
    assert " ".join(t.name for t in parse_address(text).types) == types


def test_a_timer_as_bool_is_its_bit() -> None:
    assert parse_address("T37[2]").as_type(DataType.BOOL) == Address(Area.T, 37, Width.BIT, 0, 2)


def test_an_accumulator_takes_the_width_of_the_type() -> None:
    widths = {t.name: parse_address("AC1").as_type(t).width for t in parse_address("AC1").types}
    assert widths["BYTE"] is Width.BYTE
    assert widths["INT"] is Width.WORD
    assert widths["REAL"] is Width.DWORD


@pytest.mark.parametrize(
    ("text", "data_type", "said"),
    [
        ("VW0", DataType.REAL, "VW0 is a word and cannot be REAL; it can be INT, WORD"),
        ("T37", DataType.DINT, "T37 is a timer and cannot be DINT; it can be INT, WORD, BOOL"),
        ("C5", DataType.REAL, "C5 is a counter and cannot be REAL"),
        ("Q0.0", DataType.BYTE, "Q0.0 is a bit and cannot be BYTE; it can be BOOL"),
        ("MB0", DataType.STRING, "MB0 is a byte and cannot be STRING; it can be BYTE, CHAR"),
        ("HC0", DataType.REAL, "HC0 is a double word and cannot be REAL; it can be DINT, DWORD"),
    ],
)
def test_a_type_that_does_not_fit_says_what_would(text: str, data_type: DataType, said: str) -> None:
    with pytest.raises(AddressError) as caught:
        parse_address(text).as_type(data_type)
    assert str(caught.value).startswith(said)


@st.composite
def addresses(draw: st.DrawFn) -> Address:
    area = draw(st.sampled_from(list(Area)))
    if area.is_analog:
        return Address(area, 2 * draw(st.integers(0, 30)), Width.WORD, 0, draw(st.integers(1, 99)))
    if area.is_numbered:
        width = Width.WORD if area in (Area.T, Area.C) else Width.DWORD
        return Address(area, draw(st.integers(0, 255)), width, 0, draw(st.integers(1, 99)))
    width = draw(st.sampled_from(list(Width)))
    bit = draw(st.integers(0, 7)) if width is Width.BIT else 0
    return Address(area, draw(st.integers(0, 99_999)), width, bit, draw(st.integers(1, 999)))


@given(addresses())
def test_a_printed_address_reads_back_the_same_in_any_case(address: Address) -> None:
    assert parse_address(str(address)) == address
    assert parse_address(str(address).lower()) == address


@given(addresses())
def test_every_type_an_address_says_it_can_have_it_can_have(address: Address) -> None:
    for data_type in DataType:
        if data_type in address.types:
            assert address.as_type(data_type).offset == address.offset
        else:
            with pytest.raises(AddressError):
                address.as_type(data_type)


@given(st.text(alphabet="IQVMSLTCHAEZBWDX0123456789.[]db ", max_size=20))
def test_no_text_does_more_than_say_that_it_is_no_address(text: str) -> None:
    with contextlib.suppress(AddressError):
        assert parse_address(str(parse_address(text))) == parse_address(text)
