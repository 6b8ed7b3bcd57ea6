"""Addresses below the gateway's that spreadsheets fetch.

Source:   docs/rest.md; RFC 3986 for the percent signs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final
from urllib.parse import quote

from pcaccess.sheet.entries import Chosen, SheetError

MAX_QUERY: Final = 60_000
"""Characters; the gateway takes a head of 64 KB."""


def gateway_url(web: str) -> str:
    """Where a program of this machine finds a gateway that serves at ``web`` (``host:port`` of the project file)."""
    host, _, port = web.rpartition(":")
    return f"http://{'127.0.0.1' if host == '0.0.0.0' else host}:{port}"


def item_path(item_id: str, what: str = "") -> str:
    """``/api/items/ID`` or ``/api/items/ID/value``."""
    return f"/api/items/{quote(item_id, safe='')}{what and '/' + what}"


def source_path(chosen: Chosen) -> str:
    """The CSV of all readable items; of the group, when the items are just those."""
    if chosen.group is not None:
        return f"/api/groups/{quote(chosen.group, safe='')}.csv"
    return items_path([entry.item_id for entry in chosen.readable])


def items_path(item_ids: Sequence[str]) -> str:
    """The CSV of these items. Raises SheetError when they are too many for one address."""
    path = "/api/items.csv?" + "&".join(f"id={quote(item_id, safe='')}" for item_id in item_ids)
    if len(path) > MAX_QUERY:
        raise SheetError(
            f"{len(item_ids)} items are too many for one address; make a group of them in the project file and use "
            "--group"
        )
    return path
