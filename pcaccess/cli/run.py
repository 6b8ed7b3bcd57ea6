"""``pcaccess run``: serve a project."""

from __future__ import annotations

import logging
import sys
from contextlib import suppress
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from pcaccess import __version__
from pcaccess.cli.endpoint import PROJECT_FILE
from pcaccess.cli.failures import Failed
from pcaccess.cli.logs import set_up_logging
from pcaccess.cli.options import AsJson, MaxSize, check_listen, check_url
from pcaccess.cli.output import json_line, note, show, show_problems
from pcaccess.cli.projects import content_of, load_all
from pcaccess.cli.streams import NoReader
from pcaccess.counting import counted

if TYPE_CHECKING:
    from pcaccess.cli.serving import Addresses
    from pcaccess.gateway.programs import Programs
    from pcaccess.project.load import Loaded

PLCS_SHOWN: Final = 20
"""PLCs that are named at the start; of more, their number is enough."""


class LogLevel(StrEnum):
    DEBUG = "debug"
    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


def run(
    project: Annotated[Path, typer.Argument(help="The project file.")] = Path(PROJECT_FILE),
    endpoint: Annotated[
        str | None,
        typer.Option(help="Serve here instead of where the file says; port 0 takes any free port.", metavar="URL"),
    ] = None,
    web: Annotated[
        str | None,
        typer.Option(help="Web server here instead of where the file says; off does without.", metavar="HOST:PORT"),
    ] = None,
    log_level: Annotated[LogLevel, typer.Option(help="How much to report on standard error.")] = LogLevel.WARNING,
    as_json: AsJson = False,
    max_size: MaxSize = None,
) -> None:
    """Serve the items of a project to OPC UA and web clients until Ctrl-C or SIGTERM.

    A saved project file is applied at once, when it is valid. With --json one line says when clients may come:
    {"url": …, "web": …, "project": …, "links": …, "plcs": …, "items": …, "groups": …, "warnings": …}.
    """
    if endpoint is not None:
        check_url(endpoint)
    if web is not None:
        check_listen(web)
    loaded, programs = load_all(project, max_size)
    show_problems([*loaded.warnings, *programs.warnings], stderr=True)
    set_up_logging(logging.getLevelNamesMapping()[log_level.name], sys.stderr)
    _serve(loaded, programs, project, endpoint, web, as_json=as_json)


def _serve(
    loaded: Loaded, programs: Programs, path: Path, endpoint: str | None, web: str | None, *, as_json: bool
) -> None:
    import asyncio

    from pcaccess.cli.serving import serve, stopped_by_signals
    from pcaccess.clock import SystemClock
    from pcaccess.collector import settle
    from pcaccess.opcua.server import EndpointError
    from pcaccess.web.server import WebError

    def ready(addresses: Addresses) -> None:
        settle()
        content = content_of(loaded.project)
        with suppress(NoReader, Failed):  # the clients are what matters, not who reads this
            if as_json:
                places = {"url": addresses.opcua, "web": addresses.web}
                warnings = len(loaded.warnings) + len(programs.warnings)
                json_line({**places, "project": loaded.project.name, **content, "warnings": warnings})
            else:
                _announce(addresses, loaded, content)
        if addresses.why_no_web:
            note(f"no web server: {addresses.why_no_web}")

    async def main() -> None:
        stop = asyncio.Event()
        with stopped_by_signals(stop):
            await serve(loaded, programs, path, SystemClock(), stop, ready, endpoint, web)

    try:
        asyncio.run(main())
    except (EndpointError, WebError) as error:
        raise Failed(str(error)) from None


def _announce(addresses: Addresses, loaded: Loaded, content: dict[str, int]) -> None:
    """What is served, in a few lines."""
    name = f": {loaded.project.name}" if loaded.project.name else ""
    show(f"pcaccess {__version__}{name}")
    what = counted(content, "links", "plcs", "items", "groups") or "nothing yet"
    show(f"serving {what} at {addresses.opcua}", meaning="good")
    if addresses.web:
        show(f"and at {addresses.web}", meaning="good")
    plcs = [(link, plc) for link in loaded.project.links for plc in link.plcs]
    for link, plc in plcs[:PLCS_SHOWN]:
        away = "" if plc.connected else ", not connected"
        model = f"{plc.cpu.name}, " if link.type.has_s7_memory else ""
        items = counted({"items": sum(1 for _ in plc.all_items())}, "items") or "no items"
        show(f"  {plc.item_id}: {link.type.value}, {model}{items}{away}")
    if len(plcs) > PLCS_SHOWN:
        show(f"  and {len(plcs) - PLCS_SHOWN} more PLCs")
    show("Ctrl-C stops.", meaning="dim")
