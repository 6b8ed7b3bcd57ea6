"""Names and the item IDs made of them: what a name may contain, and that no ID stands for two things.

Source:   design: an item ID is ``Link.PLC.Folder.Item``, a run-time name ``Link:2:...,VW0,INT``, and everything
          that is no item hangs under ``ID/...``; so a name can hold none of these separators.
"""

from __future__ import annotations

import re
from typing import Final

from pcaccess.problems import Span
from pcaccess.project.problems import Findings

MAX_NAME: Final = 255
RESERVED_LINK: Final = "groups"
"""``Groups/Fast`` are the project's groups in the server's own namespace."""
_FORBIDDEN: Final = re.compile(r"[.,:/\x00-\x1f\x7f]")
_WHY: Final = {
    ".": "'.' separates link, PLC, folder and item in an item ID",
    ",": "',' separates the parts of a run-time name",
    ":": "':' separates link, station and IP address in a run-time name",
    "/": "'/' leads to what belongs to an item, such as its Quality",
}


def why_bad_name(name: str) -> str | None:
    """Why an item ID cannot hold the name; None when it can."""
    if not name.strip():
        return "the name is empty"
    if name != name.strip():
        return f"the name {name!r} begins or ends with a blank"
    if len(name) > MAX_NAME:
        return f"the name has {len(name)} characters; {MAX_NAME} are possible"
    match = _FORBIDDEN.search(name)
    return f"the name {name!r}: {_WHY.get(match[0], 'control characters cannot be typed')}" if match else None


class Ids:
    """Every link, PLC, folder and item of a project, in any case."""

    def __init__(self, findings: Findings) -> None:
        self._findings = findings
        self._spans: dict[str, Span] = {}
        self.written: dict[str, str] = {}
        """Casefolded to written, of items."""

    def take(self, name: str, parent: str, span: Span, *, is_item: bool = False) -> str | None:
        """The ID of the new thing; None, and a report, when its name is bad or its ID is taken."""
        why = why_bad_name(name)
        if why is None and not parent and name.casefold() == RESERVED_LINK:
            why = "a link cannot be called Groups, which is where the server keeps the groups"
        if why:
            self._findings.report("PRJ014", span, why)
            return None
        item_id = f"{parent}.{name}" if parent else name
        key = item_id.casefold()
        first = self._spans.setdefault(key, span)
        if first is not span:
            self._findings.report(
                "PRJ015",
                span,
                f"there are two of {item_id}; case makes no difference",
                related=((first, "first used here"),),
            )
            return None
        if is_item:
            self.written[key] = item_id
        return item_id

    def declare(self, item_id: str) -> None:
        """An item that stands in the file but was wrong: groups may name it."""
        self.written.setdefault(item_id.casefold(), item_id)
