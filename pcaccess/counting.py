"""Numbers of things in words, singular and plural."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

_PLURALS: Final = MappingProxyType({"plcs": "PLCs"})


def counted(counts: Mapping[str, int], *names: str) -> str:
    """``1 link, 2 PLCs, 14 items``; what there is none of is left out."""
    return ", ".join(_number(counts[name], name) for name in names if counts.get(name))


def _number(count: int, name: str) -> str:
    words = _PLURALS.get(name, name)
    return f"{count:,} {words.removesuffix('s') if count == 1 else words}"
