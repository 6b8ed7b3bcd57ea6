"""Endpoints, hosts and TSAPs as a user writes them."""

from __future__ import annotations

import ipaddress
import re
from enum import Enum
from typing import Final
from urllib.parse import urlsplit


class NetworkError(ValueError):
    """The text is no such thing; the message says what was expected."""


class OpenEndpointError(NetworkError):
    """The endpoint could be reached from other machines; ``expected`` is one that could not."""

    def __init__(self, message: str, expected: str) -> None:
        super().__init__(message)
        self.expected = expected


class WebClients(Enum):
    """Who may use the web server, in the words of the project file."""

    THIS_MACHINE = "this machine"
    READERS = "anyone may read"
    WRITERS = "anyone may read and write"


DEFAULT_ENDPOINT: Final = "opc.tcp://127.0.0.1:4840/pcaccess"
DEFAULT_WEB: Final = "127.0.0.1:8080"
_OFF: Final = ("off", "false", "no")
_ON: Final = ("on", "true", "yes")
_HOST: Final = re.compile(r"[A-Za-z0-9]([A-Za-z0-9_-]*[A-Za-z0-9])?(\.[A-Za-z0-9]([A-Za-z0-9_-]*[A-Za-z0-9])?)*")
_TSAP: Final = re.compile(r"([0-9A-F]{2})\.?([0-9A-F]{2})", re.IGNORECASE)


def check_server_endpoint(text: str) -> str:
    """The endpoint of our own server. Raises OpenEndpointError when it is not on this machine alone."""
    host = check_endpoint(text)
    if not is_loopback(host):
        raise OpenEndpointError(
            f"{text} would be open to everybody on the network. This version has no users and no certificates, "
            "so it serves this machine only",
            DEFAULT_ENDPOINT,
        )
    return text


def parse_web(text: str) -> str | None:
    """``host:port`` of our own web server, None for ``off``."""
    word = text.strip().lower()
    if word in _OFF:
        return None
    if word in _ON:
        return DEFAULT_WEB
    host, _, port = text.strip().rpartition(":")
    if not _HOST.fullmatch(host) or not port.isdecimal() or int(port) > 65535:
        raise NetworkError(f"{text!r}; expected HOST:PORT such as {DEFAULT_WEB}, or off")
    return f"{host}:{port}"


def check_web(text: str, clients: WebClients = WebClients.THIS_MACHINE) -> str | None:
    """The same; raises OpenEndpointError when other machines reach it and ``clients`` does not say that they may."""
    place = parse_web(text)
    if place is not None and clients is WebClients.THIS_MACHINE and not is_loopback(place.rpartition(":")[0]):
        raise OpenEndpointError(
            f"{text} would be open to everybody on the network, without passwords or encryption; if that is wanted, "
            f"say so in the project file: server: web_clients: {WebClients.READERS.value}",
            DEFAULT_WEB,
        )
    return place


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
    return host.lower() == "localhost" or (is_address(host) and ipaddress.ip_address(host).is_loopback)


def is_address(host: str) -> bool:
    """Whether it is an IP address rather than a name."""
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True


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
