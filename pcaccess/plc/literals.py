"""Values as a scenario writes them: what is put into memory, and what is expected there.

A number without a decimal point is an integer of the place's width, signed or unsigned, whichever it fits; with
one it is a REAL. A text in quotes is a STRING. ``T37`` is the value of a timer, ``T37.bit`` its bit.

Errors:   :class:`LiteralError`, whose message says what was expected.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from pcaccess.s7200.address import Address, AddressError, Width, parse_address
from pcaccess.s7200.cpu import CpuModel
from pcaccess.s7200.types import DATA_TYPE_NAMES, DataType, Value
from pcaccess.stl.constants import ConstantError, parse_number
from pcaccess.stl.evaluate import round_to_single
from pcaccess.stl.program import SymbolTable

_SIGNED: Final = {Width.BYTE: DataType.CHAR, Width.WORD: DataType.INT, Width.DWORD: DataType.DINT}
_UNSIGNED: Final = {Width.BYTE: DataType.BYTE, Width.WORD: DataType.WORD, Width.DWORD: DataType.DWORD}


class LiteralError(ValueError):
    """Not an address, or not a value for it."""


@dataclass(frozen=True, slots=True)
class Target:
    """One place in a scenario. ``text`` is how it was written; ``address`` has width BIT for a bit."""

    text: str
    address: Address


def parse_target(text: str, model: CpuModel, symbols: SymbolTable) -> Target:
    """An address, ``T37.bit``, or a symbol of the program."""
    symbol = symbols.find(text)
    if symbol is not None and isinstance(symbol.target, Address):
        return Target(text, symbol.target)
    name, dot, suffix = text.partition(".")
    wants_bit = bool(dot) and suffix.lower() == "bit"
    try:
        address = parse_address(name if wants_bit else text)
        if wants_bit:
            address = address.as_type(DataType.BOOL)
        model.check(address)
    except AddressError as error:
        raise LiteralError(str(error)) from None
    if address.count != 1:
        raise LiteralError(f"{text}: one value at a time")
    return Target(text, address)


def parse_typed(text: str, model: CpuModel, symbols: SymbolTable) -> tuple[Target, DataType]:
    """A place to show, with a type where it matters: ``VD20:REAL``."""
    name, colon, word = text.partition(":")
    target = parse_target(name.strip(), model, symbols)
    kind = DATA_TYPE_NAMES.get(word.strip().upper()) if colon else plain_type(target)
    if kind is None:
        raise LiteralError(f"there is no type {word}; types are {', '.join(DATA_TYPE_NAMES)}")
    try:
        return Target(text, target.address.as_type(kind)), kind
    except AddressError as error:
        raise LiteralError(str(error)) from None


def parse_value(text: str, quoted: bool, target: Target) -> tuple[DataType, Value]:
    """What ``text`` means at ``target``."""
    width = target.address.width
    if quoted:
        if width is not Width.BYTE:
            raise LiteralError(f"{target.text} takes a number; a text stands in bytes, for example VB100")
        return DataType.STRING, text
    number = _number(text)
    if number is None:
        word = {"true": 1, "false": 0}.get(text.lower()) if width is Width.BIT else None
        if word is None:
            raise LiteralError(f"{text!r} is not a value; expected a number, or a text in quotes")
        number = word
    if isinstance(number, float):
        if width is not Width.DWORD:
            raise LiteralError(f"{target.text} cannot hold {text}; a REAL stands in a double word, for example VD20")
        return DataType.REAL, round_to_single(number)
    return _integer_type(number, target), number


def _number(text: str) -> int | float | None:
    try:
        parsed = parse_number(text)
    except ConstantError as error:
        raise LiteralError(str(error)) from None
    return None if parsed is None else parsed.value


def _integer_type(number: int, target: Target) -> DataType:
    width = target.address.width
    if width is Width.BIT:
        if number not in (0, 1):
            raise LiteralError(f"{target.text} is a bit; expected 0 or 1, not {number}")
        return DataType.BOOL
    signed, unsigned = _SIGNED[width], _UNSIGNED[width]
    if signed.low <= number <= signed.high:
        return signed
    if number <= unsigned.high and number >= 0:
        return unsigned
    raise LiteralError(f"{number} does not fit {target.text} ({signed.low} to {unsigned.high})")


def plain_type(target: Target) -> DataType:
    """How a place is shown when nothing says otherwise."""
    width = target.address.width
    return DataType.BOOL if width is Width.BIT else {**_SIGNED, Width.BYTE: DataType.BYTE}[width]


@dataclass(frozen=True, slots=True)
class Expectation:
    """What a place must hold. ``type`` says how it is read."""

    target: Target
    type: DataType
    value: Value | None = None
    low: float = -math.inf
    high: float = math.inf
    shown: str = ""
    """The expectation for people: ``5``, ``0 to 1``, ``12.5 within 0.01``."""

    def holds(self, actual: Value) -> bool:
        if self.value is not None:
            return actual == self.value
        return not isinstance(actual, str) and self.low <= actual <= self.high

    def as_json(self) -> Value | dict[str, float]:
        """The value expected, or its limits."""
        if self.value is not None:
            return self.value
        limits = {"min": self.low, "max": self.high}
        return {name: limit for name, limit in limits.items() if math.isfinite(limit)}


def exactly(target: Target, text: str, quoted: bool) -> Expectation:
    """``VW10: -5``"""
    kind, value = parse_value(text, quoted, target)
    return Expectation(target, kind, value, shown=quote(text) if quoted else text)


def quote(text: str) -> str:
    """A STRING for people and XML: characters that cannot be printed as STL writes them, ``$01``."""
    return '"' + "".join(sign if sign.isprintable() else f"${ord(sign):02X}" for sign in text) + '"'


def between(target: Target, low: str | None, high: str | None) -> Expectation:
    """``{min: 0, max: 1}``"""
    limits = [parse_value(text, False, target) for text in (low, high) if text is not None]
    if not limits:
        raise LiteralError("expected min, max or both")
    kinds = [kind for kind, _ in limits]
    kind = next((k for k in kinds if k in _UNSIGNED.values()), kinds[0])
    if DataType.REAL in kinds:
        kind = DataType.REAL
    bottom = -math.inf if low is None else float(limits[0][1])
    top = math.inf if high is None else float(limits[-1][1])
    words = " and ".join(w for w in (low and f"at least {low}", high and f"at most {high}") if w)
    return Expectation(target, kind, low=bottom, high=top, shown=words)


def near(target: Target, text: str, tolerance: str | None) -> Expectation:
    """``{near: 12.5, tol: 0.01}``; without ``tol`` the nearest REAL values count."""
    middle = _number(text)
    within = 0.0 if tolerance is None else _number(tolerance)
    if middle is None or within is None or within < 0:
        raise LiteralError("expected near: a number, tol: a number of 0 or more")
    if target.address.width is not Width.DWORD:
        raise LiteralError(f"{target.text} cannot hold a REAL; near needs a double word, for example VD20")
    middle = round_to_single(float(middle))
    words = text if tolerance is None else f"{text} within {tolerance}"
    return Expectation(target, DataType.REAL, low=middle - within, high=middle + within, shown=words)
