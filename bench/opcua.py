"""OPC UA reads and writes: our server beside stock asyncua, node-opcua and open62541, in one run.

    python bench/opcua.py [--json | --markdown] [--servers ours,stock,node-opcua,open62541] [--seconds 1.5] [--rounds 3]
                          [--items 1000] [--memory-items 100000] [--peers FOLDER]

Every server runs in a process of its own with the same items (half Float, half Int16, 100 to a folder, all changing
every 100 ms; only the server being measured changes them) and is driven by one raw client with 64 requests for one
node, or 16 for many, in flight. "Repeated" sends the same request again and again (handle and time stamp count on, as
any client's do); "fresh" never sends the same twice, so that no cache of requests helps. Servers take turns within a
round; the best of the rounds counts, since noise only takes away. Memory is the resident set of the whole process, less
that of the same server without items.

node-opcua (npm) and open62541 (PyPI ``o6``) are installed into ``--peers``, or into a folder that is gone afterwards;
what cannot be installed or started is reported and left out. o6 listens on every address and can not be told
otherwise, so the whole run moves into a network namespace of its own (``unshare``); where that is not permitted,
open62541 is left out. Its free mode ends after ten minutes: every round starts it anew.

Sources of the targets: issue "The data plane I", section Speed. Ratios are to the best of the other servers.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import fcntl
import json
import logging
import os
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from _opcua_client import CLIENT_URI, Channel, Requests, WrongAnswer
from _opcua_servers import URI, Running, ServerMissing
from asyncua.crypto.cert_gen import setup_self_signed_certificate
from cryptography.x509.oid import ExtendedKeyUsageOID

OURS = "ours"
NAMES = (OURS, "stock", "node-opcua", "open62541")
MOST_AHEAD = 8000
"""Encrypted messages made before a measurement."""

WORK: dict[str, Callable[[Requests], Any]] = {
    "read 1, repeated": lambda r: r.read_one(repeated=True),
    "read 1, fresh": lambda r: r.read_one(repeated=False),
    "read all, repeated": lambda r: r.read_all(repeated=True),
    "read all, fresh": lambda r: r.read_all(repeated=False),
    "write 1": lambda r: r.write_one(),
    "write all": lambda r: r.write_all(),
}
SECURED = ("read 1, fresh", "read all, fresh")
WARM_UP = ("read 1, fresh", "read 1, fresh", "read all, fresh", "write 1", "write all")
"""Done once, uncounted: node-opcua's rate grows tenfold in its first seconds, while V8 compiles it."""
RATES = {
    "read 1, repeated": 1.0,
    "read 1, fresh": 1.0,
    "read all, repeated": 10.0,
    "read all, fresh": 2.0,
    "write all": 0.7,
}
"""At least so many times the rate of the best other server."""
MEMORY_SHARE = 0.5
"""At most so much of the memory per item of the best other server."""

Figures = dict[str, dict[str, float]]
"""By row of the table, by server."""


@dataclass
class Report:
    """What a run found."""

    rates: Figures = field(default_factory=dict)
    """Requests per second."""
    latencies: Figures = field(default_factory=dict)
    """Seconds."""
    memory: dict[str, float] = field(default_factory=dict)
    """Bytes per item."""
    notes: list[str] = field(default_factory=list)
    """What is missing and why."""
    busiest: float = 0.0
    """The client's largest share of a core."""

    def note(self, text: str) -> None:
        if text not in self.notes:
            self.notes.append(text)

    def faster(self, row: str, server: str, rate: float) -> None:
        known = self.rates.setdefault(row, {})
        known[server] = max(known.get(server, 0.0), rate)

    def quicker(self, row: str, server: str, seconds: float) -> None:
        known = self.latencies.setdefault(row, {})
        known[server] = min(known.get(server, seconds), seconds)


# ---------------------------------------------------------------------- measuring


