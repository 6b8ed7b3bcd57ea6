"""The data plane and asyncua's own path give the same answers, on plain, signed and encrypted channels.

Where stock asyncua is wrong, both are our mended path (test_attributes.py names the clauses): this test compares the
hand-written codec with the library's.
"""

from __future__ import annotations

import math
import random
import struct
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from asyncua import Client, ua
from asyncua.crypto.cert_gen import generate_private_key, generate_self_signed_app_certificate
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import ExtendedKeyUsageOID

from pcaccess.gateway.gateway import Gateway
from pcaccess.items.quality import Limit, Quality
from pcaccess.items.table import as_rows
from pcaccess.opcua.server import SECURE, Identity, OpcUaServer
from pcaccess.project.load import load_text
from tests.clocks import HandClock
from tests.opcua.conftest import PLANT

PLC = "MicroWin.NewPLC."
ITEMS = ["Motor", "Temperature", "High", "Setpoint", "Scaled", "Level", "Signed", "Unsigned"]
ITEMS += ["Big", "Huge", "Text", "Row", "Bits", "Input", "Command", "Clock"]
KINDS = {
    "Motor": ua.VariantType.Boolean,
    "Temperature": ua.VariantType.Int16,
    "High": ua.VariantType.Byte,
    "Setpoint": ua.VariantType.Int16,
    "Scaled": ua.VariantType.Float,
    "Level": ua.VariantType.Float,
    "Signed": ua.VariantType.SByte,
    "Unsigned": ua.VariantType.UInt16,
    "Big": ua.VariantType.Int32,
    "Huge": ua.VariantType.UInt32,
    "Input": ua.VariantType.Boolean,
    "Command": ua.VariantType.Int16,
}
Security = ua.MessageSecurityMode


@dataclass
class Plant:
    gateway: Gateway
    server: OpcUaServer
    client: Client
    clock: HandClock

    @property
    def plane(self) -> Any:
        return self.server._server.internal.plane

    async def both(self, call: Any, params: Any) -> tuple[Any, Any, bool]:
        """The answer with the data plane, the one without, and whether it was used."""
        answered = self.plane.answered
        fast = await call(params)
        used = self.plane.answered > answered
        await self.without()
        slow = await call(params)
        await self.with_plane()
        return fast, slow, used

    async def without(self) -> None:
        self.plane.enabled = False
        await self.client.nodes.server.read_browse_name()  # whatever a connection remembers is forgotten by this

    async def with_plane(self) -> None:
        self.plane.enabled = True


def certificate(folder: Path, name: str) -> tuple[Path, Path]:
    key = generate_private_key()
    address = [x509.UniformResourceIdentifier(f"urn:{name}"), x509.DNSName("localhost")]
    usages = [ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH]
    made = generate_self_signed_app_certificate(key, name, {"countryName": "DE"}, address, usages)
    paths = folder / f"{name}.der", folder / f"{name}.pem"
    paths[0].write_bytes(made.public_bytes(Encoding.DER))
    paths[1].write_bytes(key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))
    return paths


@asynccontextmanager
async def plant(folder: Path, mode: Security) -> AsyncIterator[Plant]:
    clock = HandClock()
    gateway = Gateway(load_text(PLANT).project, clock)
    gateway.show()
    identity = None if mode is Security.None_ else Identity(*certificate(folder, "server"), SECURE)
    server = OpcUaServer(gateway, "opc.tcp://127.0.0.1:0/test", identity)
    await server.start()
    client = Client(server.url, timeout=40, watchdog_intervall=40)
    if mode is not Security.None_:
        own, own_key = certificate(folder, "client")
        client.application_uri = "urn:client"
        await client.set_security(SecurityPolicyBasic256Sha256, own, own_key, None, folder / "server.der", mode)
    try:
        async with client:
            yield Plant(gateway, server, client, clock)
    finally:
        await server.stop()


# -- requests ----------------------------------------------------------------------------------------------------------


def node_id(text: str) -> ua.NodeId:
    return ua.NodeId.from_string(text)


