"""Strings in memory: what the cold string instructions share.

A STRING is a length byte (at most 254) and its characters. An operand is a constant text or a place.

Errors:   ``BadString`` inside a cold function becomes its outcome (:func:`outcome`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Final, Protocol, cast

from pcaccess.s7200.types import MAX_STRING
from pcaccess.stl.builder import Place
from pcaccess.stl.errors import OPERAND_RANGE, RunTimeError
from pcaccess.stl.ir_values import IrType, Value
from pcaccess.stl.routine import Routine
from pcaccess.stl.runtime import Outcome, Runtime

Text = bytes | None
"""A constant text with its length byte; None: it lies in memory."""
_NOWHERE: Final = -1


class BadString(Exception):
    """The instruction cannot be carried out."""

    def __init__(self, error: RunTimeError) -> None:
        super().__init__(error.text)
        self.error = error


def arguments(b: Routine, *operands: Place | bytes) -> tuple[tuple[Text, ...], list[Value]]:
    """String operands for a cold call: the constant ones as static texts, the others as addresses."""
    constants = tuple(operand if isinstance(operand, bytes) else None for operand in operands)
    nowhere = b.const(IrType.I32, _NOWHERE)
    return constants, [nowhere if isinstance(o, bytes) else b.address(o) for o in operands]


def read(runtime: Runtime, constant: Text, address: int) -> bytes:
    """The characters. Raises BadString when the string does not end in its area or is too long."""
    if constant is not None:
        return constant[1:]
    length = runtime.memory[address]
    if length > MAX_STRING or length + 1 > runtime.room(address):
        raise BadString(OPERAND_RANGE)
    return bytes(runtime.memory[address + 1 : address + 1 + length])


def write(runtime: Runtime, address: int, characters: bytes) -> None:
    """Store a string. Raises BadString when it has no room."""
    if len(characters) > MAX_STRING or len(characters) + 1 > runtime.room(address):
        raise BadString(OPERAND_RANGE)
    runtime.memory[address] = len(characters)
    runtime.memory[address + 1 : address + 1 + len(characters)] = characters


class _Cold(Protocol):
    def __call__(self, runtime: Runtime, *arguments: Any) -> Outcome: ...


def outcome(function: Callable[..., Outcome]) -> _Cold:
    """Decorator of a cold function: BadString becomes the run-time error it names."""

    @wraps(function)
    def run(runtime: Runtime, *arguments: Any) -> Outcome:
        try:
            return function(runtime, *arguments)
        except BadString as bad:
            return bad.error

    return cast(_Cold, run)