def measure(options: argparse.Namespace, servers: Sequence[str], certificates: Path) -> Report:
    report = Report()
    for turn in range(options.rounds):
        run_round(options, rotated(servers, turn), certificates, report)
    if options.memory_items:
        for server in servers:
            try:
                share = memory_of(server, options.memory_items, options.peers) - memory_of(server, 0, options.peers)
                report.memory[server] = share / options.memory_items
            except ServerMissing as missing:
                report.note(f"{server}, memory: {missing}")
    return report


def rotated(servers: Sequence[str], turn: int) -> list[str]:
    at = turn % len(servers)
    return [*servers[at:], *servers[:at]]


def run_round(options: argparse.Namespace, servers: Sequence[str], certificates: Path, report: Report) -> None:
    with contextlib.ExitStack() as running:
        started = {}
        for name in servers:
            with reported(report, name):
                started[name] = running.enter_context(server_of(name, options, certificates))
        clients = {}
        for name, server in started.items():
            with reported(report, name):
                clients[name] = running.enter_context(contextlib.closing(Channel(server.url)))
        requests = {name: Requests(started[name].index, options.items) for name in clients}
        for name, client in clients.items():
            with reported(report, f"{name}, warming up"), changing(started[name]):
                for row in WARM_UP:
                    client.rate(WORK[row](requests[name]), options.seconds)
        for row, request in WORK.items():
            for name, client in clients.items():
                with reported(report, f"{name}, {row}"), changing(started[name]):
                    rate = client.rate(request(requests[name]), options.seconds)
                    report.faster(row, name, rate.requests)
                    report.busiest = max(report.busiest, rate.busy)
        for name, client in clients.items():
            with reported(report, f"{name}, latency"), changing(started[name]):
                latency = client.latency(requests[name].read_one(repeated=False), options.seconds)
                report.quicker("read 1, p50", name, latency.p50)
                report.quicker("read 1, p99", name, latency.p99)
        for name, server in started.items():
            with reported(report, f"{name}, Basic256Sha256"), changing(server):
                measure_secured(name, server, requests[name], options.seconds, certificates, report)


def measure_secured(
    name: str, server: Running, requests: Requests, seconds: float, certificates: Path, report: Report
) -> None:
    """Fresh reads over an encrypted channel; the encrypted requests are ready before the clock starts."""
    with contextlib.closing(Channel(server.url, certificates)) as client:
        for row in SECURED:
            ahead = min(MOST_AHEAD, int(report.rates[row][name] * seconds) + 1)
            rate = client.rate(WORK[row](requests), seconds, ahead)
            report.faster(f"{row}, encrypted", name, rate.requests)


@contextlib.contextmanager
def reported(report: Report, what: str) -> Iterator[None]:
    """One server's failure is a line of the report and costs its own figures only."""
    try:
        yield
    except (ServerMissing, WrongAnswer, OSError, KeyError) as problem:
        report.note(f"{what}: {problem or type(problem).__name__}")
    except Exception as problem:  # asyncua's client has many kinds
        report.note(f"{what}: {type(problem).__name__}: {problem}")


@contextlib.contextmanager
def changing(server: Running) -> Iterator[None]:
    """While this server is measured its values change; the others rest."""
    server.tell("go")
    try:
        yield
    finally:
        server.tell("rest")


@contextlib.contextmanager
def server_of(name: str, options: argparse.Namespace, certificates: Path) -> Iterator[Running]:
    server = Running(name, options.items, options.peers, certificates)
    try:
        yield server
    finally:
        server.stop()


def memory_of(name: str, items: int, peers: Path) -> int:
    server = Running(name, items, peers)
    try:
        return server.resident()
    finally:
        server.stop()


# ---------------------------------------------------------------------- the verdict


def targets_of(report: Report, servers: Sequence[str]) -> list[dict[str, Any]]:
    """A target without a figure of ours does not hold; one without a figure of anybody else is not judged."""
    if OURS not in servers:
        return []
    targets = []
    for row, least in RATES.items():
        others = [rate for server, rate in report.rates.get(row, {}).items() if server != OURS]
        if others:
            value = report.rates[row].get(OURS, 0.0) / max(others)
            targets.append(target(row, value, f">= {least}", value >= least))
    others = [share for server, share in report.memory.items() if server != OURS]
    if others:
        # Beyond any target, and a number that JSON has, where ours did not come up.
        value = report.memory[OURS] / min(others) if OURS in report.memory else 1e9
        held = value <= MEMORY_SHARE
        targets.append(target("memory per item", value, f"<= {MEMORY_SHARE}", held))
    return targets


