"""The one buffer: where an address lies, and that nothing lies on anything else."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.s7200.address import Address, Area, Width, parse_address
from pcaccess.s7200.cpu import cpu_model
from pcaccess.s7200.memory import (
    AREA_BYTES,
    AREA_START,
    C_BITS,
    MEMORY_SIZE,
    T_BITS,
    locate,
    read_value,
    write_value,
)
from pcaccess.s7200.types import DataType, Value, ValueRangeError

BIGGEST = cpu_model("CPU 226")


def test_areas_and_the_bits_of_timers_and_counters_fill_the_buffer_without_gap_or_overlap() -> None:
    pieces = sorted((AREA_START[area], AREA_START[area] + size) for area, size in AREA_BYTES.items())
    pieces += [(T_BITS, T_BITS + 32), (C_BITS, C_BITS + 32)]
    assert [start for start, _ in pieces] == [0, *(end for _, end in pieces[:-1])]
    assert pieces[-1][1] == MEMORY_SIZE


def test_every_area_has_a_place() -> None:
    assert set(AREA_START) == set(Area)


@pytest.mark.parametrize(
    ("text", "data_type", "area", "offset", "bit"),
    [
        ("V10.3", DataType.BOOL, Area.V, 10, 3),
        ("VW10", DataType.INT, Area.V, 10, 0),
        ("T37", DataType.INT, Area.T, 74, 0),
        ("C5", DataType.WORD, Area.C, 10, 0),
        ("HC1", DataType.DINT, Area.HC, 4, 0),
        ("AC1", DataType.DINT, Area.AC, 4, 0),
        ("AC1", DataType.INT, Area.AC, 6, 0),
        ("AC1", DataType.BYTE, Area.AC, 7, 0),
        ("AIW4", DataType.INT, Area.AI, 4, 0),
    ],
)
def test_an_address_lies_in_its_area(text: str, data_type: DataType, area: Area, offset: int, bit: int) -> None:
    assert locate(parse_address(text).as_type(data_type)) == (AREA_START[area] + offset, bit)


def test_the_bits_of_timers_and_counters_are_apart_from_their_values() -> None:
    assert locate(parse_address("T37").as_type(DataType.BOOL)) == (T_BITS + 4, 5)
    assert locate(parse_address("C255").as_type(DataType.BOOL)) == (C_BITS + 31, 7)


def test_a_word_is_its_two_bytes_the_high_one_first() -> None:
    memory = bytearray(MEMORY_SIZE)
    write_value(memory, parse_address("VW0"), DataType.INT, 0x1234)
    assert read_value(memory, parse_address("VB0"), DataType.BYTE) == 0x12
    assert read_value(memory, parse_address("VB1"), DataType.BYTE) == 0x34
    write_value(memory, parse_address("V1.0"), DataType.BOOL, True)
    assert read_value(memory, parse_address("VW0"), DataType.INT) == 0x1235


@st.composite
def places(draw: st.DrawFn) -> tuple[Address, DataType]:
    area = draw(st.sampled_from(list(Area)))
    size = BIGGEST.sizes[area]
    if area.is_numbered:
        width = Width.WORD if area in (Area.T, Area.C) else Width.DWORD
        address = Address(area, draw(st.integers(0, size - 1)), width)
    elif area.is_analog:
        address = Address(area, 2 * draw(st.integers(0, size // 2 - 1)), Width.WORD)
    else:
        width = draw(st.sampled_from(list(Width)))
        bit = draw(st.integers(0, 7)) if width is Width.BIT else 0
        address = Address(area, draw(st.integers(0, size - width.size)), width, bit)
    data_type = draw(st.sampled_from([t for t in address.types if t is not DataType.STRING]))
    return address.as_type(data_type), data_type


def values(data_type: DataType) -> st.SearchStrategy[Value]:
    if data_type is DataType.BOOL:
        return st.booleans()
    if data_type is DataType.REAL:
        return st.floats(width=32, allow_nan=False)
    return st.integers(data_type.low, data_type.high)


@given(places(), st.data(), st.booleans())
def test_a_value_written_is_read_and_touches_nothing_else(
    place: tuple[Address, DataType], data: st.DataObject, ones: bool
) -> None:
    address, data_type = place
    memory = bytearray([0xFF if ones else 0x00]) * MEMORY_SIZE
    before = bytes(memory)
    value = data.draw(values(data_type))
    write_value(memory, address, data_type, value)
    assert read_value(memory, address, data_type) == value
    start, bit = locate(address)
    end = start + data_type.size
    assert memory[:start] + memory[end:] == before[:start] + before[end:]
    if data_type is DataType.BOOL:
        assert (memory[start] ^ before[start]) & ~(1 << bit) == 0


def test_a_value_that_does_not_fit_changes_nothing() -> None:
    memory = bytearray(MEMORY_SIZE)
    with pytest.raises(ValueRangeError):
        write_value(memory, parse_address("VW0"), DataType.INT, 40_000)
    with pytest.raises(ValueRangeError):
        write_value(memory, parse_address("VB0"), DataType.STRING, "abcd", length=3)
    assert memory == bytes(MEMORY_SIZE)


def test_a_string_is_written_with_its_length() -> None:
    memory = bytearray(MEMORY_SIZE)
    write_value(memory, parse_address("VB10"), DataType.STRING, "Halt", length=8)
    assert read_value(memory, parse_address("VB10"), DataType.STRING) == "Halt"
    assert memory[AREA_START[Area.V] + 10 :][:5] == b"\x04Halt"
