"""Where items come from: a project file, or a gateway that runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Protocol

from pcaccess.project.model import Access, Project
from pcaccess.project.network import DEFAULT_WEB
from pcaccess.s7200.types import DataType
from pcaccess.sheet.client import GatewayClient, Refused
from pcaccess.sheet.entries import Entry, GroupEntry, SheetError
from pcaccess.sheet.links import gateway_url, item_path

TITLE: Final = "PLC values"
"""Of a workbook, where the project has no name."""
_PAGE: Final = 1000


class Source(Protocol):
    """What can be chosen from."""

    @property
    def title(self) -> str: ...

    @property
    def gateway(self) -> str:
        """``http://127.0.0.1:8080``."""

    def entries(self) -> Sequence[Entry]:
        """All items in the project's order."""

    def groups(self) -> Sequence[GroupEntry]: ...

    def dynamic(self, name: str) -> Entry | None:
        """An item that a run-time name makes; None when there is none, or nobody to ask."""


class ProjectSource:
    """A project that was loaded; the gateway need not run."""

    def __init__(self, project: Project, gateway: str | None = None) -> None:
        """``gateway`` stands instead of the project's ``server: web:``."""
        if gateway is None and project.server.web is None:
            raise SheetError("the project has no web server (server: web: off), which spreadsheets need")
        self._project = project
        self._gateway = gateway or gateway_url(project.server.web or DEFAULT_WEB)

    @property
    def title(self) -> str:
        return self._project.name or TITLE

    @property
    def gateway(self) -> str:
        return self._gateway

    def entries(self) -> Sequence[Entry]:
        return [
            Entry(
                item.item_id,
                item.data_type,
                item.count,
                bool(item.access & Access.R),
                bool(item.access & Access.W),
                item.low,
                item.high,
                item.unit,
                item.description,
            )
            for item in self._project.all_items()
        ]

    def groups(self) -> Sequence[GroupEntry]:
        return [GroupEntry(group.name, group.items) for group in self._project.groups]

    def dynamic(self, name: str) -> Entry | None:
        return None


@dataclass(slots=True)
class GatewaySource:
    """A gateway that answers; raises SheetError when it does not."""

    client: GatewayClient
    _entries: list[Entry] = field(default_factory=list)

    @property
    def title(self) -> str:
        return TITLE

    @property
    def gateway(self) -> str:
        return self.client.url

    def entries(self) -> Sequence[Entry]:
        total = None if not self._entries else len(self._entries)
        while total is None or len(self._entries) < total:
            page = self.client.get(f"/api/items?samples=0&limit={_PAGE}&offset={len(self._entries)}")
            if not page["items"]:
                break
            self._entries += map(_entry, page["items"])
            total = page["total"]
        return self._entries

    def groups(self) -> Sequence[GroupEntry]:
        return [GroupEntry(group["name"], tuple(group["items"])) for group in self.client.get("/api/groups")["groups"]]

    def dynamic(self, name: str) -> Entry | None:
        try:
            return _entry(self.client.get(item_path(name)))
        except Refused as refused:
            if refused.status == 404:
                return None
            raise


def _entry(item: dict[str, Any]) -> Entry:
    return Entry(
        item["id"],
        DataType[item["type"]],
        item["count"],
        "R" in item["access"],
        "W" in item["access"],
        item["low"],
        item["high"],
        item["unit"],
        item["description"],
    )