def any_name(dice: random.Random) -> str:
    name = f"ns=2;s={PLC}{dice.choice(ITEMS)}"
    twist = dice.random()
    if twist < 0.6:
        return name
    if twist < 0.7:
        return dice.choice([name.upper().replace("NS=2;S=", "ns=2;s="), "ns=2;s=MicroWin.Dead.Value"])
    if twist < 0.8:
        return dice.choice(["ns=2;s=2,VW700,INT", "ns=2;s=2,VB300,STRING", "ns=2;s=2,QB0,byte", "ns=2;s=9,VW0,INT"])
    return dice.choice(
        [
            "ns=2;s=MicroWin.Dead.Text",
            "ns=2;s=MicroWin.NewPLC.Nothing",
            "ns=2;s=Grüße",
            "ns=2;s=",
            "ns=2;s=MicroWin.NewPLC",
            "ns=2;i=77",
            "ns=3;i=1",
            "ns=3;s=MicroWin.NewPLC.Motor/Quality",
            "ns=7;s=x",
            "i=2267",
            "ns=2;g=00000000-0000-0000-0000-000000000001",
            "ns=2;b=bytes",
        ]
    )


def any_read(dice: random.Random) -> ua.ReadParameters:
    wanted = []
    odd = dice.random() < 0.3
    for _ in range(dice.choice([1, 1, 2, 5, 9, 40])):
        attribute = ua.AttributeIds(dice.choice([13, 1, 4, 14, 17])) if odd and dice.random() < 0.3 else 13
        part = dice.choice(["0", "1:2", "5:3", "x"]) if odd and dice.random() < 0.3 else None
        wanted.append(ua.ReadValueId(node_id(any_name(dice)), attribute, part))
    times = ua.TimestampsToReturn(dice.randrange(4))
    return ua.ReadParameters(dice.choice([0.0, 5.0, 1e9]), times, wanted)


def any_value(dice: random.Random, kind: ua.VariantType) -> Any:
    if kind == ua.VariantType.Boolean:
        return dice.random() < 0.5
    if kind == ua.VariantType.Float:
        return dice.choice([0.0, -0.0, 1.5, 3.4e38, math.inf, math.nan, 10.1, struct.unpack("f", b"\1\0\0\0")[0]])
    low, high = {
        ua.VariantType.Byte: (0, 255),
        ua.VariantType.SByte: (-128, 127),
        ua.VariantType.Int16: (-(2**15), 2**15 - 1),
        ua.VariantType.UInt16: (0, 2**16 - 1),
        ua.VariantType.Int32: (-(2**31), 2**31 - 1),
        ua.VariantType.UInt32: (0, 2**32 - 1),
    }[kind]
    return dice.choice([low, high, 0, dice.randint(low, high)])


def any_write(dice: random.Random) -> ua.WriteParameters:
    writes = []
    odd = dice.random() < 0.3
    for _ in range(dice.choice([1, 1, 2, 20, 40])):
        item = dice.choice(sorted(KINDS))
        name = f"ns=2;s={PLC}{item}" if dice.random() < 0.9 else any_name(dice)
        kind = KINDS[item] if dice.random() < 0.9 else dice.choice(sorted(KINDS.values()))
        value = ua.DataValue(ua.Variant(any_value(dice, kind), kind))
        if dice.random() < 0.4:
            stamp = datetime(2026, 1, 1, tzinfo=UTC)
            value = ua.DataValue(value.Value, ua.StatusCode(0), stamp, stamp, 1, 1)
        if odd and dice.random() < 0.3:
            value = dice.choice(
                [
                    ua.DataValue(ua.Variant("text", ua.VariantType.String)),
                    ua.DataValue(ua.Variant([1, 2, 3, 4], ua.VariantType.Int16)),
                    ua.DataValue(ua.Variant(1, ua.VariantType.Int16), ua.StatusCode(ua.StatusCodes.Bad)),
                    ua.DataValue(),
                ]
            )
        writes.append(ua.WriteValue(node_id(name), ua.AttributeIds.Value, None, value))
    return ua.WriteParameters(writes)


