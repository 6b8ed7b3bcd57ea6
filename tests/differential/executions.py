"""The executions that tests compare with the interpreter, by name.

Programs of tests are short; ``pieces`` cuts them as long ones are cut (``pcaccess.plc.llvm.regions``), and
``optimised`` shows what LLVM makes of code that says more than it may.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final
from unittest import mock

from pcaccess.plc.compiler import Compiled
from pcaccess.plc.executor import Executor, MakeExecutor
from pcaccess.plc.llvm import regions
from pcaccess.plc.llvm.machine import Tier
from pcaccess.stl.ir import Module
from pcaccess.stl.runtime import Runtime


def compiled(module: Module, runtime: Runtime) -> Executor:
    return Compiled(module, runtime, optimise=False)


def pieces(module: Module, runtime: Runtime) -> Executor:
    with mock.patch.multiple(regions, PIECE=12, WHOLE=0):
        return Compiled(module, runtime, optimise=False)


def optimised(module: Module, runtime: Runtime) -> Executor:
    with mock.patch.multiple(regions, PIECE=40, WHOLE=0):
        return Compiled(module, runtime, tier=Tier.OPTIMISED)


COMPILED: Final[Mapping[str, MakeExecutor]] = {"compiled": compiled, "pieces": pieces, "optimised": optimised}
