"""A whole IR module as LLVM text."""

from __future__ import annotations

from dataclasses import dataclass

from pcaccess.plc.llvm.abi import Sites
from pcaccess.plc.llvm.function import function_text
from pcaccess.plc.llvm.operations import Parts
from pcaccess.plc.llvm.prelude import prelude
from pcaccess.stl import ir

_WEIGHTS = '!0 = !{!"branch_weights", i32 1000000, i32 1}\n!1 = !{!"branch_weights", i32 1, i32 1000000}\n'


@dataclass(frozen=True, slots=True)
class ModuleText:
    """A module ready for LLVM."""

    text: str
    sites: Sites
    entries: tuple[int, ...]
    """Functions that can be run from outside; function n is the symbol ``fn``."""


def module_text(module: ir.Module) -> ModuleText:
    parts = Parts()
    entries = (module.main, *sorted(module.interrupts.values()))
    functions = [
        function_text(function, index, exported=index in entries, parts=parts)
        for index, function in enumerate(module.functions)
    ]
    head = prelude(module.pointers, parts.sites) + parts.tables.text()
    return ModuleText("".join([head, *functions, _WEIGHTS]), parts.sites, entries)
