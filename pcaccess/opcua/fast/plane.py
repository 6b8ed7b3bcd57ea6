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
from pcaccess.items.ticks import TICKS_PER_SECOND
from pcaccess.opcua.fast.bulkwrites import BulkWrite
from pcaccess.opcua.fast.channel import Channel
from pcaccess.opcua.fast.frames import (
    READ_REQUEST,
    READ_RESPONSE,
    RESPONSE,
    SERVICE_FAULT,
    WRITE_REQUEST,
    WRITE_RESPONSE,
    skip_header,
)
from pcaccess.opcua.fast.lookup import Lookup
from pcaccess.opcua.fast.readplans import ReadPlan
from pcaccess.opcua.fast.reads import Reads
from pcaccess.opcua.fast.writerequest import WriteRequest
from pcaccess.opcua.fast.writes import Writes
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
_TOUCH: Final = TICKS_PER_SECOND // 2
"""How often a session in use is told so."""
_SURELY_FITS: Final = 8_000
"""Bytes that every client takes (``limits.MIN_FRAME``)."""
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
        self._touched = 0

    def forget(self) -> None:
        """Something else came: channel and session may be others now."""
        self._ready = None
        self._touched = 0

    def answer(self, frame: bytes, now: int) -> bytes | Job | None:
        """The reply to a frame, or what will give it; ``now`` in ticks. None, with nothing touched, for asyncua."""
        ready = self._ready or self._prepare()
        if ready is None:
            return None
        session, channel = ready.session, ready.channel
        if session.channel is not self._processor or not session.is_activated():
            return None
        opened = channel.open(frame)
        if opened is None:
            return None
        plain, at = opened
        if len(plain) < at + 8:
            return None
        sequence, request_id = _SEQUENCE.unpack_from(plain, at)
        at += 8
        is_read = plain.startswith(ready.read, at)
        if not (is_read or plain.startswith(ready.write, at)) or not channel.is_next(sequence):
            return None
        header = skip_header(plain, at + len(ready.read))
        if header is None:
            return None
        call = _Call(self._plane, self._processor, channel, sequence, request_id, header[0])
        if is_read:
            reply = self._read(call, session, plain, header[1], now)
        else:
            reply = self._write(call, session, plain[header[1] :], now)
        if reply is not None and not 0 <= now - self._touched <= _TOUCH:  # wall clocks go back, too
            self._touched = now
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

    def _read(self, call: _Call, session: Session, request: bytes, at: int, now: int) -> bytes | Job | None:
        reads = self._plane.reads
        plan = reads.plan(request, at, session.registered)
        if plan is None:
            return None
        if not plan.polled:
            return call.done(READ_RESPONSE, reads.reply(plan, now), now)
        call.accept()
        return lambda: call.answered(self._read_later(call, session, request, at, plan))

    async def _read_later(self, call: _Call, session: Session, request: bytes, at: int, plan: ReadPlan) -> bytes:
        reads = self._plane.reads
        await reads.fetch(plan, reads.max_age(request, at))
        again = reads.plan(request, at, session.registered)  # rows may have gone while it waited
        now = self._plane.gateway.now()
        if again is None:
            return call.fault(StatusCodes.BadInvalidState, now)
        return call.reply(READ_RESPONSE, reads.reply(again, now), now)

    def _write(self, call: _Call, session: Session, body: bytes, now: int) -> bytes | Job | None:
        writes = self._plane.writes
        request = writes.parse(body, session.registered)
        if request is None:
            return None
        done = writes.write_now(request)
        if done is not None:
            return call.done(WRITE_RESPONSE, done, now)
        call.accept()
        removals = self._plane.gateway.table.removals
        return lambda: call.answered(self._write_later(call, session, body, request, removals))

    async def _write_later(
        self, call: _Call, session: Session, body: bytes, request: WriteRequest | BulkWrite, removals: int
    ) -> bytes:
        plane, wanted = self._plane, request
        if plane.gateway.table.removals != removals:  # it waited, and a row may be another item now
            again = plane.writes.parse(body, session.registered)
            if again is None:
                return call.fault(StatusCodes.BadInvalidState, plane.gateway.now())
            wanted = again
        done = await plane.writes.write(wanted)
        return call.reply(WRITE_RESPONSE, done, plane.gateway.now())


class _Call:
    """One request that will be answered here."""

    __slots__ = ("_channel", "_handle", "_limits", "_plane", "_request_id", "_sequence")

    def __init__(
        self,
        plane: DataPlane,
        processor: Processor,
        channel: Channel,
        sequence: int,
        request_id: int,
        handle: bytes,
    ) -> None:
        self._plane = plane
        self._limits = processor._limits
        self._channel = channel
        self._sequence = sequence
        self._request_id = request_id
        self._handle = handle

    def accept(self) -> None:
        """The request is ours from now on."""
        self._plane.answered += 1
        self._channel.accept(self._sequence)

    async def answered(self, work: Awaitable[bytes]) -> bytes:
        """The reply, whatever becomes of the work: one request must not cost the connection."""
        try:
            return await work
        except Exception:
            log.exception("a request failed in the data plane")
            return self.fault(StatusCodes.BadInternalError, self._plane.gateway.now())

    def done(self, type_id: bytes, parameters: bytes, now: int) -> bytes:
        """The reply to a request that is done; until here a failure left it to asyncua."""
        self.accept()
        return self.reply(type_id, parameters, now)

    def reply(self, type_id: bytes, parameters: bytes, now: int) -> bytes:
        if len(parameters) > _SURELY_FITS and not self._fits(len(parameters) + RESPONSE.size):
            return self.fault(StatusCodes.BadResponseTooLarge, now)
        return self._channel.respond(self._request_id, type_id, now, self._handle, 0, parameters)

    def _fits(self, size: int) -> bool:
        """Whether the client takes a response of that size."""
        most = getattr(self._limits, "max_response", MAX_MESSAGE)
        chunks = getattr(self._limits, "max_response_chunks", 0)
        return size <= most and (not chunks or self._channel.chunks(size) <= chunks)

    def fault(self, status: int, now: int) -> bytes:
        return self._channel.respond(self._request_id, SERVICE_FAULT, now, self._handle, status, b"")