def target(name: str, value: float, text: str, holds: bool) -> dict[str, Any]:
    return {"name": name, "value": round(value, 3), "target": text, "holds": holds}


Cells = list[str]


def figures_of(report: Report, servers: Sequence[str], items: int) -> list[Cells]:
    """Rows of a table, what was measured first."""

    def row(name: str, figures: dict[str, float], scale: float = 1.0) -> Cells:
        return [name, *(f"{figures[s] * scale:,.0f}" if s in figures else "-" for s in servers)]

    rows = []
    for name, figures in report.rates.items():
        if " all" in name:
            rows.append(row(name.replace(" all", f" {items}") + ", values/s", figures, items))
        else:
            rows.append(row(name + ", requests/s", figures))
    rows += [row(f"{name}, µs", figures, 1e6) for name, figures in report.latencies.items()]
    return rows + ([row("memory per item, bytes", report.memory)] if report.memory else [])


def table(report: Report, servers: Sequence[str], items: int) -> list[str]:
    rows = [["", *servers], *figures_of(report, servers, items)]
    return [f"{name:38}" + "".join(f"{cell:>12}" for cell in cells) for name, *cells in rows]


def markdown(report: Report, servers: Sequence[str], items: int, targets: list[dict[str, Any]]) -> list[str]:
    """Both tables of docs/performance.md."""
    names = {"stock": "stock asyncua"}
    lines = ["| | " + " | ".join(names.get(s, s) for s in servers) + " |", "|---|" + "---:|" * len(servers)]
    lines += ["| " + " | ".join(cells) + " |" for cells in figures_of(report, servers, items)]
    lines += ["", "| target, to the best of the others | found | wanted |", "|---|---:|---:|"]
    for entry in targets:
        wanted = entry["target"].replace(">=", "≥").replace("<=", "≤")
        lines.append(f"| {entry['name'].replace(' all', f' {items}')} | {entry['value']} | {wanted} |")
    return [*lines, ""]


# ---------------------------------------------------------------------- surroundings


def install(servers: Sequence[str], peers: Path) -> list[str]:
    """Fetch the other servers; what is there stays. Returns what could not be had."""
    wanted = {
        "node-opcua": (
            peers / "node_modules" / "node-opcua-server",
            ["npm", "install", "--no-audit", "--no-fund", "--prefix", str(peers), "node-opcua-server"],
        ),
        "open62541": (
            peers / "python" / "o6",
            [sys.executable, "-m", "pip", "install", "-q", "--target", str(peers / "python"), "o6"],
        ),
    }
    failed = []
    for name, (there, command) in wanted.items():
        if name not in servers or there.exists():
            continue
        if shutil.which(command[0]) is None:
            failed.append(f"{name}: there is no {command[0]} here")
            continue
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode or not there.exists():
            lines = (done.stderr or done.stdout).strip().splitlines()
            failed.append(f"{name}: not installed: {lines[-1] if lines else done.returncode}")
    return failed


def namespace_permitted() -> bool:
    if shutil.which("unshare") is None:
        return False
    return subprocess.run(["unshare", "-rn", "true"], capture_output=True, check=False).returncode == 0


