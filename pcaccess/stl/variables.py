"""Variable sections of a block: declarations to local variables with their L addresses.

An export writes no addresses. They follow from the order: one running bit pointer from L0.0 through IN, IN_OUT,
OUT and TEMP; a BOOL takes the next bit, anything else starts at the next byte (words need no even address).

Source:   docs/stl.md, "Local variables" (the rule holds in 96 of 96 subroutines that were compared); System
          Manual, "Local memory": 64 bytes.
Errors:   collected; a wrong declaration is left out.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from types import MappingProxyType
from typing import Final

from pcaccess.problems import Span
from pcaccess.s7200.address import Address, Area, Width
from pcaccess.s7200.types import DataType
from pcaccess.stl.lexer import comment_text
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import PouKind, Section, Variable

L_BYTES: Final = 64
TYPES: Final = MappingProxyType({t.name: t for t in DataType if t is not DataType.CHAR})
_ORDER: Final = tuple(Section)
_DECLARATION: Final = re.compile(
    r"\s*(?P<name>[^\W\d](?:[\w ]*\w)?)\s*:\s*(?P<type>\w+)\s*(?P<end>;?)\s*(?P<comment>//.*)?", re.IGNORECASE
)
_SPLIT_BYTES: Final = {DataType.STRING: 4}
"""A STRING parameter is passed as the address of the text, a double word."""
WIDTHS: Final = MappingProxyType({1: Width.BYTE, 2: Width.WORD, 4: Width.DWORD})


def read_variables(
    kind: PouKind, declarations: Iterable[tuple[Section, int, str]], problems: Collector
) -> tuple[Variable, ...]:
    """The variables of one block in the order IN, IN_OUT, OUT, TEMP."""
    found: list[tuple[Section, str, DataType, str, Span]] = []
    names: dict[str, Span] = {}
    for section, number, line in declarations:
        one = _declaration(section, number, line, problems)
        if one is None:
            continue
        name, data_type, comment, span = one
        if name.casefold() in names:
            first = ((names[name.casefold()], "declared here first"),)
            problems.add("STL012", span, f"{name} is declared already", expected="another name", related=first)
            continue
        if section is not Section.TEMP and kind is not PouKind.SBR:
            message = f"{name} is a parameter, and only subroutines have parameters"
            problems.add("STL014", span, message, expected="VAR … END_VAR for variables of this block")
            continue
        if data_type is DataType.STRING and section is not Section.IN:
            problems.add("STL014", span, f"{name} is a STRING", expected="a STRING in VAR_INPUT only")
            continue
        names[name.casefold()] = span
        found.append((section, name, data_type, comment, span))
    found.sort(key=lambda row: _ORDER.index(row[0]))
    return _with_addresses(found, problems)


def _declaration(
    section: Section, number: int, line: str, problems: Collector
) -> tuple[str, DataType, str, Span] | None:
    text = line.strip()
    if text.startswith("//"):
        return None
    match = _DECLARATION.fullmatch(line)
    if match is None:
        span = problems.span(number, line.index(text) + 1, len(text))
        problems.add("STL011", span, f"{text!r} declares no variable", expected="name:TYPE; for example Speed:INT;")
        return None
    data_type = TYPES.get(match["type"].upper())
    if data_type is None:
        span = problems.span(number, match.start("type") + 1, len(match["type"]))
        nearest = problems.nearest(match["type"], TYPES)
        message = f"there is no type {match['type']}"
        problems.add("STL011", span, message, expected=", ".join(TYPES), nearest=nearest)
        return None
    span = problems.span(number, match.start("name") + 1, len(match["name"]))
    return match["name"], data_type, comment_text(match["comment"] or ""), span


def _with_addresses(rows: list[tuple[Section, str, DataType, str, Span]], problems: Collector) -> tuple[Variable, ...]:
    variables = []
    bit = 0
    for section, name, data_type, comment, span in rows:
        if data_type is DataType.BOOL:
            address = Address(Area.L, bit // 8, Width.BIT, bit % 8)
            bit += 1
        else:
            size = _SPLIT_BYTES.get(data_type, data_type.size)
            start = (bit + 7) // 8
            address = Address(Area.L, start, WIDTHS[size])
            bit = (start + size) * 8
        if bit > L_BYTES * 8:
            message = f"{name} has no room: the variables of a block have {L_BYTES} bytes"
            problems.add("STL013", span, message, expected="fewer or smaller variables")
            break
        variables.append(Variable(name, section, data_type, address, comment, span))
    return tuple(variables)
