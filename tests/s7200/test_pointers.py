"""Pointers: area code and offset."""

from __future__ import annotations

import pytest

from pcaccess.s7200.address import parse_address
from pcaccess.s7200.pointers import AREA_CODES, pointer_to


@pytest.mark.parametrize(
    ("text", "pointer"),
    [
        ("VB100", 0x0800_0064),
        ("VW0", 0x0800_0000),
        ("IB3", 0x0100_0003),
        ("QB0", 0x0200_0000),
        ("MB31", 0x0300_001F),
        ("SB2", 0x0400_0002),
        ("SMB34", 0x0500_0022),
        ("AIW4", 0x0600_0004),
        ("AQW2", 0x0700_0002),
        ("T37", 0x0900_004A),
        ("C1", 0x0A00_0002),
    ],
)
def test_a_pointer_is_area_code_and_byte_offset(text: str, pointer: int) -> None:
    assert pointer_to(parse_address(text)) == pointer


def test_no_area_has_code_0() -> None:
    assert 0 not in AREA_CODES.values()


@pytest.mark.parametrize("text", ["LB0", "HC0", "AC1"])
def test_l_hc_and_ac_have_no_pointers(text: str) -> None:
    with pytest.raises(KeyError):
        pointer_to(parse_address(text))
