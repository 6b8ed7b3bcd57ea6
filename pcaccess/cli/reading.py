"""Samples of items, read from a server."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from asyncua import ua
from asyncua.ua.status_codes import StatusCodes

from pcaccess.cli.names import Found, Target, Unknown, content, expand, status_of
from pcaccess.cli.remote import Remote, connect, status_name, status_text
from pcaccess.cli.samples import SHARED, Shown, derived_quality
from pcaccess.items.quality import Quality

_OF_SAMPLES: Final = frozenset(quality.status() for quality in Quality)
"""StatusCodes that say how good a value is; any other in place of a value says that there was nothing to read."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What reading a name gave; ``error`` says why it gave no sample."""

    sample: Shown
    error: str | None = None
    is_failure: bool = False
    """An item that can only be written is none where nobody named it: it came with its branch."""

    def as_json(self) -> dict[str, Any]:
        return self.sample.as_json() | ({} if self.error is None else {"error": self.error})


async def read(url: str, names: Sequence[str]) -> list[Answer]:
    """Samples of the items that the names stand for."""
    async with connect(url) as remote:
        return await read_found(remote, await expand(remote, names))


async def read_found(remote: Remote, found: Sequence[Found]) -> list[Answer]:
    """Samples of items, in order; what is unknown stays what it is."""
    targets = [one for one in found if isinstance(one, Target)]
    values = await remote.read_values(target.node for target in targets)
    codes = await read_qualities(remote, targets)
    answers = iter([answer(*one) for one in zip(targets, values, codes, strict=True)])
    return [unknown(one) if isinstance(one, Unknown) else next(answers) for one in found]


async def read_qualities(remote: Remote, targets: Sequence[Target]) -> list[int | None]:
    """The items' own ``Quality``; None where the server has none."""
    nodes = [remote.belonging(target.node, "Quality") for target in targets]
    values = iter(await remote.read_values(node for node in nodes if node is not None))
    return [None if node is None else content(next(values)) for node in nodes]


def answer(target: Target, value: ua.DataValue, quality: int | None) -> Answer:
    sample = shown(target, value, quality)
    if sample.value is None and sample.status & 0xFFFF0000 not in _OF_SAMPLES:
        is_failure = target.is_named or not is_write_only(sample.status)
        return Answer(sample, f"{target.item_id}: {status_text(sample.status)}", is_failure)
    return Answer(sample)


def unknown(name: Unknown) -> Answer:
    quality = derived_quality(name.status)
    return Answer(Shown(name.name, None, 0, quality, name.status, status_name(name.status), None), name.message, True)


def shown(target: Target, value: ua.DataValue, quality: int | None = None) -> Shown:
    """A value of the server as the command shows it; ``quality`` where the item itself said it."""
    status = status_of(value)
    kind = int(value.Value.VariantType.value) if value.Value is not None else 0
    return Shown(
        target.item_id,
        content(value),
        kind or target.type,
        derived_quality(status) if quality is None else quality,
        status,
        status_name(status),
        value.SourceTimestamp,
    )


def is_write_only(status: int) -> bool:
    """Whether the server says that the item can only be written."""
    return status & 0xFFFF0000 == StatusCodes.BadNotReadable


def needs_quality(value: ua.DataValue) -> bool:
    """Whether the StatusCode alone does not say which quality it is."""
    return status_of(value) & 0xFFFF0000 in SHARED
