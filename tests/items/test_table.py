"""The item table: rows, records as the wire has them, change numbers."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from datetime import UTC, datetime

import numpy as np
import pytest
from asyncua import ua
from asyncua.common.utils import Buffer
from asyncua.ua.ua_binary import struct_from_binary
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.items.quality import Limit, Quality
from pcaccess.items.records import KINDS, MASK_ALL, MASK_VALUE
from pcaccess.items.rowset import RowSet
from pcaccess.items.sample import ItemValue
from pcaccess.items.table import ItemTable, as_rows
from pcaccess.items.ticks import from_ticks, to_ticks
from pcaccess.items.varianttypes import VARIANT_TYPES
from pcaccess.s7200.types import DataType

BORN = to_ticks(datetime(2026, 11, 22, tzinfo=UTC))
NOW = BORN + 10_000_000
LATER = NOW + 10_000_000

VALUES: dict[DataType, st.SearchStrategy[ItemValue]] = {
    DataType.BOOL: st.booleans(),
    DataType.REAL: st.floats(width=32, allow_nan=False),
    DataType.STRING: st.text(st.characters(max_codepoint=255), max_size=254),
    **{t: st.integers(t.low, t.high) for t in DataType if t.is_integer},
}


def decoded(table: ItemTable, row: int) -> ua.DataValue:
    """The row's record as a client of OPC UA reads it."""
    kinds, places = table.places(as_rows(row))
    kind, place = int(kinds[0]), int(places[0])
    record = table.block(kind)[place]
    if kind < len(KINDS):
        wire = record.tobytes()
    else:
        variant = table.object_variant(place) if record["mask"] & 1 else b""
        tail = struct.pack("<Iqq", record["status"], record["source"], record["server"])
        wire = bytes((record["mask"],)) + variant + tail
    value: ua.DataValue = struct_from_binary(ua.DataValue, Buffer(wire))
    return value


@st.composite
def typed_values(draw: st.DrawFn) -> tuple[DataType, int, ItemValue]:
    data_type = draw(st.sampled_from(DataType))
    count = draw(st.sampled_from([1, 1, 2, 5]))
    one = VALUES[data_type]
    return data_type, count, draw(one if count == 1 else st.lists(one, min_size=count, max_size=count))


# -- rows ------------------------------------------------------------------------------------------------------------


def test_an_id_is_found_in_any_case_and_kept_as_written() -> None:
    table = ItemTable(BORN)
    row = table.add("MicroWin.NewPLC.Straße", DataType.INT)
    assert table.find("MICROWIN.newplc.STRASSE") == row
    assert table.item_id(row) == "MicroWin.NewPLC.Straße"


@pytest.mark.parametrize("second", ["a.b.c", "A.B.C"])
def test_an_id_that_exists_is_refused_and_nothing_is_added(second: str) -> None:
    table = ItemTable(BORN)
    table.add("a.b.C", DataType.INT)
    with pytest.raises(KeyError, match=r"a\.b\.c"):
        table.add_many([("a.b.new", DataType.INT, 1), (second, DataType.INT, 1)])
    assert len(table) == 1
    assert table.find("a.b.new") is None


def test_two_equal_ids_in_one_call_are_refused() -> None:
    with pytest.raises(KeyError, match=r"x\.y"):
        ItemTable(BORN).add_many([("x.y", DataType.INT, 1), ("X.Y", DataType.INT, 1)])


def test_an_alias_finds_the_row_and_never_hides_an_id() -> None:
    table = ItemTable(BORN)
    first, second = table.add("a", DataType.INT), table.add("b", DataType.INT)
    table.add_alias("2,VW0,INT", first)
    table.add_alias("B", first)
    assert table.find("2,vw0,int") == first
    assert table.find("b") == second


def test_a_removed_row_is_found_no_more_and_its_number_is_used_again() -> None:
    table = ItemTable(BORN)
    keep, gone = table.add("keep", DataType.INT), table.add("gone", DataType.STRING)
    table.add_alias("other name", gone)
    before = table.generation
    table.remove([gone])
    assert (table.find("gone"), table.find("other name"), table.find("keep")) == (None, None, keep)
    assert table.item_id(gone) == ""
    assert table.generation > before
    with pytest.raises(KeyError):
        table.data_type(gone)
    again = table.add("new", DataType.REAL, 3)
    assert again == gone
    assert table.count(again) == 3
    assert table.sample(again).value == []
    assert table.sample(again).quality is Quality.WAITING_FOR_INITIAL_DATA


def test_rows_and_places_survive_growth() -> None:
    table = ItemTable(BORN)
    first = table.add("first", DataType.DINT)
    table.put(first, 42, NOW)
    table.add_many([(f"i{n}", DataType.DINT, 1) for n in range(1000)])
    assert table.sample(first).value == 42
    assert len(table) == 1001


