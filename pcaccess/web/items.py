"""Items over REST: list, look at, read and write them, one or thousands at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import orjson
from starlette.requests import Request

from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.writing import WriteRefused, raw_write
from pcaccess.items.quality import Quality
from pcaccess.items.sample import ItemValue
from pcaccess.links.base import Outcome
from pcaccess.project.durations import DurationError, parse_duration
from pcaccess.project.model import Access, Item
from pcaccess.web import shapes
from pcaccess.web.answers import TEXT_TYPE, Answer, json_answer
from pcaccess.web.catalogue import Catalogue, Search
from pcaccess.web.counts import Counts
from pcaccess.web.endpoints import (
    Endpoint,
    Parameter,
    body_of,
    json_bytes,
    media_type_of,
    members,
    number_parameter,
    only_parameters,
    parse_json,
)
from pcaccess.web.formats import CSV, JSON, Format, value_text
from pcaccess.web.plans import Plan, Plans
from pcaccess.web.refusals import OF_OUTCOME, Refusal
from pcaccess.web.rendering import sample_entry
from pcaccess.web.values import from_json, from_text

PLAIN: Final = f"{TEXT_TYPE}; charset=utf-8"
MAX_ITEMS: Final = 20_000
"""In one request; more would hold up the event loop for longer than a scan may wait."""
PAGE: Final = 100
MAX_PAGE: Final = 1000
MAX_SEARCH: Final = 200
"""Characters of a search."""


class Items:
    """The endpoints below ``/api/items``, ``/api/read`` and ``/api/write``."""

    def __init__(self, gateway: Gateway, plans: Plans, catalogue: Catalogue, counts: Counts) -> None:
        self._gateway = gateway
        self._plans = plans
        self._catalogue = catalogue
        self._counts = counts

    def endpoints(self) -> list[Endpoint]:
        """The busiest first: that is the order in which they are tried."""
        search = (
            Parameter("filter", "Pattern for the ID (with * and ?), or a part of ID or description; any case."),
            Parameter("plc", "Only items of this link or Link.PLC."),
        )
        return [
            Endpoint(
                "POST",
                "/api/read",
                self.read,
                "Read items",
                shapes.SAMPLES,
                description="Samples in the order of the request. What cannot be read has an `error` in its place.",
                body=shapes.an_object(
                    {"items": shapes.list_of(shapes.TEXT) | {"maxItems": MAX_ITEMS}},
                    max_age=shapes.TEXT | {"description": "How old a sample may be, such as 500ms; 0s asks the PLC."},
                ),
                refusals=("bad-request", "unsupported-type", "too-large"),
            ),
            Endpoint(
                "POST",
                "/api/write",
                self.write,
                "Write items",
                shapes.RESULTS,
                description="Answered when every PLC has taken or refused its values. One refusal holds up no other.",
                body=shapes.an_object(
                    {
                        "items": shapes.list_of(shapes.an_object({"id": shapes.TEXT, "value": shapes.VALUE}))
                        | {"maxItems": MAX_ITEMS}
                    }
                ),
                statuses={207: "Some values were not written; see their `error`."},
                changes=True,
                refusals=("bad-request", "unsupported-type", "too-large"),
            ),
            Endpoint(
                "GET",
                "/api/items/{id:path}/value",
                self.value,
                "The bare value of an item",
                shapes.TEXT,
                media_type=PLAIN,
                description="As text for spreadsheets: BOOL is 1 or 0. Whether it is any good, the quality says.",
                refusals=("unknown-item", "not-readable"),
            ),
            Endpoint(
                "GET",
                "/api/items/{id:path}/quality",
                self.quality,
                "The bare quality of an item",
                shapes.TEXT,
                media_type=PLAIN,
                description="The OPC DA code as text for spreadsheets; 192 is good.",
                refusals=("unknown-item", "not-readable"),
            ),
            Endpoint(
                "GET",
                "/api/items/{id:path}/check",
                self.check,
                "Whether an item would take a value",
                shapes.TEXT,
                media_type=PLAIN,
                description="`ok`, or in words why not; nothing is written. For spreadsheets, which see no refusals.",
                parameters=(Parameter("value", "The value as text."),),
                refusals=("unknown-item",),
            ),
            Endpoint(
                "PUT",
                "/api/items/{id:path}/value",
                self.put_value,
                "Write an item",
                shapes.named("Written"),
                description='Takes the value as JSON (`21.5`, or `{"value": 21.5}`) or as plain text.',
                body={"anyOf": [shapes.VALUE, shapes.an_object({"value": shapes.VALUE})]},
                takes_text=True,
                changes=True,
                refusals=(
                    *("bad-request", "unsupported-type", "too-large", "unknown-item"),
                    *(kind for kind, _ in OF_OUTCOME.values()),
                ),
            ),
            Endpoint(
                "GET",
                "/api/items.csv",
                self.csv,
                "Items as CSV",
                shapes.TEXT,
                media_type=CSV.media_type,
                description="A spreadsheet of many items goes on when one goes: that has the quality CONFIG_ERROR (4).",
                parameters=(*search, Parameter("id", "An item ID; give it once for each item.")),
                refusals=("bad-request", "too-large"),
            ),
            Endpoint(
                "GET",
                "/api/items",
                self.page,
                "List items",
                shapes.an_object(
                    {
                        "total": shapes.COUNT,
                        "offset": shapes.COUNT,
                        "items": shapes.list_of(shapes.named("Item")),
                    }
                ),
                parameters=(
                    *search,
                    Parameter("writable", "1: only items that can be written.", {"enum": ["0", "1"]}),
                    Parameter("offset", "How many to leave out.", {"type": "integer", "minimum": 0}),
                    Parameter(
                        "limit",
                        f"How many to give, {PAGE} unless said.",
                        {"type": "integer", "minimum": 0, "maximum": MAX_PAGE},
                    ),
                    Parameter("samples", "0: without samples.", {"enum": ["0", "1"]}),
                ),
                refusals=("bad-request",),
            ),
            Endpoint(
                "GET",
                "/api/items/{id:path}",
                self.get,
                "An item and its sample",
                shapes.named("Item"),
                refusals=("unknown-item",),
            ),
        ]

    # ------------------------------------------------------------------ many

    async def read(self, request: Request) -> Answer:
        data = await json_bytes(request)
        answer = await self._plans.answer(("read", data), lambda: self._read_plan(data))
        return Answer(answer)

    def _read_plan(self, data: bytes) -> Plan:
        wanted = members(parse_json(data), items=list, max_age=str)
        names = wanted.get("items")
        if names is None or not all(isinstance(name, str) for name in names):
            raise Refusal("bad-request", "expected items, a list of item IDs")
        return self.plan_for(JSON, names, _max_age(wanted.get("max_age")))

    def plan_for(self, form: Format, names: Sequence[str], max_age: float = 0.0) -> Plan:
        """A plan that reads items by name; what cannot be read is a gap that says why."""
        if len(names) > MAX_ITEMS:
            raise Refusal("too-large", f"{len(names)} items; at most {MAX_ITEMS} are read at once")
        rows = [self._gateway.find(name) for name in names]
        hidden = {n for n, row in enumerate(rows) if row is not None and not self._can_be_read(row)}
        shown = [None if n in hidden else row for n, row in enumerate(rows)]
        return self._plans.plan(form, shown, lambda n: gap(form, names[n], exists=n in hidden), max_age)

    def _can_be_read(self, row: int) -> bool:
        return bool(self._gateway.item(row).access & Access.R)

    async def csv(self, request: Request) -> Answer:
        only_parameters(request, "filter", "plc", "id")
        names = request.query_params.getlist("id")
        if not names:
            found = await self._catalogue.find(_search(request))
            names = [entry.item_id for entry in found if self._can_be_read(entry.row)]
        answer = await self._plans.answer(("csv", tuple(names)), lambda: self.plan_for(CSV, names))
        return Answer(answer, CSV.media_type)

    async def write(self, request: Request) -> Answer:
        wanted = members(parse_json(await json_bytes(request)), items=list).get("items")
        if wanted is None or len(wanted) > MAX_ITEMS:
            raise Refusal("bad-request", f"expected items, a list of at most {MAX_ITEMS} items with id and value")
        pairs = []
        for place, one in enumerate(wanted):
            given = members(one, id=str, value=object)
            if len(given) != 2:
                missing = "id" if "value" in given else "value"
                raise Refusal("bad-request", f"item {place + 1} of the list has no {missing}")
            pairs.append((given["id"], given["value"]))
        return results_answer(await self.write_all(pairs))

    async def write_all(self, wanted: Sequence[tuple[str, Any]]) -> Sequence[dict[str, Any]]:
        """Write JSON values to items by name; a result for each, in order."""
        results: dict[int, dict[str, Any]] = {}
        writes: list[tuple[int, ItemValue]] = []
        places = []
        for place, (name, value) in enumerate(wanted):
            try:
                row = self._row(name)
                writes.append((row, from_json(self._gateway.item(row), value)))
                places.append(place)
            except Refusal as refusal:
                results[place] = self._failed(name, refusal)
        for place, (row, written), outcome in zip(places, writes, await self._gateway.write(writes), strict=True):
            results[place] = self._result(row, written, outcome)
        return [results[place] for place in range(len(wanted))]

    def _result(self, row: int, value: ItemValue, outcome: Outcome) -> dict[str, Any]:
        if outcome is Outcome.DONE:
            self._counts.written["Good"] += 1
            return {"id": self._gateway.table.item_id(row), "status": "Good"}
        return self._failed(self._gateway.table.item_id(row), self._why(row, value, outcome))

    def _failed(self, item_id: str, refusal: Refusal) -> dict[str, Any]:
        status = refusal.more.get("opcua_status", "BadNodeIdUnknown")
        self._counts.written[status] += 1
        return {"id": item_id, "status": status, "error": str(refusal), "problem": refusal.kind}

    def _why(self, row: int, value: ItemValue, outcome: Outcome) -> Refusal:
        """A write that was not done, in words."""
        kind, status = OF_OUTCOME[outcome]
        item_id = self._gateway.table.item_id(row)
        message = f"{item_id} was not written: {outcome.value}"
        try:
            raw_write(self._gateway.item(row), value)
        except WriteRefused as refused:
            message = str(refused)
        except KeyError:
            message = f"{item_id} went away while it was written"
        return Refusal(kind, message, id=item_id, opcua_status=status)

    # ------------------------------------------------------------------ one

    async def value(self, request: Request) -> Answer:
        row = self._readable_row(request.path_params["id"])
        await self._gateway.read([row])
        sample = self._gateway.sample(row)
        text = value_text(CSV, self._gateway.table.data_type(row), sample.value)
        if isinstance(sample.value, str):
            text = sample.value.encode()  # here nothing separates cells
        return Answer(text, PLAIN)

    async def quality(self, request: Request) -> Answer:
        row = self._readable_row(request.path_params["id"])
        await self._gateway.read([row])
        return Answer(b"%d" % self._gateway.sample(row).quality.code, PLAIN)

    async def check(self, request: Request) -> Answer:
        row = self._row(request.path_params["id"])
        item = self._gateway.item(row)
        try:
            raw_write(item, from_text(item, request.query_params.get("value", "")))
        except (Refusal, WriteRefused) as refused:
            return Answer(str(refused).encode(), PLAIN)
        return Answer(b"ok", PLAIN)

    async def put_value(self, request: Request) -> Answer:
        row = self._row(request.path_params["id"])
        item = self._gateway.item(row)
        value = _value_of(item, media_type_of(request), await body_of(request))
        (outcome,) = await self._gateway.write([(row, value)])
        result = self._result(row, value, outcome)
        if outcome is not Outcome.DONE:
            raise self._why(row, value, outcome)
        return json_answer(result)

    async def get(self, request: Request) -> Answer:
        name = request.path_params["id"]
        row = self._gateway.find(name)
        if row is None:
            near = None if "," in name else await self._catalogue.nearest(name)
            raise _unknown(name, near)
        await self._gateway.read([row])
        return Answer(self._entry(row, with_sample=True))

    async def page(self, request: Request) -> Answer:
        only_parameters(request, "filter", "plc", "writable", "offset", "limit", "samples")
        offset = number_parameter(request, "offset", 0, 0, 10_000_000)
        limit = number_parameter(request, "limit", PAGE, 0, MAX_PAGE)
        with_samples = number_parameter(request, "samples", 1, 0, 1) == 1
        found = await self._catalogue.find(_search(request))
        if number_parameter(request, "writable", 0, 0, 1):
            found = [entry for entry in found if self._gateway.item(entry.row).access & Access.W]
        rows = [entry.row for entry in found[offset : offset + limit]]
        if with_samples:
            await self._gateway.read(rows)
        entries = b",".join(self._entry(row, with_sample=with_samples) for row in rows)
        return Answer(b'{"total":%d,"offset":%d,"items":[%s]}' % (len(found), offset, entries))

    def _entry(self, row: int, *, with_sample: bool) -> bytes:
        item = self._gateway.item(row)
        entry = orjson.dumps(
            {
                "id": item.item_id,
                "name": item.name,
                "plc": self._gateway.station(row).name,
                "type": item.data_type.name,
                "count": item.count,
                "access": str(item.access),
                "address": str(item.address),
                "run_time_name": item.run_time_name,
                "low": item.low,
                "high": item.high,
                "unit": item.unit,
                "description": item.description,
            }
        )
        if not with_sample:
            return entry
        sample = b"null"
        if item.access & Access.R:
            sample = sample_entry(JSON, item.item_id, item.data_type, self._gateway.sample(row))
        return entry[:-1] + b',"sample":' + sample + b"}"

    # ------------------------------------------------------------------ names

    def _row(self, name: str) -> int:
        row = self._gateway.find(name)
        if row is None:
            raise _unknown(name)
        return row

    def _readable_row(self, name: str) -> int:
        row = self._row(name)
        if not self._can_be_read(row):
            raise _not_readable(name)
        return row


def gap(form: Format, name: str, *, exists: bool) -> bytes:
    """What stands in the place of an item that cannot be read."""
    if form is CSV:
        quality = Quality.CONFIG_ERROR
        return CSV.head(name) + f",{quality.code},{quality.name},\r\n".encode()
    refusal = _not_readable(name) if exists else _unknown(name)
    return orjson.dumps({"id": name, "error": str(refusal), "problem": refusal.kind})


def results_answer(results: Sequence[dict[str, Any]]) -> Answer:
    """What became of writes; the status says whether all are done."""
    failed = sum("error" in result for result in results)
    return json_answer({"failed": failed, "results": results}, 207 if failed else 200)


def _unknown(name: str, near: str | None = None) -> Refusal:
    guess = f"; did you mean {near}?" if near else ""
    more = {"nearest": near} if near else {}
    return Refusal("unknown-item", f"there is no item {name[:200]}{guess}", id=name, **more)


def _not_readable(name: str) -> Refusal:
    return Refusal("not-readable", f"{name} is write-only", id=name)


def _search(request: Request) -> Search:
    words = request.query_params.get("filter", "")
    plc = request.query_params.get("plc", "")
    if max(len(words), len(plc)) > MAX_SEARCH:
        raise Refusal("bad-request", f"a search has at most {MAX_SEARCH} characters")
    return Search(words, plc)


def _max_age(text: str | None) -> float:
    if text is None:
        return 0.0
    try:
        return parse_duration(text)
    except DurationError as error:
        raise Refusal("bad-request", f"max_age: {error}") from None


def _value_of(item: Item, media_type: str, data: bytes) -> ItemValue:
    """The value in a body. LibreOffice sends no content type, which no page of another site could do with PUT."""
    if media_type in ("", TEXT_TYPE):
        try:
            return from_text(item, data.decode())
        except UnicodeDecodeError:
            raise Refusal("bad-request", "the text is not UTF-8") from None
    if media_type != "application/json":
        raise Refusal("unsupported-type", "send the value as application/json or text/plain")
    value = parse_json(data)
    if isinstance(value, dict):
        value = members(value, value=object).get("value")
    return from_json(item, value)
