"""One client's connection: frames in, replies out, nothing buffered that was not agreed on.

A frame that the data plane can answer at once is answered here; every other one waits its turn for asyncua. The order
of a connection's requests is kept: while one of them waits, all that follow wait behind it.

Mended here (docs/decisions/2026-11-22-asyncua.md): a frame of any declared size was buffered before anyone had logged
in, and so were 500 of them and any number of chunks; replies piled up for a client that does not read; a chunk that
failed its checks was logged and the connection went on; receive and send buffer were exchanged in Acknowledge.

Source:   OPC UA Part 6, 7.1.2 (Hello, Acknowledge, Error), 6.7.2 (what ends a secure channel).
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from asyncua import ua
from asyncua.common.connection import TransportLimits
from asyncua.common.utils import Buffer, NotEnoughData, ServiceError
from asyncua.server.binary_server_asyncio import OPCUAProtocol
from asyncua.ua.status_codes import StatusCodes
from asyncua.ua.ua_binary import header_from_binary
from asyncua.ua.uaerrors import UaError, UaStatusCodeError

from pcaccess.opcua.fast.frames import INTERMEDIATE, FrameError, FrameReader, error_message
from pcaccess.opcua.fast.plane import FastPath, Job
from pcaccess.opcua.limits import MAX_FRAME, MAX_MESSAGE, MIN_FRAME
from pcaccess.opcua.processor import Processor

if TYPE_CHECKING:
    from pcaccess.opcua.asyncua_server import Internal

log = logging.getLogger(__name__)

MAX_QUEUED: Final = 100
MAX_QUEUED_BYTES: Final = 1 << 20
"""Frames waiting for asyncua; beyond that the client's socket is not read until half of them are done."""
MAX_STRANGER: Final = 1 << 18
"""Bytes that chunks of one message may take before a session is active."""
FLUSH: Final = 1 << 16
"""Bytes of replies that are collected before they are sent in one go."""


@dataclass
class Limits(TransportLimits):
    """What both sides may send, as Hello and Acknowledge settle it."""

    max_recv_buffer: int = MAX_FRAME
    max_send_buffer: int = MAX_FRAME
    max_chunk_count: int = MAX_MESSAGE // MIN_FRAME + 1
    max_message_size: int = MAX_MESSAGE
    max_response: int = MAX_MESSAGE
    """Bytes of a response that the client takes."""
    max_response_chunks: int = 0
    """Chunks of a response that the client takes; 0 is any number."""

    def create_acknowledge_and_set_limits(self, msg: ua.Hello) -> ua.Acknowledge:
        """Each side's receive buffer bounds what the other sends (Part 6, 7.1.2.3 and 7.1.2.4)."""
        if min(msg.ReceiveBufferSize, msg.SendBufferSize) < MIN_FRAME:
            raise UaStatusCodeError(StatusCodes.BadConnectionRejected)
        self.max_send_buffer = min(msg.ReceiveBufferSize, MAX_FRAME)
        self.max_recv_buffer = min(msg.SendBufferSize, MAX_FRAME)
        self.max_response = min(msg.MaxMessageSize or MAX_MESSAGE, MAX_MESSAGE)
        self.max_response_chunks = int(msg.MaxChunkCount)
        return ua.Acknowledge(
            ReceiveBufferSize=ua.UInt32(self.max_recv_buffer),
            SendBufferSize=ua.UInt32(self.max_send_buffer),
            MaxMessageSize=ua.UInt32(self.max_message_size),
            MaxChunkCount=ua.UInt32(self.max_chunk_count),
        )


