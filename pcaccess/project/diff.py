"""What changed between two projects, for taking over a saved file while everything else goes on.

Where a thing stands in its file takes no part: moving lines about changes nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from pcaccess.project.model import Group, Item, Link, Plc, Project

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Delta(Generic[T]):
    """Of one kind of thing."""

    added: tuple[T, ...] = ()
    removed: tuple[T, ...] = ()
    changed: tuple[tuple[T, T], ...] = ()
    """(old, new) of things that kept their name, in any case."""

    def __bool__(self) -> bool:
        return bool(self.added or self.removed or self.changed)


@dataclass(frozen=True, slots=True)
class Changes:
    """Links are compared without their PLCs, PLCs without their folders and items: each change stands once."""

    items: Delta[Item]
    plcs: Delta[Plc]
    links: Delta[Link]
    groups: Delta[Group]
    server: bool
    """Endpoint, time-outs or the rules for dynamic items."""
    folders: bool
    """Folders came, went, or got another description."""
    programs: int = 0
    """PLCs whose program reads differently now; who has read the programs counts them."""

    def __bool__(self) -> bool:
        return bool(
            self.items or self.plcs or self.links or self.groups or self.server or self.folders or self.programs
        )

    def __str__(self) -> str:
        """``2 items added, 1 changed; 1 group removed``, for the log."""
        parts = []
        for word, delta in (("item", self.items), ("PLC", self.plcs), ("link", self.links), ("group", self.groups)):
            counts = ((len(delta.added), "added"), (len(delta.changed), "changed"), (len(delta.removed), "removed"))
            told = [f"{count} {verb}" for count, verb in counts if count]
            if told:
                first, *others = told
                number, verb = first.split(" ")
                parts.append(", ".join([f"{number} {word}{'s' if number != '1' else ''} {verb}", *others]))
        if self.programs:
            parts.append(f"{self.programs} program{'s' if self.programs != 1 else ''} changed")
        if self.server:
            parts.append("server settings changed")
        return "; ".join(parts) if parts else ("folders changed" if self.folders else "nothing changed")


def compare(old: Project, new: Project) -> Changes:
    """Everything that is different in ``new``."""
    return Changes(
        items=_delta(_by_id(old.all_items()), _by_id(new.all_items())),
        plcs=_delta(_plcs(old), _plcs(new)),
        links=_delta(_links(old), _links(new)),
        groups=_delta(_groups(old), _groups(new)),
        server=(old.name, old.server, old.dynamic_items) != (new.name, new.server, new.dynamic_items),
        folders=_folders(old) != _folders(new),
    )


def _delta(old: dict[str, T], new: dict[str, T]) -> Delta[T]:
    return Delta(
        added=tuple(thing for key, thing in new.items() if key not in old),
        removed=tuple(thing for key, thing in old.items() if key not in new),
        changed=tuple((old[key], thing) for key, thing in new.items() if key in old and old[key] != thing),
    )


def _by_id(items: Iterable[Item]) -> dict[str, Item]:
    return {item.item_id.casefold(): item for item in items}


def _plcs(project: Project) -> dict[str, Plc]:
    return {plc.item_id.casefold(): replace(plc, folders=(), items=()) for plc in project.all_plcs()}


def _links(project: Project) -> dict[str, Link]:
    return {link.name.casefold(): replace(link, plcs=()) for link in project.links}


def _groups(project: Project) -> dict[str, Group]:
    return {group.name.casefold(): group for group in project.groups}


def _folders(project: Project) -> set[tuple[str, str]]:
    """(ID, description) of every folder."""
    found = set()
    waiting = [(plc.item_id, folder) for plc in project.all_plcs() for folder in plc.folders]
    while waiting:
        parent, folder = waiting.pop()
        path = f"{parent}.{folder.name}"
        found.add((path, folder.description))
        waiting += [(path, inner) for inner in folder.folders]
    return found
