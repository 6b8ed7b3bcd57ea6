"""What is sent back: bytes with their headers made ready beforehand, because thousands a second go out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import orjson
from starlette.types import Receive, Scope, Send

JSON_TYPE: Final = "application/json"
TEXT_TYPE: Final = "text/plain"
_ALWAYS: Final = (
    (b"cache-control", b"no-store"),
    (b"x-content-type-options", b"nosniff"),
    (b"cross-origin-resource-policy", b"same-origin"),
)
"""Of every answer: it is true only now, it is what it says, and it is for our own pages."""

Headers = Sequence[tuple[bytes, bytes]]


class Answer:
    """A whole answer. ``more``: headers beside type and length."""

    __slots__ = ("body", "headers", "status")

    def __init__(self, body: bytes, media_type: str = JSON_TYPE, status: int = 200, more: Headers = ()) -> None:
        self.status = status
        self.body = body
        self.headers = [
            (b"content-type", media_type.encode("latin-1")),
            (b"content-length", b"%d" % len(body)),
            *_ALWAYS,
            *more,
        ]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """As the framework wants it."""
        await send({"type": "http.response.start", "status": self.status, "headers": self.headers})
        await send({"type": "http.response.body", "body": b"" if scope["method"] == "HEAD" else self.body})


def json_answer(value: Any, status: int = 200) -> Answer:
    """Anything as JSON."""
    return Answer(orjson.dumps(value), status=status)
