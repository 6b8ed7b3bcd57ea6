"""The reference interpreter: the definition of what a program does.

Each operation of the IR becomes one small Python function over the list of registers, made once; a block runs
its functions in order and its terminator says which block is next. That is all there is to it, and it is what
the compiler is compared with.

Units:    registers hold Python ints, bools and floats in the range of their IR type.
Source:   ``pcaccess.stl.ir`` says what each operation means, ``pcaccess.stl.evaluate`` how it computes.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from pcaccess.plc.frames import pop_frame, push_frame
from pcaccess.stl import evaluate, ir, layout
from pcaccess.stl.ir_values import BinaryOp, IrError, IrType
from pcaccess.stl.runtime import Runtime

Registers = list[Any]
Step = Callable[[Registers], None]

_STRUCT: Final = {
    IrType.U8: struct.Struct(">B"),
    IrType.I8: struct.Struct(">b"),
    IrType.U16: struct.Struct(">H"),
    IrType.I16: struct.Struct(">h"),
    IrType.U32: struct.Struct(">I"),
    IrType.I32: struct.Struct(">i"),
    IrType.F32: struct.Struct(">f"),
}


class _Unwind(Exception):
    """A function and everything that called it ends."""


@dataclass(slots=True, eq=False)
class _Block:
    steps: tuple[Step, ...] = ()
    next: Callable[[Registers], _Block | None] = lambda _: None


@dataclass(slots=True, eq=False)
class _Function:
    entry: _Block
    frame: Registers
    """Registers by the index of their value, then variables; constants are in place."""
    initial: list[int]
    variables: int
    """Where the variables begin in the frame."""
    busy: bool = field(default=False)


class Interpreter:
    """An ``Executor`` without any machinery."""

    name = "interpreter"

    def __init__(self, module: ir.Module, runtime: Runtime) -> None:
        self._functions = [_Translator(function, module, runtime, self).translate() for function in module.functions]

    def run(self, function: int) -> bool:
        try:
            self.call(function)
        except _Unwind:
            return True
        return False

    def close(self) -> None:
        """Nothing to give up."""

    def call(self, index: int) -> None:
        """Run a function within another; raises to unwind."""
        function = self._functions[index]
        registers = list(function.frame) if function.busy else function.frame
        registers[function.variables :] = function.initial
        was_busy, function.busy = function.busy, True
        try:
            block: _Block | None = function.entry
            while block is not None:
                for step in block.steps:
                    step(registers)
                block = block.next(registers)
        finally:
            function.busy = was_busy


class _Translator:
    """Makes the functions for one IR function."""

    def __init__(self, function: ir.Function, module: ir.Module, runtime: Runtime, interpreter: Interpreter) -> None:
        self._function = function
        self._module = module
        self._runtime = runtime
        self._memory = runtime.memory
        self._interpreter = interpreter
        self._first_variable = len(function.values)

    def translate(self) -> _Function:
        blocks = [_Block() for _ in self._function.blocks]
        for source, block in zip(self._function.blocks, blocks, strict=True):
            block.steps = tuple(_STEPS[type(op)](self, op) for op in source.operations)
            block.next = self._terminator(source, blocks)
        initial = [variable.initial for variable in self._function.variables]
        frame: Registers = [value.constant for value in self._function.values]
        return _Function(blocks[0], frame + initial, initial, self._first_variable)

    def _terminator(self, block: ir.Block, blocks: list[_Block]) -> Callable[[Registers], _Block | None]:
        end = block.terminator
        if isinstance(end, ir.Jump):
            target = blocks[end.target.index]
            return lambda _: target
        if isinstance(end, ir.Branch):
            condition = end.condition.index
            then, otherwise = blocks[end.then.index], blocks[end.otherwise.index]
            return lambda r: then if r[condition] else otherwise
        if isinstance(end, ir.Return):
            return _unwind if end.unwind else lambda _: None
        raise IrError(f"{self._function.name}: {block} has no end")

    # memory

    def load(self, op: ir.Load) -> Step:
        m, out, at = self._memory, op.out.index, op.at
        if op.out.type is IrType.U8:

            def byte(r: Registers) -> None:
                r[out] = m[at]

            return byte
        unpack = _STRUCT[op.out.type].unpack_from

        def run(r: Registers) -> None:
            (r[out],) = unpack(m, at)

        return run

    def store(self, op: ir.Store) -> Step:
        m, at, value, pack = self._memory, op.at, op.value.index, _STRUCT[op.value.type].pack_into

        def run(r: Registers) -> None:
            pack(m, at, r[value])

        return run

    def load_bit(self, op: ir.LoadBit) -> Step:
        m, out, at, bit = self._memory, op.out.index, op.at, op.bit

        def run(r: Registers) -> None:
            r[out] = m[at] >> bit & 1

        return run

    def store_bits(self, op: ir.StoreBits) -> Step:
        m, at = self._memory, op.at
        bits = [(1 << bit, ~(1 << bit), value.index) for bit, value in op.bits]
        if len(bits) == 1:
            ((on, off, index),) = bits

            def one(r: Registers) -> None:
                if r[index]:
                    m[at] |= on
                else:
                    m[at] &= off

            return one

        def run(r: Registers) -> None:
            byte = m[at]
            for on, off, index in bits:
                byte = byte | on if r[index] else byte & off
            m[at] = byte

        return run

    def load_from(self, op: ir.LoadFrom) -> Step:
        m, out, address, unpack = self._memory, op.out.index, op.address.index, _STRUCT[op.out.type].unpack_from

        def run(r: Registers) -> None:
            (r[out],) = unpack(m, r[address])

        return run

    def store_to(self, op: ir.StoreTo) -> Step:
        m, address, value, pack = self._memory, op.address.index, op.value.index, _STRUCT[op.value.type].pack_into

        def run(r: Registers) -> None:
            pack(m, r[address], r[value])

        return run

    def copy_bytes(self, op: ir.CopyBytes) -> Step:
        m, to, source, count = self._memory, op.to.index, op.source.index, op.count.index

        def run(r: Registers) -> None:
            n = r[count]
            m[r[to] : r[to] + n] = bytes(m[r[source] : r[source] + n])

        return run

    def fill_words(self, op: ir.FillWords) -> Step:
        m, to, value, count = self._memory, op.to.index, op.value.index, op.count.index

        def run(r: Registers) -> None:
            n = r[count]
            m[r[to] : r[to] + 2 * n] = (r[value] & 0xFFFF).to_bytes(2, "big") * n

        return run

    def check_pointer(self, op: ir.CheckPointer) -> Step:
        areas = {area.code: (area.start, area.size) for area in self._module.pointers}
        out, pointer, size = op.out.index, op.pointer.index, op.size.index

        def run(r: Registers) -> None:
            start, limit = areas.get(r[pointer] >> 24, (0, -1))
            offset = r[pointer] & 0xFF_FFFF
            r[out] = start + offset if offset + r[size] <= limit else -1

        return run

    # arithmetic

    def binary(self, op: ir.Binary) -> Step:
        out, a, b = op.out.index, op.a.index, op.b.index
        if op.op is BinaryOp.AND:

            def both(r: Registers) -> None:
                r[out] = r[a] & r[b]

            return both
        if op.op is BinaryOp.OR:

            def either(r: Registers) -> None:
                r[out] = r[a] | r[b]

            return either
        compute = evaluate.binary(op.op, op.a.type)

        def run(r: Registers) -> None:
            r[out] = compute(r[a], r[b])

        return run

    def unary(self, op: ir.Unary) -> Step:
        out, a = op.out.index, op.a.index
        if op.a.type is IrType.I1:

            def invert(r: Registers) -> None:
                r[out] = not r[a]

            return invert
        return self._unary_step(out, a, evaluate.unary(op.op, op.a.type))

    def _unary_step(self, out: int, a: int, compute: Callable[[Any], Any]) -> Step:
        def run(r: Registers) -> None:
            r[out] = compute(r[a])

        return run

    def compare(self, op: ir.Compare) -> Step:
        out, a, b, relation = op.out.index, op.a.index, op.b.index, evaluate.compare(op.relation)

        def run(r: Registers) -> None:
            r[out] = relation(r[a], r[b])

        return run

    def convert(self, op: ir.Convert) -> Step:
        return self._unary_step(op.out.index, op.a.index, evaluate.convert(op.a.type, op.out.type))

    def bitcast(self, op: ir.Bitcast) -> Step:
        return self._unary_step(op.out.index, op.a.index, evaluate.bitcast(op.a.type, op.out.type))

    def fits(self, op: ir.Fits) -> Step:
        return self._unary_step(op.out.index, op.a.index, evaluate.fits(op.a.type, op.type))

    def finite(self, op: ir.Finite) -> Step:
        return self._unary_step(op.out.index, op.a.index, math.isfinite)

    def select(self, op: ir.Select) -> Step:
        out, condition, a, b = op.out.index, op.condition.index, op.a.index, op.b.index

        def run(r: Registers) -> None:
            r[out] = r[a] if r[condition] else r[b]

        return run

    def lookup(self, op: ir.Lookup) -> Step:
        return self._unary_step(op.out.index, op.index.index, op.table.__getitem__)

    def get_variable(self, op: ir.GetVariable) -> Step:
        out, variable = op.out.index, self._first_variable + op.variable.index

        def run(r: Registers) -> None:
            r[out] = r[variable]

        return run

    def set_variables(self, op: ir.SetVariables) -> Step:
        pairs = [(self._first_variable + variable.index, value.index) for variable, value in op.assignments]
        if len(pairs) == 1:
            ((target, source),) = pairs

            def one(r: Registers) -> None:
                r[target] = r[source]

            return one

        def run(r: Registers) -> None:
            for variable, value in pairs:
                r[variable] = r[value]

        return run

    # the program and the CPU

    def push_frame(self, op: ir.PushFrame) -> Step:
        m = self._memory

        def run(_: Registers) -> None:
            push_frame(m)

        return run

    def pop_frame(self, op: ir.PopFrame) -> Step:
        m = self._memory

        def run(_: Registers) -> None:
            pop_frame(m)

        return run

    def call_pou(self, op: ir.CallPou) -> Step:
        call, function = self._interpreter.call, op.function

        def run(_: Registers) -> None:
            call(function)

        return run

    def call_python(self, op: ir.CallPython) -> Step:
        runtime, function, static = self._runtime, op.function, op.static
        arguments = [value.index for value in op.arguments]
        out = -1 if op.out is None else op.out.index

        def run(r: Registers) -> None:
            answer = function(runtime, *static, *[r[a] for a in arguments])
            if out >= 0:
                r[out] = answer

        return run

    def fault(self, op: ir.Fault) -> Step:
        fault, code, place = self._runtime.fault, op.code.index, op.place

        def run(r: Registers) -> None:
            fault(r[code], place)

        return run

    def poll(self, op: ir.Poll) -> Step:
        m, poll, network = self._memory, self._runtime.poll, op.network

        def run(_: Registers) -> None:
            if m[layout.ATTENTION] and poll(network):
                raise _Unwind

        return run

    def budget(self, op: ir.Budget) -> Step:
        m, exhausted, counter, place = self._memory, self._runtime.out_of_budget, _STRUCT[IrType.U32], op.place

        def run(_: Registers) -> None:
            (left,) = counter.unpack_from(m, layout.BUDGET)
            if left:
                counter.pack_into(m, layout.BUDGET, left - 1)
            elif exhausted(place):
                raise _Unwind

        return run


def _unwind(_: Registers) -> None:
    raise _Unwind


_STEPS: Final[dict[type, Callable[[_Translator, Any], Step]]] = {
    ir.Load: _Translator.load,
    ir.Store: _Translator.store,
    ir.LoadBit: _Translator.load_bit,
    ir.StoreBits: _Translator.store_bits,
    ir.LoadFrom: _Translator.load_from,
    ir.StoreTo: _Translator.store_to,
    ir.CopyBytes: _Translator.copy_bytes,
    ir.FillWords: _Translator.fill_words,
    ir.CheckPointer: _Translator.check_pointer,
    ir.Binary: _Translator.binary,
    ir.Unary: _Translator.unary,
    ir.Compare: _Translator.compare,
    ir.Convert: _Translator.convert,
    ir.Bitcast: _Translator.bitcast,
    ir.Select: _Translator.select,
    ir.Fits: _Translator.fits,
    ir.Finite: _Translator.finite,
    ir.Lookup: _Translator.lookup,
    ir.GetVariable: _Translator.get_variable,
    ir.SetVariables: _Translator.set_variables,
    ir.PushFrame: _Translator.push_frame,
    ir.PopFrame: _Translator.pop_frame,
    ir.CallPou: _Translator.call_pou,
    ir.CallPython: _Translator.call_python,
    ir.Fault: _Translator.fault,
    ir.Poll: _Translator.poll,
    ir.Budget: _Translator.budget,
}
