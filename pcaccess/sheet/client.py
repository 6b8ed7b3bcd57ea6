"""The gateway's REST interface as spreadsheets use it: one connection, JSON, and errors in words.

Units:    times are UTC.
Errors:   :class:`Gone`, the gateway does not answer (it may come back); :class:`Refused`, it answers that it will not.
Source:   docs/rest.md; RFC 9457 for the refusals.
"""

from __future__ import annotations

import base64
import http.client
import json
from collections.abc import Sequence
from typing import Any, Final
from urllib.parse import unquote, urlsplit

from pcaccess.sheet.entries import SheetError

TIMEOUT: Final = 10.0
"""Seconds; longer than the gateway itself waits for a PLC."""


class Gone(SheetError):
    """The gateway does not answer."""


class Refused(SheetError):
    """The gateway, or what answers in its place, does not do it. ``status`` is that of HTTP."""

    def __init__(self, message: str, status: int) -> None:
        super().__init__(message)
        self.status = status


def check_gateway(url: str) -> str:
    """``http://host:port`` without a slash at its end. Raises SheetError."""
    expected = "expected http://HOST:PORT, as `pcaccess run` prints it"
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError as error:
        raise SheetError(f"{url}: {error}; {expected}") from None
    if parts.scheme == "opc.tcp":
        raise SheetError(f"{url} is the OPC UA endpoint; spreadsheets use the web server: {expected}")
    if parts.scheme != "http" or not host or parts.path.strip("/") or parts.query or parts.fragment:
        raise SheetError(f"{url} is not the address of a gateway; {expected}")
    access = f"{parts.username}:{parts.password or ''}@" if parts.username else ""
    return f"http://{access}{host}" + (f":{port}" if port else "")


class GatewayClient:
    """Talks to one gateway; the connection is made when it is needed, and again after it broke."""

    def __init__(self, url: str, timeout: float = TIMEOUT) -> None:
        self.url = check_gateway(url)
        parts = urlsplit(self.url)
        self._host, self._port = parts.hostname or "", parts.port or 80
        self._headers = {"Accept": "application/json"}
        if parts.username:
            access = f"{unquote(parts.username)}:{unquote(parts.password or '')}"
            self._headers["Authorization"] = "Basic " + base64.b64encode(access.encode()).decode()
        self._timeout = timeout
        self._connection: http.client.HTTPConnection | None = None

    def close(self) -> None:
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    def get(self, path: str) -> Any:
        """JSON at a path."""
        return self._ask("GET", path, None)

    def read(self, item_ids: Sequence[str]) -> list[dict[str, Any]]:
        """A sample of each item, in order; one that cannot be read has an ``error``."""
        body = json.dumps({"items": list(item_ids)}).encode()
        samples: list[dict[str, Any]] = self._ask("POST", "/api/read", body)["samples"]
        return samples

    def _ask(self, method: str, path: str, body: bytes | None) -> Any:
        status, media_type, data = self._exchange(method, path, body)
        try:
            answer = json.loads(data) if "json" in media_type else None
        except ValueError:
            answer = None
        if status < 300 and answer is not None:
            return answer
        if isinstance(answer, dict) and "detail" in answer:
            raise Refused(f"{self.url}: {answer['detail']}", status)
        if status in (401, 407):
            raise Refused(
                f"{self.url} wants a user name and a password (http://USER:PASSWORD@HOST:PORT), or those are wrong; "
                "pcaccess itself has no users yet: is it another server?",
                status,
            )
        raise Refused(f"{self.url} answers ({status}), but not as pcaccess does; is the port right?", status)

    def _exchange(self, method: str, path: str, body: bytes | None) -> tuple[int, str, bytes]:
        # A connection that was idle may have been closed at the other end: that is found out by using it, once.
        for fresh in (self._connection is None, True):
            if self._connection is None:
                self._connection = http.client.HTTPConnection(self._host, self._port, timeout=self._timeout)
            headers = self._headers if body is None else {**self._headers, "Content-Type": "application/json"}
            try:
                self._connection.request(method, path, body, headers)
                response = self._connection.getresponse()
                return response.status, response.headers.get("Content-Type", ""), response.read()
            except (OSError, http.client.HTTPException) as error:
                self.close()
                if fresh or isinstance(error, TimeoutError):
                    raise Gone(self._silence(error)) from None
        raise AssertionError("the second attempt answers or raises")

    def _silence(self, error: Exception) -> str:
        if isinstance(error, http.client.HTTPException) and not isinstance(error, http.client.RemoteDisconnected):
            return f"{self.url} answers, but not as a web server does; is the port right?"
        if isinstance(error, TimeoutError):
            return f"{self.url} did not answer within {self._timeout:g} s"
        why = getattr(error, "strerror", None)
        return f"{self.url} does not answer{f' ({why})' if why else ''}; is `pcaccess run` running there?"
