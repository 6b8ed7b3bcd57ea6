"""docs/items-yaml.md names every key there is, with what leaving it out means, and its examples can be loaded."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Final

import pytest
from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from pcaccess.project import raw, rawitems
from pcaccess.project.load import load_text
from pcaccess.project.model import LinkType
from pcaccess.project.sim import WaveKind, parse_wave

DOCS: Final = Path(__file__).parents[2] / "docs"
PAGE: Final = (DOCS / "items-yaml.md").read_text(encoding="utf-8")
MODELS: Final[dict[str, type[BaseModel]]] = {
    name: model
    for module in (rawitems, raw)
    for name, model in vars(module).items()
    if isinstance(model, type) and issubclass(model, rawitems.Raw) and model is not rawitems.Raw
}
_MARKS: Final = re.compile(r"((?:<!-- keys of .*? -->\n)+)((?:\|.*\n)*)")
_MARK: Final = re.compile(r"<!-- keys of (\w+)(?: (with|without) ([\w, ]+))? -->")


def tables() -> dict[str, tuple[set[str], dict[str, str]]]:
    """Model to the keys its table must have and, of those it has, what leaving them out means."""
    found = {}
    for marks, table in _MARKS.findall(PAGE):
        rows: dict[str, str] = {}
        for line in table.splitlines()[2:]:
            keys, _, left_out = (cell.strip() for cell in line.strip("|").split("|"))
            rows |= dict.fromkeys(re.findall(r"`(\w+)`", keys), left_out)
        for name, way, others in _MARK.findall(marks):
            keys = set(MODELS[name].model_fields)
            for other in others.split(", ") if others else ():
                changed = set(MODELS[other].model_fields) if other in MODELS else {other}
                keys = keys | changed if way == "with" else keys - changed
            found[name] = (keys, rows)
    return found


TABLES: Final = tables()


def test_every_shape_of_the_project_file_is_on_the_page() -> None:
    assert set(TABLES) == set(MODELS)


@pytest.mark.parametrize("name", MODELS)
def test_every_key_is_on_the_page_and_no_other(name: str) -> None:
    keys, rows = TABLES[name]
    assert set(rows) == keys


def shown(default: Any) -> str:
    """A default as the page writes it."""
    if isinstance(default, bool):
        return f"`{str(default).lower()}`"
    return f"`{default:g}`" if isinstance(default, float) else f"`{default}`"


@pytest.mark.parametrize("name", MODELS)
def test_what_leaving_a_key_out_means_is_what_the_loader_does(name: str) -> None:
    fields = MODELS[name].model_fields
    for key, left_out in TABLES[name][1].items():
        if key not in fields:
            continue  # of the shapes that the table is about in common
        default = fields[key].default
        if default is PydanticUndefined:
            assert left_out == "needed", key
        elif default not in (None, "", []) and not isinstance(default, BaseModel):
            assert left_out == shown(default), key
        else:
            assert left_out != "needed", key


def test_every_example_can_be_loaded() -> None:
    pages = [PAGE, (DOCS / "coming-from-pc-access.md").read_text(encoding="utf-8")]
    examples = [example for page in pages for example in re.findall(r"^```yaml\n(.*?)^```", page, re.M | re.S)]
    assert len(examples) >= 6
    for example in examples:
        load_text(example)


def test_every_type_of_link_and_every_wave_is_on_the_page() -> None:
    assert [kind.value for kind in LinkType if f"`{kind.value}`" not in PAGE] == []
    assert [kind.value for kind in WaveKind if f"| `{kind.value}` |" not in PAGE] == []


def test_the_waves_of_the_page_have_the_types_it_says() -> None:
    rows = re.findall(r"^\| `([A-Z]+)\((period.*?)\)` \| .* \| ([A-Z]+) \|$", PAGE, re.M)
    assert len(rows) == 5
    for name, arguments, data_type in rows:
        wave = parse_wave(f"{name}({'1s, 0, 1' if ',' in arguments else '1s'})")
        assert wave.default_type.name == data_type
