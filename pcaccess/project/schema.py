"""JSON Schema of ``items.yaml``, for editors: completion, hints and red lines while typing.

The schema is a little stricter than the loader (words in the case they are documented, durations with their unit)
and knows nothing of addresses; ``pcaccess check`` has the last word.
"""

from __future__ import annotations

from typing import Any, Final

from pcaccess.project.raw import RawProject

DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"


def project_schema() -> dict[str, Any]:
    """The schema as JSON data."""
    schema: dict[str, Any] = _tidy(RawProject.model_json_schema())
    return {"$schema": DIALECT, **schema, "title": "pcaccess project"}


def _tidy(node: Any) -> Any:
    """Without what only says how pydantic thinks: titles, defaults of None, null beside a type."""
    if isinstance(node, list):
        return [_tidy(child) for child in node]
    if not isinstance(node, dict):
        return node
    kept: dict[str, Any] = {}
    for key, value in node.items():
        if key == "properties" or key == "$defs":
            kept[key] = {name: _tidy(child) for name, child in value.items()}
        elif not (key == "title" or (key in ("default", "type") and value is None)):
            kept[key] = _tidy(value)
    if {"type": "null"} not in kept.get("anyOf", ()):
        return kept
    choices = [choice for choice in kept.pop("anyOf") if choice != {"type": "null"}]
    return {**choices[0], **kept} if len(choices) == 1 else {"anyOf": choices, **kept}
