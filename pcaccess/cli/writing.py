"""Values of users, written to items of a server."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from asyncua import ua
from asyncua.ua.status_codes import StatusCodes

from pcaccess.cli.names import Found, Target, Unknown, content, resolve
from pcaccess.cli.remote import Remote, connect, status_name, status_text
from pcaccess.cli.values import STRING, TYPES, ValueTextError, json_value, parse_value, value_text


@dataclass(frozen=True, slots=True)
class Written:
    """What became of one write; ``error`` says why it was not done."""

    item_id: str
    value: Any
    type: int
    status: int
    error: str | None = None

    @property
    def text(self) -> str:
        return f"{self.item_id} = {value_text(self.value, self.type)}"

    def as_json(self) -> dict[str, Any]:
        known = TYPES.get(self.type)
        done = {
            "id": self.item_id,
            "value": json_value(self.value, self.type),
            "type": known.name if known else None,
            "status": status_name(self.status),
        }
        return done | ({} if self.error is None else {"error": self.error})


async def write(url: str, wanted: Sequence[tuple[str, str]]) -> list[Written]:
    """Write each value text to its item, all in one go, in order; those that cannot be written hold up no other."""
    async with connect(url) as remote:
        found = await resolve(remote, [name for name, _ in wanted])
        results = [_prepare(one, text) for one, (_, text) in zip(found, wanted, strict=True)]
        ready = [(n, one) for n, one in enumerate(results) if not isinstance(one, Written)]
        statuses = await remote.write((target.node, variant) for _, (target, variant) in ready)
        for (n, (target, variant)), status in zip(ready, statuses, strict=True):
            error = await _why(remote, target, status) if status else None
            results[n] = Written(target.item_id, variant.Value, target.type, status, error)
        return [one for one in results if isinstance(one, Written)]


def _prepare(found: Found, text: str) -> Written | tuple[Target, ua.Variant]:
    """What to send, or why nothing can be."""
    if isinstance(found, Unknown):
        return Written(found.name, None, 0, found.status, found.message)
    if not found.is_item:
        message = f"{found.item_id} is no item; name one below it"
        return Written(found.item_id, None, 0, StatusCodes.BadNotWritable, message)
    kind = TYPES.get(found.type)
    if kind is None:
        message = f"{found.item_id} has a type that cannot be written from the command line"
        return Written(found.item_id, None, 0, StatusCodes.BadTypeMismatch, message)
    try:
        value = parse_value(text, kind, is_array=found.is_array)
    except ValueTextError as error:
        return Written(found.item_id, None, found.type, StatusCodes.BadTypeMismatch, f"{found.item_id}: {error}")
    return found, ua.Variant(value, ua.VariantType(found.type), is_array=found.is_array)


async def _why(remote: Remote, target: Target, status: int) -> str:
    """A refusal in words, with the limits when they were the reason."""
    words = f"{target.item_id}: {status_text(status)}"
    if status == StatusCodes.BadOutOfRange and target.type == STRING:
        return f"{words}: the text is too long for it, or has characters that a PLC does not (one byte each)"
    limits = remote.belonging(target.node, "EURange") if status == StatusCodes.BadOutOfRange else None
    if limits is None:
        return words
    (answer,) = await remote.read_values([limits])
    found = content(answer)
    return f"{words} (its engineering range is {found.Low:g} to {found.High:g})" if found is not None else words
