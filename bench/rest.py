"""REST, CSV and websocket of the gateway beside bare handlers of the same framework, in one run.

What is compared:
- POST /api/read and the CSV of a group, 1,000 items of which every one changes ten times a second, against a Starlette
  handler that returns the same bytes ready-made (after reading the request's body, as ours must). Rounds alternate; the
  ratio is the median of the rounds.
- /ws with 2,000 items that all change twice a second, against a bare loop that makes the same message of the same
  values with orjson and sends it, and against one that sends messages recorded from ours, ready-made. All servers run
  the same engine; the ratio is of processor time, whole process. The target is about the first loop: what changes
  cannot be ready-made.

Each server is a process of its own, the client a third one. `--json` prints {"targets": [...]}; exit code 1 when one
does not hold.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import count
from typing import Any

import numpy as np
import orjson
import uvicorn
from _http import Socket, Target, fetch, rate, request_bytes
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from pcaccess.clock import SystemClock
from pcaccess.gateway.gateway import Gateway
from pcaccess.project.load import load_text
from pcaccess.s7200.types import DataType
from pcaccess.web.server import WebServer

READ_ITEMS = 1000
WATCHED = 2000
CONNECTIONS = 8


# ---------------------------------------------------------------------- servers


def project() -> str:
    """2,000 items of one PLC, REAL and INT in turn."""
    lines = ["links:", "  - name: Plant", "    type: sim", "    plcs:", "      - name: Line", "        items:"]
    for n in range(WATCHED):
        kind = "INT" if n % 2 else "REAL"
        lines.append(f"          - {{name: Item{n:04d}, address: CONST(0), type: {kind}}}")
    members = ", ".join(f"Plant.Line.Item{n:04d}" for n in range(READ_ITEMS))
    return "\n".join([*lines, f"groups: [{{name: Thousand, update_rate: 100ms, items: [{members}]}}]"])


class Engine:
    """A gateway whose items all change every so often, as a link would change them."""

    def __init__(self, period: float) -> None:
        self.values: dict[DataType, np.ndarray[Any, Any]] = {}
        self.gateway = Gateway(load_text(project()).project, SystemClock())
        self.gateway.show()
        self._period = period
        table = self.gateway.table
        rows = np.arange(WATCHED, dtype=np.int64)
        types = np.array([table.data_type(row) is DataType.REAL for row in rows.tolist()])
        self._rows = {DataType.REAL: rows[types], DataType.INT: rows[~types]}

    async def run(self) -> None:
        numbers = np.random.default_rng(1)
        while True:
            now = self.gateway.now()
            for kind, rows in self._rows.items():
                fresh = numbers.uniform(-20_000, 20_000, len(rows))
                values = fresh.astype(np.float32) if kind is DataType.REAL else fresh.astype("<i2")
                self.gateway.table.put_numbers(kind, rows, values, now)
                self.values[kind] = values
            await asyncio.sleep(self._period)


async def serve_ours(period: float) -> None:
    engine = Engine(period)
    server = WebServer(engine.gateway, "127.0.0.1:0")
    await server.start()
    async with asyncio.TaskGroup() as tasks:
        tasks.create_task(server.run())
        await _answer_parent(engine, server.port)


async def serve_bare(period: float, ready: dict[str, bytes], messages: list[str]) -> None:
    """The same engine, and handlers that know their answers; without ``messages`` they are made of the values."""
    engine = Engine(period)
    listeners: set[WebSocket] = set()
    places = np.concatenate([np.arange(0, WATCHED, 2), np.arange(1, WATCHED, 2)])

    def made() -> str:
        message = {
            "type": "changes",
            "name": "",
            "n": places,
            "value": np.concatenate(list(engine.values.values())).tolist(),
            "quality": 192,
            "time": f"{datetime.now(UTC):%Y-%m-%dT%H:%M:%S.%f}Z",
        }
        return orjson.dumps(message, option=orjson.OPT_SERIALIZE_NUMPY).decode()

    async def read(request: Request) -> Response:
        await request.body()
        return Response(ready["read"], media_type="application/json")

    async def csv(request: Request) -> Response:
        return Response(ready["csv"], media_type="text/csv; charset=utf-8")

    async def ws(websocket: WebSocket) -> None:
        await websocket.accept()
        listeners.add(websocket)
        try:
            await websocket.receive_text()
        except WebSocketDisconnect:
            listeners.discard(websocket)

    async def send() -> None:
        for n in count():
            message = messages[n % len(messages)] if messages else made() if listeners else ""
            for websocket in tuple(listeners):
                await websocket.send_text(message)
            await asyncio.sleep(0.5)

    routes = [
        Route("/api/read", read, methods=["POST"]),
        Route("/api/groups/Thousand.csv", csv, methods=["GET"]),
        WebSocketRoute("/ws", ws),
    ]
    config = uvicorn.Config(
        Starlette(routes=routes),
        port=0,
        http="httptools",
        ws="websockets-sansio",
        ws_per_message_deflate=False,
        lifespan="off",
        log_config=None,
        access_log=False,
        proxy_headers=False,
        server_header=False,
        date_header=False,
    )
    server = uvicorn.Server(config)
    config.load()
    server.lifespan = config.lifespan_class(config)
    await server.startup()
    async with asyncio.TaskGroup() as tasks:
        if not ready:
            tasks.create_task(send())
        await _answer_parent(engine, server.servers[0].sockets[0].getsockname()[1])


async def _answer_parent(engine: Engine, port: int) -> None:
    """Say where we listen; then for each line on standard input the processor time used so far."""
    print(port, flush=True)
    loop = asyncio.get_running_loop()

    def answer() -> None:
        if not sys.stdin.readline():
            loop.call_soon(asyncio.get_running_loop().stop)
            return
        print(time.process_time(), flush=True)

    loop.add_reader(sys.stdin, answer)
    await engine.run()


@dataclass(slots=True)
class Server:
    """A server process as the client sees it."""

    process: subprocess.Popen[str]
    target: Target

    def cpu(self) -> float:
        """Seconds of processor time used so far."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return float(self.process.stdout.readline())


