"""The shape of ``items.yaml``: which keys stand where, and what kind of value each takes.

This is the border. Keys and kinds are checked here; what a text means (an address, a duration, a name) is checked
in ``pcaccess.project.build``, which makes the objects of ``pcaccess.project.model``. The descriptions are what
editors show (``pcaccess schema``) and what docs/items-yaml.md says; nothing else repeats them.

Units:    texts as written; numbers are numbers.
"""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal

from pydantic import Field

from pcaccess.project.durations import PATTERN
from pcaccess.project.network import DEFAULT_ENDPOINT, DEFAULT_WEB, WebClients
from pcaccess.project.rawitems import (
    FOLDERS,
    ITEMS,
    Description,
    Name,
    OpcUaFolder,
    OpcUaItem,
    Raw,
    S7Folder,
    S7Item,
    SimFolder,
    SimItem,
    WriteLimitsWord,
    words,
)
from pcaccess.s7200.cpu import CPU_NAMES

_DURATION: Final = {"pattern": f"^{PATTERN}$"}
_CPU: Final = {"anyOf": [{"enum": list(CPU_NAMES)}, {"type": ["string", "integer"]}], "type": None}
_TSAP: Final = {"type": ["string", "number"]}

Generation = Annotated[
    int, Field(ge=1, le=2, description="Hardware generation of the CPU: 1 is the one before 2004, with less memory.")
]
Cpu = Annotated[
    str, Field(description="CPU model; decides which addresses exist.", examples=["CPU 224"], json_schema_extra=_CPU)
]
Unit247 = Annotated[int, Field(ge=1, le=247, description="Modbus unit (slave address).")]
Baud = Annotated[int, Field(ge=300, le=1_000_000, description="Bits per second.")]
ParityWord = Annotated[str, Field(description="Parity bit.", json_schema_extra=words("none", "even", "odd"))]
Station = Annotated[
    int | None,
    Field(
        ge=0,
        le=126,
        description="Station address as in PC Access; stands in run-time names. Left out: the next free one from 2 on.",
    ),
]


class AnyPlc(Raw):
    name: Name
    description: Description = ""
    address: Station = None
    connected: Annotated[bool, Field(description="false: nobody talks to it, its items are NOT_CONNECTED.")] = True
    write_limits: WriteLimitsWord = None
    items_from: Annotated[
        str | None,
        Field(
            description="Tag table in Kepware's columns, beside this file; its items are added to those written here.",
            examples=["tags.csv"],
        ),
    ] = None


class S7Plc(AnyPlc):
    """One S7-200."""

    cpu: Cpu = "CPU 226"
    generation: Generation = 2
    items: list[S7Item] = ITEMS
    folders: list[S7Folder] = FOLDERS


class RawPort(Raw):
    """How others reach a soft-PLC."""

    protocol: Annotated[
        str,
        Field(
            description="Protocol spoken there.",
            json_schema_extra=words("ppi", "s7", "modbus-tcp", "modbus-rtu", "modbus-ascii"),
        ),
    ]
    listen: Annotated[
        str,
        Field(
            description="host:port (s7, modbus-tcp), a serial device or socket://host:port (the others).",
            examples=["127.0.0.1:10102", "/dev/ttyS1"],
        ),
    ]
    baud: Baud = 9600
    parity: ParityWord = "even"
    unit: Unit247 = 1


class SoftPlc(S7Plc):
    """A PLC that the gateway is: memory of its CPU model, and with a program the whole CPU."""

    program: Annotated[
        str | None, Field(description="STL program it runs, beside this file. Left out: memory only.")
    ] = None
    scan: Annotated[
        str | None,
        Field(
            description="Time from scan to scan (10ms), or free for as fast as possible.",
            json_schema_extra={"pattern": f"^({PATTERN}|free)$"},
        ),
    ] = None
    process: Annotated[
        str | None, Field(description="PLCs with the same word here share one process. Left out: one of its own.")
    ] = None
    ports: Annotated[list[RawPort], Field(description="How others reach this soft-PLC.")] = []


