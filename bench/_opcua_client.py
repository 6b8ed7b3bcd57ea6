"""The client of ``bench/opcua.py``: hand-made requests on a blocking socket, many in flight, answers counted.

asyncua's client opens channel and session; from then on its socket and its channel's state are ours. Requests are
rows of an array that are filled in column by column (sequence number, handle, time stamp, nodes, values), many at
once, so that the client costs less than any server. Encrypted requests are made ahead of the measurement, since making
one costs a client more than answering it may cost a server; their answers are counted without being decrypted. Before
each measurement one answer is read in full.
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
from numpy.typing import NDArray

IN_FLIGHT, IN_FLIGHT_SINGLE = 16, 64
"""Requests for many nodes, and for one. Sixteen small ones leave every server waiting for the client's wake-ups."""
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

_START = struct.Struct("<4sI")
"""Message and chunk type, size."""
_ANSWER = struct.Struct("<4sI16x4s12xI")
"""The same, and the type and service result of a response that is not encrypted."""
_BLOCK = 1 << 18
"""Bytes of requests that are made at once, about."""

Rows = NDArray[np.uint8]
Fill = Callable[[Rows, NDArray[np.int64]], None]


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
    """A message body after its RequestHeader.

    ``fill`` patches whole messages that end with ``body``, given which sending each row is; None repeats it.
    """

    service: bytes
    body: bytes
    count: int
    fill: Fill | None = None


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
        self._nodes = np.frombuffer(b"".join(self._to_read), np.uint8).reshape(items, -1)
        self._pairs = _write_pairs([i + _VALUE_ATTRIBUTE + _NO_TEXT for i in ids])

    def read_one(self, *, repeated: bool) -> Request:
        """Never repeated: all nodes in random order, and another MaxAge each time round."""
        body = _read_body([self._to_read[0]])
        nodes = self._nodes[self._random.permutation(self.items)]
        width = nodes.shape[1]

        def fill(rows: Rows, numbers: NDArray[np.int64]) -> None:
            rounds, places = np.divmod(numbers, self.items)
            rows[:, -width:] = nodes[places]
            first = rows.shape[1] - len(body)
            rows[:, first : first + 8] = _bytes_of(rounds.astype("<f8"))

        return Request(_READ, body, 1, None if repeated else fill)

    def read_all(self, *, repeated: bool) -> Request:
        """Never repeated: another order each time."""
        body = _read_body(self._to_read)
        nodes = self._nodes.view(f"V{self._nodes.shape[1]}")[:, 0]

        def fill(rows: Rows, _numbers: NDArray[np.int64]) -> None:
            for row in rows:
                row[-self._nodes.size :] = nodes.take(self._random.permutation(self.items)).view(np.uint8)

        return Request(_READ, body, self.items, None if repeated else fill)

    def write_one(self) -> Request:
        """A REAL, another one and another value each time."""
        float_item = self._pairs.dtype["real"].itemsize
        whole = self._pairs.view(np.uint8).reshape(len(self._pairs), -1)
        body = struct.pack("<i", 1) + whole[0].tobytes()[:float_item]
        nodes = whole[:, : float_item - 4]

        def fill(rows: Rows, numbers: NDArray[np.int64]) -> None:
            rows[:, -float_item:-4] = nodes[numbers % len(nodes)]
            rows[:, -4:] = _bytes_of((numbers % 30000).astype("<f4"))

        return Request(_WRITE, body, 1, fill)

    def write_all(self) -> Request:
        """Another order and other values each time."""
        body = struct.pack("<i", self.items) + self._pairs.tobytes()
        pairs, ramp = self._pairs, np.arange(len(self._pairs))

        def fill(rows: Rows, numbers: NDArray[np.int64]) -> None:
            for row, n in zip(rows, numbers.tolist(), strict=True):
                turned = pairs.take(self._random.permutation(len(pairs)))
                turned["real"]["value"] = turned["int"]["value"] = (ramp + n) % 30000
                row[-pairs.nbytes :] = turned.view(np.uint8)

        return Request(_WRITE, body, self.items, fill)


