"""Tables of words.

The table of ATT, LIFO and FIFO begins with its greatest and its present number of entries; FND looks at the same
table from the second word on. A table has at most 100 entries; one that says more, or that does not wholly
exist, is error 0091.

Source:   System Manual, Table instructions.
"""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.types import DataType
from pcaccess.stl.builder import Place
from pcaccess.stl.define import TABLE_EMPTY, TABLE_FULL, In, InOut, Out, define
from pcaccess.stl.errors import INDIRECT_ADDRESS, OPERAND_RANGE
from pcaccess.stl.evaluate import compare
from pcaccess.stl.instructions.sm import set_sm_bit
from pcaccess.stl.ir_values import Effects, Relation, Value
from pcaccess.stl.routine import Routine
from pcaccess.stl.runtime import ENO_OFF, OK, Outcome, Runtime

INT, WORD = DataType.INT, DataType.WORD
MOST_ENTRIES: Final = 100
_SOURCE: Final = "System Manual, Table instructions"


def _word(runtime: Runtime, at: int) -> int:
    return int.from_bytes(runtime.memory[at : at + 2], "big", signed=True)


def _set_word(runtime: Runtime, at: int, value: int) -> None:
    runtime.memory[at : at + 2] = (value & 0xFFFF).to_bytes(2, "big")


def _size(runtime: Runtime, table: int) -> tuple[int, int] | None:
    """Greatest and present number of entries; None for a table that cannot be."""
    if runtime.room(table) < 4:
        return None
    most, count = _word(runtime, table), _word(runtime, table + 2)
    if not 0 <= count <= most <= MOST_ENTRIES or 4 + 2 * most > runtime.room(table):
        return None
    return most, count


@define(
    {"ATT": ()},
    group="Table",
    operands=(In("DATA", INT), InOut("TBL", WORD, block=True)),
    sm=(TABLE_FULL,),
    eno_off=(TABLE_FULL, INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
)
def add_to_table(b: Routine, data: Value, table: Place) -> None:
    """Add DATA at the end of the table. A table that is full stays as it is and sets SM1.4."""
    b.cold(add_entry, data, b.address(table), effects=Effects(sm=(TABLE_FULL,), errors=(OPERAND_RANGE,)))


def add_entry(runtime: Runtime, data: int, table: int) -> Outcome:
    size = _size(runtime, table)
    if size is None:
        return OPERAND_RANGE
    most, count = size
    set_sm_bit(runtime.memory, TABLE_FULL, count == most)
    if count == most:
        return ENO_OFF
    _set_word(runtime, table + 4 + 2 * count, data)
    _set_word(runtime, table + 2, count + 1)
    return OK


@define(
    {"LIFO": (True,), "FIFO": (False,)},
    group="Table",
    operands=(InOut("TBL", WORD, block=True), Out("DATA", INT)),
    sm=(TABLE_EMPTY,),
    eno_off=(TABLE_EMPTY, INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
)
def take(b: Routine, newest: bool, table: Place, out: Place) -> None:
    """Take the newest (FIFO: oldest) entry out of the table; the others move up. An empty table sets SM1.5."""
    effects = Effects(sm=(TABLE_EMPTY,), errors=(OPERAND_RANGE,))
    b.cold(take_entry, b.address(table), b.address(out), static=(newest,), effects=effects)


def take_entry(runtime: Runtime, newest: bool, table: int, out: int) -> Outcome:
    size = _size(runtime, table)
    if size is None:
        return OPERAND_RANGE
    _, count = size
    set_sm_bit(runtime.memory, TABLE_EMPTY, count == 0)
    if count == 0:
        return ENO_OFF
    first, last = table + 4, table + 4 + 2 * (count - 1)
    data = _word(runtime, last if newest else first)
    if not newest:
        runtime.memory[first:last] = bytes(runtime.memory[first + 2 : last + 2])
    _set_word(runtime, table + 2, count - 1)
    _set_word(runtime, out, data)
    return OK


@define(
    {"FND=": (Relation.EQ,), "FND<>": (Relation.NE,), "FND<": (Relation.LT,), "FND>": (Relation.GT,)},
    group="Table",
    operands=(In("TBL", WORD, constant=False, block=True), In("PTN", INT), InOut("INDX", WORD)),
    eno_off=(INDIRECT_ADDRESS, OPERAND_RANGE),
    source=_SOURCE,
)
def find(b: Routine, relation: Relation, table: Place, pattern: Value, index: Place) -> None:
    """Find the next entry that is = <> < > PTN, from entry INDX on; INDX becomes its number.

    TBL is the word with the number of entries; they follow it and count from 0. When none fits, INDX becomes
    the number of entries. To look for the next one, add 1 to INDX before.
    """
    effects = Effects(errors=(OPERAND_RANGE,))
    b.cold(find_entry, b.address(table), pattern, b.address(index), static=(relation,), effects=effects)


def find_entry(runtime: Runtime, relation: Relation, table: int, pattern: int, index: int) -> Outcome:
    count = _word(runtime, table)
    if not 0 <= count <= MOST_ENTRIES or 2 + 2 * count > runtime.room(table):
        return OPERAND_RANGE
    fits = compare(relation)
    first = _word(runtime, index) & 0xFFFF
    entries = range(min(first, count), count)
    found = next((n for n in entries if fits(_word(runtime, table + 2 + 2 * n), pattern)), count)
    _set_word(runtime, index, found)
    return OK
