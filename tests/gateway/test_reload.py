"""A changed project under a running gateway."""

from __future__ import annotations

from collections.abc import Callable

from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.reload import apply_project
from pcaccess.items.quality import Quality
from pcaccess.project.load import load_text

MakeGateway = Callable[[str], Gateway]

BEFORE = """
project: Test
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: P
        address: 2
        items:
          - {name: Stays, address: VW0, type: INT}
          - {name: Retyped, address: VW2, type: INT}
          - {name: Described, address: VW4, type: INT}
          - {name: Goes, address: VW6, type: INT}
  - {name: Sim, type: sim, plcs: [{name: D, items: [{name: Wave, address: "RAMP(10s, 0, 100)", type: REAL}]}]}
groups:
  - {name: Fast, update_rate: 250ms, items: [MicroWin.P.Stays]}
"""
AFTER = """
# a line more than before
project: Test
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: P
        address: 2
        items:
          - {name: Stays, address: VW0, type: INT}
          - {name: Retyped, address: VD2, type: REAL}
          - {name: Described, address: VW4, type: INT, unit: bar, access: R}
          - {name: Comes, address: VB1, type: BYTE}
      - name: Q
        address: 3
        items: [{name: New, address: VW0, type: INT}]
groups:
  - {name: Fast, update_rate: 250ms, items: [MicroWin.P.Stays]}
"""


def find(gateway: Gateway, name: str) -> int:
    row = gateway.find(name)
    assert row is not None
    return row


async def test_what_did_not_change_keeps_its_row_and_value(gateway: MakeGateway) -> None:
    g = gateway(BEFORE)
    stays, described = find(g, "MicroWin.P.Stays"), find(g, "MicroWin.P.Described")
    await g.write([(stays, 258), (described, 7)])
    done = apply_project(g, load_text(AFTER).project)
    assert str(done).startswith("2 items added, 2 changed, 2 removed; 1 PLC added")
    assert (find(g, "MicroWin.P.Stays"), find(g, "MicroWin.P.Described")) == (stays, described)
    assert (g.sample(stays).value, g.sample(described).value) == (258, 7)
    assert g.item(described).unit == "bar"


async def test_new_and_changed_items_are_good_at_once_and_removed_ones_unknown(gateway: MakeGateway) -> None:
    g = gateway(BEFORE)
    await g.write([(find(g, "MicroWin.P.Stays"), 258)])
    apply_project(g, load_text(AFTER).project)
    assert g.sample(find(g, "MicroWin.P.Comes")).value == 2
    assert g.table.data_type(find(g, "MicroWin.P.Retyped")).name == "REAL"
    assert g.sample(find(g, "MicroWin.P.Retyped")).quality is Quality.GOOD
    assert g.sample(find(g, "MicroWin.Q.New")).quality is Quality.GOOD
    assert g.find("MicroWin.P.Goes") is None
    assert g.find("Sim.D.Wave") is None


async def test_a_second_reload_brings_everything_back(gateway: MakeGateway) -> None:
    g = gateway(BEFORE)
    old = load_text(BEFORE).project
    apply_project(g, load_text(AFTER).project)
    apply_project(g, old)
    assert [g.sample(find(g, i.item_id)).quality for i in old.all_items()] == [Quality.GOOD] * 5
    assert g.find("MicroWin.Q.New") is None


async def test_connecting_and_cutting_a_plc_keeps_value_and_time(gateway: MakeGateway) -> None:
    g = gateway(BEFORE)
    stays = find(g, "MicroWin.P.Stays")
    await g.write([(stays, 5)])
    before = g.sample(stays)
    apply_project(g, load_text(BEFORE.replace("address: 2\n", "address: 2\n        connected: false\n")).project)
    cut = g.sample(stays)
    assert (cut.value, cut.time, cut.quality) == (5, before.time, Quality.NOT_CONNECTED)
    apply_project(g, load_text(BEFORE).project)
    assert (g.sample(stays).value, g.sample(stays).quality) == (5, Quality.GOOD)


async def test_a_group_keeps_what_clients_set_unless_the_file_changed_it(gateway: MakeGateway) -> None:
    g = gateway(BEFORE)
    fast = g.group("fast")
    assert fast is not None
    fast.active = False
    apply_project(g, load_text(AFTER).project)
    assert g.group("Fast") is fast
    apply_project(g, load_text(AFTER.replace("250ms", "500ms")).project)
    changed = g.group("Fast")
    assert changed is not None
    assert (changed.active, changed.update_rate) == (True, 0.5)


async def test_listeners_hear_of_a_changed_structure(gateway: MakeGateway) -> None:
    g = gateway(BEFORE)
    heard: list[str] = []
    g.on_structure(lambda: heard.append("changed"))
    apply_project(g, load_text(AFTER).project)
    assert heard == ["changed"]