def disturb(dice: random.Random, gateway: Gateway) -> None:
    """Qualities with limits, values in every item, PLCs lost and back."""
    row = gateway.find(PLC + dice.choice(ITEMS))
    assert row is not None
    gateway.table.set_quality(as_rows(row), dice.choice(list(Quality)), gateway.now(), dice.choice(list(Limit)))
    if dice.random() < 0.1:
        gateway.lost("MicroWin.NewPLC", Quality.COMM_FAILURE)
    elif dice.random() < 0.5:
        gateway.received("MicroWin.NewPLC", bytes(dice.randrange(256) for _ in range(900)), 984 + dice.randrange(9))


MODES = [Security.None_, Security.Sign, Security.SignAndEncrypt]


def plain(value: ua.DataValue) -> tuple[Any, ...]:
    """What a client sees; NaN by its bytes."""
    content = value.Value
    inner = content.Value if content is not None else None
    if isinstance(inner, float):
        inner = struct.pack("<d", inner)
    kind = content.VariantType if content is not None and inner is not None else None
    return kind, inner, value.StatusCode, value.SourceTimestamp, value.ServerTimestamp


@pytest.mark.parametrize("mode", MODES, ids=lambda m: m.name)
async def test_reads_are_answered_alike(tmp_path: Path, mode: Security) -> None:
    dice = random.Random(7)
    async with plant(tmp_path, mode) as running:
        used = 0
        for _ in range(150):
            disturb(dice, running.gateway)
            running.clock.move(0.05)
            params = any_read(dice)
            for _ in range(2):  # the second time from a plan that was made before
                fast, slow, by_plane = await running.both(running.client.uaclient.read, params)
                assert list(map(plain, fast)) == list(map(plain, slow)), params
                used += by_plane
        assert used > 60


@pytest.mark.parametrize("mode", MODES, ids=lambda m: m.name)
async def test_writes_are_answered_alike_and_leave_the_same(tmp_path: Path, mode: Security) -> None:
    dice = random.Random(11)
    async with plant(tmp_path, mode) as running:
        used = 0
        driver = running.gateway.driver("MicroWin")
        memory = driver._plcs["MicroWin.NewPLC"].memory
        for _ in range(150):
            running.clock.move(0.05)
            params = any_write(dice)
            before = bytes(memory)
            answered = running.plane.answered
            fast = await running.client.uaclient.write(params)
            used += running.plane.answered > answered
            after = bytes(memory)
            values = [running.gateway.sample(r).value for r in range(len(ITEMS))]
            memory[:] = before
            driver.show()
            await running.without()
            slow = await running.client.uaclient.write(params)
            await running.with_plane()
            assert fast == slow, params
            assert after == bytes(memory), params
            again = [running.gateway.sample(r).value for r in range(len(ITEMS))]
            assert repr(values) == repr(again)
        assert used > 60


def many_places(dice: random.Random) -> list[tuple[str, ua.VariantType]]:
    """Run-time names of places that do not overlap, of all lengths and types; in any order."""
    places = []
    for n in range(dice.choice([16, 40, 200])):
        at = 2000 + 8 * n
        kind, text = dice.choice(
            [
                (ua.VariantType.Boolean, f"V{at}.{n % 8},BOOL"),
                (ua.VariantType.SByte, f"VB{at},CHAR"),
                (ua.VariantType.Byte, f"VB{at},BYTE"),
                (ua.VariantType.Int16, f"VW{at},INT"),
                (ua.VariantType.UInt16, f"VW{at},WORD"),
                (ua.VariantType.Int32, f"VD{at},DINT"),
                (ua.VariantType.UInt32, f"VD{at},DWORD"),
                (ua.VariantType.Float, f"VD{at},REAL"),
            ]
        )
        places.append((f"ns=2;s=2,{text}", kind))
    dice.shuffle(places)
    return places


