"""The OpenAPI text of the web server, made from its endpoints. Source: OpenAPI 3.1.0."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, Final

from pcaccess import __version__
from pcaccess.web.answers import JSON_TYPE, TEXT_TYPE
from pcaccess.web.endpoints import Endpoint
from pcaccess.web.refusals import KINDS, MEDIA_TYPE
from pcaccess.web.shapes import COMPONENTS, TEXT, named

ALWAYS: Final = ("cross-site", "wrong-host", "internal")
"""Refusals that any request may get."""
_ABOUT: Final = (
    "Items of S7-200 PLCs over HTTP. Refusals are problem JSON (RFC 9457) whose `detail` is for people. Changes are "
    "sent over the websocket at `/ws`, which OpenAPI cannot describe."
)


def openapi(endpoints: Sequence[Endpoint]) -> dict[str, Any]:
    """The whole document as JSON data."""
    paths: dict[str, dict[str, Any]] = {}
    for endpoint in endpoints:
        path = endpoint.path.replace(":path", "")
        paths.setdefault(path, {})[endpoint.method.lower()] = _operation(endpoint, path)
    return {
        "openapi": "3.1.0",
        "info": {"title": "pcaccess", "version": __version__, "description": _ABOUT},
        "paths": paths,
        "components": {"schemas": COMPONENTS},
    }


def _operation(endpoint: Endpoint, path: str) -> dict[str, Any]:
    good = {"content": {endpoint.media_type: {"schema": endpoint.answer}}}
    responses: dict[str, Any] = {"200": {"description": endpoint.summary, **good}}
    for status, meaning in endpoint.statuses.items():
        responses[str(status)] = {"description": meaning, **good}
    for kind in dict.fromkeys((*endpoint.refusals, *(("only-reading",) if endpoint.changes else ()), *ALWAYS)):
        number = str(KINDS[kind].status)
        known = responses.get(number)
        title = f"{known['description']}; or {KINDS[kind].title}" if known else KINDS[kind].title
        responses[number] = {"description": title, "content": {MEDIA_TYPE: {"schema": named("Problem")}}}
    in_path = [{"name": name, "in": "path", "required": True, "schema": TEXT} for name in re.findall(r"{(\w+)}", path)]
    in_query = [
        {"name": p.name, "in": "query", "description": p.description, "schema": dict(p.schema)}
        for p in endpoint.parameters
    ]
    operation: dict[str, Any] = {
        "operationId": re.sub(r"\W+", "_", f"{endpoint.method.lower()}{path}").strip("_"),
        "summary": endpoint.summary,
        "parameters": in_path + in_query,
        "responses": responses,
    }
    if endpoint.description:
        operation["description"] = endpoint.description
    if endpoint.body is not None:
        content = {JSON_TYPE: {"schema": endpoint.body}}
        if endpoint.takes_text:
            content[TEXT_TYPE] = {"schema": TEXT}
        operation["requestBody"] = {"required": True, "content": content}
    return operation
