"""What a user calls an item, and which items of the server that is.

An item ID or run-time name in any case, a NodeId text, a branch (every item below it) or a pattern with ``*`` and
``?``. A name that is nothing gets the nearest ones that are.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fnmatch import translate
from typing import Any, Final

from asyncua import ua
from asyncua.ua.attribute_ids import AttributeIds
from asyncua.ua.status_codes import StatusCodes

from pcaccess.cli.remote import Child, Remote, status_text
from pcaccess.cli.values import TYPES
from pcaccess.problems import either, nearest_words
from pcaccess.project.names import RunTimeNameError, parse_run_time_name

NEAREST: Final = 3
"""So many names are suggested."""
HELPED: Final = 5
"""So many unknown names get suggestions; then typing is not the trouble, and looking costs time."""
LONGEST_SHOWN: Final = 200
"""Characters of a name in a message; an item ID has fewer."""
SEARCHED: Final = 20_000
"""Items that are looked at for a suggestion, when nothing near the name is one."""


@dataclass(frozen=True, slots=True)
class Target:
    """A node that a name led to."""

    node: ua.NodeId
    item_id: str
    """As the server writes it."""
    is_item: bool
    type: int = 0
    """OPC UA built-in type, 0 for others."""
    is_array: bool = False
    is_named: bool = True
    """Somebody asked for it; false: it came with a branch or pattern."""


@dataclass(frozen=True, slots=True)
class Unknown:
    """A name that led nowhere."""

    name: str
    status: int
    message: str


Found = Target | Unknown


async def resolve(remote: Remote, names: Sequence[str]) -> list[Found]:
    """The node of each name, in order; no patterns, no branches taken apart."""
    nodes = [remote.node(name) for name in names]
    answers = await remote.read((node, attribute) for node in nodes if node is not None for attribute in _ATTRIBUTES)
    rest = iter(answers)
    found: list[Found] = []
    for name, node in zip(names, nodes, strict=True):
        if node is None:
            found.append(Unknown(name, StatusCodes.BadNodeIdInvalid, _no_name(remote, name)))
            continue
        written, kind, data_type, rank = (next(rest) for _ in _ATTRIBUTES)
        if written.Value is None or written.Value.Value is None:
            helped = sum(isinstance(one, Unknown) for one in found) >= HELPED
            found.append(await _unknown(remote, name, status_of(written), helped=helped))
            continue
        node = written.Value.Value
        is_item = content(kind) == ua.NodeClass.Variable
        is_array = is_item and (content(rank) or 0) > 0
        found.append(Target(node, remote.name(node), is_item, built_in(content(data_type)), is_array))
    return found


_ATTRIBUTES: Final = (AttributeIds.NodeId, AttributeIds.NodeClass, AttributeIds.DataType, AttributeIds.ValueRank)


def content(value: ua.DataValue) -> Any:
    """What an attribute holds; None when it could not be read."""
    return value.Value.Value if value.Value is not None else None


def status_of(value: ua.DataValue) -> int:
    """The StatusCode; Good when there is none (OPC UA Part 6, DataValue)."""
    return int(value.StatusCode.value) if value.StatusCode is not None else 0


def built_in(data_type: ua.NodeId | None) -> int:
    """The built-in type of a DataType node; 0 for types made of others."""
    if data_type is None or data_type.NamespaceIndex != 0 or not isinstance(data_type.Identifier, int):
        return 0
    return data_type.Identifier if data_type.Identifier in TYPES else 0


# ---------------------------------------------------------------------- branches and patterns


async def expand(remote: Remote, names: Sequence[str]) -> list[Found]:
    """The items that names, branches and patterns stand for, in order.

    A name is answered as often as it stands there; what came already does not come again with a branch or pattern.
    """
    plain = [name for name in names if not is_pattern(name)]
    resolved = dict(zip(plain, await resolve(remote, plain), strict=True))
    found: list[Found] = []
    known: set[ua.NodeId] = set()
    for name in names:
        one = resolved.get(name)
        if one is None:
            some = await _matching(remote, name)
        elif isinstance(one, Target) and not one.is_item:
            some = await items_below(remote, one.node)
            some = some or [Unknown(name, StatusCodes.BadNoData, f"there are no items in {one.item_id}")]
        else:
            some = [one]
        fresh = [f for f in some if not isinstance(f, Target) or f.is_named or f.node not in known]
        known.update(f.node for f in fresh if isinstance(f, Target))
        found += fresh
    return found


async def items_below(remote: Remote, node: ua.NodeId) -> list[Found]:
    """Every item below a node, branch by branch in the server's order."""
    below = await walk(remote, node)
    return await _unnamed(remote, [remote.name(c.NodeId) for _, c in below if c.NodeClass == ua.NodeClass.Variable])


async def _unnamed(remote: Remote, names: Sequence[str]) -> list[Found]:
    """Items that a branch or pattern led to."""
    found = await resolve(remote, names)
    return [replace(one, is_named=False) if isinstance(one, Target) else one for one in found]


def is_pattern(name: str) -> bool:
    return "*" in name or "?" in name


