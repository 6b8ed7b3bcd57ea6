"""Builds one POU: the logic stack, power flow, labels, loops and SCR segments on top of plain IR.

The logic stack is symbolic: nine values that the lowering shuffles, so LPS or ALD cost nothing at run time.
Where control flow joins (labels, loops, ends of segments) the levels pass through variables. What persists:
a POU starts with level 0 on and the others off; networks do not touch the stack; a called POU has a stack of
its own. ENO is a variable of its own; a box that does not run leaves it as it was.

Consecutive boxes with the same power flow share one branch (``power``).

Source:   docs/decisions/2026-11-22-stl-ir.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from pcaccess.s7200.cpu import CpuModel
from pcaccess.stl import ir, layout
from pcaccess.stl.builder import Builder, Place
from pcaccess.stl.errors import INDIRECT_ADDRESS
from pcaccess.stl.ir_values import Effects, IrError, IrType, PythonFunction, Value, Variable
from pcaccess.stl.program import Operand
from pcaccess.stl.runtime import OK

LEVELS = layout.STACK_LEVELS


@dataclass(slots=True)
class Loop:
    """A FOR that waits for its NEXT."""

    index: Place
    final: Callable[[], Value]
    body: ir.Block
    after: ir.Block


@dataclass(slots=True)
class Segment:
    """An SCR segment that waits for its SCRE."""

    bit: Place
    idle: ir.Block
    after: ir.Block
    idle_actions: list[Callable[[], None]] = field(default_factory=list)


class Routine(Builder):
    """The builder that instruction bodies get."""

    def __init__(self, name: str, model: CpuModel, *, observed: bool) -> None:
        """``observed``: the final logic stack and ENO are stored (OB1)."""
        super().__init__(name)
        self.model = model
        self._observed = observed
        self._levels: list[Value | Variable] = [self.bit(level == 0) for level in range(LEVELS)]
        self._stack_variables: list[Variable] = []
        self._eno = self._variable("eno", initial=1)
        self._open: Value | None = None
        self._after_open: ir.Block | None = None
        self._labels: dict[int, ir.Block] = {}
        self._passed: set[int] = set()
        self._loops: list[Loop] = []
        self.segment: Segment | None = None
        self.valid: Value = self.bit(True)
        """For contacts: 0 when a pointer of this instruction was bad."""

    def new_edge(self) -> int:
        """Flat address of the edge memory for one more EU or ED of the program."""
        raise NotImplementedError

    def call_subroutine(self, number: int, operands: tuple[Operand, ...]) -> None:
        """Emit a CALL with what it passes."""
        raise NotImplementedError

    def _variable(self, name: str, *, initial: int = 0) -> Variable:
        variable = Variable(len(self.function.variables), IrType.I1, name, initial)
        self.function.variables.append(variable)
        return variable

    # the logic stack

    def level(self, number: int) -> Value:
        """Level ``number`` of the logic stack; 0 is the top. Read it before ``when`` and ``choose``."""
        value = self._levels[number]
        if isinstance(value, Variable):
            if self.nested:
                raise IrError("a stack level is read for the first time where it is not always computed")
            self.close_power()
            value = self._get(value)
            self._levels[number] = value
        return value

    def _get(self, variable: Variable) -> Value:
        out = self.new_value(variable.type)
        self.emit(ir.GetVariable(out, variable))
        return out

    @property
    def top(self) -> Value:
        return self.level(0)

    def set_top(self, value: Value) -> None:
        self._levels[0] = value

    def push(self, value: Value) -> None:
        """The lowest level is lost."""
        self._levels = [value, *self._levels[:-1]]

    def pop(self) -> Value:
        """Take the top off; the lowest level becomes 0."""
        value = self.top
        self._levels = [*self._levels[1:], self.bit(False)]
        return value

    def _spill(self) -> None:
        """Put the stack into its variables: control flow joins next."""
        if not self._stack_variables:
            self._stack_variables = [self._variable(f"stack{n}") for n in range(LEVELS)]
        changed = []
        for number, variable in enumerate(self._stack_variables):
            if self._levels[number] is not variable:
                changed.append((variable, self.level(number)))
        if changed:
            self.emit(ir.SetVariables(tuple(changed)))

    def _join(self, block: ir.Block) -> None:
        """Go on in a block that several edges reach; each has spilled."""
        self.start(block)
        self._levels = list(self._stack_variables)

    @contextmanager
    def _aside(self) -> Iterator[None]:
        """Inside: a way that leaves the text here; what it does to the stack does not count after it."""
        levels = list(self._levels)
        yield
        self._levels = levels

    # power flow

    @contextmanager
    def power(self) -> Iterator[None]:
        """Inside: what runs while S0 is 1. The region stays open for the next box with the same S0."""
        condition = self.top
        if self._open is not condition:
            self.close_power()
        if condition.constant != 1 and self._open is None:
            inside, self._after_open = self.new_block(), self.new_block()
            self.branch(condition, inside, self._after_open)
            self.start(inside)
            self._open = condition
        yield

    def close_power(self) -> None:
        """End the region that boxes share; called before anything that is not a box."""
        if self._open is not None:
            assert self._after_open is not None
            self.jump(self._after_open)
            self.start(self._after_open)
            self._open = None

    # ENO

    def eno(self, value: Value | bool) -> None:
        value = value if isinstance(value, Value) else self.bit(value)
        self.emit(ir.SetVariables(((self._eno, value),)))

    def get_eno(self) -> Value:
        return self._get(self._eno)

    def bad_pointer(self) -> None:
        """What every box does with a pointer that names nothing."""
        self.fault(INDIRECT_ADDRESS)
        self.eno(False)

    def cold(
        self,
        function: PythonFunction,
        *arguments: Value,
        static: tuple[object, ...] = (),
        effects: Effects | None = None,
    ) -> None:
        """A whole box as one Python function: its outcome gives ENO and the error (``pcaccess.stl.runtime``)."""
        outcome = self.call(function, *arguments, static=static, effects=effects, result=IrType.I32)
        assert outcome is not None
        good = self.eq(outcome, OK)
        self.eno(good)
        if effects is None or effects.errors:
            with self.when(self.gt(outcome, OK)):
                self.fault(outcome)

    def check_pointer(self, pointer: Value, size: int | Value) -> Value:
        """Flat address (I32) that ``pointer`` (U32) names, or -1."""
        out = self.new_value(IrType.I32)
        self.emit(ir.CheckPointer(out, pointer, size if isinstance(size, Value) else self.const(IrType.I32, size)))
        return out

    # leaving

    def leave(self, *, unwind: bool = False) -> None:
        """Return from the POU here. What follows starts a block that only a jump reaches."""
        self.close_power()
        self._finish(unwind=unwind)
        self.start(self.new_block())

    def leave_if_powered(self, before: Callable[[], None] | None = None, *, unwind: bool = False) -> None:
        """Return while S0 is 1; ``before`` emits what is done first."""
        out, after = self._split()
        with self._aside():
            self.start(out)
            if before is not None:
                before()
            self._finish(unwind=unwind)
        self.start(after)

    def _split(self) -> tuple[ir.Block, ir.Block]:
        """Branch on S0: the block for 1 and the block for 0."""
        condition = self.top
        self.close_power()
        powered, other = self.new_block(), self.new_block()
        self.branch(condition, powered, other)
        return powered, other

    def _finish(self, *, unwind: bool) -> None:
        if self._observed:
            self._store_stack()
        self.terminate(ir.Return(unwind))

    def _store_stack(self) -> None:
        levels = [self.level(n) for n in range(LEVELS)]
        self.emit(ir.StoreBits(layout.LOGIC_STACK + 1, tuple(enumerate(levels[:8]))))
        self.emit(ir.StoreBits(layout.LOGIC_STACK, ((0, levels[8]),)))
        self.emit(ir.StoreBits(layout.ENO, ((0, self.get_eno()),)))

    def end(self) -> ir.Function:
        """The POU ends here."""
        self.close_power()
        self._finish(unwind=False)
        for block in self.function.blocks:
            if block.terminator is None:
                raise IrError(f"{self.function.name}: {block} has no end")
        return self.function

    # jumps and loops

    def poll(self, network: int = -1) -> None:
        self.close_power()
        self.emit(ir.Poll(network))

    def _back(self) -> None:
        self.emit(ir.Budget(self.place))
        self.emit(ir.Poll(-1))

    def label(self, number: int) -> None:
        """LBL: a block that jumps and the text before it reach."""
        self.close_power()
        if number not in self._labels:
            self._labels[number] = self.new_block()
        block = self._labels[number]
        self._spill()
        self.jump(block)
        self._join(block)
        self._passed.add(number)

    def jump_to_label(self, number: int) -> None:
        """JMP: go on at the label while S0 is 1."""
        if number not in self._labels:
            self._labels[number] = self.new_block()
        out, after = self._split()
        with self._aside():
            self.start(out)
            self._spill()
            if number in self._passed:
                self._back()
            self.jump(self._labels[number])
        self.start(after)

    def begin_loop(self, index: Place, first: Value, final: Callable[[], Value], valid: Value) -> None:
        """FOR: run up to :meth:`end_loop` once for each value of ``index`` from ``first`` to ``final``."""
        condition = self.and_(self.top, valid)
        enter, body, after = self.new_block(), self.new_block(), self.new_block()
        self._spill()
        self.branch(condition, enter, after)
        self.start(enter)
        self.eno(True)
        self.store(index, first)
        self.branch(self.le(first, final()), body, after)
        self._join(body)
        self._loops.append(Loop(index, final, body, after))

    def end_loop(self) -> None:
        """NEXT: count up; again, or on behind the loop."""
        self.close_power()
        loop = self._loops.pop()
        self.set_top(self.bit(True))
        self._spill()
        index = self.load(loop.index)
        again, block = self.lt(index, loop.final()), self.new_block()
        self.store(loop.index, self.add(index, 1))
        self.branch(again, block, loop.after)
        self.start(block)
        self._back()
        self.jump(loop.body)
        self._join(loop.after)

    # SCR segments

    def begin_segment(self, bit: Place) -> None:
        """LSCR: what stands up to :meth:`end_segment` runs while ``bit`` is 1."""
        self.close_power()
        active = self.load(bit)
        inside, idle, after = self.new_block(), self.new_block(), self.new_block()
        self.set_top(active)
        self._spill()
        self.branch(active, inside, idle)
        self.segment = Segment(bit, idle, after)
        self.start(inside)
        self.set_top(self.bit(True))

    def leave_segment(self) -> None:
        """CSCRE: go to the end of the segment while S0 is 1."""
        assert self.segment is not None
        out, after = self._split()
        with self._aside():
            self.start(out)
            self._spill()
            self.jump(self.segment.after)
        self.start(after)

    def when_idle(self, action: Callable[[], None]) -> None:
        """``action`` emits what the instruction does while the SCR segment it stands in is not active."""
        if self.segment is not None:
            self.segment.idle_actions.append(action)

    def end_segment(self) -> None:
        """SCRE: the end; what the segment does while it is not active goes here."""
        assert self.segment is not None
        segment, self.segment = self.segment, None
        self.close_power()
        self._spill()
        self.jump(segment.after)
        self.start(segment.idle)
        for action in segment.idle_actions:
            action()
        self.jump(segment.after)
        self._join(segment.after)
