"""What the cases owe: computed from the definitions, so a new instruction without cases is found here."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

from conformance import Case, load_cases

from pcaccess.stl.define import Definition, Power, SmBit
from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.errors import INDIRECT_ADDRESS, RunTimeError

CASES: dict[str, list[Case]] = defaultdict(list)
for _case in load_cases():
    CASES[_case.mnemonic].append(_case)

ELSEWHERE: frozenset[RunTimeError] = frozenset({INDIRECT_ADDRESS})
"""test_variants.py tries a bad pointer for every operand that can be one."""


IMPOSSIBLE = {"MUL: SM1.1 is never 1"}
"""A product of two words always fits a double word; MUL clears SM1.1."""


WAITING = {"TODR", "TODW", "TODRX", "TODWX", "XMT", "RCV", "NETR", "NETW", "HDEF", "HSC", "PLS", "PID", "ATCH"}
"""Their peripherals are not there yet; until then the cases show what they answer without them."""


def expectations(case: Case) -> Iterator[tuple[str, str]]:
    for scan in case.scans:
        yield from scan.expect.items()


def owed(definition: Definition) -> Iterator[str]:
    """What is missing for one instruction, in words."""
    cases = CASES[definition.mnemonic]
    if not cases:
        yield "has no case"
        return
    seen = {pair for case in cases for pair in expectations(case)}
    if definition.mnemonic in WAITING:
        return
    for bit in definition.sm:
        yield from (f"{bit} is never {value}" for value in ("0", "1") if (str(bit), value) not in seen)
    for cause in (*definition.eno_off, *definition.errors):
        if isinstance(cause, SmBit):
            if not any({(str(cause), "1"), ("Q1.7", "0")} <= set(expectations(case)) for case in cases):
                yield f"ENO is never 0 because of {cause}"
        elif cause not in ELSEWHERE and not any(case.fault == str(cause) for case in cases):
            yield f"error {cause} never happens"
    if definition.power is Power.CONTACT:
        yield from (f"the result is never {value}" for value in ("0", "1") if ("Q0.0", value) not in seen)
    if definition.power is Power.BOX and definition.eno_off and ("Q1.7", "1") not in seen:
        yield "ENO is never 1"


def test_every_obligation_has_a_case() -> None:
    executable = [definition for definition in DEFINITIONS.values() if definition.body is not None]
    missing = [f"{d.mnemonic}: {what}" for d in executable for what in owed(d)]
    assert set(missing) == IMPOSSIBLE


def test_every_case_names_an_instruction() -> None:
    assert set(CASES) <= set(DEFINITIONS)


def test_no_case_expects_nothing() -> None:
    idle = [
        str(c)
        for cases in CASES.values()
        for c in cases
        if not (any(expectations(c)) or c.fault or c.stop or c.problem)
    ]
    assert idle == []
