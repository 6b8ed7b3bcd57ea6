"""How tools/problem_pages.py reads a page. That the pages themselves are right is tests/test_docs_problems.py."""

from __future__ import annotations

from pathlib import Path

import problem_pages
import pytest
from problem_pages import Mark

PAGE = """# PRJ999: a title

Text.

## Wrong

```yaml
a: 1
b: 22
   ^^
c: 3
^
```

```csv tags.csv
x,y
  ^
```

## Right

```yaml
a: 1
```
"""


@pytest.fixture
def write_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(problem_pages, "PAGES", tmp_path)
    return lambda text: (tmp_path / "PRJ999.md").write_text(text)


def test_carets_mark_the_line_above_and_vanish(write_page) -> None:
    write_page(PAGE)
    wrong = problem_pages.read_page("PRJ999").wrong
    assert wrong.files[0] == ("items.yaml", "a: 1\nb: 22\nc: 3\n")
    assert wrong.marks[:2] == (Mark("items.yaml", 2, 4, 2), Mark("items.yaml", 3, 1, 1))


def test_named_blocks_are_files_beside_the_example(write_page) -> None:
    write_page(PAGE)
    page = problem_pages.read_page("PRJ999")
    assert (page.title, page.wrong.language, page.wrong.files[1]) == ("a title", "yaml", ("tags.csv", "x,y\n"))
    assert page.wrong.marks[2:] == (Mark("tags.csv", 1, 3, 1),)
    assert (page.right.files, page.right.marks) == ((("items.yaml", "a: 1\n"),), ())


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("# PRJ999: ", "# PRJ998: ", "first line"),
        ("## Right", "## Good", "'## Right' with a fenced example is missing"),
        ("```csv tags.csv", "```csv", "every further one has"),
        ("```yaml\na: 1\n```\n", "```toml\na: 1\n```\n", "not toml"),
        ("```yaml\na: 1\n```\n", "```yaml\na: 1\n^\n```\n", "nothing is marked in the right example"),
    ],
)
def test_a_page_that_breaks_the_convention_is_named(write_page, old: str, new: str, message: str) -> None:
    write_page(PAGE.replace(old, new))
    with pytest.raises(ValueError, match=message):
        problem_pages.read_page("PRJ999")
