"""Pieces of a bulk request are where ``split`` says they are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.opcua.fast.columns import Marker, windows

SHORT = b"\x0d\x00\x00\x00\xff\xff\xff\xff"
LONG = SHORT + b"\x00\x00\xff\xff\xff\xff"
pieces = st.lists(
    st.binary(max_size=9) | st.sampled_from([b"\x0d", b"\x0d\x00\x00\x00", SHORT[1:], b"\xff"]), max_size=8
)


@given(st.sampled_from([SHORT, LONG]), st.binary(max_size=5), pieces)
def test_a_marker_is_found_wherever_it_stands(marker: bytes, before: bytes, between: list[bytes]) -> None:
    data = before + marker.join(between)
    expected, at = [], data.find(marker, len(before))
    while at >= 0:
        expected.append(at)
        at = data.find(marker, at + 1)
    found = Marker(marker).positions(data, len(before), len(expected))
    assert ([] if found is None else found.tolist()) == expected
    assert Marker(marker).positions(data, len(before), len(expected) + 1) is None


def test_pieces_of_one_length_are_found_without_a_search() -> None:
    data = b"head" + (b"abc" + LONG) * 5
    found = Marker(LONG).positions(data, 4, 5)
    assert found is not None
    assert found.tolist() == [7 + 17 * n for n in range(5)]


@pytest.mark.parametrize("kind", ["<u4", "<u8", "V5"])
def test_windows_are_the_bytes_at_every_place(kind: str) -> None:
    data, size = bytes(range(20)), np.dtype(kind).itemsize
    assert [w.tobytes() for w in windows(data, kind)] == [data[n : n + size] for n in range(21 - size)]
    assert len(windows(b"ab", kind)) == 0
