"""The servers that ``bench/opcua.py`` compares, each in a process of its own.

As a script this file is one of them: it prints ``ready PORT NAMESPACE-INDEX``, changes the values of its first items
every 100 ms while it is told ``go`` (``rest`` ends that) and leaves when its standard input closes. The JavaScript
server beside it keeps to the same rules.

Item n is a REAL (Float) for even n, an INT (Int16) for odd n, in folders of 100, named alike in every server.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import select
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

HOST = "127.0.0.1"
PERIOD = 0.1
"""Seconds between two changes of every value."""
PER_FOLDER, FOLDERS = 100, 20
PER_PLC = PER_FOLDER * FOLDERS
MOVING = 1000
"""So many items change; beyond them they are there for their memory alone."""
START_PATIENCE = 400.0
HEADER = "Tag Name,Address,Data Type,Respect Data Type,Client Access,Scan Rate\n"
URI = "urn:pcaccess:bench"

Change = Callable[[int], Awaitable[None]]


class ServerMissing(Exception):
    """This server cannot run here; the text says why."""


def folder_of(n: int) -> tuple[str, str]:
    """Identifiers of the PLC and of the folder of item ``n``."""
    plc, place = divmod(n, PER_PLC)
    return f"Soft.P{plc:02}", f"Soft.P{plc:02}.F{place // PER_FOLDER:02}"


def item_id(n: int) -> str:
    """Of one length for every ``n`` below 200,000, which keeps requests patchable."""
    return f"{folder_of(n)[1]}.I{n % PER_FOLDER:02}"


def is_real(n: int) -> bool:
    return n % 2 == 0


class Told:
    """What the bench wants of this process; ends it with the bench."""

    def __init__(self) -> None:
        self.changing = False
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        for line in sys.stdin:
            self.changing = line.strip() == "go"
        os._exit(0)


async def keep_changing(port: int, index: int, change: Change) -> None:
    print("ready", port, index, flush=True)
    told, turn, due = Told(), 0, time.monotonic()
    while True:
        due = max(due + PERIOD, time.monotonic())
        await asyncio.sleep(due - time.monotonic())
        if told.changing:
            turn += 1
            await change(turn)


# ---------------------------------------------------------------------- ours


def write_project(folder: Path, items: int) -> Path:
    """A soft link; every PLC's items lie side by side in V memory, six bytes for a REAL and an INT."""
    plcs = []
    for first in range(0, items, PER_PLC):
        rows = []
        for n in range(first, min(first + PER_PLC, items)):
            at = (n - first) // 2 * 6
            address, kind = (f"VD{at}", "Float") if is_real(n) else (f"VW{at + 4}", "Short")
            rows.append(f"{item_id(n)[len('Soft.P00.') :]},{address},{kind},1,R/W,100\n")
        name = folder_of(first)[0][len("Soft.") :]
        (folder / f"{name}.csv").write_text(HEADER + "".join(rows))
        plcs.append(f"      - {{name: {name}, cpu: CPU 226, address: {len(plcs) + 1}, items_from: {name}.csv}}\n")
    path = folder / "items.yaml"
    none = "      - {name: P00, cpu: CPU 226, address: 1, items: []}\n"
    path.write_text("project: Bench\nlinks:\n  - name: Soft\n    type: soft\n    plcs:\n" + ("".join(plcs) or none))
    return path


async def ours(options: argparse.Namespace) -> None:
    from pcaccess.clock import SystemClock
    from pcaccess.collector import settle
    from pcaccess.gateway.gateway import Gateway
    from pcaccess.links.base import RawWrite
    from pcaccess.opcua.server import Identity, OpcUaServer
    from pcaccess.project.load import load_project
    from pcaccess.s7200.address import parse_address
    from pcaccess.s7200.types import DataType

    with tempfile.TemporaryDirectory() as folder:
        project = load_project(write_project(Path(folder), options.items)).project
    gateway = Gateway(project, SystemClock())
    gateway.show()
    identity = Identity(Path(options.certificate), Path(options.key)) if options.certificate else None
    server = OpcUaServer(gateway, f"opc.tcp://{HOST}:0/pcaccess", identity)
    await server.start()
    settle()  # as ``pcaccess run`` does
    driver, whole = gateway.driver("Soft"), parse_address("VB0")
    pairs = min(options.items, MOVING) // 2

    async def change(turn: int) -> None:
        import numpy as np

        block = np.empty(pairs, dtype=[("real", ">f4"), ("int", ">i2")])
        block["real"] = block["int"] = (turn + np.arange(pairs)) % 30000
        await driver.write("Soft.P00", [RawWrite("", whole, DataType.BYTE, block.tobytes())])

    async with asyncio.TaskGroup() as tasks:
        tasks.create_task(gateway.run())
        tasks.create_task(keep_changing(server.port, 2, change))


# ---------------------------------------------------------------------- stock asyncua