class PpiPlc(S7Plc):
    """A real S7-200 on an RS-485 network."""

    address: Annotated[int, Field(ge=0, le=126, description="Its station address on the network.")]


class S7TcpPlc(S7Plc):
    """A real S7-200 behind a CP 243-1."""

    host: Annotated[str, Field(description="Address of the CP 243-1.", examples=["192.0.2.5"])]
    port: Annotated[int, Field(ge=1, le=65535, description="TCP port.")] = 102
    local_tsap: Annotated[str, Field(description="Our TSAP.", examples=["10.00"], json_schema_extra=_TSAP)] = "10.00"
    remote_tsap: Annotated[str, Field(description="Its TSAP.", examples=["10.01"], json_schema_extra=_TSAP)] = "10.01"


class ModbusPlc(S7Plc):
    """An S7-200 that runs the Modbus slave library, on a serial line."""

    unit: Unit247 = 1
    hold_start: Annotated[
        str | None,
        Field(description="V byte where holding register 40001 lies (HoldStart of MBUS_INIT).", examples=["VB0"]),
    ] = None


class ModbusTcpPlc(ModbusPlc):
    """An S7-200 behind a Modbus TCP gateway."""

    host: Annotated[str, Field(description="Address of the Modbus server.", examples=["192.0.2.9"])]
    port: Annotated[int, Field(ge=1, le=65535, description="TCP port.")] = 502


class SimPlc(AnyPlc):
    """A set of simulated items."""

    items: list[SimItem] = ITEMS
    folders: list[SimFolder] = FOLDERS


class OpcUaPlc(AnyPlc):
    """A set of items of another OPC UA server."""

    items: list[OpcUaItem] = ITEMS
    folders: list[OpcUaFolder] = FOLDERS


class AnyLink(Raw):
    name: Name
    description: Description = ""


_PLCS: Final[Any] = Field(default=[], description="The PLCs it reaches.")
SerialPort = Annotated[
    str,
    Field(
        description="Serial device, or socket://host:port of a converter.",
        examples=["/dev/ttyUSB0", "COM3", "socket://192.0.2.7:4001"],
    ),
]


class SoftLink(AnyLink):
    """PLCs that the gateway is itself."""

    type: Literal["soft"]
    plcs: list[SoftPlc] = _PLCS


class SimLink(AnyLink):
    """Simulated values."""

    type: Literal["sim"]
    plcs: list[SimPlc] = _PLCS


class PpiLink(AnyLink):
    """A PPI cable or RS-485 network."""

    type: Literal["ppi"]
    port: SerialPort
    baud: Annotated[int, Field(description="Bits per second: 9600, 19200, 115200 or 187500.")] = 9600
    master: Annotated[int, Field(ge=0, le=126, description="Our own address on the network.")] = 0
    plcs: list[PpiPlc] = _PLCS


class S7TcpLink(AnyLink):
    """Ethernet through CP 243-1 modules."""

    type: Literal["s7tcp"]
    plcs: list[S7TcpPlc] = _PLCS


class ModbusRtuLink(AnyLink):
    """A serial line with Modbus RTU slaves."""

    type: Literal["modbus-rtu"]
    port: SerialPort
    baud: Baud = 9600
    parity: ParityWord = "even"
    plcs: list[ModbusPlc] = _PLCS


class ModbusAsciiLink(AnyLink):
    """A serial line with Modbus ASCII slaves."""

    type: Literal["modbus-ascii"]
    port: SerialPort
    baud: Baud = 9600
    parity: ParityWord = "even"
    plcs: list[ModbusPlc] = _PLCS


class ModbusTcpLink(AnyLink):
    """Modbus TCP servers."""

    type: Literal["modbus-tcp"]
    plcs: list[ModbusTcpPlc] = _PLCS


