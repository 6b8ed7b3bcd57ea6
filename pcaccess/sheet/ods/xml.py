"""XML as text: elements from names, attributes and content."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final
from xml.sax.saxutils import escape

HEAD: Final = '<?xml version="1.0" encoding="UTF-8"?>\n'
_UNFIT: Final = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 cannot hold."""


def text(value: str) -> str:
    """A text as content of an element."""
    return escape(_UNFIT.sub("\ufffd", value))


def attribute(value: str) -> str:
    return escape(_UNFIT.sub("\ufffd", value), {'"': "&quot;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"})


def element(name: str, attributes: Mapping[str, object] | None = None, *content: str) -> str:
    """``content`` is XML already. An attribute that is None is left out."""
    pairs = (attributes or {}).items()
    head = name + "".join(f' {key}="{attribute(str(value))}"' for key, value in pairs if value is not None)
    inside = "".join(content)
    return f"<{head}>{inside}</{name}>" if inside else f"<{head}/>"