def raise_loopback() -> None:
    """A new network namespace has its loopback down (netdevice(7), SIOCSIFFLAGS, IFF_UP)."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        fcntl.ioctl(any_socket, 0x8914, struct.pack("16sh14x", b"lo", 1))


async def make_certificates(folder: Path, servers: Sequence[str]) -> None:
    """Self-signed ones for every server and the client."""
    uris = {server: "urn:pcaccess:server" if server == OURS else URI for server in servers}
    for name, uri in {**uris, "client": CLIENT_URI}.items():
        use = ExtendedKeyUsageOID.CLIENT_AUTH if name == "client" else ExtendedKeyUsageOID.SERVER_AUTH
        key, certificate = folder / f"{name}.pem", folder / f"{name}.der"
        await setup_self_signed_certificate(key, certificate, uri, socket.gethostname(), [use], {"commonName": name})


def run_inside(options: argparse.Namespace) -> int:
    if options.inside:
        raise_loopback()
    with tempfile.TemporaryDirectory() as folder:
        asyncio.run(make_certificates(Path(folder), options.servers))
        report = measure(options, options.servers, Path(folder))
    report.notes[:0] = options.missing
    targets = targets_of(report, options.servers)
    if options.json:
        figures = {"rates": report.rates, "latencies": report.latencies, "memory": report.memory}
        print(json.dumps({"targets": targets, "missing": report.notes, **figures}))
    else:
        if options.markdown:
            print("\n".join(markdown(report, options.servers, options.items, targets)))
        else:
            print("\n".join(table(report, options.servers, options.items)))
        print(f"the client used at most {report.busiest:.0%} of a core")
        for note in report.notes:
            print(f"missing: {note}")
        for entry in targets:
            print(f"{'holds' if entry['holds'] else 'MISSED'}  {entry['name']}: {entry['value']} ({entry['target']})")
    return 0 if all(entry["holds"] for entry in targets) else 1


def run_outside(options: argparse.Namespace) -> int:
    """Install what is wanted, then run again where only loopback exists."""
    with contextlib.ExitStack() as kept:
        if options.peers is None:
            options.peers = Path(kept.enter_context(tempfile.TemporaryDirectory()))
        options.peers.mkdir(parents=True, exist_ok=True)
        options.missing = install(options.servers, options.peers)
        inside = "open62541" in options.servers and namespace_permitted()
        if "open62541" in options.servers and not inside:
            options.missing.append("open62541: it listens on all addresses, and a network namespace is not permitted")
        gone = {line.partition(":")[0] for line in options.missing}
        options.servers = [server for server in options.servers if server not in gone]
        if not inside:
            return run_inside(options)
        command = ["unshare", "-rn", sys.executable, os.path.abspath(__file__), "--inside"]
        command += ["--servers", ",".join(options.servers), "--peers", str(options.peers.resolve())]
        for name in ("seconds", "rounds", "items", "memory_items"):
            command += [f"--{name.replace('_', '-')}", str(getattr(options, name))]
        for line in options.missing:
            command += ["--missing", line]
        command += ["--json"] * options.json + ["--markdown"] * options.markdown
        return subprocess.run(command, check=False).returncode


def parse(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    def servers(text: str) -> list[str]:
        names = text.split(",")
        if unknown := [name for name in names if name not in NAMES]:
            raise argparse.ArgumentTypeError(f"{', '.join(unknown)}: there are {', '.join(NAMES)}")
        return names

    def even(text: str) -> int:
        count = int(text)
        if not 2 <= count <= 1000 or count % 2:
            raise argparse.ArgumentTypeError(f"{text}: an even number of at most 1000, half Float and half Int16")
        return count

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--markdown", action="store_true", help="the tables as docs/performance.md has them")
    parser.add_argument("--servers", type=servers, default=list(NAMES), help="of " + ", ".join(NAMES))
    parser.add_argument("--seconds", type=float, default=1.5, help="of each measurement")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--items", type=even, default=1000, help="nodes of a server, and of a bulk request")
    parser.add_argument("--memory-items", type=int, default=100_000, help="0 leaves memory out")
    parser.add_argument("--peers", type=Path, help="folder for the other servers, kept for the next run")
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--missing", action="append", default=[], help=argparse.SUPPRESS)
    return parser.parse_args(arguments)


def main() -> int:
    options = parse()
    logging.getLogger("asyncua").setLevel(logging.ERROR)  # that a session's time-out was revised is no news
    return run_inside(options) if options.inside else run_outside(options)


if __name__ == "__main__":
    sys.exit(main())
