"""An open secure channel, chunk by chunk: asyncua's own keys and counters, without its objects per chunk.

Every check is the one that ``asyncua.common.connection.SecureConnection`` makes. What does not pass at once, such as
the first chunk under a renewed token, is left to it untouched.

Source:   OPC UA Part 6, 6.7.2 to 6.7.4.
"""

from __future__ import annotations

import struct
from typing import Any, Final

from asyncua.common.connection import MessageChunk, SecureConnection
from asyncua.crypto.security_policies import CryptographyNone
from cryptography.exceptions import InvalidSignature

from pcaccess.opcua.fast.frames import FINAL, INTERMEDIATE, NO_HEADER, RESPONSE, SECURE_HEADER

_IDS: Final = struct.Struct("<II")
_CHUNK: Final = struct.Struct("<4sI8sII")
_CHUNK_HEADER: Final = struct.Struct("<4sI8s")
_SINGLE: Final = struct.Struct(_CHUNK.format + RESPONSE.format.removeprefix("<"))
_WRAP: Final = 1 << 32


class Channel:
    """Made from a connection whose channel is open; to be made again after anything else touched that channel."""

    def __init__(self, connection: SecureConnection) -> None:
        self._connection = connection
        token = connection.security_token
        self._ids = _IDS.pack(token.ChannelId, token.TokenId)
        crypto: Any = connection.security_policy.symmetric_cryptography
        self._crypto = None if type(crypto) is CryptographyNone else crypto
        self._largest_in = connection._limits.max_recv_buffer
        self._portion = MessageChunk.max_body_size(crypto, connection._limits.max_send_buffer)

    def open(self, frame: bytes) -> tuple[bytes, int] | None:
        """A final chunk's plain text and where its sequence header stands in it; None where asyncua must look."""
        if not frame.startswith(FINAL) or not frame.startswith(self._ids, 8) or len(frame) > self._largest_in:
            return None
        if self._connection._incoming_parts:
            return None
        crypto = self._crypto
        if crypto is None:
            return frame, SECURE_HEADER
        try:
            crypto.use_prev_key = False
            plain = crypto.decrypt(frame[SECURE_HEADER:])
            size = crypto.vsignature_size()
            if size:
                plain, signature = plain[:-size], plain[-size:]
                crypto.verify(frame[:SECURE_HEADER] + plain, signature)
            return crypto.remove_padding(plain), 0
        except (InvalidSignature, ValueError):
            return None

    def is_next(self, sequence: int) -> bool:
        """Whether a chunk has the number after the last one; asyncua judges what has not."""
        last = self._connection._peer_sequence_number
        return last is not None and sequence == last + 1

    def accept(self, sequence: int) -> None:
        """A chunk was taken: its number is the last one."""
        self._connection._peer_sequence_number = sequence

    def chunks(self, size: int) -> int:
        """How many chunks a message of ``size`` bytes takes."""
        return -(-size // self._portion)

    def respond(
        self, request_id: int, type_id: bytes, now: int, handle: bytes, result: int, parameters: bytes
    ) -> bytes:
        """A whole response: headers and parameters, as chunks on the wire."""
        size = RESPONSE.size + len(parameters)
        if self._crypto is not None or size > self._portion:
            head = RESPONSE.pack(type_id, now, handle, result, 0, -1, NO_HEADER)
            return self.seal(request_id, head + parameters)
        connection = self._connection
        number = connection._sequence_number + 1
        connection._sequence_number = number = number if number < _WRAP else 1
        head = _SINGLE.pack(
            FINAL, 24 + size, self._ids, number, request_id, type_id, now, handle, result, 0, -1, NO_HEADER
        )
        return head + parameters

    def seal(self, request_id: int, body: bytes) -> bytes:
        """A response as chunks on the wire."""
        portion = self._portion
        if len(body) <= portion:
            return self._chunk(FINAL, request_id, body)
        parts = [body[at : at + portion] for at in range(0, len(body), portion)]
        sealed = [self._chunk(INTERMEDIATE, request_id, part) for part in parts[:-1]]
        return b"".join((*sealed, self._chunk(FINAL, request_id, parts[-1])))

    def _chunk(self, kind: bytes, request_id: int, part: bytes) -> bytes:
        connection, crypto = self._connection, self._crypto
        number = connection._sequence_number + 1
        connection._sequence_number = number = number if number < _WRAP else 1
        if crypto is None:
            return _CHUNK.pack(kind, 24 + len(part), self._ids, number, request_id) + part
        plain = _IDS.pack(number, request_id) + part
        plain += crypto.padding(len(plain))
        size = (len(plain) + crypto.signature_size()) // crypto.plain_block_size() * crypto.encrypted_block_size()
        header = _CHUNK_HEADER.pack(kind, SECURE_HEADER + size, self._ids)
        sealed: bytes = header + crypto.encrypt(plain + crypto.signature(header + plain))
        return sealed
