"""Renderings: however often and whatever changed between, they say what the table holds."""

from __future__ import annotations

import csv
import io
import json
import math
from datetime import UTC, datetime
from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.items.quality import Quality
from pcaccess.items.table import ItemTable
from pcaccess.s7200.types import DataType
from pcaccess.web.formats import CSV, JSON
from pcaccess.web.rendering import Rendering

NOW = 134_118_000_000_000_000
ITEMS = [
    ("P.Int", DataType.INT, 1),
    ("P.Real", DataType.REAL, 1),
    ("P.Bool", DataType.BOOL, 1),
    ('P."Quoted", text', DataType.STRING, 1),
    ("P.Int2", DataType.INT, 1),
    ("P.Array", DataType.DINT, 3),
]
VALUES = {
    DataType.INT: st.integers(-32768, 32767),
    DataType.REAL: st.floats(width=32),
    DataType.BOOL: st.booleans(),
    DataType.STRING: st.text("abc,=\"'\n", max_size=5),
    DataType.DINT: st.lists(st.integers(-(2**31), 2**31 - 1), min_size=3, max_size=3),
}


def changes() -> st.SearchStrategy[tuple[int, Any]]:
    """(place of an item, new value or quality)"""
    return st.one_of(
        *(st.tuples(st.just(n), VALUES[data_type]) for n, (_, data_type, _) in enumerate(ITEMS)),
        st.tuples(st.integers(0, len(ITEMS) - 1), st.sampled_from(Quality)),
    )


def expected(table: ItemTable, rows: list[int]) -> list[dict[str, Any]]:
    """Straight from the table's samples, one by one."""
    found = []
    for row in rows:
        sample = table.sample(row)
        value: Any = sample.value
        if isinstance(value, float):
            value = float(np.float32(value)) if math.isfinite(value) else str(value)
            value = {"nan": "NaN", "inf": "Infinity", "-inf": "-Infinity"}.get(str(value), value)
        found.append(
            {
                "id": table.item_id(row),
                "value": value,
                "type": table.data_type(row).name,
                "quality": sample.quality.code,
                "quality_name": sample.quality.name,
                "status": sample.quality.status_name,
                "source_timestamp": f"{sample.time:%Y-%m-%dT%H:%M:%S}.{sample.time.microsecond // 1000:03d}Z",
            }
        )
    return found


def as_float32(samples: list[dict[str, Any]]) -> list[dict[str, Any]]:
    for sample in samples:
        if sample["type"] == "REAL" and isinstance(sample["value"], float):
            sample["value"] = float(np.float32(sample["value"]))
    return samples


@given(st.lists(st.lists(changes(), max_size=4), min_size=1, max_size=6), st.permutations(range(len(ITEMS))))
def test_a_rendering_says_what_the_table_holds(rounds: list[list[tuple[int, Any]]], order: list[int]) -> None:
    table = ItemTable(NOW)
    added = table.add_many(ITEMS).tolist()
    rows = [added[n] for n in order]
    rendering = Rendering(JSON, table, rows)
    csv_rendering = Rendering(CSV, table, rows)
    for step, round_ in enumerate(rounds):
        now = NOW + step * 12_345_678
        for n, change in round_:
            if isinstance(change, Quality):
                table.set_quality(np.array([added[n]]), change, now)
            else:
                table.put(added[n], change, now)
        wanted = expected(table, rows)
        assert as_float32(json.loads(b"[" + rendering.joined() + b"]")) == wanted
        assert b",".join(rendering.entries()) == rendering.joined()
        lines = list(csv.reader(io.StringIO(csv_rendering.joined().decode(), newline="")))
        assert [line[0] for line in lines] == [sample["id"] for sample in wanted]
        assert [(int(line[2]), line[3]) for line in lines] == [(s["quality"], s["quality_name"]) for s in wanted]


def test_a_quality_instead_of_their_own_comes_and_goes() -> None:
    table = ItemTable(NOW)
    rows = table.add_many(ITEMS[:2]).tolist()
    rendering = Rendering(JSON, table, rows)
    for row in rows:
        table.put(row, 1, NOW)

    def names(instead: Quality | None) -> list[str]:
        return [sample["quality_name"] for sample in json.loads(b"[" + rendering.joined(instead) + b"]")]

    assert names(None) == ["GOOD"] * 2
    assert names(Quality.OUT_OF_SERVICE) == ["OUT_OF_SERVICE"] * 2
    assert names(None) == ["GOOD"] * 2


def test_only_a_time_that_moved_is_shown_too() -> None:
    table = ItemTable(NOW)
    rows = table.add_many(ITEMS[:2]).tolist()
    rendering = Rendering(JSON, table, rows)
    before = rendering.joined()
    table.stamp(np.array(rows[1:]), NOW + 20_000_000)
    first, second = json.loads(b"[" + rendering.joined() + b"]")
    assert json.loads(b"[" + before + b"]")[0] == first
    apart = datetime.fromisoformat(second["source_timestamp"]) - datetime.fromisoformat(first["source_timestamp"])
    assert apart.total_seconds() == 2
    assert datetime.fromisoformat(first["source_timestamp"]).tzinfo == UTC


def test_nothing_is_nothing() -> None:
    assert Rendering(JSON, ItemTable(NOW), []).joined() == b""
    assert Rendering(CSV, ItemTable(NOW), []).entries() == []
