"""Python's garbage collector while much is being built, and after.

Building a hundred thousand objects that stay makes the collector look at all of them again and again; it doubled the
time of a start. Nothing here changes what is freed, only when it is looked for.
"""

from __future__ import annotations

import ctypes
import gc
from collections.abc import Iterator
from contextlib import contextmanager, suppress


@contextmanager
def paused() -> Iterator[None]:
    """No collections inside; nests, and leaves a collector that was off alone."""
    if not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def settle() -> None:
    """What was made so far stays for good: the collector need not look at it again, which costs pauses.

    What was needed only for making it goes back to the system, where the C library can (a tenth of the memory of a
    large project).
    """
    gc.collect()
    gc.freeze()
    with suppress(OSError, AttributeError, TypeError):  # glibc alone has it
        ctypes.CDLL(None).malloc_trim(0)