# -- samples -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("data_type", DataType)
@pytest.mark.parametrize("count", [1, 3])
def test_a_new_row_waits_for_its_first_sample(data_type: DataType, count: int) -> None:
    table = ItemTable(BORN)
    row = table.add("a", data_type, count)
    assert table.sample(row).quality is Quality.WAITING_FOR_INITIAL_DATA
    wire = decoded(table, row)
    assert wire.StatusCode is not None
    assert wire.StatusCode.value == Quality.WAITING_FOR_INITIAL_DATA.status()
    assert wire.SourceTimestamp == from_ticks(BORN).replace(tzinfo=UTC)


@given(typed_values())
def test_what_was_put_is_the_sample_and_the_record_on_the_wire(case: tuple[DataType, int, ItemValue]) -> None:
    data_type, count, value = case
    table = ItemTable(BORN)
    row = table.add("a", data_type, count)
    table.put(row, value, NOW)
    sample = table.sample(row)
    assert (sample.value, sample.quality, sample.time) == (value, Quality.GOOD, from_ticks(NOW))
    wire = decoded(table, row)
    assert wire.Value is not None
    assert wire.Value.Value == value
    assert wire.Value.VariantType == ua.VariantType(VARIANT_TYPES[data_type])
    assert wire.Value.is_array == (count > 1)
    assert (wire.StatusCode, wire.SourceTimestamp) == (ua.StatusCode(0), from_ticks(NOW))
    variant, status, source, server = table.encoded(row)
    assert struct_from_binary(ua.DataValue, Buffer(b"\x01" + variant)).Value == wire.Value
    assert (status, source, server) == (0, NOW, NOW)


def test_numbers_come_in_bulk() -> None:
    table = ItemTable(BORN)
    rows = table.add_many([(f"i{n}", DataType.INT, 1) for n in range(5)])
    table.put_numbers(DataType.INT, rows[1:4], np.array([7, -8, 9], "<i2"), NOW)
    assert [table.sample(r).value for r in rows.tolist()] == [0, 7, -8, 9, 0]
    assert table.source_ticks(rows).tolist() == [BORN, NOW, NOW, NOW, BORN]


@pytest.mark.parametrize("limit", Limit)
@pytest.mark.parametrize("quality", Quality)
@pytest.mark.parametrize("data_type", [DataType.INT, DataType.STRING])
def test_a_quality_leaves_value_and_time_alone(data_type: DataType, quality: Quality, limit: Limit) -> None:
    table = ItemTable(BORN)
    row = table.add("a", data_type)
    value: ItemValue = "text" if data_type is DataType.STRING else 5
    table.put(row, value, NOW)
    table.set_quality(as_rows(row), quality, LATER, limit)
    sample = table.sample(row)
    assert (sample.value, sample.quality, sample.limit, sample.time) == (value, quality, limit, from_ticks(NOW))
    wire = decoded(table, row)
    assert wire.Value is not None
    assert wire.Value.Value == value
    assert wire.StatusCode is not None
    assert wire.StatusCode.value == quality.status(limit)
    assert (wire.SourceTimestamp, wire.ServerTimestamp) == (from_ticks(NOW), from_ticks(LATER))


def test_a_string_that_was_never_read_has_no_value_whatever_its_quality() -> None:
    table = ItemTable(BORN)
    row = table.add("a", DataType.STRING)
    table.set_quality(as_rows(row), Quality.NOT_CONNECTED, NOW)
    wire = decoded(table, row)
    assert wire.Value is not None
    assert wire.Value.VariantType == ua.VariantType.Null
    assert wire.StatusCode is not None
    assert wire.StatusCode.value == Quality.NOT_CONNECTED.status()
    assert table.block(len(KINDS))[0]["mask"] == MASK_ALL - MASK_VALUE


# -- changes -----------------------------------------------------------------------------------------------------------


class Heard:
    """Rows reported to a listener since the last look."""

    def __init__(self, table: ItemTable) -> None:
        self._rows: list[int] = []
        self.stop = table.listen(lambda rows: self._rows.extend(rows.tolist()))

    def take(self) -> list[int]:
        rows, self._rows = sorted(self._rows), []
        return rows


def test_only_rows_whose_value_or_status_changed_are_reported() -> None:
    table = ItemTable(BORN)
    rows = table.add_many([(f"i{n}", DataType.INT, 1) for n in range(3)])
    heard = Heard(table)
    table.put_numbers(DataType.INT, rows, np.array([0, 1, 2]), NOW)
    assert heard.take() == rows.tolist(), "the first sample is a change even where the value was 0 already"
    table.put_numbers(DataType.INT, rows, np.array([0, 1, 5]), LATER)
    assert heard.take() == [rows[2]]
    table.stamp(rows, LATER + 1)
    assert heard.take() == []
    table.set_quality(rows[:2], Quality.COMM_FAILURE, LATER + 2)
    assert heard.take() == rows[:2].tolist()
    table.set_quality(rows, Quality.COMM_FAILURE, LATER + 3)
    assert heard.take() == [rows[2]]
    heard.stop()
    table.put_numbers(DataType.INT, rows, np.array([9, 9, 9]), LATER + 4)
    assert heard.take() == []


