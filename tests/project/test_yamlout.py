from __future__ import annotations

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.project.yamlout import mapping, scalar
from pcaccess.project.yamltext import plain, read_yaml


@given(st.dictionaries(st.sampled_from(["name", "address", "description"]), st.text(max_size=30), min_size=1))
def test_every_reader_of_yaml_gets_the_text_back(pairs: dict[str, str]) -> None:
    pairs = {key: text.encode("utf-8", "replace").decode() for key, text in pairs.items()}
    line = f"- {mapping(dict(pairs))}\n"
    assert yaml.safe_load(line) == [pairs]
    assert plain(read_yaml(line, "x").root) == [pairs]


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("Motor", "Motor"),
        ("Oven 1 (left)", "Oven 1 (left)"),
        ("°C", "°C"),
        ("On", '"On"'),
        ("007", '"007"'),
        ("1:30", '"1:30"'),
        ("", '""'),
        ("a, b", '"a, b"'),
        ("x: y", '"x: y"'),
        ("Pump on?", '"Pump on?"'),
        ('say "hi"', '"say \\"hi\\""'),
        ("tab\there", '"tab\\x09here"'),
    ],
)
def test_quotes_stand_only_where_somebody_could_misread_it(text: str, written: str) -> None:
    assert scalar(text) == written


@pytest.mark.parametrize(
    ("value", "written"), [(1000.0, "1000"), (0.1, "0.1"), (-3, "-3"), (1e300, "1.0e+300"), (True, "true")]
)
def test_numbers_are_written_so_that_every_reader_takes_them_for_numbers(value: float, written: str) -> None:
    assert scalar(value) == written
    assert yaml.safe_load(written) == value
