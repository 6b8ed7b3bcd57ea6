"""Start and memory: ours beside a stock asyncua server with the same nodes, in one run.

    python bench/startup.py [--json] [--items 10000,100000] [--rounds 2]

Each server starts in a process of its own: once empty, once with the items, 100 to a folder in both. An item's share
is the difference between the two, so that what a server costs by itself (asyncua's standard address space, the same
in both) does not hide it; whole figures are printed too. Ours has simulated items from a tag table; reading and
checking the project file is reported apart, since the stock server has nothing like it.

Source of the target: at most a fifth of the time and of the memory per item.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

PER_FOLDER = 100
TARGET = 0.2
HEADER = "Tag Name,Address,Data Type,Respect Data Type,Client Access,Scan Rate\n"


@dataclass
class Measured:
    """One process. Seconds and bytes; ``parse`` is reading the project."""

    seconds: float
    memory: int
    parse: float = 0.0


def resident() -> int:
    """Bytes of this process in memory."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096


def write_project(folder: Path, items: int) -> Path:
    """A project whose items come from a tag table."""
    rows = (f'F{n // PER_FOLDER}.Item{n},"RAMP(10s, 0, 100)",Float,1,RO,100\n' for n in range(items))
    (folder / "tags.csv").write_text(HEADER + "".join(rows))
    source = "items_from: tags.csv" if items else "items: []"
    path = folder / "items.yaml"
    path.write_text(f"project: Start\nlinks:\n  - {{name: Sim, type: sim, plcs: [{{name: D, {source}}}]}}\n")
    return path


async def ours(items: int) -> Measured:
    from pcaccess.clock import SystemClock
    from pcaccess.gateway.gateway import Gateway
    from pcaccess.opcua.server import OpcUaServer
    from pcaccess.project.load import load_project

    with tempfile.TemporaryDirectory() as folder:
        path = write_project(Path(folder), items)
        began = time.perf_counter()
        loaded = load_project(path)
        parse = time.perf_counter() - began
    before, began = resident(), time.perf_counter()
    gateway = Gateway(loaded.project, SystemClock())
    gateway.show()
    server = OpcUaServer(gateway, "opc.tcp://127.0.0.1:0/pcaccess")
    await server.start()
    measured = Measured(time.perf_counter() - began, resident() - before, parse)
    await server.stop()
    return measured


async def stock(items: int) -> Measured:
    from asyncua import Server, ua

    before, began = resident(), time.perf_counter()
    server = Server()
    await server.init()
    server.set_endpoint("opc.tcp://127.0.0.1:0/stock")
    server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
    index = await server.register_namespace("urn:bench")
    plc = await server.nodes.objects.add_folder(ua.NodeId("Sim.D", index), "D")
    folder = plc
    for n in range(items):
        if n % PER_FOLDER == 0:
            name = f"F{n // PER_FOLDER}"
            folder = await plc.add_folder(ua.NodeId(f"Sim.D.{name}", index), name)
        node_id = ua.NodeId(f"Sim.D.F{n // PER_FOLDER}.Item{n}", index)
        await folder.add_variable(node_id, f"Item{n}", 0.0, ua.VariantType.Float)
    await server.start()
    measured = Measured(time.perf_counter() - began, resident() - before)
    await server.stop()
    return measured


SERVERS = {"ours": ours, "stock": stock}


def in_own_process(server: str, items: int) -> Measured:
    command = [sys.executable, __file__, "--child", server, "--items", str(items)]
    answer = subprocess.run(command, capture_output=True, text=True, check=True)
    return Measured(**json.loads(answer.stdout.splitlines()[-1]))


def best(server: str, items: int, rounds: int) -> Measured:
    """The least of several rounds: noise only adds."""
    runs = [in_own_process(server, items) for _ in range(rounds)]
    return Measured(min(r.seconds for r in runs), min(r.memory for r in runs), min(r.parse for r in runs))


def compare(items: int, empty: dict[str, Measured], rounds: int) -> tuple[list[dict[str, Any]], list[str]]:
    full = {server: best(server, items, rounds) for server in SERVERS}
    time_share = {s: (full[s].seconds - empty[s].seconds) / items for s in SERVERS}
    memory_share = {s: (full[s].memory - empty[s].memory) / items for s in SERVERS}
    lines = [
        f"{items:,} items",
        *(
            f"  {server:5}  start {full[server].seconds:6.2f} s, {full[server].memory / 1e6:6.1f} MB; per item "
            f"{time_share[server] * 1e6:6.1f} µs, {memory_share[server]:6.0f} bytes"
            for server in SERVERS
        ),
    ]
    lines.append(f"  ours: reading the project {full['ours'].parse:.2f} s before that")
    whole = full["ours"].seconds / full["stock"].seconds
    lines.append(f"  whole start, ours to stock: {whole:.2f} (both load the standard address space)")
    targets = [
        target(f"start per item to stock, {items:,} items", time_share["ours"] / time_share["stock"]),
        target(f"memory per item to stock, {items:,} items", memory_share["ours"] / memory_share["stock"]),
    ]
    return targets, lines


def target(name: str, value: float) -> dict[str, Any]:
    return {"name": name, "value": round(value, 3), "target": f"<= {TARGET}", "holds": value <= TARGET}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--items", default="10000,100000")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--child", choices=SERVERS, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        print(json.dumps(asdict(asyncio.run(SERVERS[options.child](int(options.items))))))
        return 0
    empty = {server: best(server, 0, options.rounds) for server in SERVERS}
    targets, report = [], []
    for items in (int(text) for text in options.items.split(",")):
        more, lines = compare(items, empty, options.rounds)
        targets += more
        report += lines
    if options.json:
        print(json.dumps({"targets": targets}))
    else:
        print("\n".join(report))
        for entry in targets:
            print(f"{'holds' if entry['holds'] else 'MISSED'}  {entry['name']}: {entry['value']} ({entry['target']})")
    return 0 if all(entry["holds"] for entry in targets) else 1


if __name__ == "__main__":
    sys.exit(main())
