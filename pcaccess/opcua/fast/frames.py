"""Bytes of a connection to frames, and the headers of requests and responses. No socket, no security.

Units:    sizes and offsets in bytes; times in ticks.
Errors:   :class:`FrameError` for what ends the connection; a header that cannot be read by hand is None.
Source:   OPC UA Part 6, 7.1.2 (message header), 6.7.2 (MessageChunk); Part 4, 7.32 and 7.33 (request and response
          header); all numbers are little-endian.
"""

from __future__ import annotations

import struct
from typing import Final

from asyncua.ua.status_codes import StatusCodes

HEADER: Final = 8
"""Message type, chunk type, size."""
FINAL: Final = b"MSGF"
INTERMEDIATE: Final = b"MSGC"
SECURE_HEADER: Final = 16
"""Header, channel id, token id: what stands before the sequence header of a symmetric chunk."""

READ_REQUEST: Final = b"\x01\x00\x77\x02"
READ_RESPONSE: Final = b"\x01\x00\x7a\x02"
WRITE_REQUEST: Final = b"\x01\x00\xa1\x02"
WRITE_RESPONSE: Final = b"\x01\x00\xa4\x02"
SERVICE_FAULT: Final = b"\x01\x00\x8d\x01"
"""Four-byte NodeIds of the binary encodings 631, 634, 673, 676, 397 (Part 6, annex A)."""

_SIZE: Final = struct.Struct("<I")
_INT: Final = struct.Struct("<i")
RESPONSE: Final = struct.Struct("<4sq4sIBi3s")
"""TypeId and response header: time, request handle, result, no diagnostics, no strings, no additional header."""
NO_HEADER: Final = b"\x00\x00\x00"
"""An additional header that is not there: null TypeId, no body."""
_NULL_TEXT: Final = b"\xff\xff\xff\xff"


class FrameError(Exception):
    """The peer sent what no frame can be; ``status`` goes into the Error message before the connection ends."""

    def __init__(self, status: int, message: str) -> None:
        super().__init__(message)
        self.status = status


class FrameReader:
    """Cuts what a connection receives into frames."""

    def __init__(self, largest: int) -> None:
        self._largest = largest
        self._rest = b""

    def feed(self, data: bytes) -> list[bytes]:
        """The frames that are complete now, header included; an unfinished one is kept.

        Raises FrameError as soon as a header declares more than is allowed, before its body is there.
        """
        if self._rest:
            data = self._rest + data
        frames = []
        at, end = 0, len(data)
        while end - at >= HEADER:
            (size,) = _SIZE.unpack_from(data, at + 4)
            if size > self._largest:
                raise FrameError(StatusCodes.BadTcpMessageTooLarge, f"a frame of {size} bytes; {self._largest} is most")
            if size < HEADER:
                raise FrameError(StatusCodes.BadTcpMessageTypeInvalid, f"a frame of {size} bytes")
            if at + size > end:
                break
            frames.append(data[at : at + size])
            at += size
        self._rest = data[at:] if at else data
        return frames


def skip_header(request: bytes, at: int) -> tuple[bytes, int] | None:
    """``at`` is behind the AuthenticationToken: the request handle's bytes, and where the parameters begin.

    None for an additional header with a body, which nobody here understands, and for what ends too early.
    """
    handle = request[at + 8 : at + 12]
    audit = at + 16  # behind timestamp, handle and returnDiagnostics
    if request.startswith(_NULL_TEXT, audit):
        after = audit + 4
    else:
        if audit + 4 > len(request):
            return None
        (length,) = _INT.unpack_from(request, audit)
        if length < 0:
            return None
        after = audit + 4 + length
    after += 4  # timeoutHint
    if not request.startswith(NO_HEADER, after):
        return None
    return handle, after + 3


def error_message(status: int, reason: str) -> bytes:
    """The Error message that a server sends before it closes the connection (Part 6, 7.1.2.5)."""
    text = reason.encode()
    return struct.pack("<4sIIi", b"ERRF", 16 + len(text), status, len(text)) + text
