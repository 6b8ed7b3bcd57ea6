"""Endpoints, hosts and TSAPs as a user writes them."""

from __future__ import annotations

import ipaddress
import re
from typing import Final
from urllib.parse import urlsplit


class NetworkError(ValueError):
    """The text is no such thing; the message says what was expected."""


class OpenEndpointError(NetworkError):
    """The endpoint could be reached from other machines; ``expected`` is one that could not."""

    def __init__(self, message: str, expected: str) -> None:
        super().__init__(message)
        self.expected = expected


DEFAULT_WEB: Final = "127.0.0.1:8080"
_NO_USERS: Final = "This version has no users and no certificates, so it serves this machine only"
_OFF: Final = ("off", "false", "no")
_ON: Final = ("on", "true", "yes")
_HOST: Final = re.compile(r"[A-Za-z0-9]([A-Za-z0-9_-]*[A-Za-z0-9])?(\.[A-Za-z0-9]([A-Za-z0-9_-]*[A-Za-z0-9])?)*")
_TSAP: Final = re.compile(r"([0-9A-F]{2})\.?([0-9A-F]{2})", re.IGNORECASE)


def check_server_endpoint(text: str) -> str:
    """The endpoint of our own server. Raises OpenEndpointError when it is not on this machine alone."""
    host = check_endpoint(text)
    if not is_loopback(host):
        raise OpenEndpointError(
            f"{text} would be open to everybody on the network. {_NO_USERS}", "opc.tcp://127.0.0.1:4840/pcaccess"
        )
    return text


def check_web(text: str) -> str | None:
    """``host:port`` of our own web server, None for ``off``. Raises OpenEndpointError as above."""
    word = text.strip().lower()
    if word in _OFF:
        return None
    if word in _ON:
        return DEFAULT_WEB
    host, _, port = text.strip().rpartition(":")
    if not _HOST.fullmatch(host) or not port.isdecimal() or int(port) > 65535:
        raise NetworkError(f"{text!r}; expected HOST:PORT such as {DEFAULT_WEB}, or off")
    if not is_loopback(host):
        raise OpenEndpointError(f"{text} would be open to everybody on the network. {_NO_USERS}", DEFAULT_WEB)
    return f"{host}:{port}"


def check_endpoint(text: str) -> str:
    """The host of an OPC UA endpoint."""
    expected = "expected opc.tcp://HOST:PORT/PATH"
    try:
        parts = urlsplit(text)
        host, port = parts.hostname, parts.port
    except ValueError as error:
        raise NetworkError(f"{text!r}: {error}; {expected}") from None
    if parts.scheme != "opc.tcp" or not host or any(c.isspace() for c in text):
        raise NetworkError(f"{text!r} is not an endpoint; {expected}")
    if parts.username is not None or parts.query or parts.fragment:
        raise NetworkError(f"{text!r} has more than host, port and path; {expected}")
    if port is None:
        raise NetworkError(f"{text!r} has no port; {expected}, usually port 4840")
    return host


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach it."""
    if host.lower() == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def check_host(text: str) -> str:
    """A host name or IPv4 address; no IPv6, because ':' separates the parts of a run-time name."""
    if not _HOST.fullmatch(text):
        raise NetworkError(f"{text!r} is not a host name or an IPv4 address")
    return text


def check_listen(text: str, *, serial: bool) -> str:
    """``host:port``; where ``serial`` also a device or ``socket://host:port``."""
    place = text.removeprefix("socket://")
    if serial and place == text and text.strip():
        return text
    host, _, port = place.rpartition(":")
    if (serial or place == text) and _HOST.fullmatch(host) and port.isdecimal() and int(port) <= 65535:
        return text
    raise NetworkError(f"{text!r}; expected {'a serial device or socket://HOST:PORT' if serial else 'HOST:PORT'}")


def parse_tsap(text: str) -> int:
    """``10.01`` or ``1001`` to 0x1001."""
    match = _TSAP.fullmatch(text.strip())
    if match is None:
        raise NetworkError(f"{text!r} is not a TSAP; expected two bytes in hexadecimal such as 10.01")
    return int(match[1] + match[2], 16)
