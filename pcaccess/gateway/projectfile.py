"""The project file under a running gateway: a saved file is applied when it is valid.

Errors:   a broken file changes nothing; its problems are logged and returned.
Not here: what applying means (``reload``), reading the file (``pcaccess.project.load``).
"""

from __future__ import annotations

import asyncio
import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.programs import Programs, load_programs
from pcaccess.gateway.reload import apply_project
from pcaccess.problems import Problem, ProblemError
from pcaccess.project.diff import Changes
from pcaccess.project.load import Loaded, load_project
from pcaccess.stl.reader import files_beside

log = logging.getLogger(__name__)

LOOK_EVERY: Final = 0.5
"""Seconds between looks at the files."""

_Stamp = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class Reloaded:
    """What came of a reload: ``applied``, or the problems that forbade it."""

    applied: Changes | None
    problems: tuple[Problem, ...] = ()

    def __str__(self) -> str:
        if self.applied is not None:
            return str(self.applied)
        return "nothing changed:\n" + "\n".join(str(problem) for problem in self.problems)


class ProjectFile:
    """Watches the file a gateway was started from, every file that it names, and what lies beside its programs."""

    def __init__(self, gateway: Gateway, path: Path, loaded: Loaded) -> None:
        self._gateway = gateway
        self._path = path
        self._files = loaded.files
        self._seen = self._stamps()
        self._busy = asyncio.Lock()

    def _stamps(self) -> dict[Path, _Stamp | None]:
        plcs = (plc for link in self._gateway.project.links for plc in link.plcs)
        beside = (path for plc in plcs if plc.program is not None for path in files_beside(plc.program))
        return {path: _stamp(path) for path in (self._path, *self._files, *beside)}

    async def reload(self) -> Reloaded:
        """Read the file now and apply it; one at a time."""
        async with self._busy:
            self._seen = self._stamps()
            try:
                loaded, programs = await asyncio.to_thread(_load, self._path)
            except ProblemError as error:
                for problem in error.problems:
                    log.error("%s", problem)
                log.error("%s has errors; the gateway goes on as before", self._path)
                return Reloaded(None, tuple(error.problems))
            for problem in (*loaded.warnings, *programs.warnings):
                log.warning("%s", problem)
            if loaded.project.server != self._gateway.project.server:
                log.warning("%s: changes under 'server' take effect at the next start", self._path)
            applied = apply_project(self._gateway, loaded.project, programs)
            if loaded.files != self._files:
                self._files = loaded.files
                self._seen = self._stamps()
            log.info("%s applied: %s", self._path, applied)
            return Reloaded(applied)

    async def run(self) -> None:
        """Apply the file whenever it was saved; ends only by cancellation.

        A file is read when two looks in a row see it the same, so that half a save is not taken for the whole.
        """
        before = self._seen
        while True:
            await self._gateway.clock.sleep(LOOK_EVERY)
            now = self._stamps()
            if now != self._seen and now == before and now[self._path] is not None:
                await self.reload()
            before = now


def _load(path: Path) -> tuple[Loaded, Programs]:
    loaded = load_project(path)
    return loaded, load_programs(loaded.project)


def _stamp(path: Path) -> _Stamp | None:
    """What changes when a file is saved, whether in place or by renaming; None when there is no such file."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size, status.st_ino
