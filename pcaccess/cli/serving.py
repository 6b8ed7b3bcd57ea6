"""A project, served until somebody says stop: the gateway, its OPC UA server, its watched project file."""

from __future__ import annotations

import asyncio
import logging
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Final

from pcaccess.clock import Clock
from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.programs import Programs
from pcaccess.gateway.projectfile import ProjectFile
from pcaccess.opcua.server import EndpointError, OpcUaServer
from pcaccess.project.load import Loaded

log = logging.getLogger(__name__)

_STOP_SIGNALS: Final = ("SIGINT", "SIGTERM", "SIGBREAK")
"""Those that the operating system has; SIGBREAK is Ctrl-Break of Windows."""


async def serve(
    loaded: Loaded,
    programs: Programs,
    path: Path,
    clock: Clock,
    stop: asyncio.Event,
    ready: Callable[[str], None],
    endpoint: str | None = None,
) -> None:
    """Serve until ``stop`` is set; ``ready`` is called with the URL when clients may come.

    Stops in order: clients are disconnected, then the links end, so that what a client wrote still arrives. Raises
    EndpointError when the endpoint cannot be served.
    """
    gateway = Gateway(loaded.project, clock, programs)
    gateway.show()
    file = ProjectFile(gateway, path, loaded)
    server = OpcUaServer(gateway, endpoint)
    server.offer_reload(file.reload)
    try:
        await server.start()
    except EndpointError:
        await server.stop()
        raise
    async with asyncio.TaskGroup() as tasks:
        running = [tasks.create_task(gateway.run()), tasks.create_task(file.run())]
        try:
            ready(server.url)
            await stop.wait()
        finally:
            log.info("stopping")
            await server.stop()
            for task in running:
                task.cancel()


@contextmanager
def stopped_by_signals(stop: asyncio.Event) -> Iterator[None]:
    """Set ``stop`` on Ctrl-C and on what service managers send; a second Ctrl-C ends the process at once."""
    loop = asyncio.get_running_loop()
    numbers = [getattr(signal, name) for name in _STOP_SIGNALS if hasattr(signal, name)]
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
