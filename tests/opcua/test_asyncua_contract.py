"""What we rely on inside asyncua is there, as it was when it was read: one test per internal."""

from __future__ import annotations

import inspect
import tomllib
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest
from asyncua import ua
from asyncua.common.connection import MessageChunk, SecureConnection, TransportLimits
from asyncua.common.utils import Buffer
from asyncua.crypto.permission_rules import SimpleRoleRuleset
from asyncua.crypto.security_policies import CryptographyNone, SecurityPolicyNone
from asyncua.server.binary_server_asyncio import OPCUAProtocol
from asyncua.server.internal_server import InternalServer
from asyncua.server.internal_session import InternalSession, SessionState
from asyncua.server.uaprocessor import UaProcessor
from asyncua.ua.ua_binary import header_from_binary, nodeid_to_binary, struct_to_binary
from packaging.specifiers import SpecifierSet

from pcaccess.opcua import internals
from pcaccess.opcua.fast.channel import Channel
from pcaccess.opcua.fast.frames import READ_REQUEST, READ_RESPONSE, SERVICE_FAULT, WRITE_REQUEST, WRITE_RESPONSE


def named(table: Any) -> list[Any]:
    return [
        pytest.param(cls, name, id=f"{cls.__name__}.{name}") for cls, names in table.items() for name in names.split()
    ]


@pytest.mark.parametrize(("cls", "name"), named(internals.OVERRIDDEN))
def test_a_method_that_we_replace_is_one_that_asyncua_has_and_calls(cls: type, name: str) -> None:
    assert callable(getattr(cls, name))


@pytest.mark.parametrize(("cls", "name"), named(internals.CALLED))
def test_a_method_that_we_call_exists(cls: type, name: str) -> None:
    assert hasattr(cls, name)


@pytest.mark.parametrize(("cls", "name"), named(internals.ATTRIBUTES))
def test_an_attribute_that_we_use_is_set_by_its_class(cls: type, name: str) -> None:
    sources = "".join(inspect.getsource(base) for base in cls.__mro__ if base is not object)
    assert f"self.{name}" in sources or f"{name}:" in sources or f"def {name}(" in sources


def test_everything_named_is_named_once() -> None:
    for table in (internals.OVERRIDDEN, internals.CALLED, internals.ATTRIBUTES):
        for cls, names in table.items():
            assert len(set(names.split())) == len(names.split()), cls


def test_the_installed_asyncua_is_within_the_range_these_tests_passed_on() -> None:
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
    (range_,) = (d.removeprefix("asyncua") for d in project["dependencies"] if d.startswith("asyncua"))
    assert SpecifierSet(range_).contains(version("asyncua"))
    assert "<2.2" in range_


# -- behaviour that the data plane copies ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("prefix", "name"),
    [
        (READ_REQUEST, "ReadRequest"),
        (READ_RESPONSE, "ReadResponse"),
        (WRITE_REQUEST, "WriteRequest"),
        (WRITE_RESPONSE, "WriteResponse"),
        (SERVICE_FAULT, "ServiceFault"),
    ],
)
def test_service_types_have_their_numbers(prefix: bytes, name: str) -> None:
    assert struct_to_binary(getattr(ua, name)()).startswith(prefix)


def test_our_chunks_are_asyncuas_chunks() -> None:
    """The same numbers and bytes, one chunk or several."""
    for size in (10, 65_000, 200_000):
        ours, theirs = (_connection() for _ in range(2))
        body = bytes(range(256)) * (size // 256 + 1)
        assert Channel(ours).seal(7, body) == theirs.message_to_binary(body, request_id=7)
        assert ours._sequence_number == theirs._sequence_number


def test_a_chunk_that_we_open_is_what_asyncua_reads() -> None:
    client, server = _connection(), _connection()
    frame = client.message_to_binary(b"body", request_id=9)
    opened = Channel(server).open(frame)
    assert opened is not None
    plain, at = opened
    buffer = Buffer(frame)
    header = header_from_binary(buffer)
    message = server.receive_from_header_and_body(header, buffer)
    assert plain[at + 8 :] == bytes(message.body())
    assert int.from_bytes(plain[at : at + 4], "little") == server._peer_sequence_number == 1


def test_sequence_numbers_wrap_alike() -> None:
    ours, theirs = _connection(), _connection()
    for connection in (ours, theirs):
        connection._sequence_number = (1 << 32) - 2
    for _ in range(3):
        assert Channel(ours).seal(1, b"x") == theirs.message_to_binary(b"x", request_id=1)


def _connection() -> SecureConnection:
    connection = SecureConnection(SecurityPolicyNone(), TransportLimits())
    connection.security_token.ChannelId, connection.security_token.TokenId = 6, 13
    return connection


def test_no_security_is_the_plain_cryptography_class() -> None:
    assert type(SecurityPolicyNone().symmetric_cryptography) is CryptographyNone
    assert MessageChunk.max_body_size(CryptographyNone(), 65_535) == 65_535 - 24


def test_a_session_says_by_its_state_whether_it_is_active() -> None:
    assert [state.name for state in SessionState] == ["Created", "Activated", "Closed"]
    assert "self.state == SessionState.Activated" in inspect.getsource(InternalSession.is_activated)


def test_a_token_is_encoded_the_same_way_each_time() -> None:
    token = ua.NodeId(ua.ByteString(b"t" * 32), ua.Int16(0))
    assert nodeid_to_binary(token) == b"\x05\x00\x00\x20\x00\x00\x00" + b"t" * 32


def test_the_processor_answers_through_the_names_that_we_replace() -> None:
    assert "self._process_message(" in inspect.getsource(UaProcessor.process_message)
    assert "self.process_message(" in inspect.getsource(UaProcessor.process)
    assert "self.processor.process(" in inspect.getsource(OPCUAProtocol._process_one_msg)
    assert "self._process_received_message_loop()" in inspect.getsource(OPCUAProtocol.connection_made)
    assert "(None, None)" in inspect.getsource(OPCUAProtocol.connection_lost)
    assert "self._should_close_session_on_transport_loss()" in inspect.getsource(UaProcessor.close)
    assert "create_acknowledge_and_set_limits(" in inspect.getsource(UaProcessor.process)


def test_the_servers_clock_is_a_task_that_can_be_ended() -> None:
    assert "self.time_task = asyncio.create_task(" in inspect.getsource(InternalServer.start)
    assert "if self.time_task:" in inspect.getsource(InternalServer.stop)


def test_the_standard_rules_do_not_look_into_a_request() -> None:
    """The data plane asks them once per session, not once per request."""
    assert "body" not in inspect.getsource(SimpleRoleRuleset.check_validity).split("\n", 1)[1]
