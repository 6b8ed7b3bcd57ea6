"""The data plane of one connection: a frame in, the reply as it goes on the wire out, or None for asyncua.

Everything that asyncua would check is checked first: the chunk's security and sequence number, the session's token and
state and that it is this channel's, and the caller's permission. What cannot be answered at once gives a :data:`Job`.

Source:   OPC UA Part 4, 5.6.1 (what a request must have), 7.38.2 BadResponseTooLarge.
"""

from __future__ import annotations

import logging
import struct
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from asyncua.crypto.permission_rules import SimpleRoleRuleset
from asyncua.ua.object_ids import ObjectIds
from asyncua.ua.status_codes import StatusCodes
from asyncua.ua.ua_binary import nodeid_to_binary

from pcaccess.gateway.gateway import Gateway
from pcaccess.opcua.fast.channel import Channel
from pcaccess.opcua.fast.frames import (
    READ_REQUEST,
    READ_RESPONSE,
    SERVICE_FAULT,
    WRITE_REQUEST,
    WRITE_RESPONSE,
    response_header,
    skip_header,
)
from pcaccess.opcua.fast.lookup import Lookup
from pcaccess.opcua.fast.reads import ReadPlan, Reads
from pcaccess.opcua.fast.writes import WriteRequest, Writes
from pcaccess.opcua.ids import standard
from pcaccess.opcua.limits import MAX_MESSAGE
from pcaccess.opcua.sessions import Session
from pcaccess.opcua.space import Space

if TYPE_CHECKING:
    from pcaccess.opcua.processor import Processor

log = logging.getLogger(__name__)

_READ_TYPE: Final = standard(ObjectIds.ReadRequest_Encoding_DefaultBinary)
_WRITE_TYPE: Final = standard(ObjectIds.WriteRequest_Encoding_DefaultBinary)
_NEVER: Final = b"\xff"
"""What no request begins with, for a user who may not."""
_SEQUENCE: Final = struct.Struct("<II")

Job = Callable[[], Awaitable[bytes]]
"""Work that must wait for a PLC; gives the reply."""


class DataPlane:
    """What all connections of one server share."""

    def __init__(self, gateway: Gateway, space: Space) -> None:
        self.gateway = gateway
        lookup = Lookup(gateway, space)
        self.reads = Reads(gateway, lookup)
        self.writes = Writes(gateway, lookup)
        self.enabled = True
        """Off, everything takes asyncua's path, which must give the same answers."""
        self.answered = 0
        """Requests that did not need asyncua."""


@dataclass(slots=True)
class _Ready:
    """An open channel with its active session, as long as nothing but reads and writes comes."""

    channel: Channel
    session: Session
    read: bytes
    write: bytes
    """What such a request begins with: type and token."""


class FastPath:
    """The data plane of one connection."""

    def __init__(self, plane: DataPlane, processor: Processor) -> None:
        self._plane = plane
        self._processor = processor
        self._ready: _Ready | None = None

    def forget(self) -> None:
        """Something else came: channel and session may be others now."""
        self._ready = None

    def answer(self, frame: bytes) -> bytes | Job | None:
        """The reply to a frame, or what will give it. None, with nothing touched, for asyncua."""
        ready = self._ready
        if ready is None:
            ready = self._prepare()
            if ready is None:
                return None
        session = ready.session
        if session.channel is not self._processor or not session.is_activated():
            return None
        opened = ready.channel.open(frame)
        if opened is None:
            return None
        plain, at = opened
        if len(plain) < at + _SEQUENCE.size:
            return None
        sequence, request_id = _SEQUENCE.unpack_from(plain, at)
        at += _SEQUENCE.size
        is_read = plain.startswith(ready.read, at)
        if not is_read and not plain.startswith(ready.write, at):
            return None
        if not ready.channel.is_next(sequence):
            return None
        header = skip_header(plain, at + len(ready.read))
        if header is None:
            return None
        handle, parameters = header
        call = _Call(self, ready.channel, sequence, request_id, handle)
        body = plain[parameters:]
        reply = self._read(call, session, body) if is_read else self._write(call, session, body)
        if reply is not None:
            self._processor.touch(session)
        return reply

    def _prepare(self) -> _Ready | None:
        processor = self._processor
        session = processor.session
        connection = processor._connection
        if not self._plane.enabled or session is None or not session.is_activated() or not connection.is_open():
            return None
        rules = connection.security_policy.permissions
        if rules is not None and type(rules) is not SimpleRoleRuleset:
            return None  # rules that may look into a request are asked by asyncua
        token = nodeid_to_binary(session.auth_token)
        read, write = (
            prefix + token if rules is None or rules.check_validity(session.user, type_id, None) else _NEVER
            for prefix, type_id in ((READ_REQUEST, _READ_TYPE), (WRITE_REQUEST, _WRITE_TYPE))
        )
        self._ready = _Ready(Channel(connection), session, read, write)
        return self._ready

    def _read(self, call: _Call, session: Session, body: bytes) -> bytes | Job | None:
        reads = self._plane.reads
        plan = reads.plan(body, session, session.registered)
        if plan is None:
            return None
        if not plan.polled:
            return call.accepted(READ_RESPONSE, reads.reply(plan))
        call.accept()
        return lambda: self._read_later(call, session, body, plan)

    async def _read_later(self, call: _Call, session: Session, body: bytes, plan: ReadPlan) -> bytes:
        reads = self._plane.reads
        await reads.fetch(plan)
        again = reads.plan(body, session, session.registered)  # rows may have gone while it waited
        if again is None:
            return call.fault(StatusCodes.BadInvalidState)
        return call.reply(READ_RESPONSE, reads.reply(again))

    def _write(self, call: _Call, session: Session, body: bytes) -> bytes | Job | None:
        writes = self._plane.writes
        request = writes.parse(body, session.registered)
        if request is None:
            return None
        done = writes.write_now(request)
        if done is not None:
            return call.accepted(WRITE_RESPONSE, done)
        call.accept()
        return lambda: self._write_later(call, request)

    async def _write_later(self, call: _Call, request: WriteRequest) -> bytes:
        return call.reply(WRITE_RESPONSE, await self._plane.writes.write(request))

    def count(self) -> None:
        self._plane.answered += 1

    def now(self) -> int:
        return self._plane.gateway.now()

    def fits(self, channel: Channel, size: int) -> bool:
        """Whether the client takes a response of that size."""
        limits = self._processor._limits
        most = getattr(limits, "max_response", MAX_MESSAGE)
        chunks = getattr(limits, "max_response_chunks", 0)
        return size <= most and (not chunks or channel.chunks(size) <= chunks)


@dataclass(slots=True)
class _Call:
    """One request that will be answered here."""

    path: FastPath
    channel: Channel
    sequence: int
    request_id: int
    handle: bytes

    def accept(self) -> None:
        """The request is ours from now on."""
        self.path.count()
        self.channel.accept(self.sequence)

    def accepted(self, type_id: bytes, parameters: bytes) -> bytes:
        """The reply to a request that is done; until here a failure left it to asyncua."""
        self.accept()
        return self.reply(type_id, parameters)

    def reply(self, type_id: bytes, parameters: bytes) -> bytes:
        body = response_header(type_id, self.path.now(), self.handle) + parameters
        if not self.path.fits(self.channel, len(body)):
            return self.fault(StatusCodes.BadResponseTooLarge)
        return self.channel.seal(self.request_id, body)

    def fault(self, status: int) -> bytes:
        return self.channel.seal(self.request_id, response_header(SERVICE_FAULT, self.path.now(), self.handle, status))
