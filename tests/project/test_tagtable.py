"""Tag tables in Kepware's columns, as ``items_from`` names them."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import pytest

from pcaccess.problems import ProblemError
from pcaccess.project.access import Access
from pcaccess.project.load import Loaded, load_text
from pcaccess.project.model import Item, Scaling
from pcaccess.s7200.types import DataType

HEADER = (
    "Tag Name,Address,Data Type,Respect Data Type,Client Access,Scan Rate,Scaling,Raw Low,Raw High,Scaled Low,"
    "Scaled High,Scaled Data Type,Clamp Low,Clamp High,Eng Units,Description,Negate Value\n"
)
PROJECT = "links: [{name: L, type: soft, plcs: [{name: P, items_from: tags.csv}]}]"


def load(folder: Path, table: str | bytes, project: str = PROJECT) -> Loaded:
    (folder / "tags.csv").write_bytes(table.encode() if isinstance(table, str) else table)
    return load_text(project, base=folder)


def items(folder: Path, table: str | bytes) -> dict[str, Item]:
    return {item.item_id: item for item in load(folder, table).project.all_items()}


def item(folder: Path, row: str, header: str = HEADER) -> Item:
    (only,) = items(folder, header + row + "\n").values()
    return only


def errors(folder: Path, table: str) -> list[str]:
    with pytest.raises(ProblemError) as caught:
        load(folder, table)
    return [str(problem).removeprefix(f"{folder}/") for problem in caught.value.problems]


def test_a_row_becomes_an_item_in_the_folders_of_its_name(tmp_path: Path) -> None:
    found = item(tmp_path, 'Hall.Oven.Temp,VW0,Short,1,R/W,100,None,,,,,,0,0,°C,"Oven, left",0')
    assert found.item_id == "L.P.Hall.Oven.Temp"
    assert (found.data_type, found.access, found.unit, found.description) == (
        DataType.INT,
        Access.RW,
        "°C",
        "Oven, left",
    )
    assert found.name == "Temp"


@pytest.mark.parametrize(
    ("address", "kepware_type", "own", "data_type"),
    [
        ("V100", "", "VB100", "BYTE"),
        ("V00100", "Byte", "VB100", "BYTE"),
        ("V100", "Word", "VW100", "WORD"),
        ("V100", "Short", "VW100", "INT"),
        ("V100", "Long", "VD100", "DINT"),
        ("V100", "Float", "VD100", "REAL"),
        ("V00100.03", "Boolean", "V100.3", "BOOL"),
        ("V100.32", "String", "VB100", "STRING"),
        ("V100[5]", "Word Array", "VW100[5]", "WORD"),
        ("I0.7", "Boolean", "I0.7", "BOOL"),
        ("SM66", "Byte", "SMB66", "BYTE"),
        ("AI4", "Short", "AIW4", "INT"),
        ("T37", "Boolean", "T37", "BOOL"),
        ("VD4", "Default", "VD4", "DINT"),
        ("VW4", "INT", "VW4", "INT"),
    ],
)
def test_kepware_addresses_without_type_letter_take_the_width_of_the_type(
    tmp_path: Path, address: str, kepware_type: str, own: str, data_type: str
) -> None:
    found = item(tmp_path, f"A,{address},{kepware_type}")
    assert (str(found.address), found.data_type.name) == (own, data_type)


def test_the_number_behind_a_kepware_string_is_its_length(tmp_path: Path) -> None:
    assert item(tmp_path, "A,V100.32,String").length == 32


@pytest.mark.parametrize(
    ("cell", "access"),
    [
        ("RO", Access.R),
        ("R", Access.R),
        ("RW", Access.RW),
        ("R/W", Access.RW),
        ("r/w", Access.RW),
        ("W", Access.W),
        ("", Access.RW),
    ],
)
def test_access_is_read_in_every_spelling(tmp_path: Path, cell: str, access: Access) -> None:
    assert item(tmp_path, f"A,VW0,Word,1,{cell}").access is access


def test_linear_scaling_makes_a_real_over_the_type_of_the_tag(tmp_path: Path) -> None:
    found = item(tmp_path, "A,AIW0,Short,1,RO,100,Linear,0,32000,0,10.5,Double,1,1,bar,,0")
    assert (found.data_type, found.raw_type) == (DataType.REAL, DataType.INT)
    assert found.scaling == Scaling(0, 32000, 0, 10.5, clamp=True)


def test_a_negated_value_is_a_scaling_too(tmp_path: Path) -> None:
    assert item(tmp_path, "A,VW0,Short,1,RO,100,None,,,,,,0,0,,,1").scaling == Scaling(0, 1, 0, -1)
    negated = item(tmp_path, "A,VW0,Short,1,RO,100,Linear,0,10,0,100,,0,0,,,Yes").scaling
    assert negated == Scaling(0, 10, 0, -100)


def test_old_column_names_any_order_a_semicolon_and_a_decimal_comma_are_understood(tmp_path: Path) -> None:
    header = "Eng. Units;Address;Tag Name;Scaling;Raw Low;Raw High;Scaled Low;Scaled High\n"
    found = item(tmp_path, "°C;VW0;T;Linear;0;1000;-0,5;99,5", header)
    assert (found.unit, found.scaling) == ("°C", Scaling(0, 1000, -0.5, 99.5))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_every_encoding_that_spreadsheets_save_is_read(tmp_path: Path, encoding: str) -> None:
    table = "Tag Name,Address,Eng Units\r\nÖl,VW0,°C\r\n".encode(encoding)
    assert items(tmp_path, table)["L.P.Öl"].unit == "°C"


def test_our_own_columns_carry_what_kepware_does_not_know(tmp_path: Path) -> None:
    header = "Tag Name,Address,Data Type,Low,High,Write Limits,Length\n"
    rows = "A,VW0,Short,200,1000,refuse,\nB,VB9,String,,,,20\n"
    found = items(tmp_path, header + rows)
    assert (found["L.P.A"].low, found["L.P.A"].high, found["L.P.A"].write_limits.value) == (200, 1000, "refuse")
    assert found["L.P.B"].length == 20


def test_tags_stand_beside_items_and_may_lie_in_the_same_folders(tmp_path: Path) -> None:
    project = (
        "links: [{name: L, type: soft, plcs: [{name: P, items_from: tags.csv,"
        " folders: [{name: Hall, items: [{name: A, address: VW0}]}]}]}]"
    )
    plc = next(load(tmp_path, HEADER + "hall.B,VW2\nC,VW4\n", project).project.all_plcs())
    assert [found.item_id for found in plc.all_items()] == ["L.P.C", "L.P.Hall.A", "L.P.Hall.B"]


def test_sim_tags_have_simulated_addresses(tmp_path: Path) -> None:
    project = PROJECT.replace("soft", "sim")
    (found,) = load(tmp_path, HEADER + 'A,"RAMP(10s, 0, 100)",Float\n', project).project.all_items()
    assert (found.address, found.access) == ("RAMP(10s, 0, 100)", Access.R)


@pytest.mark.parametrize(
    ("row", "line"),
    [
        ("A,VW9000", "2:3: PRJ018 VW9000: a CPU 224 has VB0 to VB8191"),
        ('"A",VX', "2:5: PRJ017 'VX' is not an address; expected an S7-200 address such as"),
        ('"a ""b"" c",VW0,Real4', "2:17: PRJ011 there is no type 'REAL4'; expected one of BOOL, BYTE"),
        ("A,VW0,LBCD", "2:7: PRJ011 there is no type LBCD in an S7-200; expected one of BOOL"),
        ("A,V0.9,Boolean", "2:3: PRJ017 V0.9: a byte has bits 0 to 7"),
        ("A,V0,Boolean", "2:3: PRJ017 V0: bit or width missing; write V0.0"),
        ("A,VW0,Word,1,XY", "2:14: PRJ011 there is no access 'XY'; expected RO, RW, R/W, R or W"),
        ("A,AIW0,Short,1,RO,100,Square Root,0,1,0,1", "2:23: PRJ024 there is no scaling 'square root'; expected None"),
        ("A,AIW0,Short,1,RO,100,Linear,0,,0,1", "2:23: PRJ024 an end of the scaling is missing; expected four numbers"),
        ("A,AIW0,Short,1,RO,100,Linear,0,x,0,1", "2:32: PRJ010 'x'; expected a number such as 12.5"),
        (",VW0", "2:1: PRJ009 the tag has no name"),
        ("A.,VW0", "2:1: PRJ014 the name is empty"),
        ("A:B,VW0", "2:1: PRJ014 the name 'A:B': ':' separates"),
        ("X,VW0\n\nx,VW2", "4:1: PRJ015 there are two of L.P.x; case makes no difference"),
        ('D,"V\nW0"\nA,VW9000', "2:3: PRJ017"),
    ],
)
def test_a_mistake_is_told_at_its_cell(tmp_path: Path, row: str, line: str) -> None:
    project = PROJECT.replace("{name: P", "{name: P, cpu: CPU 224")
    (tmp_path / "tags.csv").write_text(HEADER + row + "\n")
    with pytest.raises(ProblemError) as caught:
        load_text(project, base=tmp_path)
    assert str(caught.value.problems[0]).startswith(f"{tmp_path}/tags.csv:{line}")


def test_mistakes_of_every_row_are_told_at_once_and_with_those_of_the_project(tmp_path: Path) -> None:
    (tmp_path / "tags.csv").write_text(HEADER + "A,XW0\nB,VW0,Nope\nC,VW0\n")
    with pytest.raises(ProblemError) as caught:
        load_text(PROJECT + "\ngroups: [{name: G, items: [L.P.C, L.P.D]}]", base=tmp_path)
    assert sorted(problem.code for problem in caught.value.problems) == ["PRJ011", "PRJ017", "PRJ029"]


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("", "no column 'Tag Name'"),
        ("Name,Adress\nA,VW0\n", "no column 'Address'; expected a header such as .*; did you mean 'Adress'"),
        ("<html><body></body></html>", "no column 'Tag Name'"),
    ],
)
def test_a_table_without_its_columns_is_none(tmp_path: Path, table: str, words: str) -> None:
    with pytest.raises(ProblemError, match=words):
        load(tmp_path, table)


def test_a_file_that_is_no_table_is_told_where_the_project_names_it(tmp_path: Path) -> None:
    (tmp_path / "tags.csv").write_bytes(b"PK\x03\x04\x00\x00")
    with pytest.raises(ProblemError, match=r"items\.yaml:1:60: PRJ001 tags\.csv: this is an archive or a workbook"):
        load_text(PROJECT, base=tmp_path)


def test_an_item_costs_little(tmp_path: Path) -> None:
    count = 5000
    rows = "".join(
        f"F{n // 100}.Tag{n},VW{2 * n},Short,1,RO,100,,,,,,,0,0,bar,Tag number {n},0\n" for n in range(count)
    )
    (tmp_path / "tags.csv").write_text(HEADER + rows)
    load_text(PROJECT, base=tmp_path)  # what is made once does not count
    tracemalloc.start()
    loaded = load_text(PROJECT, base=tmp_path)
    bytes_per_item = tracemalloc.get_traced_memory()[0] / count
    tracemalloc.stop()
    assert sum(1 for _ in loaded.project.all_items()) == count
    assert bytes_per_item < 300
