"""What every importer makes: links, PLCs and items as texts, cleaned until a project file can hold them.

Other programs allow what item IDs cannot hold, and their files have gaps. Here names are mended, doubles get
a number, and what no S7-200 has is left out; each time the user is told.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import Final

from pcaccess.problems import Problem, Severity, Span
from pcaccess.project.ids import MAX_NAME, RESERVED_LINK, why_bad_name
from pcaccess.project.itemtext import ItemMaker, ItemText
from pcaccess.project.model import LinkType, WriteLimits
from pcaccess.project.problems import PROJECT, Findings
from pcaccess.s7200.cpu import DEFAULT_CPU, cpu_model

_FORBIDDEN: Final = re.compile(r"[.,:/\x00-\x1f\x7f]")


@dataclass(slots=True)
class DraftItem:
    folders: tuple[str, ...]
    text: ItemText
    span: Span
    where: str = ""
    """In words, where a line says nothing: ``Microwin.Project1.USER1.Ut``."""


@dataclass(slots=True)
class DraftPlc:
    link: str
    name: str
    address: int | None = None
    items: list[DraftItem] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    """Lines for a comment."""


@dataclass(slots=True)
class Draft:
    """What an importer found."""

    name: str
    source: str
    """In words, for the comment at the top."""
    plcs: list[DraftPlc] = field(default_factory=list)
    warnings: list[Problem] = field(default_factory=list)
    left_out: int = 0
    """Items of the source that could not be taken."""

    def leave_out(self, code: str, span: Span, message: str, where: str = "") -> None:
        self.left_out += 1
        self.warn(code, span, f"{message}; left out", where)

    def warn(self, code: str, span: Span, message: str, where: str = "") -> None:
        problem = PROJECT.problem(code, span, message, where=where)
        self.warnings.append(replace(problem, severity=Severity.WARNING))


def clean(draft: Draft) -> None:
    """Make the draft fit for a project file."""
    taken: set[str] = set()
    links: dict[str, str] = {}
    for plc in draft.plcs:
        known = links.get(plc.link.casefold())
        if known is None:
            known = links[plc.link.casefold()] = _mended(plc.link, "", taken, draft, Span(draft.name, 1, 1))
        plc.link = known
        plc.name = _mended(plc.name, plc.link, taken, draft, Span(draft.name, 1, 1))
        _clean_items(plc, taken, draft)
    _clean_addresses(draft)


def _clean_items(plc: DraftPlc, taken: set[str], draft: Draft) -> None:
    folders: dict[tuple[str, str], str] = {}
    kept = []
    for item in plc.items:
        if not _usable(item, draft):
            continue
        parent = f"{plc.link}.{plc.name}"
        path = []
        for name in item.folders:
            key = (parent.casefold(), name.casefold())
            if key not in folders:
                folders[key] = _mended(name, parent, taken, draft, item.span, item.where)
            path.append(folders[key])
            parent = f"{parent}.{folders[key]}"
        item.folders = tuple(path)
        item.text.name = _mended(item.text.name, parent, taken, draft, item.span, item.where)
        kept.append(item)
    plc.items = kept


def _mended(name: str, parent: str, taken: set[str], draft: Draft, span: Span, where: str = "") -> str:
    """The name, or one like it that an item ID can hold and that is still free."""
    plain = _FORBIDDEN.sub("_", name).strip()[: MAX_NAME - 4] or "unnamed"
    if why_bad_name(name) is None:
        plain = name
    if not parent and plain.casefold() == RESERVED_LINK:
        plain += "_"
    free, count = plain, 1
    while f"{parent}.{free}".casefold() in taken:
        count += 1
        free = f"{plain}_{count}"
    taken.add(f"{parent}.{free}".casefold())
    if free != name:
        why = why_bad_name(name) or f"there are two of {name}"
        draft.warn("PRJ014" if why_bad_name(name) else "PRJ015", span, f"{why}; it is called {free} now", where)
    return free


def _usable(item: DraftItem, draft: Draft) -> bool:
    """Whether a PLC of the largest model can have it.

    Type and access are written down even where they are the usual ones, limits the wrong way round are put right.
    """
    text = item.text
    if text.low is not None and text.high is not None and text.low > text.high:
        text.low, text.high = text.high, text.low
    if text.low == text.high:
        text.low = text.high = None
    findings = Findings()
    cpu = cpu_model(DEFAULT_CPU)
    maker = ItemMaker(LinkType.SOFT, "", cpu, WriteLimits.NONE, findings, runs_program=True)
    made = maker.make(text, "", lambda _: item.span)
    if made is None:
        errors = [problem for problem in findings.problems if problem.is_error]
        said = "; ".join(problem.message for problem in errors)
        draft.leave_out(errors[0].code, item.span, said if item.where else f"{text.name}: {said}", item.where)
        return False
    text.type, text.access = made.data_type.name, str(made.access)
    return True


def _clean_addresses(draft: Draft) -> None:
    """Two PLCs of a link cannot have one address; the second then gets the next free one."""
    seen: set[tuple[str, int]] = set()
    for plc in draft.plcs:
        if plc.address is None:
            continue
        if (plc.link, plc.address) in seen:
            span = Span(draft.name, 1, 1)
            draft.warn("PRJ016", span, f"{plc.link}.{plc.name} has address {plc.address}, which is taken; left out")
            plc.address = None
        else:
            seen.add((plc.link, plc.address))
