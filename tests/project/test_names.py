"""Run-time names in every form that clients of PC Access use."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.project.access import Access
from pcaccess.project.load import load_text
from pcaccess.project.model import limit_text
from pcaccess.project.names import RunTimeName, RunTimeNameError, Stations, parse_run_time_name
from pcaccess.s7200.address import Address, Area, Width, parse_address
from pcaccess.s7200.types import DataType

VW0 = parse_address("VW0")


def test_the_full_form_says_everything() -> None:
    name = parse_run_time_name("MicroWin:2:0.0.0.0:0000:0000,VW0,INT,RW,1000.000,200.000")
    assert name == RunTimeName(2, VW0, DataType.INT, Access.RW, 1000.0, 200.0, "MicroWin", "0.0.0.0", 0, 0)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("2:0.0.0.0:0000:0000,VW0,INT,RW", RunTimeName(2, VW0, DataType.INT, Access.RW, ip="0.0.0.0")),
        ("3:0.0.0.0:0000:0000,VW0,INT", RunTimeName(3, VW0, DataType.INT, ip="0.0.0.0")),
        (
            "2:161.218.182.132:1000:0301,vw0,int,rw",
            RunTimeName(2, VW0, DataType.INT, Access.RW, None, None, None, "161.218.182.132", 0x1000, 0x0301),
        ),
        (
            "MWSMART:2:192.168.2.1:0201:0201,VW0,WORD",
            RunTimeName(2, VW0, DataType.WORD, None, None, None, "MWSMART", "192.168.2.1", 0x0201, 0x0201),
        ),
        ("2,IB0,byte", RunTimeName(2, parse_address("IB0"), DataType.BYTE)),
        ("2,IB0", RunTimeName(2, parse_address("IB0"))),
        ("Micro Win:2,VW0", RunTimeName(2, VW0, link="Micro Win")),
        ("2:3:0.0.0.0,VW0", RunTimeName(3, VW0, link="2", ip="0.0.0.0")),
        ("2,VW0[10],INT", RunTimeName(2, parse_address("VW0[10]"), DataType.INT)),
        (" 2 , VW0 , INT , , 9 , 1 ", RunTimeName(2, VW0, DataType.INT, None, 9.0, 1.0)),
        ("2,T37,BOOL", RunTimeName(2, Address(Area.T, 37, Width.BIT), DataType.BOOL)),
    ],
)
def test_whatever_may_be_left_out_may_be_left_out(text: str, name: RunTimeName) -> None:
    assert parse_run_time_name(text) == name


def test_a_bit_written_with_the_decimal_comma_of_the_windows_it_comes_from_is_understood() -> None:
    text = "MicroWin:2:0.0.0.0:0000:0000,Q0,0,BOOL,R,0.0000000,0.0000000"
    assert parse_run_time_name(text).address == parse_address("Q0.0")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("MicroWin.NewPLC.Motor", "not a run-time name"),
        ("2", "not a run-time name"),
        (",VW0", "which station"),
        ("MicroWin,VW0", "which station"),
        (":2,VW0", "which station"),
        ("127,VW0", "0 to 126"),
        ("2:1.2.3.4:0:0:0,VW0", "which station"),
        ("2:1.2.3.4:G000:0000,VW0", "not a TSAP"),
        ("2:a/b,VW0", "not an IP address"),
        ("2,XW0", "not an address"),
        ("2,VW0,REAL", "cannot be REAL"),
        ("2,VW0,FLOAT", "no type 'FLOAT'"),
        ("2,VW0,INT,RX", "no access 'RX'"),
        ("2,VW0,INT,RW,much", "not a number"),
        ("2,VW0,INT,RW,inf", "not a number"),
        ("2,VW0,INT,RW,1,2,3", "7 parts"),
        ("²,VW0", "which station"),
    ],
)
def test_what_is_wrong_is_said(text: str, why: str) -> None:
    with pytest.raises(RunTimeNameError, match=why):
        parse_run_time_name(text)


def test_the_short_form_is_station_address_and_type() -> None:
    assert parse_run_time_name("MicroWin:2:0.0.0.0:0000:0000,vw0").short() == "2,VW0,INT"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0.0000000"),
        (-0.0, "0.0000000"),
        (1000, "1000.000"),
        (200.5, "200.500"),
        (0.12345, "0.12345"),
        (1e20, "1e+20"),
    ],
)
def test_limits_are_printed_as_pc_access_prints_them(value: float, text: str) -> None:
    assert limit_text(value) == text


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_printed_limit_reads_back_as_the_same_number(value: float) -> None:
    assert float(limit_text(value)) == value


@st.composite
def places(draw: st.DrawFn) -> tuple[Address, DataType | None]:
    area = draw(st.sampled_from([Area.V, Area.I, Area.M, Area.T, Area.C, Area.HC, Area.AC, Area.AI]))
    if area in (Area.T, Area.C):
        width = Width.WORD
    elif area in (Area.HC, Area.AC):
        width = Width.DWORD
    else:
        width = Width.WORD if area is Area.AI else draw(st.sampled_from(list(Width)))
    offset = draw(st.integers(0, 5000)) * (2 if area is Area.AI else 1)
    bit = draw(st.integers(0, 7)) if width is Width.BIT else 0
    address = Address(area, offset, width, bit, draw(st.integers(1, 20)))
    data_type = draw(st.sampled_from([None, *address.types]))
    return (address.as_type(data_type) if data_type else address), data_type


@st.composite
def names(draw: st.DrawFn) -> RunTimeName:
    address, data_type = draw(places())
    limits = st.none() | st.floats(allow_nan=False, allow_infinity=False).map(lambda value: value + 0.0)
    ip = draw(st.sampled_from([None, "0.0.0.0", "192.0.2.5", "oven-1.plant"]))
    tsaps = st.integers(0, 0xFFFF) if ip else st.just(0)
    return RunTimeName(
        station=draw(st.integers(0, 126)),
        address=address,
        data_type=data_type,
        access=draw(st.sampled_from([None, *Access])),
        high=draw(limits),
        low=draw(limits),
        link=draw(st.sampled_from([None, "MicroWin", "MWSMART", "Line 1", "7", "Größe"])),
        ip=ip,
        local_tsap=draw(tsaps),
        remote_tsap=draw(tsaps),
    )


@given(names())
def test_a_printed_name_reads_back_as_the_same_name(name: RunTimeName) -> None:
    assert parse_run_time_name(str(name)) == name
    assert replace(parse_run_time_name(str(name).lower()), link=name.link) == name


@given(st.text(alphabet="MicroWn:20.,VWBINTRqx [];\t\x00é", max_size=60))
def test_no_text_does_more_than_say_that_it_is_no_name(text: str) -> None:
    try:
        name = parse_run_time_name(text)
    except RunTimeNameError:
        return
    assert math.isfinite(name.station)


def test_the_run_time_name_of_an_item_means_its_own_plc_address_and_type() -> None:
    text = """
