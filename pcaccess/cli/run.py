"""``pcaccess run``: serve a project."""

from __future__ import annotations

import logging
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from pcaccess import __version__
from pcaccess.cli.endpoint import PROJECT_FILE
from pcaccess.cli.failures import Failed
from pcaccess.cli.options import AsJson, MaxSize, check_url
from pcaccess.cli.output import counted, json_line, show, show_problems
from pcaccess.cli.projects import content_of, load_all

if TYPE_CHECKING:
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
    log_level: Annotated[LogLevel, typer.Option(help="How much to report on standard error.")] = LogLevel.WARNING,
    as_json: AsJson = False,
    max_size: MaxSize = None,
) -> None:
    """Serve the items of a project to OPC UA clients until Ctrl-C or SIGTERM.

    A saved project file is applied at once, when it is valid. With --json one line says when clients may come:
    {"url": …, "project": …, "links": …, "plcs": …, "items": …, "groups": …, "warnings": …}.
    """
    if endpoint is not None:
        check_url(endpoint)
    loaded, programs = load_all(project, max_size)
    show_problems([*loaded.warnings, *programs.warnings], stderr=True)
    _set_up_logging(log_level)
    _serve(loaded, programs, project, endpoint, as_json=as_json)


def _serve(loaded: Loaded, programs: Programs, path: Path, endpoint: str | None, *, as_json: bool) -> None:
    import asyncio

    from pcaccess.cli.serving import serve, stopped_by_signals
    from pcaccess.clock import SystemClock
    from pcaccess.collector import settle
    from pcaccess.opcua.server import EndpointError

    def ready(url: str) -> None:
        settle()
        content = content_of(loaded.project)
        warnings = len(loaded.warnings) + len(programs.warnings)
        if as_json:
            json_line({"url": url, "project": loaded.project.name, **content, "warnings": warnings})
        else:
            _announce(url, loaded, content)

    async def main() -> None:
        stop = asyncio.Event()
        with stopped_by_signals(stop):
            await serve(loaded, programs, path, SystemClock(), stop, ready, endpoint)

    try:
        asyncio.run(main())
    except EndpointError as error:
        raise Failed(str(error)) from None


def _announce(url: str, loaded: Loaded, content: dict[str, int]) -> None:
    """What is served, in a few lines."""
    name = f": {loaded.project.name}" if loaded.project.name else ""
    show(f"pcaccess {__version__}{name}")
    show(f"serving {counted(content, 'links', 'plcs', 'items', 'groups') or 'nothing yet'} at {url}", meaning="good")
    plcs = [(link, plc) for link in loaded.project.links for plc in link.plcs]
    for link, plc in plcs[:PLCS_SHOWN]:
        away = "" if plc.connected else ", not connected"
        model = f"{plc.cpu.name}, " if link.type.has_s7_memory else ""
        items = counted({"items": sum(1 for _ in plc.all_items())}, "items") or "no items"
        show(f"  {plc.item_id}: {link.type.value}, {model}{items}{away}")
    if len(plcs) > PLCS_SHOWN:
        show(f"  and {len(plcs) - PLCS_SHOWN} more PLCs")
    show("Ctrl-C stops.", meaning="dim")


def _set_up_logging(level: LogLevel) -> None:
    number = logging.getLevelNamesMapping()[level.name]
    logging.basicConfig(level=number, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    if number <= logging.WARNING:  # who saves a file wants to know what became of it
        for name in ("pcaccess.gateway.projectfile", "pcaccess.gateway.download"):
            logging.getLogger(name).setLevel(min(number, logging.INFO))
    # Below debug, what asyncua reports of its own workings is noise.
    logging.getLogger("asyncua").setLevel(number if level is LogLevel.DEBUG else max(number, logging.ERROR))
