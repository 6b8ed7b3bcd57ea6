"""However the bytes of a connection arrive and whatever happens between them, every request is answered once."""

from __future__ import annotations

import asyncio
import random
from collections.abc import AsyncIterator, Callable
from typing import Any

import pytest
import pytest_asyncio
from asyncua import ua
from asyncua.ua.status_codes import StatusCodes

from pcaccess.opcua.connection import Connection
from tests.gateways import RunningGateway, start_gateway
from tests.opcua.conftest import PLANT
from tests.opcua.wire import Wire, connected, decode, fault, read_request, write_request

pytestmark = pytest.mark.asyncio(loop_scope="module")

PLC = "ns=2;s=MicroWin.NewPLC."
Int16 = ua.VariantType.Int16
FOLDERS = "        folders:\n"
MORE = "          - {name: Extra, address: VW800, type: INT, access: RW}\n"
ONE_MORE = PLANT.replace(FOLDERS, MORE + FOLDERS, 1)
ONE_LESS = "".join(line for line in PLANT.splitlines(keepends=True) if "name: Temperature," not in line)


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def running() -> AsyncIterator[RunningGateway]:
    async with start_gateway(PLANT) as gateway:
        yield gateway


class Feeder:
    """Sends bytes piece by piece: the next goes out when the server has taken the one before."""

    def __init__(self, wire: Wire, monkeypatch: pytest.MonkeyPatch) -> None:
        self._wire = wire
        self._taken, self._sent = 0, 0
        self._news = asyncio.Event()
        feeder, received = self, Connection.data_received

        def data_received(self: Connection, data: bytes) -> None:
            feeder._taken += len(data)
            feeder._news.set()
            received(self, data)

        monkeypatch.setattr(Connection, "data_received", data_received)

    async def send(self, data: bytes) -> None:
        self._wire.send(data)
        self._sent += len(data)
        async with asyncio.timeout(40):
            while self._taken < self._sent:
                self._news.clear()
                await self._news.wait()


def any_request(dice: random.Random) -> Any:
    """Of every way through the server: plan, no plan yet, bulk, a write of each size, asyncua's own."""
    names = [PLC + name for name in ("Motor", "Temperature", "Level", "Text", "Row", "Nothing", "Extra")]
    places = [f"ns=2;s=2,VW{2000 + 2 * n},INT" for n in range(40)]
    kind = dice.randrange(7)
    if kind == 0:
        return read_request(PLC + "Motor")
    if kind == 1:
        return read_request(*dice.sample(names, 3))
    if kind == 2:
        return read_request(*dice.sample(places, 40))
    if kind == 3:
        return write_request(PLC + "Temperature", dice.randrange(1000), Int16)
    if kind == 4:
        request = write_request(places[0], 0, Int16)
        for place in places[1:]:
            request.Parameters.NodesToWrite += write_request(place, 7, Int16).Parameters.NodesToWrite
        return request
    if kind == 5:
        return read_request(PLC + "Motor", attribute=4)
    return ua.FindServersRequest()


def pieces_of(data: bytes, dice: random.Random, sizes: Callable[[random.Random], int]) -> list[bytes]:
    pieces, at = [], 0
    while at < len(data):
        size = sizes(dice)
        pieces.append(data[at : at + size])
        at += size
    return pieces


async def answers(wire: Wire, handles: list[int]) -> list[Any]:
    found = [decode(await wire.body()) for _ in handles]
    assert [answer.ResponseHeader.RequestHandle for answer in found] == handles
    assert {fault(answer) for answer in found} == {0}
    return found


@pytest.mark.parametrize(
    ("count", "sizes"),
    [
        (8, lambda dice: 1),
        (40, lambda dice: dice.choice([1, 2, 3, 7, 8, 9, 23, 24, 25, 100, 1000])),
        (40, lambda dice: dice.randrange(1, 200)),
        (60, lambda dice: 1 << 20),
    ],
    ids=["bytes", "around headers", "random", "at once"],
)
async def test_a_stream_in_any_pieces_is_answered_in_order(
    running: RunningGateway, monkeypatch: pytest.MonkeyPatch, count: int, sizes: Callable[[random.Random], int]
) -> None:
    dice = random.Random(3)
    async with connected(running.server.port) as wire:
        feeder = Feeder(wire, monkeypatch)
        for _ in range(3):
            first = wire.requests + 1
            stream = b"".join(wire.wrap(wire.encode(any_request(dice))) for _ in range(count))
            for piece in pieces_of(stream, dice, sizes):
                await feeder.send(piece)
            await answers(wire, list(range(first, first + count)))


@pytest.mark.parametrize("cut", [1, 7, 8, 9, 15, 16, 23, 24, 25, -1])
async def test_a_frame_cut_anywhere_waits_for_its_rest(
    running: RunningGateway, monkeypatch: pytest.MonkeyPatch, cut: int
) -> None:
    """A whole frame goes before the cut one, and the rest comes with the start of the next."""
    async with connected(running.server.port) as wire:
        feeder = Feeder(wire, monkeypatch)
        first = wire.requests + 1
        frames = [wire.wrap(wire.encode(read_request(PLC + "Motor"))) for _ in range(3)]
        await feeder.send(frames[0] + frames[1][:cut])
        await answers(wire, [first])
        await feeder.send(frames[1][cut:] + frames[2][:cut])
        await answers(wire, [first + 1])
        await feeder.send(frames[2][cut:])
        await answers(wire, [first + 2])