links:
  - name: MicroWin
    type: soft
    plcs:
      - {name: A, address: 2, items: [{name: X, address: vw0, high: 0.1, low: -7}, {name: T, address: T37, type: BOOL}]}
      - {name: B, address: 3, items: [{name: Y, address: "VW0[10]", access: R}, {name: S, address: VB9, type: STRING}]}
  - {name: Eth, type: s7tcp, plcs: [{name: C, host: 192.0.2.5, items: [{name: Z, address: VD0, type: REAL}]}]}
"""
    project = load_text(text).project
    stations = Stations(project)
    for plc in project.all_plcs():
        for item in plc.all_items():
            name = parse_run_time_name(item.run_time_name)
            assert stations.find(name) == [plc]
            assert (name.address, name.data_type, name.access) == (item.address, item.data_type, item.access)


STATIONS = """
links:
  - {name: MicroWin, type: soft, plcs: [{name: A, address: 2}, {name: B, address: 3}]}
  - {name: Eth, type: s7tcp, plcs: [{name: C, host: 192.0.2.5, remote_tsap: "10.01"}]}
  - {name: Sim, type: sim, plcs: [{name: D}]}
"""


@pytest.mark.parametrize(
    ("text", "plcs"),
    [
        ("3,VW0", ["MicroWin.B"]),
        ("2,VW0", ["MicroWin.A", "Eth.C"]),
        ("microwin:2,VW0", ["MicroWin.A"]),
        ("MicroWin:2:0.0.0.0:0201:0201,VW0", ["MicroWin.A"]),
        ("2:192.0.2.5:0000:0000,VW0", ["Eth.C"]),
        ("2:192.0.2.5:1000:1001,VW0", ["Eth.C"]),
        ("2:192.0.2.5:1000:0301,VW0", []),
        ("2:192.0.2.6:1000:1001,VW0", []),
        ("4,VW0", []),
        ("Sim:2,VW0", []),
    ],
)
def test_a_name_finds_the_plcs_it_may_mean(text: str, plcs: list[str]) -> None:
    stations = Stations(load_text(STATIONS).project)
    assert [plc.item_id for plc in stations.find(parse_run_time_name(text))] == plcs
