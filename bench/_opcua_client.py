"""The client of ``bench/opcua.py``: hand-made requests on a blocking socket, sixteen in flight, answers counted.

asyncua's client opens channel and session; from then on its socket and its channel's state are ours. A request is
made once and patched in place (sequence number, handle, time stamp, nodes, values). Encrypted requests are made ahead
of the measurement, since making one costs a client more than answering it may cost a server; their answers are
counted without being decrypted. Before each measurement one answer is read in full.
"""

from __future__ import annotations

import asyncio
import gc
import os
import socket
import struct
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from _opcua_servers import item_id
from asyncua import Client, ua
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256
from asyncua.ua.ua_binary import header_from_binary, nodeid_to_binary, struct_from_binary

IN_FLIGHT = 16
PATIENCE = 60.0
CLIENT_URI = "urn:pcaccess:bench:client"

_READ, _WRITE = b"\x01\x00\x77\x02", b"\x01\x00\xa1\x02"
_READ_ANSWER, _WRITE_ANSWER = b"\x01\x00\x7a\x02", b"\x01\x00\xa4\x02"
_ANSWERS = {_READ: _READ_ANSWER, _WRITE: _WRITE_ANSWER}
"""Encoding ids of the binary requests and responses, OPC UA part 6, annex A."""
_HEADER = 24
"""Bytes before the body in a message that is not encrypted: message, channel, token and sequence headers."""
_VALUE_ATTRIBUTE = struct.pack("<I", 13)
_NO_TEXT = b"\xff\xff\xff\xff"
_FLOAT, _INT16 = 10, 4

Fill = Callable[[bytearray, int], None]


class WrongAnswer(Exception):
    """The server answered something else than was asked for."""


@dataclass(frozen=True)
class Rate:
    """What one measurement found. ``busy``: the client's share of a core."""

    requests: float
    """Per second."""
    busy: float


@dataclass(frozen=True)
class Latency:
    """Of single requests, one at a time, in seconds."""

    p50: float
    p99: float


@dataclass(frozen=True)
class Request:
    """A message body after its RequestHeader. ``fill`` patches ``body`` for the n-th sending; None repeats it."""

    service: bytes
    body: bytes
    count: int
    fill: Fill | None = None
    start: int = 0


def node_ids(index: int, items: range) -> list[bytes]:
    texts = (item_id(n).encode() for n in items)
    return [b"\x03" + struct.pack("<HI", index, len(text)) + text for text in texts]


