"""What changed between two versions of a project file."""

from __future__ import annotations

import pytest

from pcaccess.project.diff import Changes, compare
from pcaccess.project.load import load_text

OLD = """
project: Line
links:
  - name: L
    type: soft
    plcs:
      - name: P
        items:
          - {name: A, address: VW0}
          - {name: B, address: VW2}
        folders: [{name: F, items: [{name: C, address: VW4}]}]
  - {name: M, type: soft, plcs: [{name: Q, items: [{name: D, address: VW0}]}]}
groups:
  - {name: G, update_rate: 1s, items: [L.P.A, L.P.B]}
"""


def changes(*edits: tuple[str, str]) -> Changes:
    new = OLD
    for old, text in edits:
        assert old in new
        new = new.replace(old, text)
    return compare(load_text(OLD).project, load_text(new).project)


def test_the_same_file_with_other_lines_and_comments_is_no_change() -> None:
    assert not changes(("project: Line\n", "# a comment\n\nproject: Line\n"), ("{name: A, ", "{ name: A,   "))


def test_an_item_that_comes_changes_and_goes() -> None:
    found = changes(
        ("- {name: B, address: VW2}", "- {name: N, address: VW6}"), ("address: VW4", "address: VW8"), (", L.P.B", "")
    )
    assert [item.item_id for item in found.items.added] == ["L.P.N"]
    assert [item.item_id for item in found.items.removed] == ["L.P.B"]
    assert [(str(old.address), str(new.address)) for old, new in found.items.changed] == [("VW4", "VW8")]
    assert [new.items for _, new in found.groups.changed] == [("L.P.A",)]
    assert not any((found.plcs, found.links, found.server, found.folders))


@pytest.mark.parametrize(
    ("edit", "told"),
    [
        (("name: P\n", "name: P\n        connected: false\n"), "1 PLC changed"),
        (("name: P\n", "name: P\n        address: 9\n"), "3 items changed; 1 PLC changed"),
        (("project: Line", "server: {read_timeout: 5s}"), "server settings changed"),
        (("update_rate: 1s", "update_rate: 2s"), "1 group changed"),
        (("name: M,", "name: M, description: x,"), "1 link changed"),
        (("name: F,", "name: F, description: x,"), "folders changed"),
        (("name: A,", "name: a,"), "1 item changed; 1 group changed"),
        (("project: Line", "project: Line"), "nothing changed"),
    ],
)
def test_each_change_stands_where_it_belongs(edit: tuple[str, str], told: str) -> None:
    assert str(changes(edit)) == told


def test_a_link_that_goes_takes_its_plcs_and_items_along() -> None:
    gone = "  - {name: M, type: soft, plcs: [{name: Q, items: [{name: D, address: VW0}]}]}\n"
    found = changes((gone, ""))
    assert (len(found.links.removed), len(found.plcs.removed), len(found.items.removed)) == (1, 1, 1)
    assert str(found) == "1 item removed; 1 PLC removed; 1 link removed"
