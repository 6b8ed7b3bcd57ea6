"""A client of bytes: what it sends is what a test wants on the wire, right or wrong."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from asyncua import ua
from asyncua.common.utils import Buffer
from asyncua.ua.ua_binary import nodeid_from_binary, nodeid_to_binary, struct_from_binary, struct_to_binary

PATIENCE = 40.0

HELLO = ua.Hello()
HELLO.ReceiveBufferSize = HELLO.SendBufferSize = 65_535
HELLO.EndpointUrl = "opc.tcp://127.0.0.1/test"


class Wire:
    """One connection without security."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.reader, self.writer = reader, writer
        self.sequence, self.requests = 0, 0
        self.channel = self.token = 0
        self.session: ua.NodeId = ua.NodeId()

    # -- bytes -------------------------------------------------------------------------------------------------------

    def send(self, data: bytes) -> None:
        self.writer.write(data)

    async def frame(self) -> bytes:
        """The next frame of the server; empty when it closed the connection."""
        async with asyncio.timeout(PATIENCE):
            try:
                head = await self.reader.readexactly(8)
                return head + await self.reader.readexactly(int.from_bytes(head[4:], "little") - 8)
            except (asyncio.IncompleteReadError, ConnectionError):
                return b""

    def wrap(self, body: bytes, kind: bytes = b"MSGF") -> bytes:
        """A chunk with the next numbers."""
        self.sequence += 1
        self.requests += 1
        head = struct.pack("<4sIIIII", kind, 24 + len(body), self.channel, self.token, self.sequence, self.requests)
        return head + body

    async def body(self) -> bytes:
        """The body of the next response, its chunks put together."""
        parts = []
        while True:
            frame = await self.frame()
            if not frame.startswith(b"MSG"):
                raise ConnectionError(frame)
            parts.append(frame[24:])
            if frame[3:4] == b"F":
                return b"".join(parts)

    # -- services ------------------------------------------------------------------------------------------------------

    def encode(self, request: Any) -> bytes:
        request.RequestHeader.AuthenticationToken = self.session
        request.RequestHeader.RequestHandle = ua.IntegerId(self.requests + 1)
        return struct_to_binary(request)

    async def ask(self, request: Any) -> Any:
        """The decoded response, a ServiceFault too."""
        self.send(self.wrap(self.encode(request)))
        return decode(await self.body())

    async def open(self, hello: ua.Hello = HELLO) -> bytes:
        """Hello and OpenSecureChannel; gives the Acknowledge."""
        content = struct_to_binary(hello)
        self.send(struct.pack("<4sI", b"HELF", 8 + len(content)) + content)
        acknowledge = await self.frame()
        request = ua.OpenSecureChannelRequest()
        request.Parameters.SecurityMode = ua.MessageSecurityMode.None_
        request.Parameters.RequestedLifetime = 3_600_000
        policy = b"http://opcfoundation.org/UA/SecurityPolicy#None"
        security = struct.pack("<i", len(policy)) + policy + b"\xff" * 8
        self.sequence += 1
        self.requests += 1
        body = security + struct.pack("<II", self.sequence, self.requests) + struct_to_binary(request)
        self.send(struct.pack("<4sII", b"OPNF", 12 + len(body), 0) + body)
        answer = await self.frame()
        if answer:
            at = 12 + len(security) + 8
            opened = decode(answer[at:])
            self.channel = opened.Parameters.SecurityToken.ChannelId
            self.token = opened.Parameters.SecurityToken.TokenId
        return acknowledge

    async def log_in(self) -> None:
        created = await self.ask(create_session())
        self.session = created.Parameters.AuthenticationToken
        await self.activate()

    async def activate(self) -> Any:
        request = ua.ActivateSessionRequest()
        request.Parameters.UserIdentityToken = ua.AnonymousIdentityToken("anonymous")
        return await self.ask(request)


def decode(body: bytes) -> Any:
    kind = nodeid_from_binary(Buffer(body))
    return struct_from_binary(_RESPONSES[kind.Identifier], Buffer(body))


_RESPONSES = {
    getattr(ua.ObjectIds, f"{name}_Encoding_DefaultBinary"): getattr(ua, name)
    for name in dir(ua)
    if name.endswith("Response") or name == "ServiceFault"
    if hasattr(ua.ObjectIds, f"{name}_Encoding_DefaultBinary")
}


def create_session() -> ua.CreateSessionRequest:
    """With a timeout that an overloaded machine does not reach."""
    request = ua.CreateSessionRequest()
    request.Parameters.RequestedSessionTimeout = 600_000.0
    return request


def fault(response: Any) -> int:
    """Status of the whole response."""
    return int(response.ResponseHeader.ServiceResult.value)


def read_request(*nodes: str, attribute: int = 13) -> ua.ReadRequest:
    request = ua.ReadRequest()
    request.Parameters.TimestampsToReturn = ua.TimestampsToReturn.Both
    request.Parameters.NodesToRead = [ua.ReadValueId(ua.NodeId.from_string(n), attribute) for n in nodes]
    return request


def write_request(node: str, value: Any, kind: ua.VariantType) -> ua.WriteRequest:
    request = ua.WriteRequest()
    written = ua.DataValue(ua.Variant(value, kind))
    request.Parameters.NodesToWrite = [ua.WriteValue(ua.NodeId.from_string(node), ua.AttributeIds.Value, None, written)]
    return request


def token_bytes(token: ua.NodeId) -> bytes:
    return nodeid_to_binary(token)


@asynccontextmanager
async def connected(port: int, *, logged_in: bool = True) -> AsyncIterator[Wire]:
    """A connection with an open channel and, unless told otherwise, an active session."""
    wire = Wire(*await asyncio.open_connection("127.0.0.1", port))
    try:
        await wire.open()
        if logged_in:
            await wire.log_in()
        yield wire
    finally:
        wire.writer.close()
