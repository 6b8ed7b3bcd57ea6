"""How an IR function is laid out: the order of its code, and the pieces it is cut into.

LLVM's code generator keeps every value that lives across blocks in the stack frame of its function, and some of its
work grows faster than the function. A long program is therefore cut into many LLVM functions of a few hundred
operations, which one driver calls in turn: the frame stays small and in the cache, and ten thousand instructions cost
ten times a thousand. A piece is a range of the order with one way in (its first node) and one way on (the node
behind it); networks begin such ranges nearly everywhere. What is in no piece stays in the driver.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

from pcaccess.stl import ir

PIECE: Final = 400
"""Operations in a piece, as a rule."""
WHOLE: Final = 3 * PIECE
"""A function up to so many operations is not cut."""


@dataclass(slots=True)
class Node:
    """Operations ``first`` to ``last`` (exclusive) of a block; a block is divided where networks begin."""

    block: ir.Block
    first: int
    last: int
    label: str
    ends: bool
    """The block's terminator follows."""
    targets: tuple[int, ...] = ()
    """Positions that control can go to from here; none for a return."""
    rare: bool = False
    """An error path: it is written behind the others of its function."""


@dataclass(slots=True)
class Piece:
    """Nodes ``start`` to ``end`` (exclusive)."""

    start: int
    end: int


@dataclass(slots=True)
class Plan:
    nodes: list[Node]
    likely: set[int] = field(default_factory=set)
    """Indices of values that are 1 as a rule: what a result that fits says."""
    pieces: list[Piece] = field(default_factory=list)
    """In order, none within another."""


def plan(function: ir.Function) -> Plan:
    """Only blocks that can be reached are in it."""
    order = _order(function)
    nodes, likely = _nodes(order)
    size = sum(node.last - node.first for node in nodes)
    return Plan(nodes, likely, _pieces(nodes) if size > WHOLE else [])


def _order(function: ir.Function) -> list[ir.Block]:
    """Reverse postorder, so that what is written first runs first; the side that is taken when power flows follows
    its branch directly."""
    order: list[ir.Block] = []
    seen = {0}
    stack = [(function.blocks[0], iter(reversed(function.blocks[0].successors())))]
    while stack:
        block, successors = stack[-1]
        for successor in successors:
            if successor.index not in seen:
                seen.add(successor.index)
                stack.append((successor, iter(reversed(successor.successors()))))
                break
        else:
            order.append(block)
            stack.pop()
    order.reverse()
    return order


def _nodes(order: list[ir.Block]) -> tuple[list[Node], set[int]]:
    nodes: list[Node] = []
    starts: dict[int, int] = {}
    likely: set[int] = set()
    faults: set[int] = set()
    for block in order:
        starts[block.index] = len(nodes)
        cuts = []
        for n, op in enumerate(block.operations):
            kind = type(op)
            if kind is ir.Poll:
                cuts.append(n)
            elif kind is ir.Fits or kind is ir.Finite:
                likely.add(op.out.index)  # type: ignore[union-attr]
            elif kind is ir.Fault:
                faults.add(block.index)
        bounds = [0, *(n for n in cuts if n), len(block.operations)]
        for first, last in pairwise(bounds):
            label = f"n{len(nodes)}" if first else f"b{block.index}"
            nodes.append(Node(block, first, last, label, ends=last == bounds[-1]))
        if len(bounds) == 1:
            nodes.append(Node(block, 0, 0, f"b{block.index}", ends=True))
    for position, node in enumerate(nodes):
        if node.ends:
            node.targets = tuple(starts[successor.index] for successor in node.block.successors())
        else:
            node.targets = (position + 1,)
    ways = Counter(successor.index for block in order for successor in block.successors())
    for block in order:
        end = block.terminator
        if isinstance(end, ir.Branch) and end.condition.index in likely and ways[end.otherwise.index] == 1:
            faults.add(end.otherwise.index)
    for node in nodes[1:]:
        if node.ends and not node.first and node.block.index in faults:
            # What it computed would be used before its text, and numbered too late.
            node.rare = all(ir.result(op) is None for op in node.block.operations)
    return nodes, likely


def _pieces(nodes: list[Node]) -> list[Piece]:
    sources: list[list[int]] = [[] for _ in nodes]
    for position, node in enumerate(nodes):
        for target in node.targets:
            sources[target].append(position)
    pieces = []
    start = 0
    while start < len(nodes):
        end = _end(nodes, sources, start)
        if end is None:
            start += 1
        else:
            pieces.append(Piece(start, end))
            start = end
    return pieces


def _end(nodes: list[Node], sources: list[list[int]], start: int) -> int | None:
    """The end of the piece that begins at ``start``: the first good one with enough in it, else the last good one."""
    size, best = 0, None
    furthest = last_source = start
    for position in range(start, len(nodes)):
        node = nodes[position]
        if position > start and sources[position]:
            if min(sources[position]) < start:
                break  # a second way in
            last_source = max(last_source, *sources[position])
        if node.targets:
            if min(node.targets) < start:
                break  # a way out to somewhere else
            furthest = max(furthest, *node.targets)
        size += node.last - node.first
        if furthest <= position + 1 and last_source <= position and size >= PIECE // 4:
            best = position + 1
            if size >= PIECE:
                break
        if size > 8 * PIECE:
            break
    return best