async def test_reloads_between_the_pieces_lose_no_answer(
    running: RunningGateway, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows come, go and come again under the plans that were made."""
    dice = random.Random(4)
    texts = [ONE_MORE, PLANT, ONE_LESS, PLANT]
    async with connected(running.server.port) as wire:
        feeder = Feeder(wire, monkeypatch)
        for turn in range(12):
            first = wire.requests + 1
            stream = b"".join(wire.wrap(wire.encode(any_request(dice))) for _ in range(10))
            pieces = pieces_of(stream, dice, lambda dice: dice.randrange(1, 400))
            for n, piece in enumerate(pieces):
                if n == len(pieces) // 2:
                    running.reload(texts[turn % len(texts)])
                await feeder.send(piece)
            await answers(wire, list(range(first, first + 10)))
            text = texts[turn % len(texts)]
            for name in ("Temperature", "Extra"):
                known = (await wire.ask(read_request(PLC + name))).Results[0].StatusCode.value == 0
                assert known == (f"name: {name}," in text)


async def test_a_write_that_waited_while_its_item_went_writes_nowhere_else(
    running: RunningGateway, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The new item may have got the row of the one that went."""
    link = running.gateway.driver("MicroWin")
    async with connected(running.server.port) as wire:
        monkeypatch.setattr(link, "is_prompt", lambda _station: False)
        row = running.gateway.find("MicroWin.NewPLC.Temperature")
        connection = running.server._server.bserver.clients[-1]
        work = connection._fast.answer(wire.wrap(wire.encode(write_request(PLC + "Temperature", 5, Int16))), 0)
        assert callable(work)
        running.reload(ONE_LESS)
        running.reload(ONE_LESS.replace(FOLDERS, MORE + FOLDERS, 1))
        assert running.gateway.find("MicroWin.NewPLC.Extra") == row
        assert decode((await work())[24:]).Results[0].value == StatusCodes.BadNodeIdUnknown
        assert running.gateway.sample(row).value == 0
    running.reload(PLANT)


async def test_a_link_that_fails_costs_the_request_and_not_the_connection(
    running: RunningGateway, monkeypatch: pytest.MonkeyPatch
) -> None:
    link = running.gateway.driver("MicroWin")

    async def fails(_station: str, _writes: Any) -> Any:
        raise KeyError("gone")

    async with connected(running.server.port) as wire:
        with monkeypatch.context() as patch:
            patch.setattr(link, "is_prompt", lambda _station: False)
            patch.setattr(link, "write", fails)
            answer = await wire.ask(write_request(PLC + "Temperature", 5, Int16))
            assert fault(answer) == StatusCodes.BadInternalError
        assert fault(await wire.ask(write_request(PLC + "Temperature", 6, Int16))) == 0


async def test_a_boolean_is_one_bit_however_it_is_sent(running: RunningGateway) -> None:
    """Part 6, 5.2.2.1: any byte but 0 is true."""
    bits = [f"ns=2;s=2,V{1000 + n // 8}.{n % 8},BOOL" for n in range(40)]
    request = write_request(bits[0], True, ua.VariantType.Boolean)
    for bit in bits[1::2]:
        request.Parameters.NodesToWrite += write_request(bit, True, ua.VariantType.Boolean).Parameters.NodesToWrite
    async with connected(running.server.port) as wire:
        true = b"\xff\xff\xff\xff\x03\x01"
        body = wire.encode(request).replace(true + b"\x01", true + b"\xfe")
        assert body.count(true + b"\xfe") == len(request.Parameters.NodesToWrite)
        wire.send(wire.wrap(body))
        assert {result.value for result in decode(await wire.body()).Results} == {0}
        values = [result.Value.Value for result in (await wire.ask(read_request(*bits))).Results]
        assert values == [n == 0 or n % 2 == 1 for n in range(40)]


async def test_a_plan_with_registered_nodes_is_their_sessions_own(running: RunningGateway) -> None:
    """Part 4, 5.8.5: handles of one session mean nothing in another."""
    names = [PLC + "Motor"] * 40
    async with connected(running.server.port) as wire, connected(running.server.port) as other:
        register = ua.RegisterNodesRequest()
        register.Parameters.NodesToRegister = [ua.NodeId.from_string(name) for name in names]
        handles = [node.to_string() for node in (await wire.ask(register)).Parameters.RegisteredNodeIds]
        for _ in range(3):  # the third is answered from a plan that is kept
            assert {r.StatusCode.value for r in (await wire.ask(read_request(*handles))).Results} == {0}
            results = (await other.ask(read_request(*handles))).Results
            assert {r.StatusCode.value for r in results} == {StatusCodes.BadNodeIdUnknown}


@pytest.mark.parametrize("count", [2, 40])
async def test_a_handle_that_was_given_back_is_unknown(running: RunningGateway, count: int) -> None:
    """Plans and look-ups that were made with it are forgotten (Part 4, 5.8.6)."""
    async with connected(running.server.port) as wire:
        register = ua.RegisterNodesRequest()
        register.Parameters.NodesToRegister = [ua.NodeId.from_string(PLC + "Motor")] * count
        nodes = (await wire.ask(register)).Parameters.RegisteredNodeIds
        handles = [node.to_string() for node in nodes]
        for _ in range(3):
            assert {r.StatusCode.value for r in (await wire.ask(read_request(*handles))).Results} == {0}
        turned = (await wire.ask(read_request(*reversed(handles)))).Results
        assert {r.StatusCode.value for r in turned} == {0}
        unregister = ua.UnregisterNodesRequest()
        unregister.Parameters.NodesToUnregister = nodes[:1]
        assert fault(await wire.ask(unregister)) == 0
        for wanted in (handles, handles[:1] + handles):
            first, *others = (await wire.ask(read_request(*wanted))).Results
            assert first.StatusCode.value == StatusCodes.BadNodeIdUnknown
            assert others[-1].StatusCode.value == 0
