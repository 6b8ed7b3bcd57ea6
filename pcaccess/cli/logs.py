"""What a server has to say, on standard error, without ever waiting for who reads it.

A terminal that was stopped (Ctrl-S, or text selected in a Windows console) and a pipe whose reader hangs take nothing.
A log written straight to them would hold the whole gateway, so a thread writes it. Messages that find no room are
counted, and their number is told when there is room again.
"""

from __future__ import annotations

import logging
from contextlib import suppress
from queue import Full, Queue
from threading import Thread
from typing import Final, TextIO

WAITING: Final = 1000
"""Messages that may wait to be written."""
GRACE: Final = 1.0
"""Seconds that the end of the process waits for the last ones."""
_FORMAT: Final = "%(asctime)s %(levelname)s %(name)s: %(message)s"


class LogWriter(logging.Handler):
    """Writes to ``stream`` from a thread of its own; :meth:`close` waits for it, but not for long."""

    def __init__(self, stream: TextIO, waiting: int = WAITING) -> None:
        super().__init__()
        self.setFormatter(logging.Formatter(_FORMAT))
        self._stream = stream
        self._queue: Queue[str | None] = Queue(waiting)
        self._lost = 0
        self._thread = Thread(target=self._write_all, name="log", daemon=True)
        self._thread.start()

    def emit(self, record: logging.LogRecord) -> None:
        try:
            text = self.format(record)
        except Exception:
            self.handleError(record)
            return
        try:
            self._queue.put_nowait(text)
        except Full:
            self._lost += 1

    def close(self) -> None:
        """Write what waits. A reader that takes nothing is left behind after ``GRACE`` seconds."""
        if self._thread.is_alive():
            try:
                self._queue.put(None, timeout=GRACE)
            except Full:
                pass
            else:
                self._thread.join(GRACE)
        super().close()

    def _write_all(self) -> None:
        while (text := self._queue.get()) is not None:
            self._write(text)
            if self._lost and self._queue.qsize() < self._queue.maxsize // 2:
                lost, self._lost = self._lost, 0
                self._write(f"{lost} messages were lost: standard error took nothing")

    def _write(self, text: str) -> None:
        # Below Python's own buffer, whose lock the end of the process would wait for.
        raw = getattr(getattr(self._stream, "buffer", None), "raw", None)
        with suppress(OSError, ValueError):  # nobody reads it, or it was closed
            if raw is None:  # in tests
                self._stream.write(f"{text}\n")
                return
            left = f"{text}\n".encode(self._stream.encoding, "backslashreplace")
            while left and (taken := raw.write(left)) is not None:  # None: it does not wait, and is full
                left = left[taken:]


def set_up_logging(level: int, stream: TextIO) -> None:
    """``level``: of the standard library's; asyncua's own workings are told below debug only."""
    logging.basicConfig(level=level, handlers=[LogWriter(stream)])
    if level <= logging.WARNING:  # who saves a file wants to know what became of it
        for name in ("pcaccess.gateway.projectfile", "pcaccess.gateway.download"):
            logging.getLogger(name).setLevel(min(level, logging.INFO))
    logging.getLogger("asyncua").setLevel(level if level <= logging.DEBUG else max(level, logging.ERROR))
