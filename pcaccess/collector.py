"""Python's garbage collector while much is being built, and after.

Building a hundred thousand objects that stay makes the collector look at all of them again and again; it doubled the
time of a start. Nothing here changes what is freed, only when it is looked for.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


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
    """What was made so far stays for good: the collector need not look at it again, which costs pauses."""
    gc.collect()
    gc.freeze()
