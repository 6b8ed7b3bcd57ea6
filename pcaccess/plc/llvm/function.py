"""One IR function as LLVM functions: ``i1 @fN(ptr %m, ptr %e)``, 1 when it unwound, and its pieces ``@fN_K``.

``%m`` is the CPU's memory, ``%e`` the environment (``pcaccess.plc.llvm.abi``). A piece also gets ``%x``, the frame that
all pieces of one running function share; it answers 0 to go on behind it, 1 when the function returned, 2 when it
unwound. Within a piece variables are its own: loaded from the frame first, stored back where the piece is left for
the next one.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

from pcaccess.plc.llvm.operations import NAMES, Parts, Writer, constant
from pcaccess.plc.llvm.regions import Node, Piece, Plan, plan
from pcaccess.stl import ir
from pcaccess.stl.ir_values import IrError, Variable

_ON, _RETURNED, _UNWOUND = 0, 1, 2
_SLOT: Final = 8
"""Bytes of a value or variable in the frame."""


@dataclass(slots=True)
class _Shared:
    """What several pieces use, and where it lies in the frame."""

    slots: dict[int, int] = field(default_factory=dict)
    """Index of a value -> offset."""
    variables: dict[int, int] = field(default_factory=dict)
    size: int = 0


def function_text(function: ir.Function, index: int, *, exported: bool, parts: Parts) -> str:
    """``exported``: it can be run from outside."""
    composer = _Composer(function, index, parts)
    return composer.text("" if exported else "internal ")


class _Composer:
    def __init__(self, function: ir.Function, index: int, parts: Parts) -> None:
        self._function = function
        self._index = index
        self._parts = parts
        self._plan: Plan = plan(function)
        self._names = ["" if v.constant is None else constant(v) for v in function.values]
        reads = {op.variable.index for op in function.operations() if isinstance(op, ir.GetVariable)}
        self._variables = [v for v in function.variables if v.index in reads]
        self._read = frozenset(reads)
        self._home: list[int] = []
        """Piece of each node, -1: the driver."""
        self._shared = _Shared()

    def text(self, linkage: str) -> str:
        pieces = self._plan.pieces
        self._home = [-1] * len(self._plan.nodes)
        for number, piece in enumerate(pieces):
            self._home[piece.start : piece.end] = [number] * (piece.end - piece.start)
        if pieces:
            self._share()
        texts = [_PieceText(self, number, piece).text() for number, piece in enumerate(pieces)]
        return "".join([*texts, self._driver(linkage)])

    def _share(self) -> None:
        """Give a place in the frame to every variable, and to every value that is used in another piece."""
        home: dict[int, int] = {}
        used: list[tuple[int, int]] = []
        for node, piece in zip(self._plan.nodes, self._home, strict=True):
            for op in operations(node):
                used += [(v.index, piece) for v in ir.uses(op) if v.constant is None]
                if not isinstance(op, ir.Jump | ir.Branch | ir.Return) and (out := ir.result(op)) is not None:
                    home[out.index] = piece
        slots = dict.fromkeys(value for value, piece in used if home[value] != piece)
        self._shared.slots = {value: _SLOT * n for n, value in enumerate(slots)}
        first = _SLOT * len(slots)
        self._shared.variables = {v.index: first + _SLOT * n for n, v in enumerate(self._variables)}
        self._shared.size = first + _SLOT * len(self._variables)

    def _driver(self, linkage: str) -> str:
        w = Writer(self._function, self._names, self._parts)
        w.variables = self._read
        w.out.append(f"define {linkage}zeroext i1 @f{self._index}(ptr %m, ptr %e) nounwind {{\nentry:\n")
        shared = self._shared
        if self._plan.pieces:
            w.out.append(f"%x = alloca [{shared.size} x i8], align {_SLOT}\n")
        for variable in self._variables:
            name, kind = f"%x{variable.index}", NAMES[variable.type]
            place = (
                f"getelementptr i8, ptr %x, i64 {shared.variables[variable.index]}" if shared.size else f"alloca {kind}"
            )
            w.out.append(f"{name} = {place}\nstore {kind} {variable.initial}, ptr {name}\n")
        w.out.append(f"br label %{self._plan.nodes[0].label}\n")
        region = _Region(self, w, -1, "ret i1 false", "ret i1 true")
        region.write([n for n, home in enumerate(self._home) if home < 0])
        for number, piece in enumerate(self._plan.pieces):
            self._call(w, number, piece)
        return _finished(w, "ret i1 true")

    def _call(self, w: Writer, number: int, piece: Piece) -> None:
        """Run a piece in its place."""
        nodes = self._plan.nodes
        w.out.append(f"{nodes[piece.start].label}:\n")
        status = w.line(f"call i8 @f{self._index}_{number}(ptr %m, ptr %e, ptr %x)")
        if piece.end < len(nodes):
            on = w.line(f"icmp eq i8 {status}, {_ON}")
            w.out.append(f"br i1 {on}, label %{nodes[piece.end].label}, label %left{number}\n")
        else:
            w.out.append(f"br label %left{number}\n")
        w.rare.append(f"left{number}:\n%l{number} = icmp eq i8 {status}, {_UNWOUND}\nret i1 %l{number}\n")


class _PieceText:
    """One piece as a function of its own."""

    def __init__(self, composer: _Composer, number: int, piece: Piece) -> None:
        self._composer = composer
        self._number = number
        self._piece = piece

    def text(self) -> str:
        c = self._composer
        w = Writer(c._function, c._names, c._parts)
        w.variables = c._read
        name = f"@f{c._index}_{self._number}"
        w.out.append(f"define internal i8 {name}(ptr %m, ptr %e, ptr noalias %x) noinline nounwind {{\nentry:\n")
        used, changed = self._variables()
        for variable in used:
            kind, place = NAMES[variable.type], f"%x{variable.index}"
            now = w.line(f"load {kind}, ptr {self._slot(w, variable)}")
            w.out.append(f"{place} = alloca {kind}\nstore {kind} {now}, ptr {place}\n")
        w.out.append(f"br label %{c._plan.nodes[self._piece.start].label}\n")
        region = _Region(c, w, self._number, f"ret i8 {_RETURNED}", f"ret i8 {_UNWOUND}")
        region.write(range(self._piece.start, self._piece.end))
        w.out.append("done:\n")
        for variable in changed:
            kind = NAMES[variable.type]
            now = w.line(f"load {kind}, ptr %x{variable.index}")
            w.out.append(f"store {kind} {now}, ptr {self._slot(w, variable)}\n")
        w.out.append(f"ret i8 {_ON}\n")
        return _finished(w, f"ret i8 {_UNWOUND}")

    def _slot(self, w: Writer, variable: Variable) -> str:
        return w.line(f"getelementptr i8, ptr %x, i64 {self._composer._shared.variables[variable.index]}")

    def _variables(self) -> tuple[list[Variable], list[Variable]]:
        """Those that the piece uses, and those of them that it changes."""
        read: set[int] = set()
        written: set[int] = set()
        for node in self._composer._plan.nodes[self._piece.start : self._piece.end]:
            for op in node.block.operations[node.first : node.last]:
                if isinstance(op, ir.GetVariable):
                    read.add(op.variable.index)
                elif isinstance(op, ir.SetVariables):
                    written.update(variable.index for variable, _ in op.assignments)
        every = self._composer._variables
        return [v for v in every if v.index in read | written], [v for v in every if v.index in written]


class _Region:
    """Nodes written into one LLVM function."""

    def __init__(self, composer: _Composer, w: Writer, number: int, returned: str, unwound: str) -> None:
        self._composer = composer
        self._w = w
        self._number = number
        self._returned = returned
        self._unwound = unwound
        self._slots = composer._shared.slots
        self._own: set[int] = set()
        """Values that were computed here."""

    def write(self, positions: Iterable[int]) -> None:
        """Nodes in their order, those that seldom run behind the others."""
        nodes = self._composer._plan.nodes
        usual: list[int] = []
        rare: list[int] = []
        for position in positions:
            (rare if nodes[position].rare else usual).append(position)
        before = -1
        for position in usual + rare:
            self._node(position, labelled=position != before + 1 or not nodes[position].first)
            before = position

    def _node(self, position: int, *, labelled: bool) -> None:
        w, node = self._w, self._composer._plan.nodes[position]
        if labelled:
            w.out.append(f"{node.label}:\n")
        if self._slots:
            for op in operations(node):
                self._fetch(op)
                if not isinstance(op, ir.Jump | ir.Branch | ir.Return):
                    w.operation(op)
                    self._keep(op)
        else:
            for op in node.block.operations[node.first : node.last]:
                w.operation(op)
        if node.ends:
            self._terminate(node)
        elif not self._inside(position + 1):
            w.out.append(f"br label %{self._label(position + 1)}\n")

    def _inside(self, position: int) -> bool:
        home = self._composer._home
        return position < len(home) and home[position] == self._number

    def _label(self, position: int) -> str:
        """Where to go for the node at ``position``: from a piece to other nodes only through its end."""
        if self._number >= 0 and not self._inside(position):
            return "done"
        return self._composer._plan.nodes[position].label

    def _terminate(self, node: Node) -> None:
        end = node.block.terminator
        if isinstance(end, ir.Return):
            self._w.out.append(f"{self._unwound if end.unwind else self._returned}\n")
            return
        labels = [self._label(target) for target in node.targets]
        if isinstance(end, ir.Branch):
            condition = self._w.name(end.condition)
            weights = ", !prof !0" if end.condition.index in self._composer._plan.likely else ""
            self._w.out.append(f"br i1 {condition}, label %{labels[0]}, label %{labels[1]}{weights}\n")
        elif isinstance(end, ir.Jump):
            self._w.out.append(f"br label %{labels[0]}\n")
        else:
            raise IrError(f"{self._composer._function.name}: {node.block} has no end")

    def _fetch(self, op: ir.Operation | ir.Terminator) -> None:
        """Bring what another piece computed."""
        for value in ir.uses(op):
            if value.index in self._slots and value.index not in self._own:
                at = self._w.line(f"getelementptr i8, ptr %x, i64 {self._slots[value.index]}")
                self._w.rename(value, self._w.line(f"load {NAMES[value.type]}, ptr {at}"))

    def _keep(self, op: ir.Operation) -> None:
        """Put what another piece needs where it finds it."""
        out = ir.result(op)
        if out is not None and out.index in self._slots:
            self._own.add(out.index)
            at = self._w.line(f"getelementptr i8, ptr %x, i64 {self._slots[out.index]}")
            self._w.out.append(f"store {NAMES[out.type]} {self._w.name(out)}, ptr {at}\n")


def operations(node: Node) -> Iterable[ir.Operation | ir.Terminator]:
    """The node's operations, and the block's end where the node has it."""
    yield from node.block.operations[node.first : node.last]
    if node.ends and node.block.terminator is not None:
        yield node.block.terminator


def _finished(w: Writer, unwind: str) -> str:
    return "".join([*w.out, *w.rare, f"unwind:\n{unwind}\n}}\n"])
