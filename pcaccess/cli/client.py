"""``pcaccess browse``, ``read``, ``write`` and ``watch``: commands that talk to a running server."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING, Annotated, Final

import typer

from pcaccess.cli.options import AsJson, Url, duration, server_url
from pcaccess.cli.output import complain, json_list, note, show, show_table
from pcaccess.cli.streams import stdout_console

if TYPE_CHECKING:
    from pcaccess.cli.watching import View

NAMES: Final = "Item IDs or run-time names in any case, PLCs and folders (all items below), patterns with * and ?."


def browse(
    node: Annotated[str | None, typer.Argument(help="Where to begin; left out: at the top.")] = None,
    recursive: Annotated[bool, typer.Option("--recursive", "-r", help="All levels below.")] = False,
    depth: Annotated[int, typer.Option(min=1, help="So many levels below.")] = 1,
    everything: Annotated[
        bool, typer.Option("--all", "-a", help="Also properties, and what PLCs say of themselves.")
    ] = False,
    as_json: AsJson = False,
    url: Url = None,
) -> None:
    """List links, PLCs, folders and items of a server."""
    from pcaccess.cli.browsing import COLUMNS
    from pcaccess.cli.browsing import browse as run

    listed = asyncio.run(run(server_url(url), node, None if recursive else depth, everything=everything))
    if as_json:
        json_list([one.as_json() for one in listed])
    elif listed:
        show_table(COLUMNS, [one.as_row() for one in listed])


def read(
    items: Annotated[list[str], typer.Argument(help=NAMES)],
    as_json: AsJson = False,
    url: Url = None,
) -> None:
    """Read items: value, time stamp and quality.

    A sample of bad quality is an answer (exit code 0); an item that gives none makes the exit code 1. Of a branch
    or pattern what can be read is read; items that can only be written are named and are no failure.
    """
    from pcaccess.cli.reading import read as run
    from pcaccess.cli.samples import COLUMNS

    answers = asyncio.run(run(server_url(url), items))
    if as_json:
        json_list([answer.as_json() for answer in answers])
    elif samples := [answer.sample.as_row() for answer in answers if answer.error is None]:
        show_table(COLUMNS, samples)
    for answer in answers:
        if answer.error is not None:
            (complain if answer.is_failure else note)(answer.error)
    if any(answer.is_failure for answer in answers):
        raise typer.Exit(1)


def write(
    values: Annotated[
        list[str], typer.Argument(help="ITEM VALUE [ITEM VALUE …], or ITEM=VALUE …", metavar="ITEM VALUE …")
    ],
    as_json: AsJson = False,
    url: Url = None,
) -> None:
    """Write values to items.

    A value is converted to the item's type: true or 1; -12, 16#FF, 2#1010; 3.5; a text; an array as 1,2,3.
    """
    from pcaccess.cli.writing import write as run

    results = asyncio.run(run(server_url(url), pairs(values)))
    if as_json:
        json_list([result.as_json() for result in results])
    else:
        for result in results:
            if result.error is None:
                show(result.text)
    errors = [result.error for result in results if result.error is not None]
    for error in errors:
        complain(error)
    if errors:
        raise typer.Exit(1)


def watch(
    items: Annotated[list[str] | None, typer.Argument(help=f"{NAMES} Left out: all items.")] = None,
    group: Annotated[str | None, typer.Option(help="The items of a group of the project, at its rate.")] = None,
    interval: Annotated[
        str | None, typer.Option(help="Time between looks. [default: 100ms]", show_default=False)
    ] = None,
    count: Annotated[int | None, typer.Option(min=1, help="End after so many changes.")] = None,
    period: Annotated[str | None, typer.Option("--for", help="End after a time such as 5s.", metavar="TIME")] = None,
    as_json: AsJson = False,
    url: Url = None,
) -> None:
    """Watch items change: the Test Client.

    On a terminal all items stand in one table, live; else every change is a line. What an item is at the beginning
    counts as a change. Ctrl-C ends it.
    """
    from pcaccess.cli.views import JsonLines, LiveTable, PlainLines
    from pcaccess.cli.watching import Wanted
    from pcaccess.cli.watching import watch as run
    from pcaccess.clock import SystemClock

    server = server_url(url)
    wanted = Wanted(items or (), group, duration(interval), count, duration(period))
    failures: list[str] = []
    with ExitStack() as stack, suppress(KeyboardInterrupt):
        view: View
        if as_json:
            view = JsonLines()
        elif (out := stdout_console()).is_terminal:
            view = stack.enter_context(LiveTable(server, out))
        else:
            view = PlainLines()
        asyncio.run(run(server, wanted, view, SystemClock(), failures))
    if failures:
        raise typer.Exit(1)


_NUMBER: Final = re.compile(r"-(\d|\.\d|inf|nan)", re.IGNORECASE)


def pairs(words: Sequence[str]) -> list[tuple[str, str]]:
    """Items and values of a command line: ``A 1 B 2`` or ``A=1 B=2``. Wrong usage raises BadParameter."""
    option = next((word for word in words if word.startswith("-") and not _NUMBER.match(word)), None)
    if option is not None:
        raise typer.BadParameter(f"no such option: {option} (a text that begins with - is written as ITEM={option})")
    if all("=" in word for word in words):
        return [(item, value) for item, _, value in (word.partition("=") for word in words)]
    if len(words) % 2:
        raise typer.BadParameter(f"{words[-1]} has no value; write ITEM VALUE [ITEM VALUE …] or ITEM=VALUE …")
    return list(zip(words[::2], words[1::2], strict=True))