@contextmanager
def server(kind: str, period: float, extra: dict[str, Any] | None = None) -> Iterator[Server]:
    process = subprocess.Popen(
        [sys.executable, __file__, "--serve", kind, "--period", str(period)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        process.stdin.write(json.dumps(extra or {}) + "\n")
        process.stdin.flush()
        yield Server(process, Target("127.0.0.1", int(process.stdout.readline())))
    finally:
        process.kill()
        process.wait()


# ---------------------------------------------------------------------- measuring


@dataclass(frozen=True, slots=True)
class Compared:
    """Answers per second, and per second of the server's processor time."""

    ours: float
    bare: float
    ratio: float
    cpu_ratio: float


async def compare_rates(ours: Server, bare: Server, method: str, path: str, body: bytes, seconds: float) -> Compared:
    rounds = 7
    rates: dict[str, list[float]] = {"ours": [], "bare": []}
    per_cpu: dict[str, list[float]] = {"ours": [], "bare": []}
    for _ in range(rounds):
        for name, one in (("ours", ours), ("bare", bare)):
            request = request_bytes(one.target, method, path, body)
            before, started = one.cpu(), time.perf_counter()
            answers = await rate(one.target, request, seconds / rounds, CONNECTIONS)
            rates[name].append(answers)
            per_cpu[name].append(answers * (time.perf_counter() - started) / (one.cpu() - before))
    return Compared(
        statistics.median(rates["ours"]),
        statistics.median(rates["bare"]),
        _median_ratio(rates),
        _median_ratio(per_cpu),
    )


def _median_ratio(rounds: dict[str, list[float]]) -> float:
    return statistics.median(o / b for o, b in zip(rounds["ours"], rounds["bare"], strict=True))


async def bulk(seconds: float) -> list[Compared]:
    """Bulk read and CSV."""
    names = [f"Plant.Line.Item{n:04d}" for n in range(READ_ITEMS)]
    body = json.dumps({"items": names}).encode()
    path = "/api/groups/Thousand.csv"
    with server("ours", 0.1) as ours:
        read = await fetch(ours.target, request_bytes(ours.target, "POST", "/api/read", body))
        csv = await fetch(ours.target, request_bytes(ours.target, "GET", path))
        with server("bare", 0.1, {"read": read.decode(), "csv": csv.decode()}) as bare:
            return [
                await compare_rates(ours, bare, "POST", "/api/read", body, seconds),
                await compare_rates(ours, bare, "GET", path, b"", seconds),
            ]


@dataclass(frozen=True, slots=True)
class Watched:
    """Processor time of the servers, in percent of one core."""

    ours: float
    making: float
    """A bare loop that makes and sends the messages."""
    sending: float
    """A bare loop that sends recorded ones."""
    idle: float
    """Of our server with nobody subscribed."""


async def watch(seconds: float, clients: int) -> Watched:
    """Both servers at the same time, because other work on the machine changes what a wake-up costs."""
    names = [f"Plant.Line.Item{n:04d}" for n in range(WATCHED)]
    subscribe = json.dumps({"op": "subscribe", "items": names, "interval_ms": 500}).encode()
    with server("ours", 0.5) as ours, server("ours", 0.5) as idle:
        sockets = [await Socket.open(ours.target, "/ws") for _ in range(clients)]
        for socket in sockets:
            await socket.send(subscribe)
            await socket.receive()
        messages = [(await sockets[0].receive()).decode() for _ in range(6)][1:]
        with server("bare", 0.5) as making, server("bare", 0.5, {"messages": messages}) as sending:
            for bare in (making, sending):
                sockets += [await Socket.open(bare.target, "/ws") for _ in range(clients)]
            measured = (ours, making, sending, idle)
            async with asyncio.TaskGroup() as tasks:
                takers = [tasks.create_task(_take(socket)) for socket in sockets]
                await asyncio.sleep(1)
                before = [one.cpu() for one in measured]
                await asyncio.sleep(seconds)
                used = [one.cpu() - earlier for one, earlier in zip(measured, before, strict=True)]
                for taker in takers:
                    taker.cancel()
    return Watched(*(100 * one / seconds for one in used))


async def _take(socket: Socket) -> None:
    while True:
        await socket.receive()


# ---------------------------------------------------------------------- the command


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--json", action="store_true", help="print the targets as JSON")
    parser.add_argument("--seconds", type=float, default=14.0, help="of each measurement")
    parser.add_argument("--serve", choices=("ours", "bare"), help=argparse.SUPPRESS)
    parser.add_argument("--period", type=float, default=0.1, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        extra = json.loads(sys.stdin.readline())
        if options.serve == "ours":
            asyncio.run(serve_ours(options.period))
        else:
            ready = {name: str(extra[name]).encode() for name in ("read", "csv") if name in extra}
            asyncio.run(serve_bare(options.period, ready, extra.get("messages", [])))
        return 0
    return _report(options.seconds, as_json=options.json)


def _report(seconds: float, *, as_json: bool) -> int:
    read, csv = asyncio.run(bulk(seconds))
    one = asyncio.run(watch(seconds, 1))
    five = asyncio.run(watch(seconds, 5))
    targets = [
        ("bulk read of 1000 items, rate against ready-made bytes", read.ratio, ">=", 0.8),
        ("CSV of 1000 items, rate against ready-made bytes", csv.ratio, ">=", 0.8),
        ("/ws, 2000 items at 2 Hz, one client, CPU against a bare loop", one.ours / one.making, "<=", 1.5),
    ]
    rows = [
        {
            "name": name,
            "value": round(value, 3),
            "target": f"{sign} {bound}",
            "holds": value >= bound if sign == ">=" else value <= bound,
        }
        for name, value, sign, bound in targets
    ]
    if as_json:
        print(json.dumps({"targets": rows}))
    else:
        for name, compared in (("bulk read", read), ("CSV", csv)):
            print(
                f"{name}: {compared.ours:.0f}/s, bare {compared.bare:.0f}/s, ratio {compared.ratio:.2f} "
                f"({compared.cpu_ratio:.2f} by processor time)"
            )
        for clients, watched in ((1, one), (5, five)):
            print(
                f"/ws, {clients} client(s): {watched.ours:.3f} % of a core, bare loop {watched.making:.3f} %, with "
                f"ready-made messages {watched.sending:.3f} %, engine alone {watched.idle:.3f} %; "
                f"ratios {watched.ours / watched.making:.2f} and {watched.ours / watched.sending:.2f}"
            )
        for row in rows:
            print(f"{'holds' if row['holds'] else 'FAILS'}: {row['name']}: {row['value']} (target {row['target']})")
    return 0 if all(row["holds"] for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
