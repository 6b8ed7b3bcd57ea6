"""The project as the rest of the program sees it: typed, checked, immutable.

``pcaccess.project.load`` makes these objects; whoever holds one need not check it again. An item is small
(about 150 bytes with its ID), because a project may have 100,000 of them: whatever items of one PLC have in
common they share, and the run-time name is made when somebody asks.

Units:    durations in seconds, dead bands in percent of the engineering range, lengths in characters.
Source:   docs/items-yaml.md has every key as a user writes it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Final

from pcaccess.problems import Span
from pcaccess.project.access import Access
from pcaccess.project.network import DEFAULT_ENDPOINT, DEFAULT_WEB, WebClients
from pcaccess.s7200.address import Address
from pcaccess.s7200.cpu import CpuModel
from pcaccess.s7200.types import DataType

__all__ = [
    "SERVED_LINKS",
    "SERVED_PROTOCOLS",
    "Access",
    "DynamicItems",
    "Folder",
    "Group",
    "Item",
    "Link",
    "LinkType",
    "Parity",
    "Plc",
    "Port",
    "Project",
    "Protocol",
    "Scaling",
    "SerialLine",
    "Server",
    "Traits",
    "WriteLimits",
    "limit_text",
]


class WriteLimits(Enum):
    """What happens to a write outside ``low``..``high``."""

    NONE = "none"
    REFUSE = "refuse"
    CLAMP = "clamp"


class LinkType(Enum):
    """Ways to reach PLCs; the value is the word in the project file."""

    SOFT = "soft"
    SIM = "sim"
    PPI = "ppi"
    S7TCP = "s7tcp"
    MODBUS_RTU = "modbus-rtu"
    MODBUS_ASCII = "modbus-ascii"
    MODBUS_TCP = "modbus-tcp"
    OPCUA = "opcua"

    @property
    def has_s7_memory(self) -> bool:
        """Items have S7-200 addresses; otherwise ``Item.address`` is a text of the link's own."""
        return self not in (LinkType.SIM, LinkType.OPCUA)


SERVED_LINKS: Final = frozenset({LinkType.SOFT, LinkType.SIM})
"""Link types that this version can run; the others are checked, and their items are NOT_CONNECTED."""


class Protocol(Enum):
    """How others may reach a soft-PLC."""

    PPI = "ppi"
    S7 = "s7"
    MODBUS_TCP = "modbus-tcp"
    MODBUS_RTU = "modbus-rtu"
    MODBUS_ASCII = "modbus-ascii"


class Parity(Enum):
    NONE = "none"
    EVEN = "even"
    ODD = "odd"


SERVED_PROTOCOLS: Final[frozenset[Protocol]] = frozenset()
"""Faces of a soft-PLC that this version can show; the others are checked and stay closed."""


@dataclass(frozen=True, slots=True)
class Scaling:
    """A straight line from the PLC's number to the engineering value."""

    raw_low: float
    raw_high: float
    scaled_low: float
    scaled_high: float
    clamp: bool = False
    """Values outside ``scaled_low``..``scaled_high`` are held at the nearer end, both ways."""


@dataclass(frozen=True, slots=True)
class Traits:
    """What many items of a PLC have in common; they share one of these."""

    station: str
    """What stands before the address in the run-time name."""
    data_type: DataType
    """Type that clients see; REAL when scaled."""
    raw_type: DataType
    """Type in the PLC's memory."""
    access: Access
    length: int = 0
    """Characters a STRING has room for; 0 for other types."""
    low: float | None = None
    high: float | None = None
    """Engineering range, ``low`` < ``high``; both are None or neither is."""
    unit: str = ""
    scaling: Scaling | None = None
    write_limits: WriteLimits = WriteLimits.NONE


@dataclass(frozen=True, slots=True)
class Item:
    """One value that clients can see. Where it stands in its file is not kept: nobody asks once it is checked."""

    item_id: str
    """``Link.PLC.Folder.Item`` as written, or a run-time name; compare it casefolded."""
    address: Address | str
    """Already ``as_type(raw_type)``, array count included; a text on sim and opcua links."""
    traits: Traits
    description: str = ""

    @property
    def name(self) -> str:
        """What stands last in the ID; a run-time name is whole."""
        return self.item_id if "," in self.item_id else self.item_id.rpartition(".")[2]

    @property
    def count(self) -> int:
        """Elements of an array item, 1 for a single value."""
        return self.address.count if isinstance(self.address, Address) else 1

    @property
    def station(self) -> str:
        return self.traits.station

    @property
    def data_type(self) -> DataType:
        return self.traits.data_type

    @property
    def raw_type(self) -> DataType:
        return self.traits.raw_type

    @property
    def access(self) -> Access:
        return self.traits.access

    @property
    def length(self) -> int:
        return self.traits.length

    @property
    def low(self) -> float | None:
        return self.traits.low

    @property
    def high(self) -> float | None:
        return self.traits.high

    @property
    def unit(self) -> str:
        return self.traits.unit

    @property
    def scaling(self) -> Scaling | None:
        return self.traits.scaling

    @property
    def write_limits(self) -> WriteLimits:
        return self.traits.write_limits

    @property
    def run_time_name(self) -> str:
        """``MicroWin:2:0.0.0.0:0000:0000,VW0,INT,RW,1000.000,200.000``, as PC Access shows it.

        A scaled item has its served type REAL there, so that it differs from the bare item of the same address.
        """
        limits = f"{limit_text(self.high or 0.0)},{limit_text(self.low or 0.0)}"
        return f"{self.station},{self.address},{self.data_type.name},{self.access},{limits}"


