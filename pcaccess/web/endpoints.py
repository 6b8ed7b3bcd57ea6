"""What the web server answers to: one row per method and path, for routes and the OpenAPI text."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import orjson
from starlette.requests import ClientDisconnect, Request

from pcaccess.web.answers import JSON_TYPE, Answer
from pcaccess.web.guard import MAX_BODY
from pcaccess.web.refusals import Refusal

Handler = Callable[[Request], Awaitable[Answer]]


@dataclass(frozen=True, slots=True)
class Parameter:
    """A query parameter."""

    name: str
    description: str
    schema: Mapping[str, Any] = field(default_factory=lambda: {"type": "string"})


@dataclass(frozen=True, slots=True)
class Endpoint:
    """One thing that can be asked."""

    method: str
    path: str
    """With ``{name}`` or ``{name:path}`` where it varies."""
    handler: Handler
    summary: str
    answer: Mapping[str, Any]
    """JSON schema of a good answer, or ``{"type": "string"}`` for a text."""
    media_type: str = JSON_TYPE
    description: str = ""
    parameters: tuple[Parameter, ...] = ()
    body: Mapping[str, Any] | None = None
    """JSON schema of the request's body."""
    takes_text: bool = False
    """The body may be plain text instead."""
    changes: bool = False
    """It writes or sets something: only for those who may."""
    statuses: Mapping[int, str] = field(default_factory=dict)
    """Further good statuses with what they mean."""
    refusals: tuple[str, ...] = ()
    """Kinds of refusals that are its own."""


# ---------------------------------------------------------------------- what comes with a request


async def body_of(request: Request) -> bytes:
    """The whole body; refuses one over ``MAX_BODY`` before it has been stored."""
    receive = request.receive
    chunks, size = [], 0
    while True:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise ClientDisconnect
        chunk: bytes = message.get("body", b"")
        size += len(chunk)
        if size > MAX_BODY:
            raise Refusal("too-large", f"the body is longer than {MAX_BODY} bytes")
        chunks.append(chunk)
        if not message.get("more_body", False):
            return chunk if len(chunks) == 1 else b"".join(chunks)


def media_type_of(request: Request) -> str:
    """Without parameters, in small letters; empty when the request does not say."""
    for name, value in request.scope["headers"]:
        if name == b"content-type":
            text: str = value.decode("latin-1")
            return text.partition(";")[0].strip().lower()
    return ""


async def json_bytes(request: Request) -> bytes:
    """The body of a request that must be JSON, not yet read."""
    if media_type_of(request) != JSON_TYPE:
        raise Refusal("unsupported-type", f"send JSON, with the header Content-Type: {JSON_TYPE}")
    return await body_of(request)


def parse_json(data: bytes) -> Any:
    try:
        return orjson.loads(data)
    except orjson.JSONDecodeError as error:
        raise Refusal("bad-request", f"the body is not JSON: {error}") from None


def members(value: Any, /, **kinds: type | tuple[type, ...]) -> dict[str, Any]:
    """The members of a JSON object; refuses unknown ones and those of another kind."""
    if not isinstance(value, dict):
        raise Refusal("bad-request", f"expected an object with {' and '.join(kinds)}")
    for name, member in value.items():
        if name not in kinds:
            raise Refusal("bad-request", f"there is no member {name!r} here; expected {', '.join(kinds)}")
        wrong = not isinstance(member, kinds[name])
        # In Python true is an int; in JSON it is no number.
        if wrong or (isinstance(member, bool) and kinds[name] is not bool and kinds[name] is not object):
            raise Refusal("bad-request", f"{name} is of the wrong kind: {str(member)[:40]}")
    return value


def number_parameter(request: Request, name: str, default: int, low: int, high: int) -> int:
    """A whole number of the query."""
    text = request.query_params.get(name)
    if text is None:
        return default
    if not text.isascii() or not text.isdecimal() or not low <= int(text[:10]) <= high:
        raise Refusal("bad-request", f"{name}={text[:40]}: expected a whole number from {low} to {high}")
    return int(text)


def only_parameters(request: Request, *names: str) -> None:
    """Refuse query parameters that would be ignored; ``tick`` is free, for those who must ask anew."""
    if not request.scope["query_string"]:
        return
    for name in request.query_params:
        if name not in names and name != "tick":
            known = ", ".join((*names, "tick"))
            raise Refusal("bad-request", f"there is no parameter {name[:40]!r} here; expected {known}")