async def stock(options: argparse.Namespace) -> None:
    from asyncua import Server, ua

    server = Server()
    await server.init()
    server.set_endpoint(f"opc.tcp://{HOST}:{options.port}/stock")
    await server.set_application_uri(URI)
    policies = [ua.SecurityPolicyType.NoSecurity]
    if options.certificate:
        policies.append(ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt)
        await server.load_certificate(options.certificate)
        await server.load_private_key(options.key)
    server.set_security_policy(policies)
    index = await server.register_namespace("urn:bench")
    ids, folder, plc = [], server.nodes.objects, server.nodes.objects
    for n in range(options.items):
        plc_id, folder_id = folder_of(n)
        if n % PER_PLC == 0:
            plc = await server.nodes.objects.add_folder(ua.NodeId(plc_id, index), plc_id)
        if n % PER_FOLDER == 0:
            folder = await plc.add_folder(ua.NodeId(folder_id, index), folder_id)
        kind = ua.VariantType.Float if is_real(n) else ua.VariantType.Int16
        node = await folder.add_variable(ua.NodeId(item_id(n), index), f"I{n % PER_FOLDER:02}", 0, kind)
        await node.set_writable()
        if n < MOVING:
            ids.append((node.nodeid, kind))
    await server.start()

    async def change(turn: int) -> None:
        for n, (node_id, kind) in enumerate(ids):
            value = ua.Variant((turn + n) % 30000, kind)
            await server.write_attribute_value(node_id, ua.DataValue(value, SourceTimestamp=ua.datetime.now()))

    await keep_changing(options.port, index, change)


# ---------------------------------------------------------------------- open62541


async def open62541(options: argparse.Namespace) -> None:
    import o6

    security = {}
    if options.certificate:
        security = {
            "certificate": options.certificate,
            "privateKey": options.key,
            "acceptAllCertificates": True,
            "applicationUri": URI,
        }
    server: Any = o6.Server(port=options.port, **security)
    moving, folder, plc = [], server.objectsNode, server.objectsNode
    for n in range(options.items):
        plc_id, folder_id = folder_of(n)
        if n % PER_PLC == 0:
            plc = await server.addObject(plc_id, server.objectsNode, nodeId=f"ns=1;s={plc_id}")
        if n % PER_FOLDER == 0:
            folder = await server.addObject(folder_id, plc, nodeId=f"ns=1;s={folder_id}")
        kind = o6.Float if is_real(n) else o6.Int16
        node_id = o6.NodeId(f"ns=1;s={item_id(n)}")
        await server.addVariable(f"I{n % PER_FOLDER:02}", folder, kind(0), nodeId=node_id)
        if n < MOVING:
            moving.append((node_id, kind))
    server.start()

    async def change(turn: int) -> None:
        await server.write({node: kind((turn + n) % 30000) for n, (node, kind) in enumerate(moving)})

    await keep_changing(options.port, 1, change)


# ---------------------------------------------------------------------- from the bench's side


class Running:
    """A server process. Raises ServerMissing when it does not come up."""

    def __init__(self, name: str, items: int, peers: Path, certificates: Path | None = None) -> None:
        port = free_port()
        command, environment = command_of(name, peers)
        command += ["--items", str(items), "--port", str(port)]
        if certificates is not None:
            command += ["--certificate", str(certificates / f"{name}.der"), "--key", str(certificates / f"{name}.pem")]
        self.name = name
        with tempfile.TemporaryFile("w+") as complaints:
            self._process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=complaints, text=True, env=environment
            )
            try:
                self.port, self.index = self._ready()
            except ServerMissing as missing:
                self.stop()
                complaints.seek(0)
                lines = [line.strip() for line in complaints.read().splitlines() if line.strip()]
                raise ServerMissing(f"{missing}: {lines[-1] if lines else 'it said nothing'}") from None

    def _ready(self) -> tuple[int, int]:
        out = self._process.stdout
        assert out is not None
        end = time.monotonic() + START_PATIENCE
        while select.select([out], [], [], max(0.0, end - time.monotonic()))[0]:
            words = out.readline().split()
            if not words and self._process.poll() is not None:
                raise ServerMissing("it ended while starting")
            if words[:1] == ["ready"]:
                return int(words[1]), int(words[2])
        raise ServerMissing(f"not ready after {START_PATIENCE:g} s")

    @property
    def url(self) -> str:
        return f"opc.tcp://{HOST}:{self.port}"

    def tell(self, word: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(word + "\n")
        self._process.stdin.flush()

    def resident(self) -> int:
        """Bytes of the process in memory."""
        pages = int(Path(f"/proc/{self._process.pid}/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE")

    def stop(self) -> None:
        self._process.kill()
        self._process.communicate()


def free_port() -> int:
    with socket.create_server((HOST, 0)) as probe:
        return int(probe.getsockname()[1])


def command_of(name: str, peers: Path) -> tuple[list[str], dict[str, str]]:
    here = Path(__file__).resolve()
    environment = dict(os.environ)
    if name == "node-opcua":
        environment["NODE_PATH"] = str(peers / "node_modules")
        environment["HOME"] = str(peers)  # it keeps its certificates below
        return ["node", str(here.parent / "_node_opcua_server.js")], environment
    before = [str(here.parent.parent)] + ([str(peers / "python")] if name == "open62541" else [])
    environment["PYTHONPATH"] = os.pathsep.join(before)
    return [sys.executable, str(here), name], environment


SERVERS = {"ours": ours, "stock": stock, "open62541": open62541}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("server", choices=SERVERS)
    parser.add_argument("--items", type=int, required=True)
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--certificate")
    parser.add_argument("--key")
    options = parser.parse_args()
    asyncio.run(SERVERS[options.server](options))


if __name__ == "__main__":
    main()