def limit_text(value: float) -> str:
    """A limit as PC Access prints it: ``0.0000000``, ``1000.000``. ``float()`` of it gives ``value`` again."""
    if value == 0:
        return "0.0000000"
    text = repr(float(value))
    if "e" in text or "n" in text:  # 1e+16, inf, nan
        return text
    whole, _, fraction = text.partition(".")
    return f"{whole}.{fraction:0<3}"


@dataclass(frozen=True, slots=True)
class Folder:
    """A named level between PLC and item."""

    name: str
    folders: tuple[Folder, ...] = ()
    items: tuple[Item, ...] = ()
    description: str = ""

    def all_items(self) -> Iterator[Item]:
        """Items of this folder, then of those below it."""
        yield from self.items
        for folder in self.folders:
            yield from folder.all_items()


@dataclass(frozen=True, slots=True)
class SerialLine:
    """A serial port: a device, or ``socket://host:port`` of a converter."""

    port: str
    baud: int
    parity: Parity


@dataclass(frozen=True, slots=True)
class Port:
    """A face that a soft-PLC shows to others."""

    protocol: Protocol
    listen: str
    """``host:port``, ``socket://host:port`` or a serial device."""
    baud: int
    parity: Parity
    unit: int
    """Modbus unit; for PPI the PLC's own address is used."""
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Plc:
    """One station on a link. Keys that the link's type does not have keep their defaults."""

    name: str
    link: str
    """Name of the link it belongs to."""
    address: int
    """PPI station 0..126; unique on its link where it has a meaning there."""
    cpu: CpuModel
    span: Span = field(compare=False)
    description: str = ""
    connected: bool = True
    write_limits: WriteLimits = WriteLimits.NONE
    folders: tuple[Folder, ...] = ()
    items: tuple[Item, ...] = ()
    items_from: Path | None = None
    program: Path | None = None
    scan: float | None = 0.010
    """Seconds from scan to scan; None is a free-running scan."""
    process: str | None = None
    """PLCs with the same name here share a process."""
    ports: tuple[Port, ...] = ()
    host: str = ""
    port: int = 0
    local_tsap: int = 0
    remote_tsap: int = 0
    unit: int = 1
    """Modbus unit."""
    hold_start: Address | None = None
    """Where Modbus holding register 40001 lies (HoldStart of MBUS_INIT)."""

    @property
    def item_id(self) -> str:
        """``Link.PLC``."""
        return f"{self.link}.{self.name}"

    @property
    def station(self) -> str:
        """What its run-time names begin with: ``MicroWin:2:0.0.0.0:0000:0000``."""
        host = self.host or "0.0.0.0"
        return f"{self.link}:{self.address}:{host}:{self.local_tsap:04X}:{self.remote_tsap:04X}"

    def all_items(self) -> Iterator[Item]:
        """Its own items, then those of its folders."""
        yield from self.items
        for folder in self.folders:
            yield from folder.all_items()


@dataclass(frozen=True, slots=True)
class Link:
    """One way to reach PLCs."""

    name: str
    type: LinkType
    plcs: tuple[Plc, ...]
    span: Span = field(compare=False)
    description: str = ""
    serial: SerialLine | None = None
    """Of ppi, modbus-rtu and modbus-ascii links."""
    master: int = 0
    """Our own address on a PPI network."""
    endpoint: str = ""
    """Of opcua links."""


@dataclass(frozen=True, slots=True)
class Group:
    """A named set of items, polled at ``update_rate`` while it is active."""

    name: str
    update_rate: float
    active: bool
    dead_band: float
    items: tuple[str, ...]
    """Item IDs as the items themselves have them."""
    span: Span = field(compare=False)
    description: str = ""


@dataclass(frozen=True, slots=True)
class DynamicItems:
    """What clients may create by run-time name."""

    access: Access = Access.RW
    max: int = 10_000
    idle: float = 600.0


@dataclass(frozen=True, slots=True)
class Server:
    endpoint: str = DEFAULT_ENDPOINT
    read_timeout: float = 2.0
    """Longest wait for a device read that a client's Read asked for."""
    web: str | None = DEFAULT_WEB
    """``host:port`` of the web server; None is off."""
    web_is_wished: bool = False
    """The project says where; otherwise the place is only the usual one, and the gateway can do without."""
    web_clients: WebClients = WebClients.THIS_MACHINE


@dataclass(frozen=True, slots=True)
class Project:
    """The content of one project file."""

    name: str
    path: Path
    links: tuple[Link, ...] = ()
    groups: tuple[Group, ...] = ()
    server: Server = field(default_factory=Server)
    dynamic_items: DynamicItems = field(default_factory=DynamicItems)

    def all_items(self) -> Iterator[Item]:
        """Every item in file order."""
        for plc in self.all_plcs():
            yield from plc.all_items()

    def all_plcs(self) -> Iterator[Plc]:
        for link in self.links:
            yield from link.plcs

    def link(self, name: str) -> Link | None:
        """The link of that name in any case."""
        folded = name.casefold()
        return next((link for link in self.links if link.name.casefold() == folded), None)

    def plc(self, item_id: str) -> Plc | None:
        """The PLC ``Link.PLC`` in any case."""
        folded = item_id.casefold()
        return next((plc for plc in self.all_plcs() if plc.item_id.casefold() == folded), None)

    def items_by_id(self) -> dict[str, Item]:
        """Casefolded item ID to item. Made anew at each call: keep it."""
        return {item.item_id.casefold(): item for item in self.all_items()}
