"""Symbol tables of Micro/WIN in the forms in which they leave it."""

from __future__ import annotations

from pathlib import Path

import pytest

from pcaccess.problems import ProblemError
from pcaccess.project.importers.run import ImportResult, Kind, import_file
from pcaccess.project.load import load_text
from pcaccess.project.model import Item


def imported(folder: Path, table: str | bytes, name: str = "USER1.txt", encoding: str | None = None) -> ImportResult:
    path = folder / name
    path.write_bytes(table.encode() if isinstance(table, str) else table)
    return import_file(path, encoding=encoding)


def items(result: ImportResult) -> list[Item]:
    return list(load_text(result.yaml_text).project.all_items())


def test_a_copied_table_becomes_items_in_a_folder_of_its_name(tmp_path: Path) -> None:
    result = imported(tmp_path, "Motor\tQ0.0\tContactor\r\nLevel\tVW0\t\r\nTimer\tT37\r\n")
    assert result.kind is Kind.SYMBOLS
    assert [(item.item_id, str(item.address), item.data_type.name, item.description) for item in items(result)] == [
        ("MicroWin.NewPLC.USER1.Motor", "Q0.0", "BOOL", "Contactor"),
        ("MicroWin.NewPLC.USER1.Level", "VW0", "INT", ""),
        ("MicroWin.NewPLC.USER1.Timer", "T37", "INT", ""),
    ]


@pytest.mark.parametrize(
    "table",
    [
        '"Symbol","Address","Comment"\r\n"Motor","Q0.0","the ""big"" one, left"\r\n',
        '"Motor","Q     0.0","BOOL","the ""big"" one, left"\n',
        'Symbol;Address;Comment\nMotor;Q0.0;"the ""big"" one, left"\n',
        'x\t\tMotor\tA0.0\t"the ""big"" one, left"\n',
    ],
)
def test_every_form_of_the_table_is_understood(tmp_path: Path, table: str) -> None:
    (item,) = items(imported(tmp_path, table))
    assert (item.name, str(item.address), item.description) == ("Motor", "Q0.0", 'the "big" one, left')


def test_constants_and_program_blocks_are_counted_and_told_once(tmp_path: Path) -> None:
    table = "Motor\tQ0.0\nLimit\t100\nMask\t16#FF\nText\t'abc'\nMain\tOB1\nSub\tSBR0\nNothing\t\n"
    result = imported(tmp_path, table)
    assert (result.counts.items, result.counts.left_out) == (1, 6)
    assert [str(warning).split(": ", 1)[1] for warning in result.warnings] == [
        "warning PRJ036 5 symbols are constants or program blocks; items are addresses, so they are left out",
        "warning PRJ017 no address in 'Nothing'; left out",
    ]


def test_names_that_no_item_id_can_hold_are_mended_and_told(tmp_path: Path) -> None:
    result = imported(tmp_path, "a.b\tVW0\nA_b\tVW2\nc/d\tVW4\n")
    assert [item.name for item in items(result)] == ["a_b", "A_b_2", "c_d"]
    assert [warning.span.line for warning in result.warnings] == [1, 2, 3]


def test_link_plc_and_folder_can_be_named(tmp_path: Path) -> None:
    (tmp_path / "t.txt").write_text("Motor\tQ0.0\n")
    result = import_file(tmp_path / "t.txt", link="Line 1", plc="Press", folder="")
    assert [item.item_id for item in items(result)] == ["Line 1.Press.Motor"]


@pytest.mark.parametrize(
    ("encoding", "comment"),
    [
        ("cp1252", "Öl °C"),
        ("cp1251", "Насос подачи"),
        ("gbk", "电机启动"),
        ("utf-16", "电机"),
        ("utf-8", "Насос"),
    ],
)
def test_comments_keep_their_letters(tmp_path: Path, encoding: str, comment: str) -> None:
    (item,) = items(imported(tmp_path, f"Motor\tQ0.0\t{comment}\r\n".encode(encoding)))
    assert item.description == comment


def test_an_encoding_can_be_named(tmp_path: Path) -> None:
    (item,) = items(imported(tmp_path, "Motor\tQ0.0\t大\n".encode("gbk"), encoding="cp1252"))
    assert item.description == "´ó"


@pytest.mark.parametrize(
    ("table", "encoding", "why"),
    [
        ("", None, "the file is empty"),
        ("hello\nworld\n", None, "no symbol with an S7-200 address"),
        ("Limit\t100\n", None, "no symbol with an S7-200 address"),
        (b"GJK\x00R04.00", None, "a Micro/WIN project; export its symbol table"),
        (b"\x00\x01\x02", None, "not a text file"),
        ("Motor\tQ0.0\n", "klingon", "there is no encoding 'klingon'"),
        ("a\tQ0.0\nö\tQ0.1\n".encode("cp1252"), "utf-8", "the byte F6 is not utf-8"),
        ("Motor\tVW99999\n", None, "no item in it that an S7-200 could have"),
        ("x" * 200_000 + "\tQ0.0\n", None, "this is no table"),
    ],
)
def test_what_is_no_symbol_table_is_refused_in_words(
    tmp_path: Path, table: str | bytes, encoding: str | None, why: str
) -> None:
    with pytest.raises(ProblemError, match=why):
        imported(tmp_path, table, encoding=encoding)
