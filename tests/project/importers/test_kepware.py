"""Kepware tag tables in, and our own export of a PLC out and in again."""

from __future__ import annotations

from pathlib import Path

import pytest

from pcaccess.problems import ProblemError
from pcaccess.project.diff import compare
from pcaccess.project.export import export_tags
from pcaccess.project.importers.run import Kind, import_file
from pcaccess.project.load import load_text
from pcaccess.project.model import Plc

HEADER = (
    "Tag Name,Address,Data Type,Client Access,Scaling,Raw Low,Raw High,Scaled Low,Scaled High,Clamp Low,Clamp High\n"
)

PLC = """
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: NewPLC
        address: 2
        items:
          - {name: Motor, address: Q0.0, description: "Contactor, left; \\"K1\\""}
          - {name: Byte, address: VB7, access: R}
          - {name: Char, address: VB8, type: CHAR, access: W}
          - {name: Word, address: MW2, type: WORD, unit: °C}
          - {name: Level, address: VW10, high: 1000.5, low: -200, write_limits: clamp}
          - {name: Range, address: VW12, high: 0.1, low: 0}
          - {name: Long, address: VD20}
          - {name: DWord, address: VD24, type: DWORD}
          - {name: Real, address: VD28, type: REAL}
          - {name: Text, address: VB100, type: STRING, length: 32}
          - {name: Row, address: "VW200[10]", type: WORD}
          - {name: Pressure, address: AIW0, scaling: {raw: [0, 32000], scaled: [-1.5, 10], clamp: true}}
          - {name: Scaled, address: VD32, raw_type: REAL, scaling: {raw: [0, 1], scaled: [0, 100]}}
          - {name: Timer, address: T37}
          - {name: TimerBit, address: T38, type: BOOL}
          - {name: Fast, address: HC0}
          - {name: Accu, address: AC1, type: BYTE}
        folders:
          - name: Hall
            items: [{name: A, address: V5.7}]
            folders:
              - {name: Oven, items: [{name: B, address: SMB30}]}
"""


def only_plc(text: str) -> Plc:
    (plc,) = load_text(text).project.all_plcs()
    return plc


def test_what_is_exported_is_imported_the_same(tmp_path: Path) -> None:
    path = tmp_path / "NewPLC.csv"
    path.write_text(export_tags(only_plc(PLC), ours=True).text, newline="")
    result = import_file(path)
    assert result.kind is Kind.KEPWARE
    assert [str(warning) for warning in result.warnings if warning.code != "PRJ034"] == []
    changes = compare(load_text(PLC).project, load_text(result.yaml_text).project)
    assert not changes.items
    assert not changes.folders


def test_what_is_exported_can_stand_behind_items_from(tmp_path: Path) -> None:
    (tmp_path / "tags.csv").write_text(export_tags(only_plc(PLC), ours=True).text, newline="")
    text = "links: [{name: MicroWin, type: soft, plcs: [{name: NewPLC, items_from: tags.csv}]}]"
    assert not compare(load_text(PLC).project, load_text(text, base=tmp_path).project).items


def test_simulated_items_are_exported_and_come_back_too(tmp_path: Path) -> None:
    text = (
        "links:\n  - name: S\n    type: sim\n    plcs:\n      - name: P\n        items:\n"
        '          - {name: A, address: "SINE(10s, 0, 100)"}\n'
        "          - {name: B, address: \"CONST('a, b')\"}\n"
    )
    exported = export_tags(only_plc(text), ours=True).text
    (tmp_path / "tags.csv").write_text(exported, newline="")
    back = load_text("links: [{name: S, type: sim, plcs: [{name: P, items_from: tags.csv}]}]", base=tmp_path)
    assert not compare(load_text(text).project, back.project).items


def test_the_export_is_what_kepware_reads() -> None:
    lines = export_tags(only_plc(PLC)).text.splitlines()
    assert lines[0] == (
        "Tag Name,Address,Data Type,Respect Data Type,Client Access,Scan Rate,Scaling,Raw Low,Raw High,Scaled Low,"
        "Scaled High,Scaled Data Type,Clamp Low,Clamp High,Eng Units,Description,Negate Value"
    )
    assert lines[1] == 'Motor,Q0.0,Boolean,1,R/W,100,None,,,,,,0,0,,"Contactor, left; ""K1""",0'
    assert "Word,M2,Word,1,R/W,100,None,,,,,,0,0,°C,,0" in lines
    assert "Text,V100.32,String,1,R/W,100,None,,,,,,0,0,,,0" in lines
    assert "Pressure,AIW0,Short,1,R/W,100,Linear,0.0,32000.0,-1.5,10.0,Float,1,1,,,0" in lines
    assert lines[-1].startswith("Hall.Oven.B,SM30,Byte")


def test_an_export_in_kepwares_columns_alone_says_how_many_items_lose_their_limits() -> None:
    assert (export_tags(only_plc(PLC)).lost, export_tags(only_plc(PLC), ours=True).lost) == (2, 0)
    assert export_tags(only_plc(PLC)).items == 19


def test_rows_that_no_item_can_be_are_left_out_and_told(tmp_path: Path) -> None:
    rows = "A,V0,Word\nB,V2,LBCD\nC,V4,Word,XX\nD,V6,Short,RO,Square Root,0,1,0,1\nE,V99999,Word\n,V8,Word\n"
    (tmp_path / "k.csv").write_text(HEADER + rows)
    result = import_file(tmp_path / "k.csv")
    assert (result.counts.items, result.counts.left_out) == (1, 5)
    assert [warning.span.line for warning in result.warnings] == [3, 4, 5, 6, 7]
    assert all("left out" in str(warning) for warning in result.warnings)


def test_an_end_that_is_clamped_alone_is_told_and_the_item_taken(tmp_path: Path) -> None:
    (tmp_path / "k.csv").write_text(HEADER + "A,V0,Short,RO,Linear,0,1,0,1,1,0\n")
    result = import_file(tmp_path / "k.csv")
    assert [warning.code for warning in result.warnings] == ["PRJ036"]
    assert result.counts.items == 1


def test_a_table_without_addresses_is_none(tmp_path: Path) -> None:
    (tmp_path / "k.csv").write_text("Tag Name,Data Type\nA,Word\n")
    with pytest.raises(ProblemError, match="no column 'Address'"):
        import_file(tmp_path / "k.csv", kind=Kind.KEPWARE)


def test_nothing_usable_says_why(tmp_path: Path) -> None:
    (tmp_path / "k.csv").write_text(HEADER + "A,V99999,Word\n")
    with pytest.raises(ProblemError) as caught:
        import_file(tmp_path / "k.csv")
    assert [problem.code for problem in caught.value.problems] == ["PRJ001", "PRJ018"]
