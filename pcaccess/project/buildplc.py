"""The PLCs of a link, with everything on them."""

from __future__ import annotations

from collections.abc import Container, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from pcaccess.problems import Span
from pcaccess.project import raw
from pcaccess.project.context import Context, children
from pcaccess.project.ids import Ids
from pcaccess.project.itemtext import ItemMaker, ItemText, find_write_limits
from pcaccess.project.model import (
    SERVED_PROTOCOLS,
    Folder,
    Item,
    LinkType,
    Parity,
    Plc,
    Port,
    Protocol,
    Scaling,
    WriteLimits,
)
from pcaccess.project.network import check_host, check_listen, parse_tsap
from pcaccess.project.rawitems import AnyItem, S7Item
from pcaccess.project.tagtable import TagRow, read_tags
from pcaccess.project.yamltext import Node
from pcaccess.s7200.address import Address, AddressError, Area, Width, parse_address
from pcaccess.s7200.cpu import CpuError, CpuModel, cpu_model

DEFAULT_SCAN: Final = 0.010
FIRST_STATION: Final = 2
"""PC Access gives the first PLC of a project address 2."""
PARITIES: Final = {p.value: p for p in Parity}
_PROTOCOLS: Final = {p.value: p for p in Protocol}


class PlcBuilder:
    def __init__(self, context: Context, ids: Ids) -> None:
        self._context = context
        self._tree = context.tree
        self._findings = context.findings
        self._ids = ids

    def build(self, link: Any, kind: LinkType, link_node: Node) -> tuple[Plc, ...]:
        nodes = list(children(link_node, "plcs"))
        taken = {plc.address for plc in link.plcs if plc.address is not None}
        free = (address for address in range(FIRST_STATION, 10**6) if address not in taken)
        places: dict[object, Span] = {}
        plcs = []
        for source, node in zip(link.plcs, nodes, strict=True):
            address = source.address
            if address is None:
                address = FIRST_STATION if kind is LinkType.S7TCP else next(free)
            plc = self._plc(source, node, kind, link.name, address)
            if plc is None:
                continue
            for what, key, place in _places(plc, kind):
                span = self._tree.value_span(node, key)
                first = places.setdefault(place, span)
                if first is not span:
                    self._findings.report(
                        "PRJ016",
                        span,
                        f"two PLCs of {link.name} have {what}",
                        related=((first, "first used here"),),
                    )
            plcs.append(plc)
        return tuple(plcs)

    def _plc(self, source: Any, node: Node, kind: LinkType, link: str, address: int) -> Plc | None:
        span = self._tree.value_span(node, "name")
        item_id = self._ids.take(source.name, link, span)
        cpu = self._cpu(source, node)
        write_limits: WriteLimits | None = None
        if source.write_limits is not None:
            where = self._context.where(node)
            write_limits = find_write_limits(source.write_limits, where, "write_limits", self._findings)
        options: dict[str, Any] = {"write_limits": write_limits or WriteLimits.NONE}
        if isinstance(source, raw.SoftPlc):
            options |= self._soft(source, node)
        elif isinstance(source, raw.S7TcpPlc):
            options |= {
                "host": self._context.checked(check_host, source.host, node, "host", ""),
                "port": source.port,
                "local_tsap": self._context.checked(parse_tsap, source.local_tsap, node, "local_tsap", 0, "PRJ031"),
                "remote_tsap": self._context.checked(parse_tsap, source.remote_tsap, node, "remote_tsap", 0, "PRJ031"),
            }
        elif isinstance(source, raw.ModbusPlc):
            options |= {"unit": source.unit, "hold_start": self._hold_start(source, node, cpu)}
            if isinstance(source, raw.ModbusTcpPlc):
                options |= {
                    "host": self._context.checked(check_host, source.host, node, "host", ""),
                    "port": source.port,
                }
        plc = Plc(source.name, link, address, cpu, span, source.description, source.connected, **options)
        maker = ItemMaker(
            kind, plc.station, cpu, plc.write_limits, self._findings, runs_program=plc.program is not None
        )
        content = self._content(source, node, maker, item_id)
        if item_id is None:
            return None
        items_from = self._items_from(source, node, maker, content, item_id)
        folders, items = content.freeze()
        plc = replace(plc, folders=folders, items=items, items_from=items_from)
        if not plc.connected and (count := sum(1 for _ in plc.all_items())):
            its_items = f"{count} items are" if count > 1 else "item is"
            message = f"{plc.item_id} is not connected, so its {its_items} NOT_CONNECTED"
            self._findings.report("PRJ033", self._tree.value_span(node, "connected"), message)
        return plc

    def _cpu(self, source: Any, node: Node) -> CpuModel:
        if not isinstance(source, raw.S7Plc):
            return cpu_model()
        try:
            return cpu_model(source.cpu, source.generation)
        except CpuError as error:
            key = "cpu" if "generation" not in str(error) else "generation"
            self._context.report("PRJ020", node, key, str(error))
            return cpu_model()

    def _soft(self, source: raw.SoftPlc, node: Node) -> dict[str, Any]:
        options: dict[str, Any] = {"scan": DEFAULT_SCAN, "process": source.process}
        if source.program is not None:
            options["program"] = self._context.file(source.program, node, "program")
        for key in ("scan", "process"):
            if getattr(source, key) is not None and source.program is None:
                self._context.report("PRJ025", node, key, "only a PLC with a program has it; this one is memory only")
        if source.scan is not None:
            free = source.scan.strip().lower() == "free"
            options["scan"] = None if free else self._context.duration(source.scan, node, "scan")
        ports = zip(source.ports, children(node, "ports"), strict=True)
        options["ports"] = tuple(self._port(port, port_node) for port, port_node in ports)
        return options

    def _port(self, source: raw.RawPort, node: Node) -> Port:
        span = self._tree.value_span(node, "protocol")
        before = self._findings.errors
        protocol = self._context.word(source.protocol, _PROTOCOLS, node, "protocol", Protocol.PPI)
        parity = self._context.word(source.parity, PARITIES, node, "parity", Parity.EVEN)
        serial = protocol not in (Protocol.S7, Protocol.MODBUS_TCP)
        self._context.checked(lambda text: check_listen(text, serial=serial), source.listen, node, "listen", "")
        if protocol not in SERVED_PROTOCOLS and self._findings.errors == before:
            self._findings.report("PRJ032", span, f"this version does not listen for {protocol.value}")
        return Port(protocol, source.listen, source.baud, parity, source.unit, span)

    def _hold_start(self, source: raw.ModbusPlc, node: Node, cpu: CpuModel) -> Address | None:
        if source.hold_start is None:
            return None
        try:
            address = parse_address(source.hold_start)
            cpu.check(address)
        except AddressError as error:
            self._context.report("PRJ017", node, "hold_start", str(error), expected="a V byte such as VB0")
            return None
        if address.area is not Area.V or address.width is not Width.BYTE or address.count != 1:
            self._context.report(
                "PRJ017", node, "hold_start", f"{address} is not a V byte", expected="a V byte such as VB0"
            )
        return address

    # -- folders and items --------------------------------------------------------------------------------------

    def _content(self, source: Any, node: Node, maker: ItemMaker, parent: str | None) -> FolderDraft:
        """What a PLC or folder holds; ``parent`` None: its own name is wrong, so nothing in it gets an ID."""
        draft = FolderDraft(source.name, source.description)
        for item, item_node in zip(source.items, children(node, "items"), strict=True):
            span = self._tree.value_span(item_node, "name")
            item_id = self._ids.take(item.name, parent, span, is_item=True) if parent is not None else ""
            made = self._item(item, item_node, maker, item_id or "")
            if made is not None and item_id:
                draft.items.append(made)
        for folder, folder_node in zip(source.folders, children(node, "folders"), strict=True):
            span = self._tree.value_span(folder_node, "name")
            folder_id = self._ids.take(folder.name, parent, span) if parent is not None else None
            inner = self._content(folder, folder_node, maker, folder_id)
            if folder_id is not None:
                draft.folders[folder.name.casefold()] = inner
        return draft

    def _item(self, source: AnyItem, node: Node, maker: ItemMaker, item_id: str) -> Item | None:
        text = ItemText(
            source.name,
            source.address,  # type: ignore[attr-defined]  # every kind of item has one
            source.type,
            source.access,
            source.high,
            source.low,
            source.unit,
            source.description,
            source.write_limits,
        )
        if isinstance(source, S7Item):
            text.length, text.raw_type = source.length, source.raw_type
            if source.scaling:
                line = source.scaling
                text.scaling = Scaling(line.raw[0], line.raw[1], line.scaled[0], line.scaled[1], line.clamp)
        return maker.make(text, item_id, self._context.where(node), self._broken(node))

    def _broken(self, node: Node) -> Container[str]:
        if not self._context.taken_out:
            return ()
        return [key for key in ("scaling", "high", "low") if (id(node), key) in self._context.taken_out]

    def _items_from(self, source: Any, node: Node, maker: ItemMaker, content: FolderDraft, parent: str) -> Path | None:
        if source.items_from is None:
            return None
        before = self._findings.errors
        path = self._context.file(source.items_from, node, "items_from")
        if self._context.base is None or self._findings.errors > before:
            return path
        span = self._tree.value_span(node, "items_from")
        for row in read_tags(path, span, self._findings, self._context.max_size):
            folder = self._folder_for(row, content, parent)
            if folder is None:
                continue
            draft, folder_id = folder
            item_id = self._ids.take(row.text.name, folder_id, row.span, is_item=True)
            item = maker.make(row.text, item_id or "", row.where)
            if item is not None and item_id:
                draft.items.append(item)
        return path

    def _folder_for(self, row: TagRow, content: FolderDraft, parent: str) -> tuple[FolderDraft, str] | None:
        """Folder of a tag and its ID; new where the tags before it had none of that name."""
        draft, draft_id = content, parent
        for name in row.folders:
            inner = draft.folders.get(name.casefold())
            if inner is None:
                if self._ids.take(name, draft_id, row.span) is None:
                    return None
                inner = draft.folders[name.casefold()] = FolderDraft(name)
            draft, draft_id = inner, f"{draft_id}.{inner.name}"
        return draft, draft_id


@dataclass(slots=True)
class FolderDraft:
    """A folder, or what a PLC holds, while items are still coming in."""

    name: str
    description: str = ""
    folders: dict[str, FolderDraft] = field(default_factory=dict)
    items: list[Item] = field(default_factory=list)

    def freeze(self) -> tuple[tuple[Folder, ...], tuple[Item, ...]]:
        folders = []
        for draft in self.folders.values():
            inner, items = draft.freeze()
            folders.append(Folder(draft.name, inner, items, draft.description))
        return tuple(folders), tuple(self.items)


def _places(plc: Plc, kind: LinkType) -> Iterable[tuple[str, str, object]]:
    """(words, key, value) of what must be unique on a link."""
    if kind is LinkType.S7TCP:
        yield f"the same address, host and TSAPs ({plc.station})", "host", (plc.station.casefold(), plc.port)
    else:
        yield f"address {plc.address}", "address", plc.address
    if kind in (LinkType.MODBUS_RTU, LinkType.MODBUS_ASCII):
        yield f"unit {plc.unit}", "unit", ("unit", plc.unit)
