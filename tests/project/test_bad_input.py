"""What is no project file at all: each a clear line with its place, nothing run, nothing crashed."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pcaccess.problems import Problem, ProblemError
from pcaccess.project.load import load_project, load_text

NO_KEYS = "items.yaml:1:1: PRJ010 a project file consists of keys; expected 'project:', 'links:' and so on"
GOOD = """project: Sample
links:
  - name: L
    type: soft
    plcs:
      - name: P
        items:
          - {name: A, address: VW0, high: 9, low: 1, description: "x: y"}
        folders:
          - name: F
            items: [{name: B, address: Q0.0}]
  - {name: S, type: sim, plcs: [{name: Q, items: [{name: C, address: "SINE(1s, 0, 1)"}]}]}
groups:
  - {name: G, update_rate: 250ms, items: [L.P.A]}
"""


NO_TAGS = "a project file obeys none; a text that begins with ! must stand in quotes"


def refusal(data: bytes | str, tmp_path: Path) -> str:
    """The only line a user sees about this file."""
    path = tmp_path / "items.yaml"
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    with pytest.raises(ProblemError) as caught:
        load_project(path)
    (problem,) = caught.value.problems
    return str(problem).removeprefix(f"{tmp_path}/")


@pytest.mark.parametrize(
    ("data", "line"),
    [
        ("", "items.yaml:1:1: PRJ007 the file is empty"),
        ("# nothing yet\n", "items.yaml:1:1: PRJ007 the file is empty"),
        ("~\n", "items.yaml:1:1: PRJ007 the file is empty"),
        ("links:\n\t- name: x\n", "items.yaml:2:1: PRJ003 a tab in the indentation; indent with blanks"),
        (
            "links:\n  - name: a\n  \t  type: soft\n",
            "items.yaml:3:3: PRJ003 a tab in the indentation; indent with blanks",
        ),
        (
            "- a\n- b\n",
            "items.yaml:1:1: PRJ010 a project file consists of keys; expected 'project:', 'links:' and so on",
        ),
        (
            "just a text",
            "items.yaml:1:1: PRJ010 a project file consists of keys; expected 'project:', 'links:' and so on",
        ),
        ("project: x\n", "items.yaml:1:1: PRJ009 the key 'links' is missing"),
        ("links: 'x\n", "items.yaml:2:1: PRJ002 a quotation mark that is never closed"),
        ("links: [1, 2\n", "items.yaml:2:1: PRJ002 a ',' or ']' is missing before this"),
        (
            "links: []\n---\nlinks: []\n",
            "items.yaml:2:1: PRJ002 a second YAML document; a project file is one document",
        ),
        ("? [a]\n: b\n", "items.yaml:1:3: PRJ002 a key must be a word"),
        ("links: *x\n", "items.yaml:1:8: PRJ002 *x refers to nothing; no &x stands above it"),
        ("links: &x [*x]\n", "items.yaml:1:12: PRJ005 *x contains itself"),
        ("links: []\n<<: 5\n", "items.yaml:2:1: PRJ002 << takes a mapping, for example <<: *defaults"),
        ("links: \x07\n", "items.yaml:1:8: PRJ002 the character '\\x07'"),
        (
            "links: !!python/object/apply:os.system [ls]",
            f"items.yaml:1:8: PRJ004 the tag !!python/object/apply:os.system; {NO_TAGS}",
        ),
        ("links: !!int 5", f"items.yaml:1:8: PRJ004 the tag !!int; {NO_TAGS}"),
        ("links: !mine {a: b}", f"items.yaml:1:8: PRJ004 the tag !mine; {NO_TAGS}"),
        ("links: []\nlinks: []\n", "items.yaml:2:1: PRJ006 the key 'links' stands here twice"),
        (
            "links: []\nproject: K\xf6ln".encode("cp1252"),
            "items.yaml:2:11: PRJ001 the byte F6 is not UTF-8 (is it 'ö'?); save the file as UTF-8",
        ),
        ("links: []".encode("utf-16"), "items.yaml:1:1: PRJ001 this is UTF-16; save the file as UTF-8"),
        (b"\x7fELF\x02\x00\x00\x00", "items.yaml:1:1: PRJ001 this is not a text file"),
        (b"PK\x03\x04whatever", "items.yaml:1:1: PRJ001 this is an archive or a workbook"),
        (
            b"\x00\x01\x00\x00Standard Jet DB\x00",
            "items.yaml:1:1: PRJ001 this is a PC Access project; turn it into YAML with: pcaccess import",
        ),
    ],
)
def test_one_line_says_what_is_wrong_with_the_file(data: bytes | str, line: str, tmp_path: Path) -> None:
    assert refusal(data, tmp_path) == line


def test_a_missing_file_and_a_directory_are_said_to_be_that(tmp_path: Path) -> None:
    for path, words in ((tmp_path / "none.yaml", "there is no such file"), (tmp_path, "a directory, not a file")):
        with pytest.raises(ProblemError, match=words):
            load_project(path)


def test_a_device_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ProblemError, match="a device, not a file"):
        load_project(tmp_path / "pipe")


def test_a_file_with_the_mark_of_windows_editors_is_read(tmp_path: Path) -> None:
    (tmp_path / "items.yaml").write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert load_project(tmp_path / "items.yaml").project.name == "Sample"


@pytest.mark.parametrize(
    "text", ["[" * 300_000, "- " * 300_000, "{a: " * 300_000, "links: [" + "[" * 200 + "]" * 200 + "]"]
)
def test_deep_nesting_is_refused_and_ends_nothing(text: str) -> None:
    with pytest.raises(ProblemError, match="nested more than 100 levels deep"):
        load_text(text)


def test_aliases_that_multiply_are_refused_before_they_fill_the_memory() -> None:
    bomb = "a: &a [x, x, x, x, x, x, x, x, x, x]\n"
    for above, name in zip("abcdefgh", "bcdefghi", strict=True):
        bomb += f"{name}: &{name} [{', '.join([f'*{above}'] * 10)}]\n"
    with pytest.raises(ProblemError, match="PRJ005"):
        load_text(bomb)


def test_merge_keys_that_multiply_are_refused_too() -> None:
    bomb = "a: &a {x: [" + "y, " * 1000 + "]}\n" + "links: [" + "{<<: *a}, " * 2000 + "]\n"
    with pytest.raises(ProblemError, match="PRJ005"):
        load_text(bomb)


def test_a_tag_and_a_double_key_are_told_together() -> None:
    with pytest.raises(ProblemError) as caught:
        load_text("links: []\nproject: !!str x\nlinks: []\n")
    assert [problem.code for problem in caught.value.problems] == ["PRJ004", "PRJ006"]


DAMAGE = ["", "\t", "\x00", "- ", "{", "]", "&a ", "*a", "!!x ", ": ", "é", "\ud800", "type: sim, ", "10"]


def problems_of(text: str) -> list[Problem]:
    try:
        load_text(text)
    except ProblemError as error:
        return error.problems
    return []


@given(st.integers(0, len(GOOD)), st.integers(0, 30), st.sampled_from(DAMAGE))
@settings(max_examples=300)
def test_a_damaged_file_is_read_or_refused_with_a_place_in_it(start: int, length: int, damage: str) -> None:
    """Cuts and foreign characters anywhere in a good file."""
    text = GOOD[:start] + damage + GOOD[start + length :]
    for problem in problems_of(text):
        assert 1 <= problem.span.line <= text.count("\n") + 2
        assert problem.span.column >= 1


@given(data=st.binary(max_size=300))
def test_bytes_of_any_kind_are_refused_in_words(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "garbage.yaml"
    path.write_bytes(data)
    with pytest.raises(ProblemError, match="PRJ"):
        load_project(path)
