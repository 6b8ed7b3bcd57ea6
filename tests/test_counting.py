"""Numbers of things in words."""

from __future__ import annotations

from pcaccess.counting import counted


def test_one_is_singular_and_what_there_is_none_of_is_left_out() -> None:
    counts = {"links": 1, "plcs": 2, "items": 1400, "groups": 0}
    assert counted(counts, "links", "plcs", "items", "groups") == "1 link, 2 PLCs, 1,400 items"
    assert counted({"plcs": 1}, "plcs") == "1 PLC"
