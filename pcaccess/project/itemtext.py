"""One item as a user wrote it, in YAML or in a tag table, to an :class:`Item` or the problems with it.

Errors:   reported, all of an item at once; the item is then None.
Not here: whether its ID is free (``pcaccess.project.ids``).
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from typing import Final

from pcaccess.problems import Span, nearest_word
from pcaccess.project.access import ACCESS_NAMES, Access
from pcaccess.project.limits import Where, check_limits, check_scaling, read_limits
from pcaccess.project.model import Item, LinkType, Scaling, Traits, WriteLimits
from pcaccess.project.problems import Findings
from pcaccess.project.sim import WaveError, parse_wave
from pcaccess.s7200.address import Address, AddressError, Area, Width, parse_address
from pcaccess.s7200.cpu import CpuModel
from pcaccess.s7200.special import LAST_READ_ONLY_SM, true_of_memory_alone
from pcaccess.s7200.types import DATA_TYPE_NAMES, MAX_STRING, DataType, ValueRangeError, ValueTypeError


@dataclass(slots=True)
class ItemText:
    """What stands in the file; None and empty texts where it says nothing."""

    name: str
    address: str
    type: str | None = None
    access: str | None = None
    high: float | None = None
    low: float | None = None
    unit: str = ""
    description: str = ""
    write_limits: str | None = None
    length: int | None = None
    scaling: Scaling | None = None
    raw_type: str | None = None


FOREIGN_TYPES: Final = {
    "BOOLEAN": "BOOL",
    "BIT": "BOOL",
    "UINT8": "BYTE",
    "USINT": "BYTE",
    "INT8": "CHAR",
    "UINT16": "WORD",
    "UINT": "WORD",
    "INT16": "INT",
    "SHORT": "INT",
    "INTEGER": "INT",
    "UINT32": "DWORD",
    "UDINT": "DWORD",
    "INT32": "DINT",
    "LONG": "DINT",
    "FLOAT": "REAL",
    "SINGLE": "REAL",
    "TEXT": "STRING",
}
"""Words of other systems, for "did you mean"."""

_NOT_BY_PPI: Final = {Area.L: "L memory", Area.AC: "an accumulator"}
_BY_MODBUS: Final = frozenset({Area.I, Area.Q, Area.V, Area.AI})
_SIGNED: Final = {Width.BYTE: DataType.CHAR, Width.WORD: DataType.INT, Width.DWORD: DataType.DINT}


def find_type(word: str, where: Where, key: str, findings: Findings) -> DataType | None:
    """The type of that name in any case; reports an unknown one."""
    plain = word.strip().upper()
    if plain not in DATA_TYPE_NAMES:
        nearest = FOREIGN_TYPES.get(plain) or nearest_word(word, DATA_TYPE_NAMES)
        expected = f"one of {', '.join(DATA_TYPE_NAMES)}"
        findings.report("PRJ011", where(key), f"there is no type {word!r}", expected=expected, nearest=nearest)
    return DATA_TYPE_NAMES.get(plain)


def find_access(word: str, where: Where, key: str, findings: Findings) -> Access | None:
    plain = word.strip().upper()
    if plain not in ACCESS_NAMES:
        findings.report("PRJ011", where(key), f"there is no access {word!r}", expected="R, W or RW")
    return ACCESS_NAMES.get(plain)


def find_write_limits(word: str, where: Where, key: str, findings: Findings) -> WriteLimits | None:
    words = {w.value: w for w in WriteLimits}
    plain = word.strip().lower()
    if plain not in words:
        findings.report(
            "PRJ011",
            where(key),
            f"there are no write limits {word!r}",
            expected="none, refuse or clamp",
            nearest=nearest_word(word, words),
        )
    return words.get(plain)


@dataclass(slots=True)
class _Place:
    """Where the value is and what it is made of."""

    address: Address | str
    data_type: DataType
    raw_type: DataType
    length: int = 0
    why_read_only: str = ""


class ItemMaker:
    """Makes the items of one PLC; what they have in common is the same object in all of them."""

    def __init__(
        self,
        link: LinkType,
        station: str,
        cpu: CpuModel,
        write_limits: WriteLimits,
        findings: Findings,
        *,
        runs_program: bool,
    ) -> None:
        self._link = link
        self._station = station
        self._cpu = cpu
        self._write_limits = write_limits
        self._findings = findings
        self._runs_program = runs_program
        self._texts: dict[str, str] = {}
        self._known: dict[tuple[object, ...], Traits] = {}

    def make(self, text: ItemText, item_id: str, where: Where, broken: Container[str] = ()) -> Item | None:
        """``broken``: keys already reported and taken out, so that their absence is no mistake."""
        before = self._findings.errors
        if self._link is LinkType.SIM:
            place = self._simulated(text, where)
        elif self._link is LinkType.OPCUA:
            place = self._foreign(text, where)
        else:
            place = self._in_memory(text, where, broken)
        limits = read_limits(text.low, text.high, where, broken, self._findings)
        access = self._access(text, where, place.why_read_only if place else "")
        write_limits = self._limited_writes(text, where, limits)
        if place is None or access is None or write_limits is None or self._findings.errors > before:
            return None
        if limits and not check_limits(text.low, text.high, place.data_type, write_limits, where, self._findings):
            return None
        description = self._texts.setdefault(text.description, text.description)
        return Item(item_id, place.address, self._traits(text, place, access, limits, write_limits), description)

    def _traits(
        self,
        text: ItemText,
        place: _Place,
        access: Access,
        limits: tuple[float, float] | None,
        write_limits: WriteLimits,
    ) -> Traits:
        """Those that an item made before has, if it is of the same sort."""
        low, high = limits or (None, None)
        sort = (
            place.data_type,
            place.raw_type,
            access,
            place.length,
            low,
            high,
            text.unit,
            text.scaling,
            write_limits,
        )
        known = self._known.get(sort)
        if known is None:
            known = self._known[sort] = Traits(self._station, *sort)
        return known

    def _report(self, code: str, span: Span, message: str, expected: str = "") -> None:
        self._findings.report(code, span, message, expected=expected)

    def _type(self, word: str | None, key: str, where: Where, default: DataType) -> DataType | None:
        return default if word is None else find_type(word, where, key, self._findings)

    # -- what lies where ---------------------------------------------------------------------------------------

    def _simulated(self, text: ItemText, where: Where) -> _Place | None:
        try:
            wave = parse_wave(text.address)
        except WaveError as error:
            self._report("PRJ030", where("address"), str(error))
            return None
        data_type = self._type(text.type, "type", where, wave.default_type)
        if data_type is None:
            return None
        try:
            wave.check(data_type)
        except (WaveError, ValueRangeError, ValueTypeError) as error:
            self._report("PRJ019", where("type" if text.type else "address"), f"{text.address}: {error}")
            return None
        length = MAX_STRING if data_type is DataType.STRING else 0
        why = "" if wave.kind.is_writable else f"{text.address} is what it is"
        return _Place(text.address, data_type, data_type, length, why)

    def _foreign(self, text: ItemText, where: Where) -> _Place | None:
        if text.type is None:
            self._report(
                "PRJ009", where("name"), "the key 'type' is missing: nobody can tell before the other server answers"
            )
            return None
        data_type = find_type(text.type, where, "type", self._findings)
        if not text.address.strip():
            self._report("PRJ017", where("address"), "the address is empty", "a NodeId such as ns=2;s=A.B.T1")
            return None
        if data_type is None:
            return None
        return _Place(text.address, data_type, data_type, MAX_STRING if data_type is DataType.STRING else 0)

    def _in_memory(self, text: ItemText, where: Where, broken: Container[str]) -> _Place | None:
        try:
            address = parse_address(text.address)
        except AddressError as error:
            self._report("PRJ017", where("address"), str(error))
            return None
        types = self._types(text, address, where, "scaling" in broken)
        if types is None:
            return None
        data_type, raw_type = types
        length = 0
        if raw_type is DataType.STRING:
            length = text.length or MAX_STRING
            if address.count > 1:
                self._report("PRJ025", where("address"), f"{address}: there are no arrays of STRING")
        elif text.length is not None:
            self._report("PRJ025", where("length"), f"length belongs to a STRING; this is {raw_type.name}")
        try:
            address = address.as_type(raw_type)
        except AddressError as error:
            self._report("PRJ019", where("raw_type" if text.raw_type else "type"), str(error))
            self._check_range(address, 0, where)
            return None
        size = length + 1 if length else 0
        self._check_range(address, size, where)
        self._check_reach(address, size, where)
        return _Place(address, data_type, raw_type, length, _why_read_only(address))

    def _types(
        self, text: ItemText, address: Address, where: Where, no_scaling: bool
    ) -> tuple[DataType, DataType] | None:
        """(served, raw)"""
        if text.scaling is None:
            if text.raw_type is not None and not no_scaling:
                self._report("PRJ025", where("raw_type"), "raw_type belongs to a scaled item; this one has no scaling")
            if no_scaling:
                return DataType.REAL, address.types[0]
            served = self._type(text.type, "type", where, address.types[0])
            return (served, served) if served else None
        served = self._type(text.type, "type", where, DataType.REAL)
        raw = self._type(text.raw_type, "raw_type", where, _SIGNED.get(address.width, DataType.BOOL))
        if served is None or raw is None:
            return None
        if served is not DataType.REAL:
            self._report(
                "PRJ025", where("type"), f"a scaled item is REAL; the type in the PLC is raw_type: {served.name}"
            )
        if address.count > 1:
            self._report("PRJ025", where("scaling"), "arrays cannot be scaled")
        if raw in (DataType.BOOL, DataType.STRING):
            self._report("PRJ024", where("scaling"), f"a {raw.name} cannot be scaled")
            return None
        if text.scaling.raw_low == text.scaling.raw_high or text.scaling.scaled_low == text.scaling.scaled_high:
            self._report(
                "PRJ024", where("scaling"), "both ends are the same", "two different numbers in raw and in scaled"
            )
        check_scaling(text.scaling, raw, where("scaling"), self._findings)
        return DataType.REAL, raw

    def _check_range(self, address: Address, size: int, where: Where) -> None:
        try:
            self._cpu.check(address, size=size or None)
        except AddressError as error:
            self._report("PRJ018", where("address"), str(error))

    def _check_reach(self, address: Address, size: int, where: Where) -> None:
        """Items that this link can never read."""
        if self._link is LinkType.SOFT:
            if not self._runs_program and not true_of_memory_alone(address, size or None):
                message = f"{address}: only a running CPU keeps it true, and this PLC has no program"
                self._report("PRJ034", where("address"), message)
        elif self._link in (LinkType.PPI, LinkType.S7TCP):
            if address.area in _NOT_BY_PPI:
                self._report(
                    "PRJ034", where("address"), f"{address}: {_NOT_BY_PPI[address.area]} is not visible from outside"
                )
        elif address.area not in _BY_MODBUS:
            self._report("PRJ034", where("address"), f"{address}: Modbus reaches I, Q, AI and V only")

    # -- what may be done with it ------------------------------------------------------------------------------

    def _access(self, text: ItemText, where: Where, why_read_only: str) -> Access | None:
        if text.access is None:
            return Access.R if why_read_only else Access.RW
        access = find_access(text.access, where, "access", self._findings)
        if why_read_only and access in (Access.W, Access.RW):
            self._report("PRJ026", where("access"), f"{why_read_only}; access is taken as R")
            return Access.R
        return access

    def _limited_writes(self, text: ItemText, where: Where, limits: tuple[float, float] | None) -> WriteLimits | None:
        if text.write_limits is None:
            return self._write_limits if limits else WriteLimits.NONE
        found = find_write_limits(text.write_limits, where, "write_limits", self._findings)
        if found not in (None, WriteLimits.NONE) and limits is None and text.low is None and text.high is None:
            self._report(
                "PRJ023", where("write_limits"), f"{text.write_limits} needs high and low, and this item has none"
            )
        return found


def _why_read_only(address: Address) -> str:
    if address.area is Area.HC:
        return f"{address}: the hardware counts, a program can only read it"
    if address.area is Area.SM and address.offset <= LAST_READ_ONLY_SM:
        return f"{address}: SMB0 to SMB{LAST_READ_ONLY_SM} are read-only in an S7-200"
    return ""
