"""JSON schemas of what the API takes and gives, for its OpenAPI text. Source of names: docs/rest.md."""

from __future__ import annotations

from typing import Any, Final

from pcaccess.items.quality import Quality
from pcaccess.s7200.types import DataType

Schema = dict[str, Any]

TEXT: Final[Schema] = {"type": "string"}
COUNT: Final[Schema] = {"type": "integer", "minimum": 0}
NUMBER_OR_NULL: Final[Schema] = {"type": ["number", "null"]}
VALUE: Final[Schema] = {
    "description": "A number, a boolean, a text, or a list of them for an array. A REAL may be the text NaN, Infinity "
    "or -Infinity, which JSON has no number for.",
    "anyOf": [
        {"type": ["number", "boolean", "string"]},
        {"type": "array", "items": {"type": ["number", "boolean", "string"]}},
    ],
}
TIME: Final[Schema] = {"type": "string", "format": "date-time", "description": "UTC, to the millisecond."}


def an_object(required: Schema, **optional: Schema) -> Schema:
    """An object that always has the first members and may have the others."""
    return {"type": "object", "properties": required | optional, "required": list(required)}


def list_of(schema: Schema) -> Schema:
    return {"type": "array", "items": schema}


def named(name: str) -> Schema:
    """A reference to one of ``COMPONENTS``."""
    return {"$ref": f"#/components/schemas/{name}"}


_SAMPLE: Final[Schema] = {
    "id": TEXT,
    "value": VALUE,
    "type": {"enum": [t.name for t in DataType]},
    "quality": {"type": "integer", "description": "OPC DA code, 192 is good."},
    "quality_name": {"enum": [q.name for q in Quality]},
    "status": {"enum": sorted({q.status_name for q in Quality}), "description": "Name of the OPC UA StatusCode."},
    "source_timestamp": TIME | {"description": "When the PLC was last read; a lost PLC keeps it. UTC."},
}
_LIMIT: Final[Schema] = {"enum": ["low", "high", "constant"], "description": "The value is stuck at a bound."}
_ENTRY: Final[Schema] = {
    "id": TEXT,
    "name": TEXT,
    "plc": TEXT,
    "type": _SAMPLE["type"],
    "count": {"type": "integer", "minimum": 1, "description": "Elements of an array, 1 for a single value."},
    "access": {"enum": ["R", "W", "RW"]},
    "address": TEXT,
    "run_time_name": TEXT,
    "low": NUMBER_OR_NULL,
    "high": NUMBER_OR_NULL,
    "unit": TEXT,
    "description": TEXT,
}
_REFUSED: Final[Schema] = {"id": TEXT, "error": TEXT, "problem": TEXT}
_GROUP: Final[Schema] = {
    "name": TEXT,
    "description": TEXT,
    "update_rate_ms": {"type": "number", "exclusiveMinimum": 0, "maximum": 86_400_000},
    "active": {"type": "boolean"},
    "dead_band": {"type": "number", "minimum": 0, "maximum": 100, "description": "Percent of the engineering range."},
    "items": list_of(TEXT),
}
SETTINGS: Final = ("update_rate_ms", "active", "dead_band")
"""What clients may change of a group."""

COMPONENTS: Final[dict[str, Schema]] = {
    "Sample": an_object(_SAMPLE, limit=_LIMIT),
    "Missing": an_object(_REFUSED),
    "Item": an_object(_ENTRY, sample={"anyOf": [named("Sample"), {"type": "null"}]}),
    "Written": an_object({"id": TEXT, "status": TEXT}, error=TEXT, problem=TEXT),
    "Group": an_object(_GROUP),
    "Settings": {
        "type": "object",
        "properties": {name: _GROUP[name] for name in SETTINGS},
        "additionalProperties": False,
        "minProperties": 1,
    },
    "Problem": an_object({"type": TEXT, "title": TEXT, "status": {"type": "integer"}, "detail": TEXT}),
}
SAMPLES: Final[Schema] = an_object(
    {"samples": list_of({"anyOf": [named("Sample"), named("Missing")]})},
)
RESULTS: Final[Schema] = an_object({"failed": COUNT, "results": list_of(named("Written"))})
