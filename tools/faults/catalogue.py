"""All faults, in the order of the way of a program: from its text to its scan."""

from __future__ import annotations

from typing import Final

from faults.compiler import COMPILER
from faults.cpu import CPU
from faults.fault import Fault
from faults.instructions import INSTRUCTIONS
from faults.interpreter import INTERPRETER
from faults.lowering import LOWERING

ALL: Final[tuple[Fault, ...]] = (*LOWERING, *INSTRUCTIONS, *INTERPRETER, *COMPILER, *CPU)