def test_the_change_number_grows_with_each_change_of_the_row_and_only_then() -> None:
    table = ItemTable(BORN)
    first, second = table.add("a", DataType.INT), table.add("b", DataType.STRING)
    rows = as_rows([first, second])
    table.put(first, 1, NOW)
    table.put(second, "x", NOW)
    seen = table.changed(rows)
    table.put(first, 1, LATER)
    table.put(second, "x", LATER)
    assert (table.changed(rows) == seen).all()
    table.put(second, "y", LATER)
    assert (table.changed(rows) > seen).tolist() == [False, True]
    assert table.counter == table.changed(rows)[1]


def test_not_a_number_is_reported_once() -> None:
    table = ItemTable(BORN)
    row = table.add("a", DataType.REAL)
    heard = Heard(table)
    for _ in range(3):
        table.put(row, math.nan, NOW)
    assert heard.take() == [row]


def test_a_stamp_moves_times_of_rows_of_every_type() -> None:
    table = ItemTable(BORN)
    rows = table.add_many([("a", DataType.INT, 1), ("b", DataType.STRING, 1), ("c", DataType.INT, 3)])
    table.stamp(rows, NOW)
    assert table.source_ticks(rows).tolist() == [NOW] * 3
    assert [table.encoded(r)[3] for r in rows.tolist()] == [NOW] * 3


@pytest.mark.parametrize(
    "change",
    [
        lambda table: table.put(0, 1, NOW),
        lambda table: table.put(1, "x", NOW),
        lambda table: table.put_numbers(DataType.INT, as_rows(0), np.array([1], "<i2"), NOW),
        lambda table: table.stamp(as_rows(0), NOW),
        lambda table: table.stamp_one(0, NOW),
        lambda table: table.set_quality(as_rows(0), Quality.BAD, NOW),
    ],
)
def test_an_answer_made_before_any_change_is_known_to_be_old(change: Callable[[ItemTable], None]) -> None:
    table = ItemTable(BORN)
    table.add_many([("a", DataType.INT, 1), ("b", DataType.STRING, 1)])
    for _ in range(2):
        before = table.moves
        change(table)
        assert table.moves > before


def test_nothing_is_asked_of_no_rows() -> None:
    table = ItemTable(BORN)
    heard = Heard(table)
    none = as_rows([])
    table.stamp(none, NOW)
    table.set_quality(none, Quality.BAD, NOW)
    table.put_numbers(DataType.INT, none, np.zeros(0), NOW)
    assert heard.take() == []


def test_an_array_with_not_a_number_is_reported_once() -> None:
    table = ItemTable(BORN)
    row = table.add("a", DataType.REAL, 2)
    heard = Heard(table)
    for _ in range(3):
        table.put(row, [1.0, float("nan")], NOW)
    assert heard.take() == [row]


@given(typed_values(), typed_values())
def test_one_number_at_a_time_is_the_same_as_many(
    first: tuple[DataType, int, ItemValue], second: tuple[DataType, int, ItemValue]
) -> None:
    """``put`` of a single value packs one record; ``put_numbers`` works on columns."""
    data_type, _, _ = first
    values = [v for t, count, v in (first, second) if t is data_type and count == 1 and t is not DataType.STRING]
    single, many = ItemTable(BORN), ItemTable(BORN)
    for table in (single, many):
        table.add("a", data_type)
    for now, value in enumerate(values, NOW):
        single.put(0, value, now)
        many.put_numbers(data_type, as_rows(0), np.array([value], KINDS[data_type].value_format), now)
        assert single.encoded(0) == many.encoded(0)
        assert single.changed(as_rows(0)) == many.changed(as_rows(0))


def test_a_set_of_rows_is_stamped_wherever_its_rows_are_now() -> None:
    table = ItemTable(BORN)
    rows = table.add_many([(f"i{n}", DataType.INT if n % 2 else DataType.REAL, 1) for n in range(6)])
    members = RowSet(rows[1:])
    table.stamp(members, NOW)
    assert table.source_ticks(rows).tolist() == [BORN] + [NOW] * 5
    table.add_many([(f"j{n}", DataType.INT, 1) for n in range(1000)])
    table.stamp(members, LATER)
    assert table.source_ticks(rows).tolist() == [BORN] + [LATER] * 5
    table.stamp_one(0, LATER)
    assert table.source_ticks(rows).tolist() == [LATER] * 6
    assert table.encoded(0)[3] == LATER
