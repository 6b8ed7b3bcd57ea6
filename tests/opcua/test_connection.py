"""What the server lets a connection do: whose session, how much, in which order, and what ends it."""

from __future__ import annotations

import random
import struct
from collections.abc import AsyncIterator
from typing import Any

import pytest
import pytest_asyncio
from asyncua import ua
from asyncua.ua.status_codes import StatusCodes

from pcaccess.links.base import Outcome
from pcaccess.opcua import connection as module
from pcaccess.opcua import limits
from tests.gateways import RunningGateway, start_gateway
from tests.opcua.conftest import PLANT
from tests.opcua.wire import Wire, connected, create_session, decode, fault, read_request, write_request

pytestmark = pytest.mark.asyncio(loop_scope="module")

MOTOR = "ns=2;s=MicroWin.NewPLC.Motor"
TEMPERATURE = "ns=2;s=MicroWin.NewPLC.Temperature"
Int16 = ua.VariantType.Int16


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def running() -> AsyncIterator[RunningGateway]:
    async with start_gateway(PLANT) as gateway:
        yield gateway


@pytest_asyncio.fixture(loop_scope="module")
async def wire(running: RunningGateway) -> AsyncIterator[Wire]:
    async with connected(running.server.port) as connection:
        yield connection


def plane_of(running: RunningGateway) -> Any:
    return running.server._server.internal.plane


# -- sessions ----------------------------------------------------------------------------------------------------------


async def test_a_read_and_a_write_take_the_fast_path(running: RunningGateway, wire: Wire) -> None:
    before = plane_of(running).answered
    assert (await wire.ask(write_request(TEMPERATURE, 7, Int16))).Results[0].value == 0
    answer = await wire.ask(read_request(TEMPERATURE, MOTOR))
    assert answer.Results[0].Value.Value == 7
    assert answer.ResponseHeader.RequestHandle == wire.requests
    assert plane_of(running).answered == before + 2


@pytest.mark.parametrize("request_of", [lambda: read_request(MOTOR), lambda: write_request(TEMPERATURE, 1, Int16)])
async def test_a_request_needs_its_own_active_session(running: RunningGateway, wire: Wire, request_of: Any) -> None:
    async with connected(running.server.port, logged_in=False) as other:
        assert fault(await other.ask(request_of())) == StatusCodes.BadSessionIdInvalid
        other.session = wire.session
        assert fault(await other.ask(request_of())) == StatusCodes.BadSessionIdInvalid
        other.session = ua.NodeId()
        created = await other.ask(create_session())
        other.session = created.Parameters.AuthenticationToken
        assert fault(await other.ask(request_of())) == StatusCodes.BadSessionNotActivated
        await other.activate()
        assert fault(await other.ask(request_of())) == 0
        other.session = wire.session
        assert fault(await other.ask(request_of())) == StatusCodes.BadSessionIdInvalid


async def test_a_closed_session_reads_nothing(wire: Wire) -> None:
    assert fault(await wire.ask(read_request(MOTOR))) == 0
    await wire.ask(ua.CloseSessionRequest())
    assert fault(await wire.ask(read_request(MOTOR))) == StatusCodes.BadSessionIdInvalid


async def test_a_client_that_goes_on_asking_in_a_dead_session_does_not_fill_the_log(
    wire: Wire, caplog: pytest.LogCaptureFixture
) -> None:
    await wire.ask(ua.CloseSessionRequest())
    with caplog.at_level("INFO"):
        for _ in range(50):
            assert fault(await wire.ask(read_request(MOTOR))) == StatusCodes.BadSessionIdInvalid
            assert fault(await wire.ask(ua.PublishRequest())) == StatusCodes.BadSessionIdInvalid
    told = [(r.levelname, r.getMessage().partition(" of ")[0]) for r in caplog.records if "answered with" in r.msg]
    assert told == [("INFO", "ReadRequest"), ("INFO", "PublishRequest")]
    assert [r for r in caplog.records if r.levelname in ("WARNING", "ERROR")] == []


