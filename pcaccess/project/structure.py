"""Nodes to the raw project: unknown keys, missing keys, values of the wrong kind.

What is wrong is reported, taken out and the rest looked at again, so that one mistake does not hide another:
an item with a misspelt key is checked without it, one without an address is left out.

Errors:   collected as problems; the result is None where nothing is left to go on with.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final, get_args

from annotated_types import Ge, Le
from pydantic import BaseModel, ValidationError

from pcaccess.problems import nearest_word
from pcaccess.project.problems import Findings
from pcaccess.project.raw import LINK_MODELS, RawProject
from pcaccess.project.yamltext import Mapping, Node, Scalar, Sequence, Tree, plain

ROUNDS: Final = 20
"""Each round finds what the one before hid; three are usual."""

_KINDS: Final = {
    "string_type": "a text",
    "int_parsing": "a whole number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_parsing": "a number such as 12.5",
    "float_type": "a number such as 12.5",
    "finite_number": "a number such as 12.5",
    "bool_parsing": "true or false",
    "bool_type": "true or false",
    "list_type": "a list",
    "model_type": "keys with values",
    "model_attributes_type": "keys with values",
}


Step = tuple[Node, Any]
"""A node and the key or index that leads on from it."""


@dataclass(frozen=True, slots=True)
class Structure:
    project: RawProject
    """Without the parts that were wrong; those are taken out of the tree too, so that indices agree."""
    taken_out: frozenset[tuple[int, Any]]
    """(id of node, key) of them."""


def read_structure(tree: Tree, findings: Findings) -> Structure | None:
    """The raw project; None when nothing is left to look at."""
    reported: set[tuple[int, Any]] = set()
    for _ in range(ROUNDS):
        try:
            return Structure(RawProject.model_validate(plain(tree.root)), frozenset(reported))
        except ValidationError as error:
            faults = [(_walk(tree.root, fault["loc"]), fault) for fault in error.errors(include_url=False)]
        mended = _mend(faults)
        gone: list[tuple[Sequence, Node]] = []
        for steps, fault in faults:
            place = (id(steps[-1][0]), steps[-1][1]) if steps else (0, None)
            if fault["type"] == "missing" and place in mended:
                continue
            if place not in reported:
                _report(tree, steps, fault, findings)
        for steps, fault in faults:
            missing = fault["type"] == "missing"
            if missing and (id(steps[-1][0]), steps[-1][1]) in mended:
                continue
            if not _take_out(steps, missing, reported, gone):
                return None
        for owner, node in gone:
            owner.children[:] = [child for child in owner.children if child is not node]
    return None


def _mend(faults: list[tuple[list[Step], Any]]) -> set[tuple[int, Any]]:
    """Take a misspelt key as the one it is nearest to, if that is free; the (node, key) so filled.

    So ``adress: VX`` is one report about the key and one about the address, and none about a missing address.
    """
    filled: set[tuple[int, Any]] = set()
    for steps, fault in faults:
        if fault["type"] != "extra_forbidden":
            continue
        owner, key = steps[-1]
        near = _nearest_key(key, list(_model_at(fault["loc"][:-1]).model_fields))
        if isinstance(owner, Mapping) and near is not None and near not in owner.pairs:
            owner.pairs[near] = owner.pairs[key]
            filled.add((id(owner), near))
    return filled


def _take_out(
    steps: list[Step], missing: bool, reported: set[tuple[int, Any]], gone: list[tuple[Sequence, Node]]
) -> bool:
    """Remove a wrong value, or of a missing one the list element that needs it; False when the file is the cause."""
    if missing:
        steps = steps[:-1]
        while steps and isinstance(steps[-1][0], Mapping):
            steps = steps[:-1]
    elif len(steps) > 1 and isinstance(steps[-2][0], Mapping) and _is_plain_list(steps[-1][0]):
        steps = steps[:-1]  # two numbers of which one is none are not one number
    if not steps:
        return False
    owner, key = steps[-1]
    if isinstance(owner, Mapping):
        owner.pairs.pop(key, None)
        reported.add((id(owner), key))
    elif isinstance(owner, Sequence):
        gone.append((owner, owner.children[key]))
    return True


def _is_plain_list(node: Node) -> bool:
    """Such as ``[0, 32000]``."""
    return isinstance(node, Sequence) and all(isinstance(child, Scalar) for child in node.children)


def _walk(root: Node, loc: tuple[int | str, ...]) -> list[Step]:
    """(node, key or index) from the root to the place; pydantic's union tags are not steps."""
    steps: list[Step] = []
    node: Node | None = root
    for part in loc:
        if isinstance(node, Mapping) and isinstance(part, str):
            if part in LINK_MODELS and part not in node.pairs:
                continue
            steps.append((node, part))
            node = node.get(part)
        elif isinstance(node, Sequence) and isinstance(part, int):
            steps.append((node, part))
            node = node.children[part]
    return steps


