"""How a command executes a program, and what it says where the fast way is not there."""

from __future__ import annotations

from dataclasses import dataclass

from pcaccess.cli.failures import Failed
from pcaccess.cli.options import Execution
from pcaccess.cli.output import note
from pcaccess.plc.compiler import Compiled, why_unavailable
from pcaccess.plc.executor import MakeExecutor
from pcaccess.plc.interpreter import Interpreter


@dataclass(slots=True)
class Executions:
    """What ``--execution`` means for each program of a command."""

    wanted: Execution
    _told: bool = False

    def choose(self, *, worth_compiling: bool = True) -> MakeExecutor:
        """Tells once when a program that is worth compiling cannot be. Raises Failed when it has to be."""
        if self.wanted is Execution.INTERPRETER or not (worth_compiling or self.wanted is Execution.COMPILED):
            return Interpreter
        why = why_unavailable()
        if why is None:
            return Compiled
        if self.wanted is Execution.COMPILED:
            raise Failed(f"programs cannot be compiled here: {why}")
        if not self._told:
            note(f"Programs run in the interpreter, which is much slower: {why}.")
            self._told = True
        return Interpreter