class Requests:
    """The requests of one server: its items under the index of its namespace."""

    def __init__(self, index: int, items: int) -> None:
        self.items = items
        self._random = np.random.default_rng(7)
        ids = node_ids(index, range(items))
        self._to_read = [i + _VALUE_ATTRIBUTE + _NO_TEXT + b"\x00\x00" + _NO_TEXT for i in ids]
        self._rows = np.frombuffer(b"".join(self._to_read), np.uint8).reshape(items, -1)
        self._pairs = _write_pairs([i + _VALUE_ATTRIBUTE + _NO_TEXT for i in ids])

    def read_one(self, *, repeated: bool) -> Request:
        """Never repeated: all nodes in random order, and another MaxAge each time round."""
        body = _read_body([self._to_read[0]])
        order = self._random.permutation(self.items).tolist()

        def fill(frame: bytearray, n: int) -> None:
            frame[-len(self._to_read[0]) :] = self._to_read[order[n % self.items]]
            struct.pack_into("<d", frame, len(frame) - len(body), float(n // self.items))

        return Request(_READ, body, 1, None if repeated else fill)

    def read_all(self, *, repeated: bool) -> Request:
        """Never repeated: another order each time."""
        body = _read_body(self._to_read)

        def fill(frame: bytearray, _n: int) -> None:
            frame[-self._rows.size :] = self._rows[self._random.permutation(self.items)].tobytes()

        return Request(_READ, body, self.items, None if repeated else fill)

    def write_one(self) -> Request:
        """A REAL, another one and another value each time."""
        float_item = self._pairs.dtype["real"].itemsize
        body = struct.pack("<i", 1) + self._pairs[0].tobytes()[:float_item]
        rows = [pair.tobytes()[: float_item - 4] for pair in self._pairs]

        def fill(frame: bytearray, n: int) -> None:
            frame[-float_item:-4] = rows[n % len(rows)]
            struct.pack_into("<f", frame, len(frame) - 4, n % 30000)

        return Request(_WRITE, body, 1, fill)

    def write_all(self) -> Request:
        """Another order and other values each time."""
        body = struct.pack("<i", self.items) + self._pairs.tobytes()
        pairs, ramp = self._pairs, np.arange(len(self._pairs))

        def fill(frame: bytearray, n: int) -> None:
            turned = pairs[self._random.permutation(len(pairs))]
            turned["real"]["value"] = turned["int"]["value"] = (ramp + n) % 30000
            frame[-pairs.nbytes :] = turned.tobytes()

        return Request(_WRITE, body, self.items, fill)


def _read_body(nodes: Sequence[bytes]) -> bytes:
    """MaxAge 0, source timestamps."""
    return struct.pack("<diI", 0.0, 0, len(nodes)) + b"".join(nodes)


def _write_pairs(heads: Sequence[bytes]) -> Any:
    """WriteValues, a Float and an Int16 side by side, so that all records are of one size."""
    size = len(heads[0])
    real = np.dtype([("head", f"V{size}"), ("mask", "u1"), ("type", "u1"), ("value", "<f4")])
    integer = np.dtype([("head", f"V{size}"), ("mask", "u1"), ("type", "u1"), ("value", "<i2")])
    pairs = np.zeros(len(heads) // 2, dtype=[("real", real), ("int", integer)])
    all_heads = np.frombuffer(b"".join(heads), dtype=f"V{size}")
    pairs["real"]["head"], pairs["int"]["head"] = all_heads[0::2], all_heads[1::2]
    pairs["real"]["mask"] = pairs["int"]["mask"] = 1
    pairs["real"]["type"], pairs["int"]["type"] = _FLOAT, _INT16
    return pairs


class Channel:
    """An open session on a socket of ours. ``certificates``: a folder with the client's; encrypts when given."""

    def __init__(self, url: str, certificates: Path | None = None) -> None:
        self._loop = asyncio.new_event_loop()
        self._secured = certificates is not None
        self._client = Client(url, timeout=PATIENCE, watchdog_intervall=3600)
        self._client.application_uri = CLIENT_URI
        self._loop.run_until_complete(asyncio.wait_for(self._connect(certificates), PATIENCE))
        protocol = self._client.uaclient.protocol
        self._connection = protocol._connection
        self._request_id = protocol._request_id + 10
        self._token = nodeid_to_binary(protocol.authentication_token)
        # The loop stands still from here on: nobody else reads or writes this socket.
        self._transport = protocol.transport
        self._socket = socket.socket(fileno=os.dup(self._transport.get_extra_info("socket").fileno()))
        self._socket.setblocking(True)  # a timeout of Python's would cost a poll per call; the kernel's is free
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("ll", int(PATIENCE), 0))
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", int(PATIENCE), 0))
        self._in = bytearray(1 << 20)
        self._filled = 0
        self._middle = False

    async def _connect(self, certificates: Path | None) -> None:
        if certificates is not None:
            await self._client.set_security(
                SecurityPolicyBasic256Sha256,
                str(certificates / "client.der"),
                str(certificates / "client.pem"),
                mode=ua.MessageSecurityMode.SignAndEncrypt,
            )
        await self._client.connect()

    def close(self) -> None:
        self._socket.close()
        self._transport.abort()
        for task in asyncio.all_tasks(self._loop):
            task.cancel()
        self._loop.run_until_complete(asyncio.sleep(0))
        self._loop.close()

    # ------------------------------------------------------------------ one request

    def _header(self, request: Request) -> tuple[bytes, int]:
        """RequestHeader with type id, and where its time stamp stands in it."""
        start = request.service + self._token
        ticks = int((datetime.now(UTC) - datetime(1601, 1, 1, tzinfo=UTC)).total_seconds() * 10_000_000)
        rest = struct.pack("<qII", ticks, 0, 0) + _NO_TEXT + struct.pack("<I", 60_000) + b"\x00\x00\x00"
        return start + rest, len(start)

    def _frame(self, request: Request) -> tuple[bytearray, int]:
        """The whole message and the place of its time stamp."""
        header, stamp = self._header(request)
        body = header + request.body
        size = _HEADER + len(body)
        if not self._secured and size > self._connection._limits.max_send_buffer:
            raise WrongAnswer(f"the server takes chunks of {self._connection._limits.max_send_buffer} bytes only")
        token = self._connection.security_token
        start = b"MSGF" + struct.pack("<IIIII", size, token.ChannelId, token.TokenId, 0, 0)
        return bytearray(start + body), _HEADER + stamp

    def _maker(self, request: Request) -> Callable[[int], bytes | bytearray]:
        """Makes the n-th message to send; the one before must have been sent or copied."""
        frame, stamp = self._frame(request)
        fill, connection = request.fill, self._connection
        pack_numbers, pack_handle = struct.Struct("<II").pack_into, struct.Struct("<I").pack_into
        pack_stamp, first_tick = struct.Struct("<q").pack_into, struct.unpack_from("<q", frame, stamp)[0]
        handle = stamp + 8

        def make(n: int) -> bytes | bytearray:
            self._request_id += 1
            pack_stamp(frame, stamp, first_tick + n)
            pack_handle(frame, handle, n)
            if fill is not None:
                fill(frame, n)
            if self._secured:
                sealed: bytes = connection.message_to_binary(bytes(frame[_HEADER:]), request_id=self._request_id)
                return sealed
            connection._sequence_number += 1
            pack_numbers(frame, 16, connection._sequence_number, self._request_id)
            return frame

        return make

    def check(self, request: Request) -> None:
        """Send it once and read the answer in full. Raises WrongAnswer."""
        self._socket.sendall(self._maker(request)(0))
        message = None
        self._connection._peer_sequence_number = None
        while message is None:
            start = self._receive(8)
            whole = start + self._receive(struct.unpack_from("<I", start, 4)[0] - 8)
            buffer = ua.utils.Buffer(whole)
            message = self._connection.receive_from_header_and_body(header_from_binary(buffer), buffer)
        if isinstance(message, ua.ErrorMessage):
            raise WrongAnswer(f"the server closed: {message.Error} {message.Reason}")
        body = message.body()
        if body.copy(4).read(4) != _ANSWERS[request.service]:
            raise WrongAnswer(str(struct_from_binary(ua.ServiceFault, body).ResponseHeader.ServiceResult))
        kind = ua.ReadResponse if request.service == _READ else ua.WriteResponse
        results = struct_from_binary(kind, body).Results
        if len(results) != request.count:
            raise WrongAnswer(f"{len(results)} results for {request.count}")
        for result in results:
            if request.service == _WRITE:
                result.check()
                continue
            if result.StatusCode is not None:
                result.StatusCode.check()
            if result.Value is None:
                raise WrongAnswer("a result without a value")

    def _receive(self, size: int) -> bytes:
        data = b""
        while len(data) < size:
            more = self._socket.recv(size - len(data))
            if not more:
                raise WrongAnswer("the server closed the connection")
            data += more
        return data

    # ------------------------------------------------------------------ many

    def rate(self, request: Request, seconds: float, ahead: int = 0) -> Rate:
        """Keep sixteen in flight for a while. ``ahead``: most messages to make beforehand, when encrypted."""
        self.check(request)
        make: Callable[[int], bytes | bytearray] = self._maker(request)
        most, sequence = 1 << 60, self._connection._sequence_number
        if self._secured:
            most = max(ahead, IN_FLIGHT)
            make = [bytes(make(n)) for n in range(most)].__getitem__
            chunks = (self._connection._sequence_number - sequence) // most
        answer = _ANSWERS[request.service]
        gc.collect()
        gc.disable()
        try:
            began, used = time.perf_counter(), time.process_time()
            self._socket.sendall(b"".join([bytes(make(n)) for n in range(IN_FLIGHT)]))
            sent, answered, end = IN_FLIGHT, 0, began + seconds
            while answered < sent:
                done = self._count(answer)
                answered += done
                if time.perf_counter() < end:
                    todo = range(sent, min(sent + done, most))
                    self._socket.sendall(b"".join([bytes(make(n)) for n in todo]))
                    sent += len(todo)
            passed = time.perf_counter() - began
            if self._secured:  # what was made and not sent must not leave a gap
                self._connection._sequence_number = sequence + sent * chunks
            return Rate(answered / passed, (time.process_time() - used) / passed)
        finally:
            gc.enable()

    def _count(self, answer: bytes) -> int:
        """Wait for something and count the messages that are complete with it. Raises WrongAnswer."""
        buffer, at, done = self._in, 0, 0
        with memoryview(buffer) as view:
            got = self._socket.recv_into(view[self._filled :])
        # The kernel forgets this at will. Without it a server that leaves Nagle's algorithm on (node-opcua) waits 40 ms
        # for an acknowledgement after every few small answers.
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
        if not got:
            raise WrongAnswer("the server closed the connection")
        filled = self._filled + got
        while filled - at >= 8:
            size = int.from_bytes(buffer[at + 4 : at + 8], "little")
            if filled - at < size:
                break
            if buffer[at : at + 3] != b"MSG":
                raise WrongAnswer(f"{bytes(buffer[at : at + min(size, 200)])!r}")
            if not self._secured and not self._middle:
                good = buffer[at + 24 : at + 28] == answer and buffer[at + 40 : at + 44] == b"\x00\x00\x00\x00"
                if not good:
                    raise WrongAnswer("a fault instead of an answer")
            self._middle = buffer[at + 3] == ord("C")
            done += not self._middle
            at += size
        buffer[: filled - at] = buffer[at:filled]
        self._filled = filled - at
        return done

    def latency(self, request: Request, seconds: float) -> Latency:
        """One at a time for a while."""
        self.check(request)
        make, answer, times = self._maker(request), _ANSWERS[request.service], []
        gc.disable()
        try:
            end, n = time.perf_counter() + seconds, 0
            while (now := time.perf_counter()) < end:
                message = make(n)
                now = time.perf_counter()
                self._socket.sendall(message)
                while not self._count(answer):
                    pass
                times.append(time.perf_counter() - now)
                n += 1
        finally:
            gc.enable()
        times.sort()
        return Latency(times[len(times) // 2], times[int(len(times) * 0.99)])