async def test_our_own_fault_is_told_with_its_place_once_and_costs_one_request(
    running: RunningGateway, wire: Wire, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def fails(_parameters: Any) -> Any:
        raise ZeroDivisionError

    monkeypatch.setattr(running.server._server.internal.item_attributes, "read_items", fails)
    for _ in range(3):
        assert fault(await wire.ask(read_request(MOTOR, attribute=4))) == StatusCodes.BadInternalError
    monkeypatch.undo()
    assert fault(await wire.ask(read_request(MOTOR, attribute=4))) == 0
    (told,) = [record for record in caplog.records if record.levelname == "ERROR"]
    assert told.exc_info is not None
    assert told.exc_info[0] is ZeroDivisionError
    assert "ReadRequest" in told.getMessage()


async def test_a_session_that_moved_leaves_its_old_channel(running: RunningGateway) -> None:
    """Part 4, 5.6.3: the server rejects requests sent by way of the old channel."""
    async with connected(running.server.port) as old, connected(running.server.port, logged_in=False) as new:
        assert fault(await old.ask(read_request(MOTOR))) == 0
        new.session = old.session
        assert fault(await new.activate()) == 0
        assert fault(await new.ask(read_request(MOTOR))) == 0
        assert fault(await old.ask(read_request(MOTOR))) == StatusCodes.BadSecureChannelIdInvalid
        old.writer.close()
        await old.frame()
        assert fault(await new.ask(read_request(MOTOR))) == 0, "the end of the old channel is not the session's"


async def test_a_channel_has_one_session(wire: Wire) -> None:
    first = wire.session
    created = await wire.ask(create_session())
    assert fault(await wire.ask(read_request(MOTOR))) == StatusCodes.BadSessionIdInvalid
    wire.session = created.Parameters.AuthenticationToken
    assert wire.session != first
    await wire.activate()
    assert fault(await wire.ask(read_request(MOTOR))) == 0


async def test_subscriptions_are_their_sessions_own(running: RunningGateway, wire: Wire) -> None:
    async with connected(running.server.port) as other:
        request = ua.CreateSubscriptionRequest()
        request.Parameters.RequestedPublishingInterval = 1000.0
        request.Parameters.PublishingEnabled = True
        mine = (await wire.ask(request)).Parameters.SubscriptionId
        invalid = StatusCodes.BadSubscriptionIdInvalid
        create = ua.CreateMonitoredItemsRequest()
        create.Parameters.SubscriptionId = mine
        create.Parameters.ItemsToCreate = [ua.MonitoredItemCreateRequest()]
        assert fault(await other.ask(create)) == invalid
        delete = ua.DeleteSubscriptionsRequest()
        delete.Parameters.SubscriptionIds = [mine]
        assert (await other.ask(delete)).Results[0].value == invalid
        modify = ua.ModifySubscriptionRequest()
        modify.Parameters.SubscriptionId = mine
        assert fault(await other.ask(modify)) == invalid
        again = ua.RepublishRequest()
        again.Parameters.SubscriptionId = mine
        assert fault(await other.ask(again)) == invalid
        transfer = ua.TransferSubscriptionsRequest()
        transfer.Parameters.SubscriptionIds = [mine, 999_999]
        results = (await other.ask(transfer)).Parameters.Results
        assert [r.StatusCode.value for r in results] == [StatusCodes.BadUserAccessDenied, invalid]
        assert fault(await other.ask(ua.PublishRequest())) == StatusCodes.BadNoSubscription
        assert [r.value for r in (await wire.ask(delete)).Results] == [0]


# -- order and amount --------------------------------------------------------------------------------------------------


async def test_replies_come_in_the_order_of_the_requests(wire: Wire) -> None:
    """A fast request behind a slow one waits for it."""
    slow = read_request(MOTOR, attribute=4)
    for n in range(20):
        wire.send(wire.wrap(wire.encode(slow if n % 3 == 0 else read_request(TEMPERATURE))))
        wire.send(wire.wrap(wire.encode(write_request(TEMPERATURE, n, Int16))))
        wire.send(wire.wrap(wire.encode(read_request(TEMPERATURE))))
    first = wire.requests - 59
    for n in range(20):
        answers = [decode(await wire.body()) for _ in range(3)]
        assert [a.ResponseHeader.RequestHandle for a in answers] == [first + 3 * n + k for k in range(3)]
        assert answers[2].Results[0].Value.Value == n


async def test_a_frame_may_come_byte_by_byte(wire: Wire) -> None:
    frame = wire.wrap(wire.encode(read_request(TEMPERATURE)))
    for byte in frame:
        wire.send(bytes((byte,)))
        await wire.writer.drain()
    assert fault(decode(await wire.body())) == 0


async def test_a_request_in_several_chunks_is_answered(wire: Wire) -> None:
    body = wire.encode(read_request(TEMPERATURE, MOTOR))
    first = wire.wrap(body[:50], b"MSGC")
    wire.requests -= 1
    wire.send(first + wire.wrap(body[50:]))
    assert len(decode(await wire.body()).Results) == 2
    assert fault(await wire.ask(read_request(MOTOR))) == 0


async def test_a_client_that_does_not_read_is_not_read_from(running: RunningGateway) -> None:
    async with connected(running.server.port) as bystander, connected(running.server.port) as wire:
        server_side = running.server._server.bserver.clients[-1]
        wire.writer.transport.pause_reading()
        names = [f"ns=2;s=2,VB{n},BYTE" for n in range(900)]
        body = wire.encode(read_request(*names))
        sent = 0
        while not server_side._choked:
            wire.send(wire.wrap(body))
            await bystander.ask(read_request(MOTOR))
            sent += 1
            assert sent < 10_000, "the server takes requests for ever"
        assert not server_side.transport.is_reading()
        wire.writer.transport.resume_reading()
        for _ in range(sent):
            assert len(decode(await wire.body()).Results) == 900
        assert fault(await wire.ask(read_request(MOTOR))) == 0


async def test_many_requests_at_once_wait_their_turn(wire: Wire) -> None:
    """Stock asyncua closed the connection of a client that had 500 requests under way."""
    many = 3 * module.MAX_QUEUED * 3
    slow = wire.encode(read_request("i=2256"))
    for _ in range(many):
        wire.send(wire.wrap(slow))
    for _ in range(many):
        assert fault(decode(await wire.body())) == 0


@pytest.mark.parametrize(
    ("request_of", "status"),
    [
        (lambda: read_request(*[MOTOR] * (limits.MAX_NODES_PER_BROWSE + 1)), 0),
        (lambda: read_request(), StatusCodes.BadNothingToDo),
    ],
)
async def test_how_many_operations_a_request_may_have(wire: Wire, request_of: Any, status: int) -> None:
    assert fault(await wire.ask(request_of())) == status


async def test_limits_are_published_and_kept(wire: Wire) -> None:
    """Part 5, 6.3.11; Part 4, 7.38.2."""
    for number, value in limits.PUBLISHED.items():
        assert (await wire.ask(read_request(f"i={number}"))).Results[0].Value == value
    body = wire.encode(read_request(*["i=1"] * (limits.MAX_NODES_PER_READ + 1)))
    parts = [body[n : n + 60_000] for n in range(0, len(body), 60_000)]
    for part in parts[:-1]:
        wire.send(wire.wrap(part, b"MSGC"))
        wire.requests -= 1
    wire.send(wire.wrap(parts[-1]))
    assert fault(decode(await wire.body())) == StatusCodes.BadTooManyOperations
    browse = ua.BrowseRequest()
    browse.Parameters.NodesToBrowse = [ua.BrowseDescription()] * (limits.MAX_NODES_PER_BROWSE + 1)
    assert fault(await wire.ask(browse)) == StatusCodes.BadTooManyOperations


async def test_a_client_that_takes_little_gets_small_chunks(running: RunningGateway) -> None:
    """Part 6, 7.1.2.4: each side's receive buffer bounds what the other sends."""
    hello = ua.Hello()
    hello.ReceiveBufferSize, hello.SendBufferSize, hello.MaxChunkCount = 8192, 65_535, 4
    async with connected(running.server.port, logged_in=False) as wire:
        wire.writer.close()
    wire = Wire(*await module.asyncio.open_connection("127.0.0.1", running.server.port))
    acknowledge = await wire.open(hello)
    receive, send = struct.unpack_from("<II", acknowledge, 12)
    assert (receive, send) == (65_535, 8192)
    await wire.log_in()
    names = [f"ns=2;s=2,VB{n},BYTE" for n in range(900)]
    wire.send(wire.wrap(wire.encode(read_request(*names))))
    sizes = []
    while not sizes or sizes[-1][0] == "C":
        frame = await wire.frame()
        sizes.append((frame[3:4].decode(), len(frame)))
    assert [kind for kind, _ in sizes] == ["C", "C", "F"]
    assert max(size for _, size in sizes) <= 8192
    more = [f"ns=2;s=2,VB{n},BYTE" for n in range(1900)]
    assert fault(await wire.ask(read_request(*more))) == StatusCodes.BadResponseTooLarge
    wire.writer.close()


# -- what ends a connection --------------------------------------------------------------------------------------------


async def ends(wire: Wire) -> int:
    """Status of the Error message that the server says goodbye with; 0 for none."""
    frame = await wire.frame()
    assert await wire.frame() == b""
    return int(struct.unpack_from("<I", frame, 8)[0]) if frame.startswith(b"ERRF") else 0


@pytest.mark.parametrize(
    ("spoil", "status"),
    [
        (lambda f: f[:8] + b"\x99\0\0\0" + f[12:], StatusCodes.BadSecurityChecksFailed),
        (lambda f: f[:12] + b"\x99\0\0\0" + f[16:], StatusCodes.BadSecurityChecksFailed),
        (lambda f: f[:16] + b"\x99\0\0\0" + f[20:], StatusCodes.BadSecurityChecksFailed),
        (lambda f: f[:4] + b"\x07\0\0\0" + f[8:], StatusCodes.BadTcpMessageTypeInvalid),
        (lambda f: f[:4] + b"\xff\xff\xff\x7f" + f[8:], StatusCodes.BadTcpMessageTooLarge),
        (lambda f: b"XYZF" + f[4:], StatusCodes.BadSecurityChecksFailed),
        (lambda f: f[:4] + b"\x20\0\0\0" + f[8:32], StatusCodes.BadDecodingError),
    ],
    ids=["channel", "token", "sequence", "tiny", "huge", "type", "short"],
)
async def test_a_spoilt_frame_ends_the_connection_and_says_why(
    running: RunningGateway, spoil: Any, status: int
) -> None:
    async with connected(running.server.port) as wire:
        assert fault(await wire.ask(read_request(MOTOR))) == 0
        wire.send(spoil(wire.wrap(wire.encode(read_request(MOTOR)))))
        assert await ends(wire) == status


async def test_a_repeated_frame_is_not_answered_again(running: RunningGateway) -> None:
    async with connected(running.server.port) as wire:
        frame = wire.wrap(wire.encode(write_request(TEMPERATURE, 1, Int16)))
        wire.send(frame)
        assert decode(await wire.body()).Results[0].value == 0
        wire.send(frame)
        assert await ends(wire) == StatusCodes.BadSecurityChecksFailed


async def test_buffers_below_the_least_are_refused(running: RunningGateway) -> None:
    wire = Wire(*await module.asyncio.open_connection("127.0.0.1", running.server.port))
    hello = ua.Hello()
    hello.ReceiveBufferSize, hello.SendBufferSize = 100, 65_535
    refusal = await wire.open(hello)
    assert refusal.startswith(b"ERRF")
    wire.writer.close()


async def test_a_stranger_cannot_fill_the_memory_with_chunks(running: RunningGateway) -> None:
    async with connected(running.server.port, logged_in=False) as wire:
        for _ in range(module.MAX_STRANGER // 60_000 + 2):
            wire.send(wire.wrap(b"x" * 60_000, b"MSGC"))
            wire.requests -= 1
        assert await ends(wire) == StatusCodes.BadTcpMessageTooLarge


async def test_mutated_frames_never_bring_the_server_down_or_another_session_in(running: RunningGateway) -> None:
    """Whatever a frame becomes, its answer is this session's or the connection ends; the server goes on."""
    dice = random.Random(5)
    async with connected(running.server.port) as bystander:
        for round_ in range(60):
            async with connected(running.server.port) as wire:
                kind = dice.choice([read_request(MOTOR, TEMPERATURE), write_request(TEMPERATURE, 3, Int16)])
                for _ in range(6):
                    frame = bytearray(wire.wrap(wire.encode(kind)))
                    for _ in range(dice.choice([1, 1, 2, 8])):
                        at = dice.randrange(24 if dice.random() < 0.8 else 0, len(frame))
                        frame[at] = dice.choice([0, 1, 0x7F, 0x80, 0xFF, frame[at] ^ (1 << dice.randrange(8))])
                    if dice.random() < 0.2:
                        cut = dice.randrange(24, len(frame))
                        frame = frame[:4] + cut.to_bytes(4, "little") + frame[8:cut]
                    wire.send(bytes(frame))
                    answer = await wire.frame()
                    if not answer.startswith(b"MSG"):
                        break
            if round_ % 10 == 0:
                assert fault(await bystander.ask(read_request(MOTOR))) == 0
        assert fault(await bystander.ask(read_request(MOTOR))) == 0


# -- waiting for a PLC -------------------------------------------------------------------------------------------------


async def test_a_write_that_must_wait_is_answered_when_the_plc_has_it(
    running: RunningGateway, wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    link = running.gateway.driver("MicroWin")
    asked = module.asyncio.Event()
    taken = module.asyncio.Event()
    write_now = link.write_now

    async def slowly(station: str, writes: Any) -> list[Outcome]:
        asked.set()
        await taken.wait()
        return write_now(station, writes)

    monkeypatch.setattr(link, "is_prompt", lambda _station: False)
    monkeypatch.setattr(link, "write", slowly)
    wire.send(wire.wrap(wire.encode(write_request(TEMPERATURE, 99, Int16))))
    wire.send(wire.wrap(wire.encode(read_request(TEMPERATURE))))
    await asked.wait()
    taken.set()
    assert decode(await wire.body()).Results[0].value == 0
    assert decode(await wire.body()).Results[0].Value.Value == 99


async def test_a_read_waits_for_a_device_that_is_polled(
    running: RunningGateway, wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    """MaxAge goes to the gateway in seconds."""
    station = running.gateway.stations["MicroWin.Dead"]
    asked: list[tuple[list[int], float]] = []

    async def read(rows: list[int], max_age: float = 0.0) -> None:
        asked.append((rows, max_age))

    monkeypatch.setattr(type(station), "polled", property(lambda self: self.name == "MicroWin.Dead"))
    monkeypatch.setattr(running.gateway, "read", read)
    running.gateway.structure_changed()
    request = read_request("ns=2;s=MicroWin.Dead.Value", MOTOR)
    request.Parameters.MaxAge = 1500.0
    results = (await wire.ask(request)).Results
    assert [r.StatusCode.value for r in results] == [StatusCodes.BadNotConnected, 0]
    assert asked == [([running.gateway.find("MicroWin.Dead.Value")], 1.5)]
    monkeypatch.undo()
    running.gateway.structure_changed()
