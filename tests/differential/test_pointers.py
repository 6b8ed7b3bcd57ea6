"""Which pointers are good, and where they lead: at the ends of every area, in every execution."""

from __future__ import annotations

import struct
from collections.abc import Iterator

import pytest

from pcaccess.s7200.address import Area
from pcaccess.s7200.cpu import cpu_model
from pcaccess.s7200.memory import AREA_START
from pcaccess.stl.builder import Builder
from pcaccess.stl.ir import CheckPointer
from pcaccess.stl.ir_values import IrType
from pcaccess.stl.lower import pointer_areas
from tests.differential.executions import COMPILED
from tests.differential.side_by_side import Pair, function, module

AREAS = pointer_areas(cpu_model("CPU 224"))
BY_CODE = {area.code: area for area in AREAS}
HIGHEST = 0xFF_FFFF


def check(b: Builder) -> None:
    """Pointer and size in, flat address out."""
    out = b.new_value(IrType.I32)
    b.emit(CheckPointer(out, b.load_at(IrType.U32, 0), b.load_at(IrType.I32, 4)))
    b.store_at(8, out)


@pytest.fixture(scope="module", params=["compiled", "optimised"])
def pair(request: pytest.FixtureRequest) -> Pair:
    return Pair(module([function(check)], AREAS), COMPILED[request.param])


def checked(pair: Pair, pointer: int, size: int) -> list[int]:
    memories = pair.run(struct.pack(">Ii", pointer, size))
    return [struct.unpack_from(">i", memory, 8)[0] for memory in memories]


def at_the_ends() -> Iterator[tuple[int, int, int]]:
    """(pointer, size, flat address)."""
    for area in AREAS:
        for size in (1, 2, 4):
            last = area.size - size
            good = [offset for offset in {0, 1, last - 1, last} if 0 <= offset <= last]
            yield from ((area.code << 24 | offset, size, area.start + offset) for offset in good)
            yield from ((area.code << 24 | offset, size, -1) for offset in (last + 1, area.size, HIGHEST))


@pytest.mark.parametrize(("pointer", "size", "address"), list(at_the_ends()), ids=lambda n: f"{n:X}")
def test_a_pointer_reaches_to_the_end_of_its_area_and_no_further(
    pair: Pair, pointer: int, size: int, address: int
) -> None:
    assert checked(pair, pointer, size) == [address, address]


@pytest.mark.parametrize("code", [code for code in range(256) if code not in BY_CODE])
def test_a_pointer_to_no_area_is_bad(pair: Pair, code: int) -> None:
    for offset in (0, 1, HIGHEST):
        assert checked(pair, code << 24 | offset, 1) == [-1, -1]


def test_every_area_that_a_pointer_can_name_is_there() -> None:
    """System Manual, Indirect addressing: I, Q, V, M, S, T, C, and by choice SM and the analog areas."""
    starts = {area.start for area in AREAS}
    assert {AREA_START[area] for area in (Area.I, Area.Q, Area.V, Area.M, Area.S, Area.T, Area.C)} <= starts
    assert AREA_START[Area.L] not in starts
