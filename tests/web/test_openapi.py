"""The OpenAPI text: complete, and true (every test of this folder holds its answers against it)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import jsonschema

from pcaccess.web.refusals import KINDS
from tests.web.conftest import Served


def schemas(node: Any) -> Iterator[dict[str, Any]]:
    if isinstance(node, dict):
        for key, value in node.items():
            if key == "schema":
                yield value
            yield from schemas(value)
    elif isinstance(node, list):
        for value in node:
            yield from schemas(value)


def references(node: Any) -> Iterator[str]:
    if isinstance(node, dict):
        if "$ref" in node:
            yield node["$ref"]
        for value in node.values():
            yield from references(value)
    elif isinstance(node, list):
        for value in node:
            yield from references(value)


async def test_it_is_served_and_its_schemas_are_schemas(web: Served) -> None:
    text = await web.json("/openapi.json")
    assert text["openapi"] == "3.1.0"
    for schema in [*schemas(text["paths"]), *text["components"]["schemas"].values()]:
        jsonschema.Draft202012Validator.check_schema(schema)
    known = {f"#/components/schemas/{name}" for name in text["components"]["schemas"]}
    assert set(references(text)) == known


async def test_every_operation_has_a_name_of_its_own_and_names_its_parameters(web: Served) -> None:
    text = await web.json("/openapi.json")
    operations = [(path, one) for path, methods in text["paths"].items() for one in methods.values()]
    names = [one["operationId"] for _, one in operations]
    assert len(set(names)) == len(names) == len(web.server.web.endpoints)
    for path, one in operations:
        in_path = [p["name"] for p in one["parameters"] if p["in"] == "path"]
        assert all(f"{{{name}}}" in path for name in in_path)
        assert path.count("{") == len(in_path)


async def test_only_what_does_not_get_has_a_body(web: Served) -> None:
    for endpoint in web.server.web.endpoints:
        assert (endpoint.body is not None) == (endpoint.method != "GET")
        assert set(endpoint.refusals) <= KINDS.keys()
