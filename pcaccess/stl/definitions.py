"""All STL instructions by mnemonic.

Each module in ``pcaccess.stl.instructions`` holds families; this one collects them. A new module is added to
``_MODULES``, nothing else.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType, ModuleType
from typing import Final

from pcaccess.stl.define import Definition, Family
from pcaccess.stl.instructions import (
    ascii_text,
    boolean,
    compare,
    control,
    convert,
    counters,
    integer_math,
    interrupts,
    logic,
    moves,
    peripherals,
    real_math,
    shifts,
    strings,
    tables,
    timers,
)

_MODULES: Final[tuple[ModuleType, ...]] = (
    boolean,
    compare,
    timers,
    counters,
    integer_math,
    real_math,
    moves,
    logic,
    shifts,
    convert,
    ascii_text,
    strings,
    tables,
    control,
    interrupts,
    peripherals,
)


def families() -> Iterator[Family]:
    """Every family, in the order of the modules and of the lines in them."""
    for module in _MODULES:
        yield from (value for value in vars(module).values() if isinstance(value, Family))


def _collect() -> Mapping[str, Definition]:
    table: dict[str, Definition] = {}
    for family in families():
        for definition in family.rows:
            if definition.mnemonic in table:
                raise ValueError(f"{definition.mnemonic} is defined twice")
            table[definition.mnemonic] = definition
    return MappingProxyType(table)


DEFINITIONS: Final[Mapping[str, Definition]] = _collect()
