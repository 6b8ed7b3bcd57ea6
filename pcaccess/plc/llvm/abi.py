"""What compiled code and Python agree on: the environment, and how values pass.

Compiled code gets two pointers: the CPU's memory (``pcaccess.stl.layout``) and the environment, an array of 64-bit
words. Word 0 is not 0 when a Python function failed and the code has to unwind; the other words are addresses of
Python functions: poll, out_of_budget, fault, and one for each signature of cold instructions.

A signature says how the arguments and the result of a cold instruction pass: ``i`` a signed 64-bit number, ``u``
an unsigned one, ``d`` a double; the result stands first, ``v`` for none: ``idi``.

Units:    offsets in bytes.
"""

from __future__ import annotations

from typing import Final

from pcaccess.stl import ir
from pcaccess.stl.ir_values import IrType

WORD: Final = 8
FAILED: Final = 0
POLL: Final = 1 * WORD
OUT_OF_BUDGET: Final = 2 * WORD
FAULT: Final = 3 * WORD
SIGNATURES: Final = 4 * WORD
"""The first of the signatures, in the order of ``Sites.signatures``."""


def letter(kind: IrType | None) -> str:
    """How a value of this type passes."""
    if kind is None:
        return "v"
    if kind.real:
        return "d"
    return "u" if kind is IrType.U64 else "i"


class Sites:
    """The places in a module where it calls a cold instruction, numbered as they are met."""

    def __init__(self) -> None:
        self.calls: list[ir.CallPython] = []
        self._signatures: dict[str, int] = {}

    @property
    def signatures(self) -> tuple[str, ...]:
        return tuple(self._signatures)

    def add(self, call: ir.CallPython) -> tuple[int, str]:
        """The number of a new place, and its signature."""
        arguments = "".join(letter(a.type) for a in call.arguments)
        signature = letter(call.out.type if call.out else None) + arguments
        self._signatures.setdefault(signature, len(self._signatures))
        self.calls.append(call)
        return len(self.calls) - 1, signature

    def offset(self, signature: str) -> int:
        """Where the environment has the function for a signature."""
        return SIGNATURES + WORD * self._signatures[signature]
