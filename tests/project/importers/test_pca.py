"""PC Access projects, from the real one in tests/data and from copies of it with other bytes."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Final

import pytest
import yaml

from pcaccess.problems import ProblemError
from pcaccess.project.importers.run import Counts, ImportResult, Kind, import_file
from pcaccess.project.load import load_text

SAMPLE: Final = Path(__file__).parents[2] / "data" / "pca" / "sample.pca"


def utf16(text: str) -> bytes:
    return text.encode("utf-16-le")


def changed(folder: Path, *changes: tuple[bytes, bytes]) -> ImportResult:
    """The sample with the first of some bytes replaced by others of the same length."""
    data = SAMPLE.read_bytes()
    for old, new in changes:
        assert len(old) == len(new)
        assert old in data
        data = data.replace(old, new, 1)
    path = folder / "changed.pca"
    path.write_bytes(data)
    return import_file(path)


def test_the_sample_becomes_a_project_with_everything_in_it() -> None:
    result = import_file(SAMPLE)
    assert result.kind is Kind.PCA
    assert result.warnings == ()
    assert result.counts == Counts(plcs=1, folders=1, items=4, left_out=0)
    (link,) = load_text(result.yaml_text).project.links
    (plc,) = link.plcs
    assert (plc.item_id, plc.address) == ("Microwin.Project1", 2)
    found = {item.item_id: (str(item.address), item.data_type.name, str(item.access)) for item in plc.all_items()}
    assert found == {
        "Microwin.Project1.USER1.Ut2": ("VB1", "BYTE", "RW"),
        "Microwin.Project1.USER1.Ut": ("QW1", "INT", "RW"),
        "Microwin.Project1.USER1.Heater": ("Q0.0", "BOOL", "RW"),
        "Microwin.Project1.USER1.Et": ("VW1", "INT", "RW"),
    }
    assert [item.description for item in plc.all_items()] == ["", "", "", "Check"]


def test_the_written_project_has_one_readable_line_for_each_item() -> None:
    lines = import_file(SAMPLE).yaml_text.splitlines()
    assert "              - {name: Et, address: VW1, type: INT, access: RW, description: Check}" in lines
    assert lines[0].startswith("# Imported from the PC Access project sample.pca.")
    assert yaml.safe_load("\n".join(lines))["project"] == "sample"


def test_the_run_time_names_of_the_items_are_those_of_pc_access() -> None:
    names = [item.run_time_name for item in load_text(import_file(SAMPLE).yaml_text).project.all_items()]
    assert names[0] == "Microwin:2:0.0.0.0:0000:0000,VB1,BYTE,RW,0.0000000,0.0000000"
    assert names[3] == "Microwin:2:0.0.0.0:0000:0000,VW1,INT,RW,0.0000000,0.0000000"


def test_access_is_carried_over(tmp_path: Path) -> None:
    result = changed(tmp_path, (b"VW1,INT,RW,0.0000000,", b"VW1,INT,R,00.0000000,"))
    assert [str(item.access) for item in load_text(result.yaml_text).project.all_items()] == ["RW", "RW", "RW", "R"]


@pytest.mark.parametrize(("first", "second"), [("2.000000e+002", "1.000000e+003"), ("1.000000e+003", "2.000000e+002")])
def test_limits_are_carried_over_from_either_order(tmp_path: Path, first: str, second: str) -> None:
    zero = "0.000000e+000"
    result = changed(tmp_path, (utf16(zero), utf16(first)), (utf16(zero), utf16(second)))
    limits = [(item.low, item.high) for item in load_text(result.yaml_text).project.all_items()]
    assert limits.count((200.0, 1000.0)) == 1
    assert limits.count((None, None)) == 3
    assert result.warnings == ()


def test_the_station_and_the_ip_address_come_from_the_run_time_names(tmp_path: Path) -> None:
    data = SAMPLE.read_bytes().replace(b":2:0.0.0.0:0000:0000,", b":7:1.2.3.4:1000:1001,")
    path = tmp_path / "ethernet.pca"
    path.write_bytes(data)
    result = import_file(path)
    assert "        address: 7\n" in result.yaml_text
    assert '# In PC Access: host: 1.2.3.4, local_tsap: "10.00", remote_tsap: "10.01"' in result.yaml_text


def test_an_item_of_another_station_than_its_plc_is_told(tmp_path: Path) -> None:
    result = changed(tmp_path, (b"2:0.0.0.0:0000:0000,Q0.0", b"3:0.0.0.0:0000:0000,Q0.0"))
    (warning,) = result.warnings
    assert "Microwin.Project1.USER1.Heater: station 3, while its PLC is station 2" in str(warning)


@pytest.mark.parametrize("address", [b"X0.0", b"Q0.9", b"QW99"])
def test_an_item_that_no_plc_could_have_is_left_out_and_told(tmp_path: Path, address: bytes) -> None:
    result = changed(tmp_path, (b",Q0.0,", b"," + address + b","))
    assert (result.counts.items, result.counts.left_out) == (3, 1)
    assert str(result.warnings[0]).endswith("left out")
    assert "Microwin.Project1.USER1.Heater" in str(result.warnings[0])


def test_an_item_without_a_run_time_name_is_left_out_and_told(tmp_path: Path) -> None:
    result = changed(tmp_path, (b":0000,QW1,INT,", b":0000 QW1 INT "))
    assert (result.counts.items, result.counts.left_out) == (3, 1)


def test_a_count_that_does_not_agree_is_told(tmp_path: Path) -> None:
    """The last row of DISTCONF says 4 items; it begins with its three columns' count and the number."""
    data = SAMPLE.read_bytes()
    at = data.rindex(b"\x04\x00\x00\x00", 0, data.rindex(b"Microwin:"))
    path = tmp_path / "x.pca"
    path.write_bytes(data[:at] + b"\x05" + data[at + 1 :])
    (warning,) = import_file(path).warnings
    assert "the project says it has 5 items, and 4 could be read" in str(warning)


