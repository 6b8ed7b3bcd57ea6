"""docs/instructions is what the definitions say today."""

from __future__ import annotations

import pytest
from instruction_docs import FOLDER, build

from pcaccess.stl.definitions import DEFINITIONS

PAGES = build()


@pytest.mark.parametrize("name", PAGES)
def test_the_page_is_up_to_date(name: str) -> None:
    """If not: python tools/instruction_docs.py"""
    assert (FOLDER / name).read_text(encoding="utf-8") == PAGES[name]


def test_there_is_no_other_page() -> None:
    assert {path.name for path in FOLDER.iterdir()} == set(PAGES)


@pytest.mark.parametrize("mnemonic", DEFINITIONS)
def test_every_instruction_is_in_the_index_and_on_a_page(mnemonic: str) -> None:
    assert f"`{mnemonic}`" in PAGES["README.md"]
    assert any(f"`{mnemonic}`" in text for name, text in PAGES.items() if name != "README.md")


def test_every_family_has_an_example() -> None:
    for name, text in PAGES.items():
        if name != "README.md":
            assert text.count("\n## ") == text.count("\nExample:"), name
