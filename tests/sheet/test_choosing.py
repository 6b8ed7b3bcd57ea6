"""Which items a workbook gets."""

from __future__ import annotations

import pytest

from pcaccess.project.load import load_text
from pcaccess.sheet.choosing import choose
from pcaccess.sheet.entries import SheetError
from pcaccess.sheet.links import source_path
from pcaccess.sheet.picker import Picker
from pcaccess.sheet.sources import ProjectSource
from tests.web.conftest import PROJECT


def source(text: str = PROJECT) -> ProjectSource:
    return ProjectSource(load_text(text).project)


def ids(*names: str, group: str | None = None, text: str = PROJECT) -> list[str]:
    return [entry.item_id for entry in choose(source(text), group, names).entries]


def test_without_a_wish_the_first_group_is_taken() -> None:
    assert ids() == ["MicroWin.P.Flow", "MicroWin.P.Level", "MicroWin.P.On"]
    assert choose(source(), None, []).group == "Fast"


def test_without_groups_all_items_are_taken() -> None:
    text = PROJECT[: PROJECT.index("groups:")]
    assert len(ids(text=text)) == 8


def test_too_many_items_want_a_choice() -> None:
    items = "".join(f"          - {{name: I{n}, address: VW{2 * n}, type: INT}}\n" for n in range(101))
    text = f"links:\n  - name: L\n    type: soft\n    plcs:\n      - name: P\n        items:\n{items}"
    with pytest.raises(SheetError, match="101 items and no group"):
        ids(text=text)


def test_names_are_ids_in_any_case_plcs_and_patterns_each_item_once() -> None:
    assert ids("microwin.p.on", "*.F*") == ["MicroWin.P.On", "MicroWin.P.Fixed", "MicroWin.P.Flow"]
    assert ids("MicroWin.Away", "microwin.away.lost") == ["MicroWin.Away.Lost"]


def test_a_group_with_more_items_is_no_group_any_more() -> None:
    chosen = choose(source(), "fast", ["MicroWin.P.Text"])
    assert [entry.name for entry in chosen.entries] == ["Flow", "Level", "On", "Text"]
    assert source_path(chosen).startswith("/api/items.csv?id=MicroWin.P.Flow&id=")


def test_everything_that_is_wrong_is_told_at_once() -> None:
    with pytest.raises(SheetError) as caught:
        ids("MicroWin.P.Lefel", "Nix*", "2,VW0,INT", group="Slow")
    assert str(caught.value).splitlines() == [
        "there is no group Slow; there are Fast",
        "there is no item MicroWin.P.Lefel; did you mean MicroWin.P.Level?",
        "no item fits Nix*",
        "2,VW0,INT is no item of the project; a run-time name needs --url of a gateway that runs",
    ]


def test_a_project_without_web_server_is_refused() -> None:
    with pytest.raises(SheetError, match="has no web server"):
        source("server: {web: off}\n" + PROJECT)


def test_what_can_be_read_written_and_charted() -> None:
    chosen = choose(source(), None, ["MicroWin.P"])
    assert "Secret" not in [entry.name for entry in chosen.readable]
    assert "Fixed" not in [entry.name for entry in chosen.writable]
    assert [entry.name for entry in chosen.charted] == ["Level", "Fixed", "Flow"]


def picker() -> Picker:
    return Picker(choose(source(), None, ["*"]).entries)


def names(p: Picker) -> list[str]:
    return [entry.name for entry in p.chosen]


def test_the_picker_takes_numbers_and_ranges_of_what_was_found() -> None:
    p = picker()
    p.command("1 3-4")
    p.command("*.away.*")
    assert p.command("1") == ["4 taken"]
    assert names(p) == ["Level", "On", "Flow", "Lost"]
    p.command("")
    assert p.done


def test_the_picker_puts_back_and_takes_all() -> None:
    p = picker()
    p.command("tank")  # in a description
    p.command("all")
    assert names(p) == ["Level"]
    p.command("-1")
    assert names(p) == []


def test_the_picker_says_which_numbers_there_are() -> None:
    assert picker().command("99") == ["99: there are the numbers 1 to 8", "0 taken"]
    assert picker().command("nothing like it") == ["nothing is like that"]


def test_quitting_the_picker_chooses_nothing() -> None:
    p = picker()
    p.command("all")
    p.command("quit")
    assert (p.done, names(p)) == (True, [])
