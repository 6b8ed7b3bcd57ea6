"""Optimising in a process of its own, so that scans do not wait for LLVM and a fault of it stays there.

:class:`Optimiser` starts it; ``main`` is what runs in it: LLVM text on standard input, an object file on standard
output. Files stand between the two, so nobody has to wait for the other.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from contextlib import ExitStack, suppress
from typing import IO

from pcaccess.plc.llvm.machine import Tier, object_code

_NICENESS = 15
_BOOT = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from pcaccess.plc.llvm.optimise import main; main()"


class Optimiser:
    """One program on its way to better code."""

    def __init__(self, text: str) -> None:
        """Start. Raises OSError when no process can be started."""
        with ExitStack() as files:
            self._out: IO[bytes] = files.enter_context(tempfile.TemporaryFile())
            self._log: IO[bytes] = files.enter_context(tempfile.TemporaryFile())
            with tempfile.TemporaryFile() as source:
                source.write(text.encode())
                source.seek(0)
                command = [sys.executable, "-c", _BOOT, json.dumps(sys.path)]
                self._process = subprocess.Popen(command, stdin=source, stdout=self._out, stderr=self._log)
            self._files = files.pop_all()

    @property
    def is_running(self) -> bool:
        return self._process.poll() is None

    def wait(self) -> None:
        self._process.wait()

    def result(self) -> bytes:
        """The object file, once it is no longer running. Raises RuntimeError when the process failed."""
        with self._files:
            code = self._process.wait()
            if code:
                self._log.seek(0)
                tail = self._log.read().decode(errors="replace").strip().splitlines()[-1:]
                raise RuntimeError(f"optimising ended with {code}: {' '.join(tail)}")
            self._out.seek(0)
            return self._out.read()

    def cancel(self) -> None:
        if self.is_running:
            self._process.kill()
            self._process.wait()
        self._files.close()


def _step_back() -> None:
    """Less important than anything that scans."""
    with suppress(OSError):  # then it competes
        if hasattr(os, "sched_setscheduler"):
            os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
    with suppress(OSError):
        if hasattr(os, "nice"):
            os.nice(_NICENESS)


def main() -> None:
    _step_back()
    sys.stdout.buffer.write(object_code(sys.stdin.buffer.read().decode(), Tier.OPTIMISED))


if __name__ == "__main__":
    main()
