"""Simulated values as a user writes them."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.project.sim import Wave, WaveError, WaveKind, parse_wave
from pcaccess.s7200.types import DataType, ValueRangeError, ValueTypeError


@pytest.mark.parametrize(
    ("text", "wave", "data_type"),
    [
        ("RAMP(10s, 0, 100)", Wave(WaveKind.RAMP, 10, 0, 100), DataType.REAL),
        (" sine ( 250ms ,-5,5.5 ) ", Wave(WaveKind.SINE, 0.25, -5, 5.5), DataType.REAL),
        ("Random(1min, 1, 2)", Wave(WaveKind.RANDOM, 60, 1, 2), DataType.REAL),
        ("TOGGLE(1s)", Wave(WaveKind.TOGGLE, 1), DataType.BOOL),
        ("COUNTER(1s)", Wave(WaveKind.COUNTER, 1), DataType.DINT),
        ("CONST(-7)", Wave(WaveKind.CONST, value=-7), DataType.DINT),
        ("CONST(1.5)", Wave(WaveKind.CONST, value=1.5), DataType.REAL),
        ("CONST(TRUE)", Wave(WaveKind.CONST, value=True), DataType.BOOL),
        ("CONST('it''s, (really)')", Wave(WaveKind.CONST, value="it's, (really)"), DataType.STRING),
        ("QUALITY(24, 5)", Wave(WaveKind.QUALITY, value=5, quality=24), DataType.DINT),
    ],
)
def test_a_simulated_value_is_read_in_any_case(text: str, wave: Wave, data_type: DataType) -> None:
    assert parse_wave(text) == wave
    assert wave.default_type is data_type


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("VW0", "expected one of RAMP"),
        ("SAW(1s, 0, 1)", "expected one of RAMP"),
        ("SINE", "expected one of RAMP"),
        ("SINE(1s, 0)", "2 values in brackets; expected SINE\\(period, low, high\\)"),
        ("TOGGLE()", "0 values in brackets"),
        ("CONST(1,)", "2 values in brackets"),
        ("SINE(1, 0, 1)", "1 has no unit"),
        ("SINE(0s, 0, 1)", "longer than nothing"),
        ("SINE(1s, 1, 0)", "low must be below high"),
        ("SINE(1s, a, 1)", "'a' is not a number"),
        ("CONST(nan)", "not a number a PLC could have"),
        ("CONST('x)", "cannot be read from"),
        ("QUALITY(256, 1)", "0 to 255"),
        ("QUALITY(GOOD, 1)", "0 to 255"),
    ],
)
def test_what_is_wrong_is_said(text: str, why: str) -> None:
    with pytest.raises(WaveError, match=why):
        parse_wave(text)


@pytest.mark.parametrize(
    ("text", "data_type"),
    [("RAMP(1s, 0, 256)", "BYTE"), ("SINE(1s, -1, 1)", "WORD"), ("CONST(40000)", "INT"), ("CONST(1)", "STRING"),
     ("SINE(1s, 0, 1)", "STRING"), ("CONST('x')", "INT"), ("CONST(1e300)", "REAL")],
)  # fmt: skip
def test_a_wave_must_fit_its_type(text: str, data_type: str) -> None:
    with pytest.raises((WaveError, ValueRangeError, ValueTypeError)):
        parse_wave(text).check(DataType[data_type])


@pytest.mark.parametrize(
    ("text", "data_type"), [("RAMP(1s, 0, 255)", "BYTE"), ("TOGGLE(1s)", "INT"), ("COUNTER(1s)", "REAL")]
)
def test_a_wave_may_have_any_type_that_holds_it(text: str, data_type: str) -> None:
    parse_wave(text).check(DataType[data_type])


@given(st.text(alphabet="SINECOT(),'0123456789.s -", max_size=40))
def test_no_text_does_more_than_say_that_it_is_no_wave(text: str) -> None:
    with contextlib.suppress(WaveError):
        parse_wave(text)
