"""Drafts are made fit for a project file, whatever their source called things."""

from __future__ import annotations

from pcaccess.problems import Span
from pcaccess.project.importers.draft import Draft, DraftItem, DraftPlc, clean
from pcaccess.project.importers.write import yaml_of
from pcaccess.project.itemtext import ItemText
from pcaccess.project.load import load_text

HERE = Span("x", 7, 1)


def item(path: str, address: str = "VB0", **more: object) -> DraftItem:
    *folders, name = path.split("|")
    return DraftItem(tuple(folders), ItemText(name, address, **more), HERE)  # type: ignore[arg-type]


def cleaned(*plcs: DraftPlc) -> Draft:
    draft = Draft("x", "a test", list(plcs))
    clean(draft)
    return draft


def ids(draft: Draft) -> list[str]:
    return [found.item_id for found in load_text(yaml_of(draft, "x")).project.all_items()]


def test_one_folder_in_two_spellings_is_one_folder() -> None:
    draft = cleaned(DraftPlc("L", "P", items=[item("Hall|a"), item("HALL|b"), item("hall|C|d")]))
    assert ids(draft) == ["L.P.Hall.a", "L.P.Hall.b", "L.P.Hall.C.d"]
    assert draft.warnings == []


def test_an_item_and_a_folder_of_one_name_get_along() -> None:
    assert ids(cleaned(DraftPlc("L", "P", items=[item("A"), item("a|b")]))) == ["L.P.A", "L.P.a_2.b"]


def test_names_without_anything_usable_and_too_long_ones_get_others() -> None:
    found = ids(cleaned(DraftPlc("Groups", " ", items=[item(""), item("\x01"), item("x" * 400)])))
    assert found[:2] == ["Groups_.unnamed.unnamed", "Groups_.unnamed._"]
    assert len(found[2].split(".")[-1]) <= 255


def test_plcs_of_one_link_stay_on_it_in_any_case() -> None:
    draft = cleaned(DraftPlc("Microwin", "A"), DraftPlc("MicroWin", "B"), DraftPlc("MicroWin", "b"))
    project = load_text(yaml_of(draft, "x")).project
    assert [plc.item_id for plc in project.all_plcs()] == ["Microwin.A", "Microwin.B", "Microwin.b_2"]


def test_the_second_plc_of_an_address_gets_another_one() -> None:
    draft = cleaned(DraftPlc("L", "A", 2), DraftPlc("L", "B", 2), DraftPlc("M", "C", 2))
    assert [plc.address for plc in draft.plcs] == [2, None, 2]
    assert [str(warning) for warning in draft.warnings] == [
        "x:1:1: warning PRJ016 L.B has address 2, which is taken; left out"
    ]
    assert [plc.address for plc in load_text(yaml_of(draft, "x")).project.all_plcs()] == [2, 3, 2]


def test_what_is_usual_is_written_down_and_what_cannot_be_is_put_right() -> None:
    draft = cleaned(
        DraftPlc("L", "P", items=[item("a", "HC0", access="RW"), item("b", "VW0", high=1.0, low=9.0), item("c", "XX")])
    )
    a, b = draft.plcs[0].items
    assert (a.text.type, a.text.access) == ("DINT", "R")
    assert (b.text.low, b.text.high) == (1.0, 9.0)
    assert draft.left_out == 1
    assert "c: 'XX' is not an address" in str(draft.warnings[0])


def test_texts_that_could_break_the_file_do_not() -> None:
    draft = cleaned(DraftPlc("L", "P", items=[item("#x", "VB0", description="a\n- b: {c}\x85\u2028'\"")]))
    draft.source = "evil\nlinks: []"
    draft.plcs[0].notes.append("a\nb: c")
    (found,) = load_text(yaml_of(draft, "On")).project.all_items()
    assert (found.name, found.description) == ("#x", "a\n- b: {c}\x85\u2028'\"")
