"""Run-time names: an address in a PLC, as PC Access's clients write it, parsed and printed.

    MicroWin:2:0.0.0.0:0000:0000,VW0,INT,RW,1000.000,200.000     everything
    2:192.0.2.5:1000:1001,vd340,DWORD                            without the link, trailing fields left out
    2,IB0,byte                                                   station, address, type
    MWSMART:2:0.0.0.0:0201:0201,M26.0,BOOL,RW                    PC Access SMART

Limits are printed as PC Access prints them, with at least three decimals and all that are needed, zero as
``0.0000000``; so a name that was printed reads back the same.

Errors:   :class:`RunTimeNameError`, whose message says which part is wrong.
Source:   source document 004, section 9.29 (run-time names, ``Q0,0`` where Windows writes a decimal comma);
          names seen in clients of PC Access and PC Access SMART.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import Final

from pcaccess.project.access import ACCESS_NAMES, Access
from pcaccess.project.model import Link, Plc, Project, limit_text
from pcaccess.s7200.address import Address, AddressError, parse_address
from pcaccess.s7200.types import DATA_TYPE_NAMES, DataType

ANY_IP: Final = "0.0.0.0"
"""Stands where there is no IP address: PPI, and a PLC in the gateway itself."""
MAX_STATION: Final = 126
PC_ACCESS_ROOTS: Final = frozenset({"microwin", "mwsmart"})
"""What PC Access and PC Access SMART put before every name. Where no link is called so, they say nothing."""
_FORM: Final = "expected STATION,ADDRESS,TYPE or LINK:STATION:IP:TSAP:TSAP,ADDRESS,TYPE,ACCESS,HIGH,LOW"
_HOST: Final = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*", re.ASCII)
_TSAP: Final = re.compile(r"[0-9A-Fa-f]{1,4}", re.ASCII)
_NUMBER: Final = re.compile(r"[0-9]{1,9}", re.ASCII)
_COMMA_BIT: Final = re.compile(r"(DB1\.DBX|[A-Z]{1,2}X?)\d{1,6}", re.ASCII)


class RunTimeNameError(ValueError):
    """The text is not a run-time name."""


@dataclass(frozen=True, slots=True)
class RunTimeName:
    """One run-time name; None for what it leaves out."""

    station: int
    address: Address
    """``as_type(data_type)`` where there is a type."""
    data_type: DataType | None = None
    access: Access | None = None
    high: float | None = None
    low: float | None = None
    link: str | None = None
    ip: str | None = None
    local_tsap: int = 0
    remote_tsap: int = 0
    """Both TSAPs are 0 where there is no ``ip``."""

    def __str__(self) -> str:
        """What is there and nothing else; :func:`parse_run_time_name` gives the same name back."""
        head = f"{self.link}:{self.station}" if self.link is not None else str(self.station)
        if self.ip is not None:
            head += f":{self.ip}:{self.local_tsap:04X}:{self.remote_tsap:04X}"
        fields = [
            head,
            str(self.address),
            self.data_type.name if self.data_type else "",
            str(self.access) if self.access else "",
            limit_text(self.high) if self.high is not None else "",
            limit_text(self.low) if self.low is not None else "",
        ]
        return ",".join(fields).rstrip(",")

    def short(self) -> str:
        """``2,IB0,BYTE``"""
        return f"{self.station},{self.address},{self.served_type.name}"

    @property
    def served_type(self) -> DataType:
        """The type it says or, where it says none, the one that PC Access gives such an address."""
        return self.data_type or self.address.types[0]


def parse_run_time_name(text: str) -> RunTimeName:
    """Read a run-time name in any of its forms, in any case."""
    head, comma, rest = text.partition(",")
    if not comma:
        raise RunTimeNameError(f"{text!r} is not a run-time name; {_FORM}")
    fields = [field.strip() for field in rest.split(",")]
    if len(fields) > 1 and _COMMA_BIT.fullmatch(fields[0].upper()) and re.fullmatch(r"[0-7]", fields[1]):
        fields[:2] = [f"{fields[0]}.{fields[1]}"]
    if len(fields) > 5:
        raise RunTimeNameError(f"{text!r} has {len(fields) + 1} parts; {_FORM}")
    fields += [""] * (5 - len(fields))
    data_type = _type(fields[1])
    try:
        address = parse_address(fields[0])
        if data_type is not None:
            address = address.as_type(data_type)
    except AddressError as error:
        raise RunTimeNameError(str(error)) from None
    link, station, ip, local_tsap, remote_tsap = _head(head, text)
    return RunTimeName(
        station=station,
        address=address,
        data_type=data_type,
        access=_access(fields[2]),
        high=_limit(fields[3]),
        low=_limit(fields[4]),
        link=link,
        ip=ip,
        local_tsap=local_tsap,
        remote_tsap=remote_tsap,
    )


def _head(head: str, text: str) -> tuple[str | None, int, str | None, int, int]:
    """link, station, ip, local TSAP, remote TSAP

    The first part is the link unless it is a number that no station follows: ``2:0.0.0.0`` is station 2, while
    ``2:3:0.0.0.0`` is station 3 of a link that somebody called 2.
    """
    parts = [part.strip() for part in head.split(":")]
    link = None
    if not _NUMBER.fullmatch(parts[0]) or (len(parts) > 1 and _NUMBER.fullmatch(parts[1])):
        link = parts.pop(0)
    if not parts or not _NUMBER.fullmatch(parts[0]) or link == "" or len(parts) > 4:
        raise RunTimeNameError(f"{head!r} does not say which station; {_FORM}")
    station = int(parts[0])
    if station > MAX_STATION:
        raise RunTimeNameError(f"{text!r}: station {station} is out of range; expected 0 to {MAX_STATION}")
    if len(parts) == 1:
        return link, station, None, 0, 0
    if not _HOST.fullmatch(parts[1]):
        raise RunTimeNameError(f"{parts[1]!r} is not an IP address; {_FORM}")
    for part in parts[2:]:
        if not _TSAP.fullmatch(part):
            raise RunTimeNameError(f"{part!r} is not a TSAP; expected four hexadecimal digits such as 1000")
    tsaps = [int(part, 16) for part in parts[2:]] + [0, 0]
    return link, station, parts[1], tsaps[0], tsaps[1]


def _type(field: str) -> DataType | None:
    if not field:
        return None
    try:
        return DATA_TYPE_NAMES[field.upper()]
    except KeyError:
        raise RunTimeNameError(f"there is no type {field!r}; expected one of {', '.join(DATA_TYPE_NAMES)}") from None


def _access(field: str) -> Access | None:
    if not field:
        return None
    try:
        return ACCESS_NAMES[field.upper()]
    except KeyError:
        raise RunTimeNameError(f"there is no access {field!r}; expected R, W or RW") from None


def _limit(field: str) -> float | None:
    if not field:
        return None
    try:
        value = float(field)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RunTimeNameError(f"the limit {field!r} is not a number")
    return value + 0.0  # no -0.0: it would print as another name


class Stations:
    """Which PLCs of a project a run-time name may mean."""

    def __init__(self, project: Project) -> None:
        self._no_link = PC_ACCESS_ROOTS - {link.name.casefold() for link in project.links}
        self._by_address: dict[int, list[tuple[Link, Plc]]] = {}
        for link in project.links:
            if not link.type.has_s7_memory:
                continue
            for plc in link.plcs:
                self._by_address.setdefault(plc.address, []).append((link, plc))

    def find(self, name: RunTimeName) -> list[Plc]:
        """Empty: no such PLC. More than one: the name must say which link, or which IP address.

        TSAPs count only where the PLC has them: a name that was made for PC Access SMART (0201) or with
        another connection's TSAPs means the same station. So does PC Access's own root where no link has its name.
        """
        if name.link is not None and name.link.casefold() in self._no_link:
            name = replace(name, link=None)
        return [plc for link, plc in self._by_address.get(name.station, ()) if _fits(name, link, plc)]


def _fits(name: RunTimeName, link: Link, plc: Plc) -> bool:
    if name.link is not None and name.link.casefold() != link.name.casefold():
        return False
    if name.ip is None or name.ip == ANY_IP:
        return True
    if name.ip.casefold() != plc.host.casefold():
        return False
    given = (name.local_tsap, name.remote_tsap)
    own = (plc.local_tsap, plc.remote_tsap)
    return all(mine == theirs for mine, theirs in zip(given, own, strict=True) if mine and theirs)
