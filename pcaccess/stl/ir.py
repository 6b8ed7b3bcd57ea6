"""The typed intermediate representation (IR) of a program: what both executions run.

A :class:`Module` has one :class:`Function` per POU; a function is a list of basic blocks; a block is a list of
operations and one terminator. Values are assigned once, where they are defined; what changes and must survive
a join of control flow lives in a :class:`Variable` (the logic stack and ENO). Memory is one big-endian buffer
(``pcaccess.s7200.memory``, ``pcaccess.stl.layout``) addressed by flat byte offsets, which the lowering has
computed; only addresses that come from a pointer are known at run time, and they are checked by
:class:`CheckPointer` before use. The IR knows no mnemonics.

Types:    of values, and how they calculate: ``pcaccess.stl.ir_values``.
Unwind:   a function ends normally or unwound; who calls an unwound function unwinds too, up to the scan. CALL,
          poll, budget and ``Return(unwind=True)`` can unwind.
Errors:   ``IrError`` is our own mistake; ``pcaccess.stl.ir_check.verify`` finds such mistakes.
Source:   docs/decisions/2026-11-22-stl-ir.md.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, get_args

from pcaccess.problems import Span
from pcaccess.stl.ir_values import BinaryOp, Effects, IrType, PythonFunction, Relation, UnaryOp, Value, Variable


@dataclass(slots=True, eq=False)
class Load:
    """``out`` := the number of its type at byte ``at``."""

    out: Value
    at: int


@dataclass(slots=True, eq=False)
class Store:
    at: int
    value: Value


@dataclass(slots=True, eq=False)
class LoadBit:
    """``out`` (I1) := bit ``bit`` of byte ``at``."""

    out: Value
    at: int
    bit: int


@dataclass(slots=True, eq=False)
class StoreBits:
    """Change some bits of byte ``at`` at once; ``bits``: (number, I1 value), each number at most once."""

    at: int
    bits: tuple[tuple[int, Value], ...]


@dataclass(slots=True, eq=False)
class LoadFrom:
    """As Load, from a checked address (I32)."""

    out: Value
    address: Value


@dataclass(slots=True, eq=False)
class StoreTo:
    address: Value
    value: Value


@dataclass(slots=True, eq=False)
class CopyBytes:
    """Copy ``count`` (I32) bytes between checked addresses (I32) that may overlap."""

    to: Value
    source: Value
    count: Value


@dataclass(slots=True, eq=False)
class FillWords:
    """Store ``value`` (16 bits) ``count`` (I32) times from the checked address ``to`` on."""

    to: Value
    value: Value
    count: Value


@dataclass(slots=True, eq=False)
class CheckPointer:
    """``out`` (I32) := flat address of ``size`` (I32) bytes at ``pointer`` (U32), or -1 when the pointer names
    no area or they do not all lie in it (``Module.pointers``)."""

    out: Value
    pointer: Value
    size: Value


@dataclass(slots=True, eq=False)
class Binary:
    op: BinaryOp
    out: Value
    a: Value
    b: Value


@dataclass(slots=True, eq=False)
class Unary:
    op: UnaryOp
    out: Value
    a: Value


@dataclass(slots=True, eq=False)
class Compare:
    """``out`` (I1) := a relation b, as their common type compares."""

    relation: Relation
    out: Value
    a: Value
    b: Value


@dataclass(slots=True, eq=False)
class Convert:
    """``out`` := ``a`` in the type of ``out``: integers keep their low bits (extended as their own type says),
    an integer becomes the nearest real, a real that ``Fits`` becomes an integer without its fraction, F64 is
    rounded to F32."""

    out: Value
    a: Value


@dataclass(slots=True, eq=False)
class Bitcast:
    """The same bits as another type of the same width (U32, I32, F32; U16, I16; U8, I8)."""

    out: Value
    a: Value


@dataclass(slots=True, eq=False)
class Select:
    """``out`` := a where ``condition`` is 1, else b."""

    out: Value
    condition: Value
    a: Value
    b: Value


@dataclass(slots=True, eq=False)
class Fits:
    """``out`` (I1) := 1 when the integer ``type`` can hold ``a``. A real fits when its integral part does; NaN
    and infinity do not."""

    out: Value
    a: Value
    type: IrType


@dataclass(slots=True, eq=False)
class Finite:
    """``out`` (I1) := 1 unless the real ``a`` is infinite or NaN."""

    out: Value
    a: Value


@dataclass(slots=True, eq=False)
class Lookup:
    """``out`` := table[index]; the index lies in the table."""

    out: Value
    index: Value
    table: tuple[int, ...]


@dataclass(slots=True, eq=False)
class GetVariable:
    out: Value
    variable: Variable


@dataclass(slots=True, eq=False)
class SetVariables:
    """Assign all at once: every value is read before any variable changes."""

    assignments: tuple[tuple[Variable, Value], ...]


@dataclass(slots=True, eq=False)
class PushFrame:
    """Save L memory as frame number CALL_DEPTH, count CALL_DEPTH up, clear L memory."""


@dataclass(slots=True, eq=False)
class PopFrame:
    """Count CALL_DEPTH down and bring that frame back to L memory."""


@dataclass(slots=True, eq=False)
class CallPou:
    """Run a function of the module. Unwinds if it does."""

    function: int


@dataclass(slots=True, eq=False)
class CallPython:
    """``out`` := function(runtime, *static, *arguments): a cold instruction.

    ``runtime`` is a ``pcaccess.stl.runtime.Runtime``. The function may read and write the whole buffer. It
    returns a number for ``out``, or None where there is no ``out``. It does not raise.
    """

    out: Value | None
    function: PythonFunction
    static: tuple[Any, ...]
    arguments: tuple[Value, ...]
    effects: Effects
    place: int


@dataclass(slots=True, eq=False)
class Fault:
    """Record the run-time error ``code`` (I32, a ``RunTimeError``) at ``place`` and set SM4.3; go on."""

    code: Value
    place: int


@dataclass(slots=True, eq=False)
class Poll:
    """If byte ATTENTION is not 0, ask ``runtime.poll(network)``: interrupts run there, time goes on. May unwind.

    ``network``: number (from 0) of the main program's network that starts here; -1 at any other place.
    """

    network: int


@dataclass(slots=True, eq=False)
class Budget:
    """Count BUDGET down; when it was 0, ask ``runtime.out_of_budget(place)``. May unwind.

    On every backward jump and every call: calls eight deep can last as long as any loop.
    """

    place: int


Operation = (
    Load
    | Store
    | LoadBit
    | StoreBits
    | LoadFrom
    | StoreTo
    | CopyBytes
    | FillWords
    | CheckPointer
    | Binary
    | Unary
    | Compare
    | Convert
    | Bitcast
    | Select
    | Fits
    | Finite
    | Lookup
    | GetVariable
    | SetVariables
    | PushFrame
    | PopFrame
    | CallPou
    | CallPython
    | Fault
    | Poll
    | Budget
)


@dataclass(slots=True, eq=False)
class Jump:
    target: Block


@dataclass(slots=True, eq=False)
class Branch:
    condition: Value
    then: Block
    otherwise: Block


@dataclass(slots=True, eq=False)
class Return:
    """Leave the function. ``unwind``: and everything that called it, up to the scan."""

    unwind: bool = False


Terminator = Jump | Branch | Return


@dataclass(slots=True, eq=False)
class Block:
    """Operations that run one after the other; ``index`` is its place in ``Function.blocks``."""

    index: int
    operations: list[Operation] = field(default_factory=list)
    terminator: Terminator | None = None

    def __repr__(self) -> str:
        return f"block{self.index}"

    def successors(self) -> tuple[Block, ...]:
        end = self.terminator
        if isinstance(end, Jump):
            return (end.target,)
        if isinstance(end, Branch):
            return (end.then, end.otherwise)
        return ()


@dataclass(slots=True, eq=False)
class Function:
    """One POU. It begins with ``blocks[0]``."""

    name: str
    """``OB1``, ``SBR0``, ``INT3``."""
    blocks: list[Block] = field(default_factory=list)
    values: list[Value] = field(default_factory=list)
    """Every value by its index; constants among them."""
    variables: list[Variable] = field(default_factory=list)

    def operations(self) -> Iterator[Operation]:
        for block in self.blocks:
            yield from block.operations


@dataclass(frozen=True, slots=True)
class Place:
    """Where in the user's program something is, for error records."""

    pou: str
    """``MAIN (OB1)``."""
    network: int
    span: Span


