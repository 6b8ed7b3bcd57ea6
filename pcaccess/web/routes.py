"""From a request's path and method to its endpoint; every answer counted, every refusal an answer.

Starlette's own routing tries patterns one after the other and wraps each request several times, which costs more than
a bulk read of a thousand items. So paths that never vary are looked up; what is no endpoint goes on to Starlette.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from starlette.requests import ClientDisconnect, Request
from starlette.routing import compile_path
from starlette.types import ASGIApp, Receive, Scope, Send

from pcaccess.clock import Clock
from pcaccess.project.network import WebClients, is_loopback
from pcaccess.web.answers import Answer
from pcaccess.web.counts import Counts
from pcaccess.web.endpoints import Endpoint
from pcaccess.web.refusals import Refusal

log = logging.getLogger(__name__)


@dataclass(slots=True)
class _Path:
    """One path and what can be done with it."""

    shown: str
    """As counters and the OpenAPI text have it."""
    pattern: re.Pattern[str]
    methods: dict[str, Endpoint] = field(default_factory=dict)

    def allowed(self) -> str:
        return ", ".join(sorted({*self.methods, *(["HEAD"] if "GET" in self.methods else [])}))


class Routes:
    """The endpoints of one gateway. ``other``: the application for everything else."""

    def __init__(
        self, endpoints: Sequence[Endpoint], clients: WebClients, clock: Clock, counts: Counts, other: ASGIApp
    ) -> None:
        self._writers = clients is WebClients.WRITERS
        self._clock = clock
        self._counts = counts
        self._other = other
        paths: dict[str, _Path] = {}
        for endpoint in endpoints:
            if endpoint.path not in paths:
                paths[endpoint.path] = _Path(endpoint.path.replace(":path", ""), compile_path(endpoint.path)[0])
            paths[endpoint.path].methods[endpoint.method] = endpoint
        self._fixed = {text: path for text, path in paths.items() if "{" not in text}
        self._varying: dict[str, list[_Path]] = {}
        for text, path in paths.items():
            if "{" in text:
                self._varying.setdefault(text.partition("{")[0], []).append(path)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        path = self._path(scope) if scope["type"] == "http" else None
        if path is None:
            await self._other(scope, receive, send)
            return
        started = self._clock.monotonic()
        method = "GET" if scope["method"] == "HEAD" else scope["method"]
        endpoint = path.methods.get(method)
        if endpoint is None:
            method = "other"
            refusal = Refusal("method-not-allowed", f"this path takes {path.allowed()}")
            answer = refusal.answer([(b"allow", path.allowed().encode())])
        else:
            answer = await self._ask(endpoint, Request(scope, receive))
        self._counts.requests[method, path.shown, answer.status] += 1
        self._counts.seconds[method, path.shown] += self._clock.monotonic() - started
        await answer(scope, receive, send)

    def _path(self, scope: Scope) -> _Path | None:
        text = scope["path"]
        found = self._fixed.get(text)
        if found is not None:
            return found
        for beginning, paths in self._varying.items():
            if not text.startswith(beginning):
                continue
            for path in paths:
                match = path.pattern.match(text)
                if match is not None:
                    scope["path_params"] = match.groupdict()
                    return path
        return None

    async def _ask(self, endpoint: Endpoint, request: Request) -> Answer:
        try:
            if endpoint.changes and not self._writers and not _is_near(request):
                said = f"the project file says web_clients: {WebClients.READERS.value}"
                raise Refusal("only-reading", f"{said}; nothing was changed")
            return await endpoint.handler(request)
        except Refusal as refusal:
            return refusal.answer()
        except ClientDisconnect:
            return Answer(b"", status=400)  # nobody is there to read it
        except Exception:
            log.exception("%s %s failed", endpoint.method, request.url.path)
            return Refusal("internal", "see the gateway's log").answer()


def _is_near(request: Request) -> bool:
    """Whether it comes from this machine."""
    return request.client is not None and is_loopback(request.client.host)
