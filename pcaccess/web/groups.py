"""Groups over REST: what they hold, reading and writing all of it, CSV for spreadsheets, settings."""

from __future__ import annotations

from typing import Any, Final

from starlette.requests import Request

from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.groups import Group, Source
from pcaccess.items.quality import Quality
from pcaccess.web import shapes
from pcaccess.web.answers import Answer, json_answer
from pcaccess.web.endpoints import (
    Endpoint,
    Parameter,
    json_bytes,
    members,
    only_parameters,
    parse_json,
)
from pcaccess.web.formats import CSV, JSON, Format
from pcaccess.web.items import Items, gap, results_answer
from pcaccess.web.plans import Plans
from pcaccess.web.refusals import Refusal
from pcaccess.web.rendering import sample_entry

MAX_RATE_MS: Final = 86_400_000
_SOURCES: Final = {"cache": Source.CACHE, "device": Source.DEVICE}


class Groups:
    """The endpoints below ``/api/groups``."""

    def __init__(self, gateway: Gateway, plans: Plans, items: Items) -> None:
        self._gateway = gateway
        self._plans = plans
        self._items = items

    def endpoints(self) -> list[Endpoint]:
        source = Parameter(
            "source",
            "cache: as the group shows it (dead band; OUT_OF_SERVICE while it is inactive). device: as the PLC has it.",
            {"enum": list(_SOURCES), "default": "cache"},
        )
        name = ("unknown-group",)
        return [
            Endpoint(
                "GET",
                "/api/groups/{name}.csv",
                self.csv,
                "A group as CSV",
                shapes.TEXT,
                media_type=CSV.media_type,
                description="One line per item in the group's order, for spreadsheets.",
                parameters=(source,),
                refusals=(*name, "bad-request"),
            ),
            Endpoint(
                "GET",
                "/api/groups/{name}/samples",
                self.samples,
                "Read a group",
                shapes.SAMPLES,
                parameters=(source,),
                refusals=(*name, "bad-request"),
            ),
            Endpoint(
                "POST",
                "/api/groups/{name}/write",
                self.write,
                "Write a group",
                shapes.RESULTS,
                description="One value per item in the group's order; null leaves its item alone.",
                body=shapes.an_object({"values": shapes.list_of({"anyOf": [shapes.VALUE, {"type": "null"}]})}),
                statuses={207: "Some values were not written; see their `error`."},
                changes=True,
                refusals=(*name, "bad-request", "unsupported-type", "too-large"),
            ),
            Endpoint("GET", "/api/groups/{name}", self.get, "A group", shapes.named("Group"), refusals=name),
            Endpoint(
                "PATCH",
                "/api/groups/{name}",
                self.change,
                "Change a group's settings",
                shapes.named("Group"),
                description="Until the next start; the project file stays as it is.",
                body=shapes.named("Settings"),
                changes=True,
                refusals=(*name, "bad-request", "unsupported-type"),
            ),
            Endpoint(
                "GET",
                "/api/groups",
                self.page,
                "List groups",
                shapes.an_object({"groups": shapes.list_of(shapes.named("Group"))}),
            ),
        ]

    def _group(self, request: Request) -> Group:
        return known_group(self._gateway, request.path_params["name"])

    # ------------------------------------------------------------------ settings

    async def page(self, request: Request) -> Answer:
        return json_answer({"groups": [_settings(group) for group in self._gateway.groups]})

    async def get(self, request: Request) -> Answer:
        return json_answer(_settings(self._group(request)))

    async def change(self, request: Request) -> Answer:
        group = self._group(request)
        wanted = members(
            parse_json(await json_bytes(request)), update_rate_ms=(int, float), active=bool, dead_band=(int, float)
        )
        rate, dead_band = wanted.get("update_rate_ms"), wanted.get("dead_band")
        if rate is not None and not 0 < rate <= MAX_RATE_MS:
            raise Refusal("bad-request", f"update_rate_ms={rate}: expected more than 0 and at most {MAX_RATE_MS}")
        if dead_band is not None and not 0 <= dead_band <= 100:
            raise Refusal("bad-request", f"dead_band={dead_band}: expected 0 to 100 percent")
        if rate is not None:
            group.update_rate = rate / 1000
        if dead_band is not None:
            group.dead_band = dead_band
        group.active = wanted.get("active", group.active)
        return json_answer(_settings(group))

    # ------------------------------------------------------------------ values

    async def samples(self, request: Request) -> Answer:
        return Answer(await self._read(request, JSON))

    async def csv(self, request: Request) -> Answer:
        return Answer(await self._read(request, CSV), CSV.media_type)

    async def _read(self, request: Request, form: Format) -> bytes:
        source = _source(request)
        group = self._group(request)
        if source is Source.CACHE and group.active and group.dead_band:
            return await self._held_back(group, form)

        def quality() -> Quality | None:
            return Quality.OUT_OF_SERVICE if source is Source.CACHE and not group.active else None

        key = ("group", form.media_type, source, group.name)
        return await self._plans.answer(key, lambda: self._items.plan_for(form, group.items), quality)

    async def _held_back(self, group: Group, form: Format) -> bytes:
        """Through the group's dead band, sample by sample."""
        samples = await group.read(Source.CACHE)
        entries = []
        for row, item_id, sample in zip(group.rows(), group.items, samples, strict=True):
            if row is None or sample is None:
                entries.append(gap(form, item_id, exists=row is not None))
            else:
                item = self._gateway.item(row)
                entries.append(sample_entry(form, item.item_id, item.data_type, sample))
        return form.opening + form.separator.join(entries) + form.closing

    async def write(self, request: Request) -> Answer:
        group = self._group(request)
        values = members(parse_json(await json_bytes(request)), values=list).get("values")
        if values is None or len(values) != len(group.items):
            count = len(group.items)
            raise Refusal("bad-request", f"expected values, a list of {count} values in the group's order, or null")
        wanted = [(name, value) for name, value in zip(group.items, values, strict=True) if value is not None]
        return results_answer(await self._items.write_all(wanted))


def known_group(gateway: Gateway, name: str) -> Group:
    """The group of that name; refuses one that is not there."""
    group = gateway.group(name)
    if group is None:
        raise Refusal("unknown-group", f"there is no group {name[:200]}", group=name)
    return group


def _source(request: Request) -> Source:
    if not request.scope["query_string"]:
        return Source.CACHE
    only_parameters(request, "source")
    source = _SOURCES.get(request.query_params.get("source", "cache"))
    if source is None:
        raise Refusal("bad-request", f"source: expected {' or '.join(_SOURCES)}")
    return source


def _settings(group: Group) -> dict[str, Any]:
    return {
        "name": group.name,
        "description": group.config.description,
        "update_rate_ms": group.update_rate * 1000,
        "active": group.active,
        "dead_band": group.dead_band,
        "items": group.items,
    }
