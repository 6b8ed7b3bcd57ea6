"""What executes a module: the interface that the interpreter and the compiler share.

An executor is made for one module, one buffer and one CPU (its ``Runtime``); a new program gets a new executor.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from pcaccess.stl.ir import Module
from pcaccess.stl.runtime import Runtime


class Executor(Protocol):
    """Runs the functions of one module."""

    @property
    def name(self) -> str:
        """For people: ``interpreter``."""
        ...

    def run(self, function: int) -> bool:
        """Run one function of the module to its end; True when it unwound. Called again from within (a poll
        that runs an interrupt routine)."""
        ...

    def close(self) -> None:
        """It will not be run again."""
        ...


MakeExecutor = Callable[[Module, Runtime], Executor]
"""How a CPU gets an executor; the buffer is ``runtime.memory`` and stays the same object."""
