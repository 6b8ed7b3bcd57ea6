"""A draft as the text of ``items.yaml``: to be read and edited by people, one line an item."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

from pcaccess.project.importers.draft import Draft, DraftItem, DraftPlc
from pcaccess.project.yamlout import mapping, scalar
from pcaccess.s7200.cpu import DEFAULT_CPU


def yaml_of(draft: Draft, name: str) -> str:
    """The whole file; PLCs of one link stand together."""
    lines = [
        f"# Imported from {_one_line(draft.source)}. docs/items-yaml.md has every key; pcaccess check reads the file.",
        "",
        f"project: {scalar(name)}",
        "",
        "links:",
    ]
    links: dict[str, list[DraftPlc]] = {}
    for plc in draft.plcs:
        links.setdefault(plc.link, []).append(plc)
    for link, plcs in links.items():
        lines += [
            f"  - name: {scalar(link)}",
            "    # soft: the gateway is the PLC itself, so that everything can be tried without hardware.",
            "    # docs/coming-from-pc-access.md says what to write for the real one.",
            "    type: soft",
            "    plcs:",
        ]
        for plc in plcs:
            lines += _plc(plc)
    return "\n".join(lines) + "\n"


def _one_line(text: str) -> str:
    return "".join(character if character.isprintable() else "?" for character in text)


def _plc(plc: DraftPlc) -> Iterator[str]:
    yield f"      - name: {scalar(plc.name)}"
    for note in plc.notes:
        yield f"        # {_one_line(note)}"
    if plc.address is not None:
        yield f"        address: {plc.address}"
    yield f"        cpu: {DEFAULT_CPU}    # the model with the most memory; write the one you have"
    yield from _level(plc.items, 0, "        ")


def _level(items: list[DraftItem], depth: int, indent: str) -> Iterator[str]:
    """Items of this folder, then the folders in it, in the order of their first item."""
    own = [item for item in items if len(item.folders) == depth]
    if own:
        yield f"{indent}items:"
        yield from (f"{indent}  - {_item(item)}" for item in own)
    deeper = [item for item in items if len(item.folders) > depth]
    if not deeper:
        return
    yield f"{indent}folders:"
    order = {name: number for number, name in reversed(list(enumerate(item.folders[depth] for item in deeper)))}
    deeper.sort(key=lambda item: order[item.folders[depth]])
    for name, inside in groupby(deeper, key=lambda item: item.folders[depth]):
        yield f"{indent}  - name: {scalar(name)}"
        yield from _level(list(inside), depth + 1, f"{indent}    ")


def _item(item: DraftItem) -> str:
    text = item.text
    pairs: dict[str, str | float | bool] = {"name": text.name, "address": text.address}
    for key in ("type", "access", "high", "low", "unit", "length", "raw_type", "write_limits", "description"):
        value = getattr(text, key)
        if value is not None and value != "":
            pairs[key] = value
    line = mapping(pairs)
    if text.scaling is None:
        return line
    ends = text.scaling
    scaling = f"raw: [{scalar(ends.raw_low)}, {scalar(ends.raw_high)}]"
    scaling += f", scaled: [{scalar(ends.scaled_low)}, {scalar(ends.scaled_high)}]"
    if ends.clamp:
        scaling += ", clamp: true"
    return f"{line[:-1]}, scaling: {{{scaling}}}}}"