class Connection(OPCUAProtocol):
    """asyncua's protocol with our reading, queueing and answering."""

    iserver: Internal

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.messages = asyncio.Queue()  # bounded by no longer reading, not by closing the connection
        self._reader = FrameReader(MAX_FRAME)
        self._waiting: deque[bytes] = deque()
        """Frames not looked at yet, because replies to earlier ones cannot be sent."""
        self._queued = 0
        self._queued_bytes = 0
        self._choked = False
        """The client does not read: the transport has all the replies it will hold."""
        self._reading = True
        self._closing = False
        self._fast: FastPath | None = None

    # ------------------------------------------------------------------ the socket's side

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        if self.processor is not None:
            self.processor = Processor(self.iserver, self.transport, self.limits)
            self.processor.set_policies(self.policies)
            self._fast = FastPath(self.iserver.plane, self.processor)

    def connection_lost(self, ex: BaseException | None) -> None:
        self._closing = True
        self._waiting.clear()
        super().connection_lost(ex)

    def pause_writing(self) -> None:
        """The transport calls this when the client leaves too many replies unread."""
        self._choked = True
        self._set_reading()

    def resume_writing(self) -> None:
        self._choked = False
        self._set_reading()
        waiting, self._waiting = self._waiting, deque()
        self._take(waiting)

    def _set_reading(self) -> None:
        """Read from the client only while there is room for what it asks."""
        room = 2 if self._reading else 1
        full = self._queued * 2 > MAX_QUEUED * room or self._queued_bytes * 2 > MAX_QUEUED_BYTES * room
        wanted = not (self._choked or full)
        if wanted != self._reading and self.transport is not None and not self.transport.is_closing():
            self._reading = wanted
            if wanted:
                self.transport.resume_reading()
            else:
                self.transport.pause_reading()

    def data_received(self, data: bytes) -> None:
        if self._closing:
            return
        try:
            frames = self._reader.feed(data)
        except FrameError as error:
            self._refuse(error.status, str(error))
            return
        if self._waiting:
            self._waiting.extend(frames)
        else:
            self._take(frames)

    # ------------------------------------------------------------------ requests

    def _take(self, frames: Iterable[bytes]) -> None:
        replies: list[bytes] = []
        size, now = 0, self.iserver.plane.gateway.now()
        for frame in frames:
            if self._closing:
                return
            if self._choked:
                self._waiting.append(frame)
                continue
            answer = self._answer(frame, now)
            if isinstance(answer, bytes):
                replies.append(answer)
                size += len(answer)
                if size < FLUSH:
                    continue
            self._send(replies)
            size = 0
            if answer is None:
                self._enqueue(frame)
            elif not isinstance(answer, bytes):
                self._await(answer, len(frame))
        self._send(replies)

    def _send(self, replies: list[bytes]) -> None:
        """Everything collected, in one go."""
        if replies and self.transport is not None:
            self.transport.write(b"".join(replies))
        replies.clear()

    def _answer(self, frame: bytes, now: int) -> bytes | Job | None:
        """What the data plane makes of a frame, unless another request waits before it."""
        if self._queued or self._fast is None:
            return None
        try:
            return self._fast.answer(frame, now)
        except Exception:
            log.exception("the data plane failed; asyncua takes the request")
            return None

    def _await(self, job: Job, size: int) -> None:
        self.messages.put_nowait((size, job))
        self._count(size)

    def _count(self, size: int) -> None:
        self._queued += 1
        self._queued_bytes += size
        self._set_reading()

    def _enqueue(self, frame: bytes) -> None:
        """To asyncua, behind whatever waits there already."""
        if frame.startswith(INTERMEDIATE) and not self._may_send_much(frame):
            self._refuse(StatusCodes.BadTcpMessageTooLarge, "a session must be active before long messages")
            return
        buffer = Buffer(frame)
        self.messages.put_nowait((header_from_binary(buffer), buffer))
        self._count(len(frame))

    def _may_send_much(self, frame: bytes) -> bool:
        processor = self.processor
        if processor is None or (processor.session is not None and processor.session.is_activated()):
            return True
        return processor._connection._incoming_size + self._queued_bytes + len(frame) <= MAX_STRANGER

    async def _process_received_message_loop(self) -> None:
        """One request after the other; a fault of the channel ends the connection."""
        while True:
            header, work = await self.messages.get()
            if work is None:
                break
            size = header if isinstance(header, int) else header.packet_size
            try:
                if isinstance(header, int):
                    self._send([await work()])
                elif not await self._process_one_msg(header, work):
                    break
            except Exception as error:
                self._refuse(*_fault(error))
                break
            finally:
                self._queued -= 1
                self._queued_bytes -= size
                if self._fast is not None:
                    self._fast.forget()
                self._set_reading()

    def _refuse(self, status: int, reason: str) -> None:
        """Tell the client why, and end the connection."""
        self._closing = True
        log.warning("closing the connection of %s: %s", self.peer_name, reason)
        if self.transport is not None and not self.transport.is_closing():
            self.transport.write(error_message(status, reason))
            self.transport.close()


def _fault(error: Exception) -> tuple[int, str]:
    """Status and words for a message that could not even be answered with a fault."""
    if isinstance(error, UaStatusCodeError | ServiceError):
        return int(error.code), str(error)
    if isinstance(error, UaError) and not isinstance(error, NotEnoughData):
        return StatusCodes.BadSecurityChecksFailed, str(error)
    log.debug("undecodable message", exc_info=error)
    return StatusCodes.BadDecodingError, f"the message could not be decoded ({type(error).__name__})"