async def _matching(remote: Remote, pattern: str) -> list[Found]:
    fixed = re.split(r"[*?]", pattern, maxsplit=1)[0]
    branch = fixed.rpartition(".")[0]
    start = remote.roots()
    if branch and remote.items is not None:
        (found,) = await resolve(remote, [branch])
        if isinstance(found, Unknown):
            return [Unknown(pattern, found.status, found.message)]
        start = found.node
    wanted = re.compile(translate(pattern.replace("[", "[[]")), re.IGNORECASE)
    below = await walk(remote, start)
    names = [remote.name(c.NodeId) for _, c in below if c.NodeClass == ua.NodeClass.Variable]
    matching = [name for name in names if wanted.match(name)]
    if not matching:
        return [Unknown(pattern, StatusCodes.BadNoData, f"no item matches {pattern}")]
    return await _unnamed(remote, matching)


async def walk(
    remote: Remote, node: ua.NodeId, depth: int | None = None, *, properties: bool = False, at_most: int | None = None
) -> list[tuple[int, Child]]:
    """What lies below a node, parents first, each with its level from 0. ``depth`` bounds the levels.

    ``properties``: also what belongs to PLCs and items. ``at_most``: look no further after so many nodes.
    """
    below: dict[ua.NodeId, list[Child]] = {}
    seen = {node}
    level = [node]
    while level and (depth is None or depth > 0) and (at_most is None or len(seen) < at_most):
        depth = None if depth is None else depth - 1
        following: list[ua.NodeId] = []
        for parent, children in zip(level, await remote.children(level, properties=properties), strict=True):
            fresh = [child for child in children if child.NodeId not in seen]
            seen.update(child.NodeId for child in fresh)
            below[parent] = fresh
            following += [c.NodeId for c in fresh if properties or c.NodeClass == ua.NodeClass.Object]
        level = following

    def in_order(parent: ua.NodeId, level: int) -> Iterator[tuple[int, Child]]:
        for child in below.get(parent, []):
            yield level, child
            yield from in_order(child.NodeId, level + 1)

    return list(in_order(node, 0))


# ---------------------------------------------------------------------- names that lead nowhere


def _no_name(remote: Remote, name: str) -> str:
    if remote.items is None:
        return (
            f"{name}: this server is not pcaccess; its nodes are named as in ns=2;s=NAME (pcaccess browse lists them)"
        )
    return f"{name} is no NodeId, although it begins like one"


async def _unknown(remote: Remote, name: str, status: int, *, helped: bool) -> Unknown:
    shown = name if len(name) <= LONGEST_SHOWN else f"{name[: LONGEST_SHOWN - 1]}…"
    if status != StatusCodes.BadNodeIdUnknown:
        return Unknown(name, status, f"{shown}: {status_text(status)}")
    if not name.strip():
        return Unknown(name, status, "there is no item without a name")
    near: list[str] = []
    more = ""
    if remote.items is not None and "," in name:
        more = f": {_why_not(name)}"
    elif is_pattern(name):
        more = "; patterns are for read and watch"
    elif remote.items is not None and not helped:
        near = await nearest(remote, name)
    guess = f"; did you mean {either(near)}?" if near else ""
    return Unknown(name, status, f"there is no item {shown}{more}{guess}")


def _why_not(run_time_name: str) -> str:
    try:
        parse_run_time_name(run_time_name)
    except RunTimeNameError as error:
        return str(error)
    return "no PLC here has that station and address, or the project allows no such dynamic item"


async def nearest(remote: Remote, name: str) -> list[str]:
    """Names of our server that an unknown one may have meant, the nearest first."""
    here = remote.roots()
    parts = name.casefold().split(".")
    leaves: dict[str, Child] = {}
    while parts:
        (children,) = await remote.children([here])
        leaves = {str(child.BrowseName.Name).casefold(): child for child in children}
        if parts[0] not in leaves:
            break
        here = leaves[parts.pop(0)].NodeId
    if not parts:
        return []
    close = [leaves[leaf] for leaf in nearest_words(parts[0], leaves, NEAREST)]
    if len(parts) == 1 and close:
        return [remote.name(child.NodeId) for child in close]
    longer = [".".join([remote.name(child.NodeId), *parts[1:]]) for child in close]
    return await _known(remote, longer) or await _anywhere(remote, here, parts[-1])


async def _known(remote: Remote, names: Sequence[str]) -> list[str]:
    """Those of the names that exist, as the server writes them."""
    nodes = [node for name in names if (node := remote.node(name)) is not None]
    answers = await remote.read((node, AttributeIds.NodeId) for node in nodes)
    return [remote.name(node) for answer in answers if (node := content(answer)) is not None]


async def _anywhere(remote: Remote, node: ua.NodeId, last: str) -> list[str]:
    """Nodes below, in any branch, whose own name is or resembles ``last``."""
    leaves: dict[str, list[str]] = {}
    for _, child in await walk(remote, node, at_most=SEARCHED):
        leaves.setdefault(str(child.BrowseName.Name).casefold(), []).append(remote.name(child.NodeId))
    close = nearest_words(last, leaves, NEAREST)
    return [name for leaf in close for name in leaves[leaf]][:NEAREST]