@dataclass(frozen=True, slots=True)
class PointerArea:
    """What a pointer with the area code ``code`` (its top byte) may reach."""

    code: int
    start: int
    """Flat address of its first byte."""
    size: int
    """Bytes the CPU model has."""


@dataclass(frozen=True, slots=True)
class Module:
    """A whole program, ready to be executed on one CPU model."""

    functions: tuple[Function, ...]
    main: int
    """Index of OB1 in ``functions``."""
    interrupts: Mapping[int, int]
    """Number of an interrupt routine -> index in ``functions``."""
    places: tuple[Place, ...]
    pointers: tuple[PointerArea, ...]
    networks: int
    """Networks of the main program."""
    edges: int
    """Edge memories in use."""


_USES: Mapping[type, tuple[str, ...]] = {
    kind: tuple(member.name for member in fields(kind) if member.type == "Value" and member.name != "out")
    for kind in get_args(Operation | Terminator)
}
"""The members of each operation that are single values it reads."""


def uses(op: Operation | Terminator) -> tuple[Value, ...]:
    """The values that ``op`` reads."""
    if isinstance(op, StoreBits):
        return tuple(value for _, value in op.bits)
    if isinstance(op, SetVariables):
        return tuple(value for _, value in op.assignments)
    if isinstance(op, CallPython):
        return op.arguments
    return tuple(getattr(op, name) for name in _USES[type(op)])


def result(op: Operation) -> Value | None:
    """The value that ``op`` defines."""
    out: Value | None = getattr(op, "out", None)
    return out