def _report(tree: Tree, steps: list[Step], fault: Any, findings: Findings) -> None:
    kind = fault["type"]
    if not steps:
        span = tree.span(tree.root)
        findings.report("PRJ010", span, "a project file consists of keys", expected="'project:', 'links:' and so on")
        return
    owner, key = steps[-1]
    if kind.startswith("union_tag"):
        _report_link_type(tree, _step(owner, key), findings)
    elif kind == "extra_forbidden":
        _report_unknown_key(tree, steps, fault["loc"], findings)
    elif kind == "missing":
        findings.report("PRJ009", tree.span(owner), f"the key {key!r} is missing")
    else:
        _report_value(tree, owner, key, fault, findings)


def _step(owner: Any, key: Any) -> Node:
    node: Node = owner.pairs[key][1] if isinstance(owner, Mapping) else owner.children[key]
    return node


def _report_value(tree: Tree, owner: Any, key: Any, fault: Any, findings: Findings) -> None:
    kind = fault["type"]
    if isinstance(owner, Mapping):
        node, span, name = owner.get(key), tree.value_span(owner, key), f"{key}: "
    else:
        node, name = owner.children[key], ""
        span = tree.span(node)
    shown = repr(node.text) if isinstance(node, Scalar) and node.text is not None else _kind_of(node)
    if kind in ("greater_than_equal", "less_than_equal"):
        findings.report("PRJ012", span, f"{name}{shown} is out of range", expected=_range_of(fault["loc"]))
    elif kind in ("too_short", "too_long"):
        count = fault["ctx"]["actual_length"]
        findings.report("PRJ010", span, f"{name}{count} numbers", expected="two, as in [0, 10]")
    else:
        findings.report("PRJ010", span, f"{name}{shown}", expected=_KINDS.get(kind, fault["msg"]))


def _kind_of(node: Node | None) -> str:
    if isinstance(node, Mapping):
        return "keys with values"
    return "a list" if isinstance(node, Sequence) else "nothing"


def _range_of(loc: tuple[int | str, ...]) -> str:
    """Both ends, though pydantic names only the one that was passed."""
    metadata = _model_at(loc[:-1]).model_fields[str(loc[-1])].metadata
    low = next(m.ge for m in metadata if isinstance(m, Ge))
    high = next(m.le for m in metadata if isinstance(m, Le))
    return f"{low} to {high}"


def _report_link_type(tree: Tree, link: Node, findings: Findings) -> None:
    expected = f"one of {', '.join(LINK_MODELS)}"
    written = link.get("type") if isinstance(link, Mapping) else None
    if isinstance(written, Scalar) and written.text:
        findings.report(
            "PRJ011",
            tree.span(written),
            f"there is no link type {written.text!r}",
            expected=expected,
            nearest=nearest_word(written.text, LINK_MODELS),
        )
    else:
        findings.report("PRJ009", tree.span(link), "the key 'type' is missing", expected=expected)


def _report_unknown_key(tree: Tree, steps: list[Step], loc: tuple[int | str, ...], findings: Findings) -> None:
    owner, key = steps[-1]
    known = list(_model_at(loc[:-1]).model_fields)
    elsewhere = [name for name in LINK_MODELS if key in _keys_on(name, loc)]
    message = f"unknown key {key!r}"
    if elsewhere:
        message += f" here; it belongs to a link of type {' or '.join(elsewhere)}"
    findings.report(
        "PRJ008",
        tree.key_span(owner, key),
        message,
        expected=f"one of {', '.join(known)}",
        nearest=None if elsewhere else _nearest_key(key, known),
    )


_OTHER_WORDS: Final = MappingProxyType(
    {
        "min": "low",
        "minimum": "low",
        "max": "high",
        "maximum": "high",
        "comment": "description",
        "remark": "description",
        "data_type": "type",
        "datatype": "type",
        "register": "address",
        "tag": "name",
        "id": "name",
        "rights": "access",
        "eu": "unit",
        "scale": "scaling",
        "ip": "host",
        "hostname": "host",
        "station": "address",
        "model": "cpu",
        "interval": "update_rate",
        "rate": "update_rate",
        "tags": "items",
        "devices": "plcs",
        "channels": "links",
        "connections": "links",
    }
)
"""What other systems call a key."""


def _nearest_key(key: str, known: Collection[str]) -> str | None:
    meant = _OTHER_WORDS.get(key.lower())
    return meant if meant in known else nearest_word(key, known)


def _keys_on(link_type: str, loc: tuple[int | str, ...]) -> set[str]:
    """Keys that the same place has on a link of that type; ``loc`` is links, index, type, ..., key."""
    if len(loc) < 4 or loc[0] != "links":
        return set()
    try:
        return set(_model_at((*loc[:2], link_type, *loc[3:-1])).model_fields)
    except KeyError:
        return set()


def _model_at(loc: tuple[int | str, ...]) -> type[BaseModel]:
    """The raw model whose keys stand at ``loc``."""
    model: type[BaseModel] = RawProject
    for part in loc:
        if isinstance(part, int):
            continue
        if part in LINK_MODELS and model is RawProject:
            model = LINK_MODELS[part]
        elif model is RawProject and part == "links":
            continue
        else:
            model = _model_in(model.model_fields[part].annotation)
    return model


def _model_in(annotation: Any) -> type[BaseModel]:
    """``S7Item`` of ``list[S7Item]`` and the like."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for part in get_args(annotation):
        try:
            return _model_in(part)
        except KeyError:
            continue
    raise KeyError(annotation)