class OpcUaLink(AnyLink):
    """Another OPC UA server."""

    type: Literal["opcua"]
    endpoint: Annotated[str, Field(description="Its endpoint.", examples=["opc.tcp://other:4840"])]
    plcs: list[OpcUaPlc] = _PLCS


RawLink = Annotated[
    SoftLink | SimLink | PpiLink | S7TcpLink | ModbusRtuLink | ModbusAsciiLink | ModbusTcpLink | OpcUaLink,
    Field(discriminator="type"),
]
LINK_MODELS: Final[dict[str, type[AnyLink]]] = {
    "soft": SoftLink,
    "sim": SimLink,
    "ppi": PpiLink,
    "s7tcp": S7TcpLink,
    "modbus-rtu": ModbusRtuLink,
    "modbus-ascii": ModbusAsciiLink,
    "modbus-tcp": ModbusTcpLink,
    "opcua": OpcUaLink,
}


class RawServer(Raw):
    """The OPC UA server and the web server."""

    endpoint: Annotated[str, Field(description="Where clients find it; for now only on this machine (127.0.0.1).")] = (
        DEFAULT_ENDPOINT
    )
    web: Annotated[
        str,
        Field(
            description="HOST:PORT of REST, websocket and metrics; off does without. "
            "Left out, they are at 127.0.0.1:8080 unless another program is there.",
            examples=["127.0.0.1:8080", "off"],
            json_schema_extra={"anyOf": [{"type": "string"}, {"type": "boolean"}], "type": None},
        ),
    ] = DEFAULT_WEB
    web_clients: Annotated[
        str,
        Field(
            description="Who may use the web server; anything but this machine opens it to the network, without "
            "passwords or encryption.",
            json_schema_extra={"enum": [clients.value for clients in WebClients]},
        ),
    ] = WebClients.THIS_MACHINE.value
    read_timeout: Annotated[
        str,
        Field(
            description="Longest wait for a device when a client reads what nobody polls.",
            examples=["2s"],
            json_schema_extra=_DURATION,
        ),
    ] = "2s"


class RawGroup(Raw):
    """A set of items that is polled together."""

    name: Name
    description: Description = ""
    update_rate: Annotated[
        str, Field(description="How often it is polled.", examples=["250ms"], json_schema_extra=_DURATION)
    ] = "1s"
    active: Annotated[bool, Field(description="false: it is not polled until somebody sets it active.")] = True
    dead_band: Annotated[
        float, Field(ge=0, le=100, description="Percent of the engineering range that a change must exceed.")
    ] = 0.0
    items: Annotated[
        list[str],
        Field(description="Item IDs, in the order SyncRead answers.", examples=[["MicroWin.NewPLC.Motor"]]),
    ] = []


class RawDynamicItems(Raw):
    """What clients may create by run-time name."""

    access: Annotated[
        str, Field(description="Most that such an item can be: R, W or RW.", json_schema_extra=words("R", "W", "RW"))
    ] = "RW"
    max: Annotated[int, Field(ge=0, le=1_000_000, description="How many there may be; 0 forbids them.")] = 10_000
    idle: Annotated[
        str,
        Field(
            description="An unused one is forgotten after this time.", examples=["10min"], json_schema_extra=_DURATION
        ),
    ] = "10min"


class RawProject(Raw):
    """A pcaccess project: what a .pca file was to PC Access."""

    project: Annotated[str, Field(description="Name of the project.", examples=["Bottling line"])] = ""
    server: RawServer = RawServer()
    dynamic_items: Annotated[RawDynamicItems, Field(description="Items that clients create by naming an address.")] = (
        RawDynamicItems()
    )
    links: Annotated[list[RawLink], Field(description="Ways to reach PLCs.")]
    groups: Annotated[list[RawGroup], Field(description="Sets of items with an update rate.")] = []
