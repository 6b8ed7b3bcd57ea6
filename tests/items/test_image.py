"""A PLC's memory to samples: the image decodes in bulk just what one-by-one decoding would."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.items.image import Field, Linear, PlcImage
from pcaccess.items.quality import Quality
from pcaccess.items.sample import ItemValue
from pcaccess.items.table import ItemTable
from pcaccess.s7200.types import DataType

SIZE = 64
BORN = 1000


class Plc:
    """An image over a table of its own, and what the table reported."""

    def __init__(self, fields: Sequence[Field], *, out_of_service: Sequence[int] = (), size: int = SIZE) -> None:
        self.table = ItemTable(BORN)
        self.fields = fields
        served = [DataType.REAL if f.linear else f.raw_type for f in fields]
        self.table.add_many([(f"i{f.row}", t, f.count) for f, t in zip(fields, served, strict=True)])
        self.image = PlcImage(self.table, size)
        self.image.add(fields, out_of_service=out_of_service)
        self._heard: list[int] = []
        self.table.listen(lambda rows: self._heard.extend(rows.tolist()))

    def changed(self) -> list[int]:
        rows, self._heard = sorted(self._heard), []
        assert len(set(rows)) == len(rows), "one change, one report"
        return rows

    def value(self, row: int) -> ItemValue:
        return self.table.sample(row).value

    def qualities(self) -> list[Quality]:
        return [self.table.sample(f.row).quality for f in self.fields]


def expected(field: Field, memory: bytes) -> ItemValue:
    """The value by the plain rules of ``s7200.types``, one element at a time."""
    elements: list[ItemValue] = []
    for n in range(field.count):
        if field.raw_type is DataType.BOOL:
            bit = field.bit + n
            elements.append(bool(memory[field.offset + bit // 8] >> bit % 8 & 1))
            continue
        step = 1 + field.length if field.raw_type is DataType.STRING else field.raw_type.size
        at = field.offset + n * step
        value = field.raw_type.decode(memory[at : at + step])
        if field.linear is not None:
            factor, offset, low, high = field.linear.coefficients()
            assert isinstance(value, int | float)
            scaled = min(max(value * factor + offset, low), high)
            value = struct.unpack("f", struct.pack("f", scaled))[0]
        elements.append(value)
    return elements if field.count > 1 else elements[0]


def same(a: ItemValue, b: ItemValue) -> bool:
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    return a == b or (isinstance(a, float) and isinstance(b, float) and math.isnan(a) and math.isnan(b))


LINEAR = Linear(0, 32000, -10, 10)


@st.composite
def layouts(draw: st.DrawFn) -> list[Field]:
    fields = []
    for row in range(draw(st.integers(1, 12))):
        raw_type = draw(st.sampled_from(DataType))
        count = draw(st.sampled_from([1, 1, 1, 3]))
        length = draw(st.integers(1, 8))
        scalable = raw_type.is_integer and draw(st.booleans())
        field = Field(row, 0, draw(st.integers(0, 7)), raw_type, count, length, LINEAR if scalable else None)
        offset = draw(st.integers(0, SIZE - field.size))
        fields.append(Field(row, offset, field.bit, raw_type, count, length, field.linear))
    return fields


# Few distinct bytes, so that updates often repeat what is there.
memories = st.binary(min_size=SIZE, max_size=SIZE).map(
    lambda raw: bytes((0, 1, 0x41, 0x7F, 0x80, 0xFF)[byte % 6] for byte in raw)
)
slices = st.tuples(st.integers(0, SIZE - 1), st.integers(1, 8) | st.integers(1, SIZE)).map(
    lambda p: (p[0], min(p[0] + p[1], SIZE))
)


@given(layouts(), memories)
def test_a_whole_image_is_every_item_decoded_from_memory(fields: list[Field], memory: bytes) -> None:
    plc = Plc(fields)
    plc.image.update(memory, 5)
    for field in fields:
        assert same(plc.value(field.row), expected(field, memory)), field
    assert plc.qualities() == [Quality.GOOD] * len(fields)
    assert plc.changed() == [f.row for f in fields]


@given(layouts(), memories, st.lists(st.tuples(slices, memories), max_size=6))
def test_parts_leave_the_same_as_the_whole_and_report_just_what_changed(
    fields: list[Field], memory: bytes, parts: list[tuple[tuple[int, int], bytes]]
) -> None:
    plc = Plc(fields)
    plc.image.update(memory, 5)
    plc.changed()
    now = 5
    for (start, end), content in parts:
        before, memory = memory, memory[:start] + content[start:end] + memory[end:]
        old = {f.row: plc.value(f.row) for f in fields}
        now += 1
        plc.image.update(content[start:end], now, start)
        for field in fields:
            assert same(plc.value(field.row), expected(field, memory)), field
            inside = start <= field.offset and field.offset + field.size <= end
            touched = (
                before[field.offset : field.offset + field.size] != memory[field.offset : field.offset + field.size]
            )
            time = plc.table.source_ticks(plc.image.rows[plc.image.rows == field.row])[0]
            assert (time == now) >= inside, "a row read whole is as new as the read"
            assert (time == now) <= (inside or touched), "a row nobody read keeps its time"
        assert plc.changed() == [f.row for f in fields if not same(old[f.row], plc.value(f.row))]


@given(layouts(), memories, st.lists(slices, min_size=1, max_size=8))
def test_a_row_is_good_once_all_its_bytes_were_seen(
    fields: list[Field], memory: bytes, parts: list[tuple[int, int]]
) -> None:
    plc = Plc(fields)
    seen = bytearray(SIZE)
    for now, (start, end) in enumerate(parts, 10):
        plc.image.update(memory[start:end], now, start)
        seen[start:end] = b"\x01" * (end - start)
        for field in fields:
            complete = all(seen[field.offset : field.offset + field.size])
            quality = plc.table.sample(field.row).quality
            assert (quality is Quality.GOOD) == complete, field
            if complete:
                assert same(plc.value(field.row), expected(field, memory)), field


def test_unseen_bytes_are_waited_for_and_keep_the_time_of_birth() -> None:
    plc = Plc([Field(0, 0, 0, DataType.DINT), Field(1, 4, 0, DataType.INT, 2)])
    plc.image.update(bytes(6), 5)
    assert plc.qualities() == [Quality.GOOD, Quality.WAITING_FOR_INITIAL_DATA]
    assert plc.table.encoded(1)[2] == BORN


def test_items_over_the_same_bytes_agree() -> None:
    plc = Plc([Field(0, 0, 0, DataType.INT), Field(1, 1, 0, DataType.BYTE), Field(2, 1, 0, DataType.BOOL)])
    plc.image.update(b"\x01\x03", 5)
    assert [plc.value(r) for r in (0, 1, 2)] == [259, 3, True]


def test_a_lost_plc_keeps_values_and_times_and_comes_back_by_itself() -> None:
    fields = [Field(0, 0, 0, DataType.INT), Field(1, 2, 0, DataType.STRING, 1, 4), Field(2, 8, 0, DataType.BOOL)]
    plc = Plc(fields)
    memory = b"\x00\x07\x02hi".ljust(16, b"\x01")
    plc.image.update(memory, 5)
    plc.changed()
    plc.image.lost(Quality.NOT_CONNECTED, 6)
    assert plc.qualities() == [Quality.NOT_CONNECTED] * 3
    assert [plc.value(r) for r in (0, 1, 2)] == [7, "hi", True]
    assert plc.table.source_ticks(plc.image.rows).tolist() == [5, 5, 5]
    assert plc.changed() == [0, 1, 2]
    plc.image.update(memory, 7)
    assert plc.qualities() == [Quality.GOOD] * 3
    assert plc.changed() == [0, 1, 2]


def test_a_row_out_of_service_never_gets_a_value() -> None:
    plc = Plc([Field(0, 0, 0, DataType.BYTE), Field(1, 0, 0, DataType.BYTE)], out_of_service=[1])
    for now in (5, 6):
        plc.image.update(b"\x09", now)
    assert plc.qualities() == [Quality.GOOD, Quality.OUT_OF_SERVICE]
    assert [plc.value(0), plc.value(1)] == [9, 0]
    assert plc.image.rows.tolist() == [0]


def test_a_removed_row_is_left_alone() -> None:
    plc = Plc([Field(0, 0, 0, DataType.BYTE), Field(1, 1, 0, DataType.STRING, 1, 4)])
    plc.image.remove([0, 1])
    plc.image.update(b"\x01\x02ab".ljust(SIZE, b"\x00"), 5)
    plc.image.lost(Quality.BAD, 6)
    assert plc.qualities() == [Quality.WAITING_FOR_INITIAL_DATA] * 2
    assert plc.changed() == []


@pytest.mark.parametrize(
    ("linear", "raw", "scaled"),
    [
        (Linear(0, 32000, 0, 10), 16000, 5.0),
        (Linear(6400, 32000, 0, 100), 6400, 0.0),
        (Linear(0, 100, 100, 0), 25, 75.0),
        (Linear(0, 100, 0, 10), 200, 20.0),
        (Linear(0, 100, 0, 10, clamp=True), 200, 10.0),
        (Linear(0, 100, 10, 0, clamp=True), -5, 10.0),
    ],
)
def test_a_scaled_item_is_a_straight_line(linear: Linear, raw: int, scaled: float) -> None:
    plc = Plc([Field(0, 0, 0, DataType.INT, 1, 0, linear), Field(1, 0, 0, DataType.INT, 1)])
    plc.image.update(struct.pack(">h", raw), 5)
    assert plc.value(0) == scaled
    assert plc.value(1) == raw


@given(
    st.tuples(st.integers(-32768, 32767), st.integers(-32768, 32767)).filter(lambda p: p[0] != p[1]),
    st.tuples(st.integers(-1000, 1000), st.integers(-1000, 1000)).filter(lambda p: p[0] != p[1]),
    st.integers(-32768, 32767),
)
def test_raw_undoes_scaled(raw_range: tuple[int, int], scaled_range: tuple[int, int], raw: int) -> None:
    linear = Linear(*raw_range, *scaled_range)
    factor, offset, _, _ = linear.coefficients()
    assert linear.raw(raw * factor + offset) == pytest.approx(raw, abs=0.01)


def test_a_clamped_scaling_takes_only_what_lies_within() -> None:
    linear = Linear(0, 1000, 0, 10, clamp=True)
    assert (linear.raw(-5), linear.raw(5), linear.raw(50)) == (0, 500, 1000)


def test_a_memory_larger_than_all_items_is_fine_and_an_empty_update_does_nothing() -> None:
    plc = Plc([Field(0, 62, 0, DataType.WORD)])
    plc.image.update(b"", 5)
    assert plc.changed() == []
    plc.image.update(b"\x01\x02", 6, 62)
    assert plc.value(0) == 0x0102


def test_rows_added_later_show_what_is_known_already() -> None:
    plc = Plc([Field(0, 0, 0, DataType.BYTE)])
    plc.image.update(b"\x01\x02\x03", 5)
    late = plc.table.add("late", DataType.BYTE)
    plc.image.add([Field(late, 2, 0, DataType.BYTE)])
    plc.image.repeat(6)
    assert plc.value(late) == 3
    assert plc.table.sample(late).quality is Quality.GOOD


def test_repeating_does_not_invent_what_was_never_seen() -> None:
    plc = Plc([Field(0, 0, 0, DataType.BYTE), Field(1, 8, 0, DataType.BYTE), Field(2, 20, 0, DataType.BYTE)])
    plc.image.update(b"\x05", 5, 0)
    plc.image.update(b"\x06", 5, 20)
    plc.image.repeat(6)
    assert plc.qualities() == [Quality.GOOD, Quality.WAITING_FOR_INITIAL_DATA, Quality.GOOD]
    assert plc.table.source_ticks(plc.image.rows).tolist() == [6, BORN, 6]


def test_all_rows_are_stamped_at_once() -> None:
    plc = Plc([Field(0, 0, 0, DataType.BYTE), Field(1, 2, 0, DataType.STRING, 1, 4), Field(2, 8, 0, DataType.BOOL)])
    plc.image.update(bytes(SIZE), 5)
    plc.image.stamp(9)
    assert plc.table.source_ticks(plc.image.rows).tolist() == [9, 9, 9]