def _bytes_of(column: NDArray[Any]) -> Rows:
    """A row of bytes per number."""
    return column.view(np.uint8).reshape(len(column), -1)


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

    def _maker(self, request: Request) -> Callable[[int, int], Rows]:
        """Makes messages ``first`` to ``first + count``, in sending order; the array is used again for the next."""
        frame, stamp = self._frame(request)
        first_tick = struct.unpack_from("<q", frame, stamp)[0]
        rows = np.zeros((0, len(frame)), np.uint8)

        def make(first: int, count: int) -> Rows:
            nonlocal rows
            if len(rows) < count:
                rows = np.tile(np.frombuffer(frame, np.uint8), (count, 1))
            wanted, numbers = rows[:count], np.arange(first, first + count)
            sequence = np.arange(1, count + 1, dtype="<u4")
            wanted[:, 16:20] = _bytes_of(sequence + np.uint32(self._connection._sequence_number))
            wanted[:, 20:24] = _bytes_of(sequence + np.uint32(self._request_id))
            wanted[:, stamp : stamp + 8] = _bytes_of((numbers + first_tick).astype("<i8"))
            wanted[:, stamp + 8 : stamp + 12] = _bytes_of(numbers.astype("<u4"))
            if request.fill is not None:
                request.fill(wanted, numbers)
            self._request_id += count
            self._connection._sequence_number += count
            return wanted

        return make

    def _sealer(self, request: Request) -> Callable[[int], bytes]:
        """Makes the n-th message as it goes over an encrypted channel."""
        make = self._maker(request)

        def seal(n: int) -> bytes:
            sequence = self._connection._sequence_number
            plain = make(n, 1)[0, _HEADER:].tobytes()
            self._connection._sequence_number = sequence
            sealed: bytes = self._connection.message_to_binary(plain, request_id=self._request_id)
            return sealed

        return seal

    def _one(self, request: Request) -> Callable[[int], bytes | memoryview]:
        """Makes the n-th message as it goes on the wire."""
        if self._secured:
            return self._sealer(request)
        make = self._maker(request)
        return lambda n: make(n, 1).data.cast("B")

    def check(self, request: Request) -> None:
        """Send it once and read the answer in full. Raises WrongAnswer."""
        self._socket.sendall(self._one(request)(0))
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
        """Keep many in flight for a while. ``ahead``: most messages to make beforehand, when encrypted."""
        self.check(request)
        answer = _ANSWERS[request.service]
        send = self._send_ahead(request, ahead) if self._secured else self._send_rows(request)
        gc.collect()
        gc.disable()
        try:
            began, used = time.perf_counter(), time.process_time()
            sent, answered, end = send(_in_flight(request)), 0, began + seconds
            while answered < sent:
                done = self._count(answer)
                answered += done
                if time.perf_counter() < end:
                    sent += send(done)
            passed = time.perf_counter() - began
            return Rate(answered / passed, (time.process_time() - used) / passed)
        finally:
            send(-1)
            gc.enable()

    def _send_rows(self, request: Request) -> Callable[[int], int]:
        """Sends so many more messages; a negative number ends it."""
        make = self._maker(request)
        size = len(self._frame(request)[0])
        at_once = max(_in_flight(request), _BLOCK // size)
        first, left = 0, memoryview(b"")

        def send(count: int) -> int:
            nonlocal first, left
            if count < 0:  # what was made and not sent must not leave a gap
                self._connection._sequence_number -= len(left) // size
                return 0
            wanted = count * size
            while wanted:
                if not left:
                    left = make(first, at_once).data.cast("B")
                    first += at_once
                part = left[:wanted]
                self._socket.sendall(part)
                left, wanted = left[len(part) :], wanted - len(part)
            return count

        return send

    def _send_ahead(self, request: Request, ahead: int) -> Callable[[int], int]:
        """The same with encrypted messages, which are ready before."""
        sequence, most = self._connection._sequence_number, max(ahead, _in_flight(request))
        seal, sent = self._sealer(request), 0
        ready = [seal(n) for n in range(most)]
        chunks = (self._connection._sequence_number - sequence) // most

        def send(count: int) -> int:
            nonlocal sent
            if count < 0:
                self._connection._sequence_number = sequence + sent * chunks
                return 0
            todo = ready[sent : sent + count]
            self._socket.sendall(b"".join(todo))
            sent += len(todo)
            return len(todo)

        return send

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
            kind, size = _START.unpack_from(buffer, at)
            if filled - at < size:
                break
            if kind != b"MSGF" and kind != b"MSGC":
                raise WrongAnswer(f"{bytes(buffer[at : at + min(size, 200)])!r}")
            if not self._secured and not self._middle:
                _, _, service, result = _ANSWER.unpack_from(buffer, at)
                if service != answer or result:
                    raise WrongAnswer("a fault instead of an answer")
            self._middle = kind == b"MSGC"
            done += not self._middle
            at += size
        buffer[: filled - at] = buffer[at:filled]
        self._filled = filled - at
        return done

    def latency(self, request: Request, seconds: float) -> Latency:
        """One at a time for a while."""
        self.check(request)
        make, answer, times = self._one(request), _ANSWERS[request.service], []
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


def _in_flight(request: Request) -> int:
    return IN_FLIGHT if request.count > 1 else IN_FLIGHT_SINGLE
