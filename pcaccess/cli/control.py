"""``pcaccess reload`` and ``pcaccess plc status``, ``start``, ``stop``, ``download``: a running gateway obeys."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Annotated

import typer

from pcaccess.cli.failures import Failed
from pcaccess.cli.options import AsJson, Url, server_url
from pcaccess.cli.output import complain, json_line, json_list, show, show_table, working

PlcName = Annotated[str, typer.Argument(metavar="LINK.PLC", help="The PLC.")]


def reload(as_json: AsJson = False, url: Url = None) -> None:
    """Let a running gateway read its project file again. (A saved file is applied by itself.)

    New items appear, changed ones change, everything else goes on. A file with errors changes nothing, and the exit
    code is 1.
    """
    from pcaccess.cli.controlling import reload as run

    applied, message = asyncio.run(run(server_url(url)))
    if as_json:
        json_line({"applied": applied, "message": message})
    elif applied:
        show(message)
    else:
        for line in message.splitlines():
            complain(line)
    if not applied:
        raise typer.Exit(1)


def status(
    plcs: Annotated[list[str] | None, typer.Argument(metavar="LINK.PLC", help="PLCs; left out: all.")] = None,
    as_json: AsJson = False,
    url: Url = None,
) -> None:
    """Show how the PLCs of a running gateway are: connected, mode, scan time, run-time errors."""
    from pcaccess.cli.controlling import STATUS_COLUMNS
    from pcaccess.cli.controlling import status as run

    states, errors = asyncio.run(run(server_url(url), plcs or ()))
    if as_json:
        json_list([state.as_json() for state in states])
    elif states:
        show_table(STATUS_COLUMNS, [state.as_row() for state in states])
    for error in errors:
        complain(error)
    if errors:
        raise typer.Exit(1)


def start(plc: PlcName, url: Url = None) -> None:
    """Put a soft-PLC that has a program to RUN."""
    _switch(plc, "Run", "RUN", url)


def stop(plc: PlcName, url: Url = None) -> None:
    """Put a soft-PLC to STOP; its outputs go to their values for STOP."""
    _switch(plc, "Stop", "STOP", url)


def _switch(plc: str, method: str, wanted: str, url: str | None) -> None:
    from pcaccess.cli.controlling import switch

    name, mode = asyncio.run(switch(server_url(url), plc, method))
    show(f"{name}: {mode}")
    if mode != wanted:
        raise Failed(f"{name} went back to {mode}; the log of pcaccess run says why")


def download(
    file: Annotated[Path, typer.Argument(help="A program as Micro/WIN exports it.")],
    plc: Annotated[str, typer.Option(metavar="LINK.PLC", help="The soft-PLC that takes it.")],
    as_json: AsJson = False,
    url: Url = None,
) -> None:
    """Give a running soft-PLC another program, which it takes between two scans; its memory stays.

    A program with errors changes nothing. The project file is not touched: the next start runs what it names.
    """
    from pcaccess.cli.controlling import download as run
    from pcaccess.stl.text import MAX_BYTES, read

    try:
        content = read(file)
    except OSError as error:
        raise Failed(f"{file} cannot be opened: {error.strerror}") from None
    if len(content) > MAX_BYTES:
        raise Failed(f"{file} has more than {MAX_BYTES:,} bytes; no program is so large")
    with working(f"{file} is checked and compiled"):
        done = asyncio.run(run(server_url(url), plc, str(file), content))
    if as_json:
        json_line(done.as_json())
    else:
        for problem in done.problems:
            complain(problem)
        taken = "runs" if done.mode == "RUN" else f"is taken; the PLC is in {done.mode}"
        show(f"{done.plc}: {file} {taken if done.accepted else 'is refused; nothing changed'}")
    if not done.accepted:
        raise typer.Exit(1)
    if done.mode != done.before:
        raise Failed(f"{done.plc} went to {done.mode}; the log of pcaccess run says why")
