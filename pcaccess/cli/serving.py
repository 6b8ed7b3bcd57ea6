"""A project, served until somebody says stop: the gateway, its OPC UA and web servers, its watched project file."""

from __future__ import annotations

import asyncio
import logging
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Final

from pcaccess.clock import Clock
from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.programs import Programs
from pcaccess.gateway.projectfile import ProjectFile
from pcaccess.opcua.server import EndpointError, OpcUaServer
from pcaccess.project.load import Loaded
from pcaccess.project.network import parse_web
from pcaccess.web.server import WebError, WebServer

log = logging.getLogger(__name__)

_STOP_SIGNALS: Final = ("SIGINT", "SIGTERM", "SIGBREAK", "SIGHUP")
"""Those that the operating system has; SIGBREAK is Ctrl-Break of Windows, SIGHUP a terminal that was closed."""


@dataclass(frozen=True, slots=True)
class Addresses:
    """Where clients come."""

    opcua: str
    web: str | None
    """None where there is no web server."""
    why_no_web: str = ""
    """Why not, when nobody asked to do without."""


async def serve(
    loaded: Loaded,
    programs: Programs,
    path: Path,
    clock: Clock,
    stop: asyncio.Event,
    ready: Callable[[Addresses], None],
    endpoint: str | None = None,
    listen: str | None = None,
) -> None:
    """Serve until ``stop`` is set; ``ready`` is called when clients may come.

    ``endpoint`` and ``listen`` stand instead of the project's ``endpoint`` and ``web``. Stops in order: clients are
    disconnected, then the links end, so that what a client wrote still arrives. Raises EndpointError or WebError when
    an address cannot be served.
    """
    gateway = Gateway(loaded.project, clock, programs)
    gateway.show()
    file = ProjectFile(gateway, path, loaded)
    server = OpcUaServer(gateway, endpoint)
    server.offer_reload(file.reload)
    try:
        await server.start()
        web, why_no_web = await _start_web(gateway, listen)
    except (EndpointError, WebError):
        await server.stop()
        raise
    async with asyncio.TaskGroup() as tasks:
        running = [tasks.create_task(gateway.run()), tasks.create_task(file.run())]
        if web is not None:
            running.append(tasks.create_task(web.run()))
        try:
            ready(Addresses(server.url, web.url if web else None, why_no_web))
            await stop.wait()
        finally:
            log.info("stopping")
            if web is not None:
                await web.stop()
            await server.stop()
            for task in running:
                task.cancel()


async def _start_web(gateway: Gateway, listen: str | None) -> tuple[WebServer | None, str]:
    """The web server, or why there is none: at an address that nobody chose, one can do without it."""
    settings = gateway.project.server
    place = settings.web if listen is None else parse_web(listen)
    if place is None:
        return None, ""
    web = WebServer(gateway, place)
    try:
        await web.start()
    except WebError as error:
        if listen is not None or settings.web_is_wished:
            raise
        return None, str(error)
    return web, ""


def _is_kept_out(number: int) -> bool:
    """``nohup`` keeps the end of the terminal from whatever it starts."""
    return signal.Signals(number).name == "SIGHUP" and signal.getsignal(number) is signal.SIG_IGN


@contextmanager
def stopped_by_signals(stop: asyncio.Event) -> Iterator[None]:
    """Set ``stop`` on Ctrl-C and on what service managers send; a second Ctrl-C ends the process at once."""
    loop = asyncio.get_running_loop()
    numbers = [getattr(signal, name) for name in _STOP_SIGNALS if hasattr(signal, name)]
    numbers = [number for number in numbers if not _is_kept_out(number)]
    before = {number: signal.getsignal(number) for number in numbers}

    def restore() -> None:
        for number in numbers:
            signal.signal(number, before[number] or signal.SIG_DFL)

    def ask(number: int, frame: FrameType | None) -> None:
        restore()
        loop.call_soon_threadsafe(stop.set)

    # Not loop.add_signal_handler: Windows does not have it.
    for number in numbers:
        signal.signal(number, ask)
    try:
        yield
    finally:
        restore()
