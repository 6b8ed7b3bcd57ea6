"""Builds docs/instructions from the definitions and the conformance cases. As a program: writes the pages.

Never edit the pages: change the definition (``pcaccess/stl/instructions``) and run this again. A test compares.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Final

from conformance import Case, load_cases

from pcaccess.s7200.address import Area
from pcaccess.s7200.types import DataType
from pcaccess.stl.define import Definition, Direction, Family, OperandSpec, Power, SmBit, Special
from pcaccess.stl.definitions import families

FOLDER: Final = Path(__file__).parent.parent / "docs" / "instructions"
_POWER: Final = {
    Power.CONTACT: "Contact: works on the top of the logic stack.",
    Power.STACK: "Rearranges the logic stack.",
    Power.COIL: "Runs in every execution, with the logic stack as its input.",
    Power.BOX: "Box: runs while the top of the logic stack is 1, and leaves the stack as it is.",
    Power.CONTROL: "Acts while the top of the logic stack is 1.",
    Power.MARK: "Whatever the logic stack says.",
}
_SPECIAL: Final = {
    Special.SBR: "a subroutine",
    Special.INT: "an interrupt routine",
    Special.COUNTER: "C0 to C255",
    Special.PARAMETERS: "what the subroutine declares: IN, IN_OUT, OUT, in this order",
}


def build() -> dict[str, str]:
    """File name -> text, for every group of instructions and the index."""
    groups: dict[str, list[Family]] = defaultdict(list)
    for family in families():
        groups[family.rows[0].group].append(family)
    examples = _examples()
    pages = {f"{_slug(group)}.md": _page(group, members, examples) for group, members in groups.items()}
    return {"README.md": _index(groups), **pages}


def _slug(group: str) -> str:
    return group.lower().replace(" ", "-")


def _examples() -> dict[str, Case]:
    """The first plain case of each mnemonic; the first that fails where there is no other."""
    plain: dict[str, Case] = {}
    failing: dict[str, Case] = {}
    for case in load_cases():
        if not case.problem:
            (failing if case.fault or case.stop else plain).setdefault(case.mnemonic, case)
    return failing | plain


def _index(groups: dict[str, list[Family]]) -> str:
    lines = [
        "# Instructions",
        "",
        "Every STL instruction that the soft-PLC executes. These pages are built from the definitions by",
        "`tools/instruction_docs.py`; do not edit them. S0 is the top of the logic stack.",
        "",
        "| instruction | group | what it does |",
        "|---|---|---|",
    ]
    for group, members in sorted(groups.items()):
        for family in members:
            names = ", ".join(f"`{row.mnemonic}`" for row in family.rows)
            lines.append(f"| {_cell(names)} | [{group}]({_slug(group)}.md) | {_cell(family.rows[0].summary)} |")
    return "\n".join(lines) + "\n"


def _page(group: str, members: Iterable[Family], examples: dict[str, Case]) -> str:
    parts = [f"# {group}", "", "Built from the definitions by `tools/instruction_docs.py`; do not edit.", ""]
    for family in members:
        parts += _family(family, examples)
    return "\n".join(parts).rstrip() + "\n"


def _family(family: Family, examples: dict[str, Case]) -> list[str]:
    first = family.rows[0]
    lines = ["## " + " ".join(f"`{row.mnemonic}`" for row in family.rows), "", first.summary, ""]
    if first.description:
        lines += [first.description, ""]
    lines += [_POWER[first.power], ""]
    lines += _operands(family)
    lines += _flags(first)
    lines += [f"Source: {first.source}.", ""]
    example = next((examples[row.mnemonic] for row in family.rows if row.mnemonic in examples), None)
    return lines + (_example(example) if example else [])


def _operands(family: Family) -> list[str]:
    first = family.rows[0]
    if not first.operands:
        return ["No operands.", ""]
    lines = ["| operand | | type | where |", "|---|---|---|---|"]
    for number, spec in enumerate(first.operands):
        by_place: dict[str, list[str]] = {}
        for row in family.rows:
            kinds = by_place.setdefault(_where(row.operands[number]), [])
            if _type(row.operands[number]) not in kinds:
                kinds.append(_type(row.operands[number]))
        for place, kinds in by_place.items():
            lines.append(f"| {spec.name} | {_direction(spec)} | {', '.join(kinds)} | {_cell(place)} |")
    return [*lines, ""]


def _direction(spec: OperandSpec) -> str:
    return {Direction.IN: "in", Direction.OUT: "out", Direction.INOUT: "in and out"}[spec.direction]


def _type(spec: OperandSpec) -> str:
    return spec.type.name if isinstance(spec.type, DataType) else spec.type.value


def _where(spec: OperandSpec) -> str:
    if spec.type is Special.TIMER:
        return "T0 to T31, T64 to T95" if spec.timers == "TONR" else "T32 to T63, T96 to T255"
    if spec.type in (Special.LABEL, Special.NUMBER):
        return f"a constant {spec.low} to {spec.high}"
    if not isinstance(spec.type, DataType):
        return _SPECIAL[spec.type]
    words = [area.value for area in Area if area in spec.areas]
    words += ["a pointer"] if spec.pointer else []
    words += ["an address (`&VB100`)"] if spec.address_of else []
    if spec.constant:
        words.append("a constant" if spec.low is None else f"a constant {spec.low} to {spec.high}")
    return ", ".join(words)


def _flags(definition: Definition) -> list[str]:
    lines = []
    if definition.sm:
        lines.append(f"Changes {', '.join(map(str, definition.sm))}.")
    causes = [str(c) if isinstance(c, SmBit) else f"{c} ({c.text})" for c in definition.eno_off]
    if causes:
        lines.append(f"ENO is 0 after {', '.join(causes)}.")
    if definition.errors:
        lines.append(f"Errors: {', '.join(f'{e} ({e.text})' for e in definition.errors)}.")
    return [*lines, ""] if lines else []


def _example(case: Case) -> list[str]:
    lines = ["Example:", "", "```", *case.program.splitlines(), "```", ""]
    for scan in case.scans:
        when = "" if len(case.scans) == 1 else f"At {scan.at:g} ms: "
        given, expected = _values(scan.given), _values(scan.expect)
        said = [f"with {given}" if given else "", f"one scan gives {expected}" if expected else "one scan runs"]
        text = ", ".join(word for word in said if word)
        lines.append(f"- {when}{text}" if when else f"{text[0].upper()}{text[1:]}.")
    if case.fault or case.stop:
        lines.append(f"Error {case.fault or case.stop}.")
    return [*lines, ""]


def _values(values: Mapping[str, str]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in values.items())


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def main() -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    pages = build()
    for path in FOLDER.glob("*.md"):
        if path.name not in pages:
            path.unlink()
    for name, text in pages.items():
        (FOLDER / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