@pytest.mark.parametrize("mode", MODES, ids=lambda m: m.name)
async def test_bulk_requests_are_answered_alike_and_leave_the_same(tmp_path: Path, mode: Security) -> None:
    """Many nodes of one request, registered ones and unknown ones among them, in another order each time."""
    dice = random.Random(13)
    async with plant(tmp_path, mode) as running:
        client, driver = running.client, running.gateway.driver("MicroWin")
        memory = driver._plcs["MicroWin.NewPLC"].memory
        handles = [
            node.nodeid
            for node in await client.register_nodes([client.get_node(f"ns=2;s={PLC}{item}") for item in ITEMS[:5]])
        ]
        for turn in range(30):
            running.clock.move(0.05)
            places = many_places(dice)
            refused = turn % 3 == 0
            writes = []
            for name, kind in places:
                given = dice.choice(sorted(KINDS.values())) if refused and dice.random() < 0.1 else kind
                value = ua.DataValue(ua.Variant(any_value(dice, given), given))
                if dice.random() < 0.2:
                    value = ua.DataValue(value.Value, ua.StatusCode(0), datetime(2026, 1, 1, tzinfo=UTC))
                writes.append(ua.WriteValue(node_id(name), ua.AttributeIds.Value, None, value))
            if refused:
                extra = ua.DataValue(ua.Variant(1, ua.VariantType.Int16))
                for name in ("ns=2;s=MicroWin.NewPLC.Nothing", f"ns=2;s={PLC}Input", "ns=2;s=MicroWin.Dead.Value"):
                    writes.insert(
                        dice.randrange(len(writes)),
                        ua.WriteValue(node_id(name), ua.AttributeIds.Value, None, extra),
                    )
            before, answered = bytes(memory), running.plane.answered
            fast = await client.uaclient.write(ua.WriteParameters(writes))
            assert running.plane.answered > answered
            after = bytes(memory)
            memory[:] = before
            driver.show()
            await running.without()
            slow = await client.uaclient.write(ua.WriteParameters(writes))
            await running.with_plane()
            assert fast == slow
            assert after == bytes(memory)

            nodes = [node_id(name) for name, _ in places] + [node_id(f"ns=2;s={PLC}{item}") for item in ITEMS]
            nodes += [*handles, node_id("ns=2;s=MicroWin.NewPLC.Nothing"), node_id("ns=2;s=2,VB300,STRING")]
            dice.shuffle(nodes)
            params = ua.ReadParameters(
                0.0,
                ua.TimestampsToReturn(dice.randrange(4)),
                [ua.ReadValueId(node, ua.AttributeIds.Value) for node in nodes],
            )
            read, stock, used = await running.both(client.uaclient.read, params)
            assert used
            assert list(map(plain, read)) == list(map(plain, stock))


async def test_a_large_reply_comes_in_chunks_alike(tmp_path: Path) -> None:
    async with plant(tmp_path, Security.SignAndEncrypt) as running:
        names = [f"ns=2;s=2,VB{n},STRING" for n in range(900)]
        running.gateway.received("MicroWin.NewPLC", b"\xfe" * 4000, 1500)
        params = ua.ReadParameters(
            0.0, ua.TimestampsToReturn.Both, [ua.ReadValueId(node_id(n), ua.AttributeIds.Value) for n in names]
        )
        fast, slow, used = await running.both(running.client.uaclient.read, params)
        assert used
        assert sum(len(str(v.Value.Value)) for v in fast) > 150_000
        assert list(map(plain, fast)) == list(map(plain, slow))


async def test_times_are_those_of_the_moment(tmp_path: Path) -> None:
    async with plant(tmp_path, Security.None_) as running:
        node = running.client.get_node(f"ns=2;s={PLC}Temperature")
        first = await node.read_data_value()
        running.clock.move(5)
        second = await node.read_data_value()
        assert second.SourceTimestamp - first.SourceTimestamp == timedelta(seconds=5)
        assert running.plane.answered >= 2
