"""How the gateway is doing: diagnostics as JSON for people, metrics as Prometheus text for machines.

Source:   Prometheus text exposition format 0.0.4: names, HELP and TYPE lines, escaping of label values.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from starlette.requests import Request

from pcaccess import __version__
from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.station import Station
from pcaccess.items.quality import split_code
from pcaccess.items.ticks import to_ticks
from pcaccess.project.model import Access
from pcaccess.s7200.types import DataType
from pcaccess.web import shapes
from pcaccess.web.answers import Answer, json_answer
from pcaccess.web.catalogue import Catalogue, Search
from pcaccess.web.counts import Counts
from pcaccess.web.endpoints import Endpoint, Parameter, only_parameters
from pcaccess.web.formats import CSV, iso_time, value_text
from pcaccess.web.groups import known_group
from pcaccess.web.refusals import Refusal
from pcaccess.web.sockets import Sockets

MAX_SERIES: Final = 10_000
"""Items in one scrape."""
_METRICS_TYPE: Final = "text/plain; version=0.0.4; charset=utf-8"
Sample = tuple[Mapping[str, str], float | str]


class Health:
    """The endpoints ``/api/diagnostics`` and ``/metrics``."""

    def __init__(self, gateway: Gateway, catalogue: Catalogue, sockets: Sockets, counts: Counts) -> None:
        self._gateway = gateway
        self._catalogue = catalogue
        self._sockets = sockets
        self._counts = counts

    def endpoints(self) -> list[Endpoint]:
        return [
            Endpoint(
                "GET",
                "/metrics",
                self.metrics,
                "Prometheus metrics",
                shapes.TEXT,
                media_type=_METRICS_TYPE,
                description="Of the gateway itself; with group or filter also values and qualities of those items.",
                parameters=(
                    Parameter("group", "A group whose items are to be included; may be given more than once."),
                    Parameter("filter", "Items to be included, as in /api/items; may be given more than once."),
                ),
                refusals=("bad-request", "unknown-group", "too-large"),
            ),
            Endpoint("GET", "/api/diagnostics", self.diagnostics, "How the gateway is doing", {"type": "object"}),
        ]

    # ------------------------------------------------------------------ diagnostics

    async def diagnostics(self, request: Request) -> Answer:
        gateway, counts = self._gateway, self._counts
        requests: dict[str, int] = {}
        for (_, _, status), number in counts.requests.items():
            requests[str(status)] = requests.get(str(status), 0) + number
        return json_answer(
            {
                "version": __version__,
                "project": gateway.project.name,
                "started": iso_time(to_ticks(counts.started)),
                "uptime_s": round((gateway.clock.now() - counts.started).total_seconds(), 3),
                "items": len(gateway.table),
                "dynamic_items": {"now": len(gateway.dynamic), "max": gateway.project.dynamic_items.max},
                "qualities": self._qualities(),
                "plcs": [self._plc(station) for station in gateway.stations.values()],
                "groups": [{"name": g.name, "active": g.active, "items": len(g.items)} for g in gateway.groups],
                "web": {
                    "requests": requests,
                    "refused": dict(counts.refused),
                    "written": dict(counts.written),
                    "websockets": len(self._sockets),
                    "subscriptions": self._sockets.subscriptions,
                    "messages_sent": counts.messages,
                    "message_bytes_sent": counts.bytes_sent,
                    "cut_off_slow": counts.slow,
                },
                "process": {"cpu_s": round(_cpu_seconds(), 3), "memory_bytes": _memory_bytes()},
            }
        )

    def _plc(self, station: Station) -> dict[str, Any]:
        link = self._gateway.project.link(station.plc.link)
        status = station.status
        return {
            "plc": station.name,
            "link_type": link.type.value if link else None,
            "connected": station.connected,
            "mode": status.mode,
            "scan_time_ms": status.scan_time,
            "items": sum(1 for _ in station.items()),
        }

    def _qualities(self) -> dict[str, int]:
        """How many items have which quality."""
        rows = np.array([row for s in self._gateway.stations.values() for row, _ in s.items()], np.int64)
        codes, numbers = np.unique(self._gateway.table.quality_codes(rows), return_counts=True)
        found: dict[str, int] = {}
        for code, number in zip(codes.tolist(), numbers.tolist(), strict=True):
            name = split_code(code)[0].name
            found[name] = found.get(name, 0) + number
        return found

    # ------------------------------------------------------------------ metrics

    async def metrics(self, request: Request) -> Answer:
        only_parameters(request, "group", "filter")
        rows = await self._wanted_rows(request)
        lines = [*self._gateway_lines(), *self._web_lines(), *await self._item_lines(rows)]
        return Answer("".join(lines).encode(), _METRICS_TYPE)

    async def _wanted_rows(self, request: Request) -> list[int]:
        rows: dict[int, None] = {}
        for name in request.query_params.getlist("group"):
            rows.update((row, None) for row in known_group(self._gateway, name).rows() if row is not None)
        for words in request.query_params.getlist("filter"):
            rows.update((entry.row, None) for entry in await self._catalogue.find(Search(words[:200])))
        if len(rows) > MAX_SERIES:
            raise Refusal("too-large", f"{len(rows)} items; at most {MAX_SERIES} go into one scrape")
        return list(rows)

    def _gateway_lines(self) -> Iterable[str]:
        gateway = self._gateway
        stations = list(gateway.stations.values())
        yield from _metric("info", "gauge", "Version of the gateway.", [({"version": __version__}, 1)])
        yield from _metric(
            "start_time_seconds", "gauge", "Start, in Unix time.", [({}, self._counts.started.timestamp())]
        )
        yield from _metric("process_cpu_seconds_total", "counter", "Processor time used.", [({}, _cpu_seconds())])
        memory = _memory_bytes()
        if memory is not None:
            yield from _metric("process_memory_bytes", "gauge", "Memory in use.", [({}, memory)])
        qualities = [({"quality": name}, number) for name, number in self._qualities().items()]
        yield from _metric("items", "gauge", "Items by quality.", qualities)
        yield from _metric("dynamic_items", "gauge", "Items that clients made.", [({}, len(gateway.dynamic))])
        connected = [({"plc": s.name}, float(s.connected)) for s in stations]
        yield from _metric("plc_connected", "gauge", "1 while the PLC answers.", connected)
        running = [({"plc": s.name}, float(s.status.mode == "RUN")) for s in stations]
        yield from _metric("plc_running", "gauge", "1 while its program runs.", running)
        scans = [({"plc": s.name}, s.status.scan_time / 1000) for s in stations]
        yield from _metric("plc_scan_seconds", "gauge", "Duration of the last scan.", scans)
        active = [({"group": g.name}, float(g.active)) for g in gateway.groups]
        yield from _metric("group_active", "gauge", "1 while the group is active.", active)

    def _web_lines(self) -> Iterable[str]:
        counts = self._counts
        requests = [
            ({"method": method, "path": path, "status": str(status)}, number)
            for (method, path, status), number in counts.requests.items()
        ]
        yield from _metric("web_requests_total", "counter", "Requests answered.", requests)
        seconds = [({"method": method, "path": path}, number) for (method, path), number in counts.seconds.items()]
        yield from _metric("web_request_seconds_total", "counter", "Time until answers were ready.", seconds)
        refused = [({"reason": kind}, number) for kind, number in counts.refused.items()]
        yield from _metric("web_refused_total", "counter", "Requests turned away at the door.", refused)
        written = [({"status": status}, number) for status, number in counts.written.items()]
        yield from _metric("web_writes_total", "counter", "Values that web clients wrote.", written)
        yield from _metric("websockets", "gauge", "Open websockets.", [({}, len(self._sockets))])
        yield from _metric(
            "websocket_subscriptions", "gauge", "Subscriptions of them.", [({}, self._sockets.subscriptions)]
        )
        yield from _metric("websocket_messages_total", "counter", "Messages sent to them.", [({}, counts.messages)])
        yield from _metric("websocket_bytes_total", "counter", "Bytes of those messages.", [({}, counts.bytes_sent)])
        yield from _metric("websockets_cut_off_total", "counter", "Those that were too slow.", [({}, counts.slow)])

    async def _item_lines(self, rows: Sequence[int]) -> Iterable[str]:
        if not rows:
            return []
        await self._gateway.read(rows)
        values: list[Sample] = []
        qualities: list[Sample] = []
        for row in rows:
            item = self._gateway.item(row)
            if not item.access & Access.R or item.count != 1 or item.data_type is DataType.STRING:
                continue
            sample = self._gateway.sample(row)
            labels = {"item": item.item_id}
            qualities.append((labels, sample.quality.code))
            values.append((labels, value_text(CSV, item.data_type, sample.value).decode()))
        return [
            *_metric("item_value", "gauge", "Value of an item; see its quality.", values),
            *_metric("item_quality", "gauge", "OPC DA quality code of an item, 192 is good.", qualities),
        ]


def _metric(name: str, kind: str, help_text: str, samples: Iterable[Sample]) -> Iterable[str]:
    yield f"# HELP pcaccess_{name} {help_text}\n# TYPE pcaccess_{name} {kind}\n"
    for labels, value in samples:
        inside = ",".join(f'{label}="{_escaped(text)}"' for label, text in labels.items())
        yield f"pcaccess_{name}{{{inside}}} {_number(value)}\n" if inside else f"pcaccess_{name} {_number(value)}\n"


def _escaped(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")


def _number(value: float | str) -> str:
    if isinstance(value, str):
        return {"Infinity": "+Inf", "-Infinity": "-Inf"}.get(value, value)
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def _cpu_seconds() -> float:
    times = os.times()
    return times.user + times.system


def _memory_bytes() -> int | None:
    """Of this process; None where the system does not say so simply."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, AttributeError):
        return None
