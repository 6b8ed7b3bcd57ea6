"""The raw project to the model: every text becomes what it means, or a problem.

Nothing stops at the first mistake: what is wrong is reported and left out.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Any, Final

from pcaccess.problems import Span, nearest_word
from pcaccess.project import raw
from pcaccess.project.buildplc import PARITIES, PlcBuilder
from pcaccess.project.context import Context, child, children
from pcaccess.project.ids import Ids, why_bad_name
from pcaccess.project.itemtext import find_access
from pcaccess.project.model import (
    SERVED_LINKS,
    Access,
    DynamicItems,
    Group,
    Link,
    LinkType,
    Parity,
    Project,
    SerialLine,
    Server,
)
from pcaccess.project.network import WebClients, check_endpoint, check_listen, check_server_endpoint, check_web
from pcaccess.project.yamltext import Node, Sequence

MAX_HINTS: Final = 20
"""Looking for the nearest of many item IDs takes time; after so many, typing mistakes are not the trouble."""

_WEB_CLIENTS: Final = {clients.value: clients for clients in WebClients}


def build_project(source: raw.RawProject, path: Path, context: Context, declared: Iterable[str] = ()) -> Project:
    """``declared``: IDs of items that stand in the file but were left out as wrong."""
    return _Builder(context).project(source, path, declared)


class _Builder:
    def __init__(self, context: Context) -> None:
        self._context = context
        self._tree = context.tree
        self._findings = context.findings
        self._ids = Ids(context.findings)
        self._plcs = PlcBuilder(context, self._ids)

    def project(self, source: raw.RawProject, path: Path, declared: Iterable[str]) -> Project:
        root = self._tree.root
        links = [self._link(link, node) for link, node in zip(source.links, children(root, "links"), strict=True)]
        for item_id in declared:
            self._ids.declare(item_id)
        return Project(
            name=source.project,
            path=path,
            links=tuple(link for link in links if link),
            groups=self._groups(source.groups, root),
            server=self._server(source.server, child(root, "server")),
            dynamic_items=self._dynamic_items(source.dynamic_items, child(root, "dynamic_items")),
        )

    # -- the server and its groups ------------------------------------------------------------------------------

    def _server(self, source: raw.RawServer, node: Node) -> Server:
        endpoint = self._context.checked(check_server_endpoint, source.endpoint, node, "endpoint", Server().endpoint)
        timeout = self._context.duration(source.read_timeout, node, "read_timeout")
        clients = self._context.word(source.web_clients, _WEB_CLIENTS, node, "web_clients", WebClients.THIS_MACHINE)
        web = self._context.checked(partial(check_web, clients=clients), source.web, node, "web", None)
        return Server(endpoint, timeout, web, "web" in source.model_fields_set, clients)

    def _dynamic_items(self, source: raw.RawDynamicItems, node: Node) -> DynamicItems:
        access = find_access(source.access, self._context.where(node), "access", self._findings)
        return DynamicItems(access or Access.RW, source.max, self._context.duration(source.idle, node, "idle"))

    def _groups(self, sources: list[raw.RawGroup], root: Node) -> tuple[Group, ...]:
        seen: dict[str, Span] = {}
        groups = []
        for source, node in zip(sources, children(root, "groups"), strict=True):
            span = self._tree.value_span(node, "name")
            if why := why_bad_name(source.name):
                self._findings.report("PRJ014", span, why)
            first = seen.setdefault(source.name.casefold(), span)
            if first is not span:
                message = f"there are two groups {source.name}; case makes no difference"
                self._findings.report("PRJ015", span, message, related=((first, "first used here"),))
            rate = self._context.duration(source.update_rate, node, "update_rate")
            members = self._members(source.items, child(node, "items"))
            groups.append(Group(source.name, rate, source.active, source.dead_band, members, span, source.description))
        return tuple(groups)

    def _members(self, ids: list[str], node: Node) -> tuple[str, ...]:
        members = []
        hints = 0
        for item_id, member in zip(ids, node.children if isinstance(node, Sequence) else (), strict=True):
            found = self._ids.written.get(item_id.casefold())
            if found is not None:
                members.append(found)
                continue
            hints += 1
            nearest = nearest_word(item_id, self._ids.written.values()) if hints <= MAX_HINTS else None
            message = f"there is no item {item_id}"
            self._findings.report(
                "PRJ029", self._tree.span(member), message, expected="an item ID of this project", nearest=nearest
            )
        return tuple(members)

    # -- links and PLCs -----------------------------------------------------------------------------------------

    def _link(self, source: Any, node: Node) -> Link | None:
        span = self._tree.value_span(node, "name")
        kind = LinkType(source.type)
        name = self._ids.take(source.name, "", span)
        plcs = self._plcs.build(source, kind, node)
        serial, endpoint = None, ""
        if isinstance(source, raw.PpiLink):
            serial = SerialLine(self._serial_port(source.port, node), source.baud, Parity.EVEN)
        elif isinstance(source, raw.ModbusRtuLink | raw.ModbusAsciiLink):
            parity = self._context.word(source.parity, PARITIES, node, "parity", Parity.EVEN)
            serial = SerialLine(self._serial_port(source.port, node), source.baud, parity)
        elif isinstance(source, raw.OpcUaLink):
            endpoint = source.endpoint
            self._context.checked(check_endpoint, endpoint, node, "endpoint", "")
        if kind not in SERVED_LINKS:
            count = sum(1 for plc in plcs for _ in plc.all_items())
            if count:
                self._context.report(
                    "PRJ032",
                    node,
                    "type",
                    f"this version checks {kind.value} links but does not run them; "
                    f"{count} item{'s stay' if count > 1 else ' stays'} NOT_CONNECTED",
                )
        if name is None:
            return None
        master = source.master if isinstance(source, raw.PpiLink) else 0
        return Link(name, kind, plcs, span, source.description, serial, master, endpoint)

    def _serial_port(self, text: str, node: Node) -> str:
        return self._context.checked(lambda port: check_listen(port, serial=True), text, node, "port", "")
