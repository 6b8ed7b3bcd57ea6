"""A client that costs little: requests ready as bytes, answers counted and thrown away. For benches only."""

from __future__ import annotations

import asyncio
import base64
import os
import struct
import time
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Target:
    """Where a server of a bench listens."""

    host: str
    port: int


def request_bytes(target: Target, method: str, path: str, body: bytes = b"") -> bytes:
    head = f"{method} {path} HTTP/1.1\r\nHost: {target.host}:{target.port}\r\n"
    if body:
        head += f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n"
    return head.encode() + b"\r\n" + body


class _Asker(asyncio.Protocol):
    """Sends one request again and again until the time is over."""

    def __init__(self, request: bytes, until: float) -> None:
        self.answers = 0
        self.done: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._request = request
        self._until = until
        self._missing = -1
        self._head = b""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        transport.write(self._request)

    def data_received(self, data: bytes) -> None:
        if self._missing < 0:
            self._head += data
            end = self._head.find(b"\r\n\r\n")
            if end < 0:
                return
            if not self._head.startswith((b"HTTP/1.1 200", b"HTTP/1.1 207")):
                self.done.set_exception(RuntimeError(self._head[:300].decode()))
                self._transport.close()
                return
            length = int(self._head[:end].lower().partition(b"content-length:")[2].split(None, 1)[0])
            self._missing = length - (len(self._head) - end - 4)
        else:
            self._missing -= len(data)
        if self._missing == 0:
            self.answers += 1
            self._missing, self._head = -1, b""
            if time.perf_counter() < self._until:
                self._transport.write(self._request)
            elif not self.done.done():
                self._transport.close()
                self.done.set_result(None)


async def rate(target: Target, request: bytes, seconds: float, connections: int) -> float:
    """Answers per second over so many connections, each asking as soon as it was answered."""
    loop = asyncio.get_running_loop()
    started = time.perf_counter()
    askers = [
        (await loop.create_connection(lambda: _Asker(request, started + seconds), target.host, target.port))[1]
        for _ in range(connections)
    ]
    await asyncio.gather(*(asker.done for asker in askers))
    return sum(asker.answers for asker in askers) / (time.perf_counter() - started)


async def fetch(target: Target, request: bytes) -> bytes:
    """The body of one answer."""
    reader, writer = await asyncio.open_connection(target.host, target.port)
    writer.write(request)
    head = await reader.readuntil(b"\r\n\r\n")
    length = int(head.lower().partition(b"content-length:")[2].split(None, 1)[0])
    body = await reader.readexactly(length)
    writer.close()
    return body


class Socket:
    """A websocket that takes text messages; nothing of it is checked."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader = reader
        self._writer = writer

    @classmethod
    async def open(cls, target: Target, path: str) -> Socket:
        reader, writer = await asyncio.open_connection(target.host, target.port, limit=2**22)
        key = base64.b64encode(os.urandom(16)).decode()
        writer.write(
            f"GET {path} HTTP/1.1\r\nHost: {target.host}:{target.port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        head = await reader.readuntil(b"\r\n\r\n")
        if not head.startswith(b"HTTP/1.1 101"):
            raise RuntimeError(head.decode())
        return cls(reader, writer)

    async def send(self, text: bytes) -> None:
        """RFC 6455, 5.2: a final text frame, masked with zeros."""
        length = struct.pack("!BH", 0x80 | 126, len(text)) if len(text) < 2**16 else struct.pack("!BQ", 0xFF, len(text))
        self._writer.write(b"\x81" + length + bytes(4) + text)
        await self._writer.drain()

    async def receive(self) -> bytes:
        """The next text message; pings are ignored."""
        while True:
            kind, short = await self._reader.readexactly(2)
            length = short
            if short == 126:
                (length,) = struct.unpack("!H", await self._reader.readexactly(2))
            elif short == 127:
                (length,) = struct.unpack("!Q", await self._reader.readexactly(8))
            body = await self._reader.readexactly(length)
            if kind == 0x81:
                return body

    def close(self) -> None:
        self._writer.close()
