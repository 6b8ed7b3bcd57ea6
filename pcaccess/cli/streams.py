"""Standard output and standard error as a command finds them: closed, full, or with a reader who goes away.

What was asked for goes to standard output. When nobody reads it any more the command ends at once and without a word,
as programs do that SIGPIPE ends; a server has other readers and goes on. What cannot be told on standard error is
lost.
"""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Final, TextIO

from rich.console import Console

from pcaccess.cli.failures import Failed

NO_READER: Final = 141
"""Exit code: 128 + SIGPIPE (13), what a shell shows of ``yes | head -1``."""
_GONE: Final = (errno.EPIPE, errno.EINVAL) if os.name == "nt" else (errno.EPIPE,)
"""What writing to a pipe without a reader gives."""


class NoReader(Exception):
    """Nobody reads standard output any more."""


class _Console(Console):
    def on_broken_pipe(self) -> None:
        """Rich itself would end the process here."""
        raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))


def stdout_console() -> Console:
    """Of standard output as it is now."""
    return _Console(highlight=False, soft_wrap=True)


def stderr_console() -> Console:
    return _Console(stderr=True, highlight=False, soft_wrap=True)


def prepare() -> None:
    """Make both streams fit to be written to, whatever the process was started with."""
    sys.stdout = _usable(sys.stdout, 1)
    sys.stderr = _usable(sys.stderr, 2)


def _usable(stream: TextIO | None, number: int) -> TextIO:
    if stream is None:  # the shell's >&-: nothing is written, and no socket shall have this number
        nowhere = os.open(os.devnull, os.O_WRONLY)
        if nowhere != number:
            os.dup2(nowhere, number)
            os.close(nowhere)
        return os.fdopen(number, "w", encoding="utf-8")
    # A terminal that cannot show a sign (Windows: °, …) shows its number instead of a traceback.
    reconfigure = getattr(stream, "reconfigure", None)
    if reconfigure is not None:
        reconfigure(errors="backslashreplace")
    return stream


@contextmanager
def writing() -> Iterator[None]:
    """Around everything that writes to standard output. Raises NoReader, or Failed when it takes no more."""
    try:
        yield
    except OSError as error:
        _forget_stdout()
        if error.errno in _GONE:
            raise NoReader from None
        raise Failed(f"standard output cannot be written: {error.strerror}") from None


def put(text: str) -> None:
    """Text on standard output; it may wait there for more."""
    with writing():
        sys.stdout.write(text)


def put_now(text: str) -> None:
    """Text on standard output, for somebody who waits for it."""
    with writing():
        sys.stdout.write(text)
        sys.stdout.flush()


def finish() -> None:
    """Everything written so far is written; errors as with :func:`writing`."""
    with writing():
        sys.stdout.flush()


@contextmanager
def best_effort() -> Iterator[None]:
    """For what goes to standard error: if it cannot be told, it is not."""
    with suppress(OSError):
        yield


def _forget_stdout() -> None:
    """What is still waiting to be written must not fail again when the process ends."""
    with suppress(OSError, ValueError):  # in tests there is no file
        number = sys.stdout.fileno()
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, number)
        os.close(nowhere)
