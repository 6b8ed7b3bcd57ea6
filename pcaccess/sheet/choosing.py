"""Which items a workbook gets: those of a group, those that names and patterns stand for, or all of a small project."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fnmatch import translate
from typing import Final

from pcaccess.problems import nearest_word
from pcaccess.sheet.entries import Chosen, Entry, SheetError
from pcaccess.sheet.sources import Source

MAX_UNASKED: Final = 100
"""So many items a workbook gets when nobody chooses; more would bury what somebody looks for."""
_LOOKED_AT: Final = 2000


def choose(source: Source, group: str | None, names: Sequence[str]) -> Chosen:
    """The items of ``group`` and of ``names``, each once. Raises SheetError that names everything that is not there.

    Without both: the first group of the project, or all its items when there is no group.
    """
    entries = source.entries()
    if group is None and not names:
        groups = source.groups()
        if groups:
            group = groups[0].name
        elif len(entries) > MAX_UNASKED:
            raise SheetError(
                f"the project has {len(entries):,} items and no group; say which ones with --items PATTERN, or --pick"
            )
        else:
            names = ["*"]
    by_id = {entry.item_id.casefold(): entry for entry in entries}
    found: dict[str, Entry] = {}
    wrong: list[str] = []
    if group is not None:
        found |= _of_group(source, group, by_id, wrong)
    for name in names:
        some = _matching(name, entries, by_id) or _dynamic(source, name)
        if not some:
            wrong.append(_unknown(name, entries))
        found |= {entry.item_id: entry for entry in some}
    if wrong:
        raise SheetError("\n".join(wrong))
    if not found:
        raise SheetError("there are no items to show")
    return Chosen(list(found.values()), group if group is not None and not names else None)


def _of_group(source: Source, name: str, by_id: dict[str, Entry], wrong: list[str]) -> dict[str, Entry]:
    groups = source.groups()
    for group in groups:
        if group.name.casefold() == name.casefold():
            members = [(item, by_id.get(item.casefold()) or source.dynamic(item)) for item in group.items]
            return {entry.item_id: entry for _, entry in members if entry is not None}
    known = ", ".join(group.name for group in groups)
    wrong.append(f"there is no group {name}; {f'there are {known}' if known else 'the project has none'}")
    return {}


def _matching(name: str, entries: Sequence[Entry], by_id: dict[str, Entry]) -> list[Entry]:
    """One item, all below a link, PLC or folder, or those that a pattern fits."""
    folded = name.casefold()
    if folded in by_id:
        return [by_id[folded]]
    if "*" in name or "?" in name:
        pattern = re.compile(translate(folded.replace("[", "[[]")))
        return [entry for entry in entries if pattern.match(entry.item_id.casefold())]
    return [entry for entry in entries if entry.item_id.casefold().startswith(f"{folded}.")]


def _dynamic(source: Source, name: str) -> list[Entry]:
    entry = source.dynamic(name) if "," in name else None
    return [] if entry is None else [entry]


def _unknown(name: str, entries: Sequence[Entry]) -> str:
    if "*" in name or "?" in name:
        return f"no item fits {name}"
    if "," in name:
        return f"{name} is no item of the project; a run-time name needs --url of a gateway that runs"
    near = nearest_word(name, [entry.item_id for entry in entries[:_LOOKED_AT]])
    return f"there is no item {name}" + (f"; did you mean {near}?" if near else "")