def refusal(path: Path) -> str:
    with pytest.raises(ProblemError) as caught:
        import_file(path)
    return str(caught.value.problems[0]).removeprefix(f"{path.parent}/")


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (b"", "this is not a PC Access project"),
        (b"hello", "this is not a PC Access project"),
        (SAMPLE.read_bytes()[:100_000], "the file is cut off"),
        (SAMPLE.read_bytes()[:4096], "the database is damaged"),
        (b"\x00\x01\x00\x00Standard Jet DB\x00" + bytes(4076), "the database is damaged"),
        (SAMPLE.read_bytes().replace(utf16("TagList"), utf16("TagLost")), "not a PC Access project"),
    ],
)
def test_garbage_is_refused_in_words(tmp_path: Path, data: bytes, why: str) -> None:
    path = tmp_path / "x.pca"
    path.write_bytes(data)
    assert why in refusal(path)


def test_table_definitions_in_a_circle_do_not_go_on_for_ever(tmp_path: Path) -> None:
    data = bytearray(SAMPLE.read_bytes())
    page = next(start for start in range(4096, len(data), 4096) if data[start] == 2)
    data[page + 4 : page + 8] = (page // 4096).to_bytes(4, "little")
    path = tmp_path / "x.pca"
    path.write_bytes(data)
    assert "the database is damaged" in refusal(path)


@pytest.mark.parametrize("seed", range(12))
def test_a_damaged_project_is_read_or_refused_and_says_nothing_else(
    tmp_path: Path, seed: int, caplog: pytest.LogCaptureFixture
) -> None:
    dice = random.Random(seed)
    data = bytearray(SAMPLE.read_bytes())
    for _ in range(dice.randint(1, 400)):
        data[dice.randrange(19, len(data))] = dice.randrange(256)
    path = tmp_path / "x.pca"
    path.write_bytes(data)
    try:
        text = import_file(path).yaml_text
    except ProblemError as error:
        text = "links: []"
        assert error.problems[0].code == "PRJ001"  # noqa: PT017
    load_text(text)
    assert caplog.records == []
