"""docs/cli.md names every command and option there is, and none that is not."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer.main

from pcaccess.cli.main import app

PAGE = (Path(__file__).parents[2] / "docs" / "cli.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"^## (\S+)\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL))


def commands(group: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Each command with its full name."""
    for name, command in group.commands.items():
        if hasattr(command, "commands"):
            yield from commands(command, f"{prefix}{name} ")
        else:
            yield f"{prefix}{name}", command


COMMANDS = dict(commands(typer.main.get_command(app)))


def options(command: Any) -> set[str]:
    """Long and short spellings, without those that switch off."""
    found = {spelling for parameter in command.params for spelling in parameter.opts if spelling.startswith("-")}
    return found - {"--help"}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_is_described_with_all_its_options(name: str) -> None:
    section = SECTIONS[name.split()[0]]
    described = set(re.findall(r"(?<![\w-])--?[a-z][a-z-]*", section))
    missing = {
        o for o in options(COMMANDS[name]) if o not in described and o.replace("--", "--no-", 1) not in described
    }
    assert missing == set()
    assert name in section


@pytest.mark.parametrize("title", SECTIONS)
def test_no_option_is_described_that_is_not_there(title: str) -> None:
    known = {o for name, command in COMMANDS.items() if name.split()[0] == title for o in options(command)}
    known |= {o.replace("--", "--no-", 1) for o in known}
    described = set(re.findall(r"`(--?[a-z][a-z-]*)", SECTIONS[title]))
    assert described - known == set() or title == "What"


def test_the_overview_names_every_command() -> None:
    overview = PAGE[: PAGE.index("## What all of them share")]
    assert {name.split()[0] for name in COMMANDS} == set(re.findall(r"\[`(\w+)`\]", overview))
