"""Quality codes: the published numbers, both ways, with limit bits."""

from __future__ import annotations

import pytest
from asyncua.ua.status_codes import StatusCodes
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.items.quality import Limit, Quality, from_status, quality_text, split_code

# OPC DA code, Automation code, UA StatusCode; the reference table of the project, typed in again.
PUBLISHED = [
    ("BAD", 0, 0, 0x80000000),
    ("CONFIG_ERROR", 4, 4, 0x80890000),
    ("NOT_CONNECTED", 8, 8, 0x808A0000),
    ("DEVICE_FAILURE", 12, 12, 0x808B0000),
    ("SENSOR_FAILURE", 16, 16, 0x808C0000),
    ("LAST_KNOWN", 20, 20, 0x808D0000),
    ("COMM_FAILURE", 24, 24, 0x80310000),
    ("OUT_OF_SERVICE", 28, 28, 0x808D0000),
    ("WAITING_FOR_INITIAL_DATA", 32, 32, 0x80320000),
    ("UNCERTAIN", 64, 64, 0x40000000),
    ("LAST_USABLE", 68, 132, 0x40900000),
    ("SENSOR_CAL", 80, 144, 0x40930000),
    ("EGU_EXCEEDED", 84, 148, 0x40940000),
    ("SUB_NORMAL", 88, 152, 0x40950000),
    ("GOOD", 192, 192, 0x00000000),
    ("LOCAL_OVERRIDE", 216, 216, 0x00960000),
]


def test_no_quality_is_missing_or_invented() -> None:
    assert [q.name for q in Quality] == [name for name, *_ in PUBLISHED]


@pytest.mark.parametrize(("name", "code", "automation", "status"), PUBLISHED)
def test_a_quality_has_its_published_numbers(name: str, code: int, automation: int, status: int) -> None:
    quality = Quality[name]
    assert (quality.code, quality.automation_code, quality.status()) == (code, automation, status)


@pytest.mark.parametrize("quality", Quality)
def test_a_status_has_its_name_in_the_specification(quality: Quality) -> None:
    assert getattr(StatusCodes, quality.status_name) == quality.status()


@pytest.mark.parametrize("quality", Quality)
@pytest.mark.parametrize("limit", Limit)
def test_either_code_with_limit_bits_gives_quality_and_limit_back(quality: Quality, limit: Limit) -> None:
    assert split_code(quality.code | limit) == (quality, limit)
    assert split_code(quality.automation_code | limit) == (quality, limit)


@pytest.mark.parametrize("limit", Limit)
@pytest.mark.parametrize("quality", [q for q in Quality if q is not Quality.LAST_KNOWN])
def test_a_status_code_with_limit_bits_gives_quality_and_limit_back(quality: Quality, limit: Limit) -> None:
    assert from_status(quality.status(limit)) == (quality, limit)


def test_last_known_shares_a_status_code_which_reads_back_as_its_ua_name() -> None:
    assert from_status(Quality.LAST_KNOWN.status()) == (Quality.OUT_OF_SERVICE, Limit.NONE)


def test_limit_bits_without_their_info_type_mean_nothing() -> None:
    assert from_status(0x00000300) == (Quality.GOOD, Limit.NONE)
    assert from_status(0x00000700) == (Quality.GOOD, Limit.CONSTANT)


def test_a_vendor_byte_does_not_change_the_quality() -> None:
    assert split_code(0x5AC0) == (Quality.GOOD, Limit.NONE)


@pytest.mark.parametrize(("code", "quality"), [(36, Quality.BAD), (100, Quality.UNCERTAIN), (252, Quality.GOOD)])
def test_an_unknown_sub_status_is_its_major_quality(code: int, quality: Quality) -> None:
    assert split_code(code) == (quality, Limit.NONE)


@pytest.mark.parametrize(
    ("status", "quality"),
    [(0x00A20000, Quality.GOOD), (0x40EE0000, Quality.UNCERTAIN), (0x80EE0000, Quality.BAD), (0xC0EE0000, Quality.BAD)],
)
def test_an_unknown_status_code_is_judged_by_its_severity(status: int, quality: Quality) -> None:
    assert from_status(status) == (quality, Limit.NONE)


def test_the_samples_13_is_device_failure_at_its_low_limit() -> None:
    assert quality_text(13) == "DEVICE_FAILURE (low limit)"


def test_a_text_names_the_quality_and_its_limit() -> None:
    assert quality_text(192) == "GOOD"
    assert quality_text(195) == "GOOD (constant limit)"
    assert quality_text(-1) == "UNKNOWN (-1)"
    assert quality_text(0x10000) == "UNKNOWN (65536)"


@given(st.integers(0, 0xFFFF))
def test_every_16_bit_number_is_some_quality(code: int) -> None:
    quality, limit = split_code(code)
    assert quality.is_good == ((code & 0xFF) >> 6 == 3)
    assert limit == code & 3


@given(st.integers(0, 0xFFFFFFFF))
def test_every_status_code_keeps_its_severity(status: int) -> None:
    quality, _ = from_status(status)
    assert min(quality.status() >> 30, 2) == min(status >> 30, 2)
