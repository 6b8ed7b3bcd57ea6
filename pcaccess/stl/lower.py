"""Lowers a checked program to IR: each instruction's definition emits what it does.

Every operand becomes what the body wants: a loaded ``Value`` for what is read, a ``Place`` for what is written
or is the first of several, a plain number for labels, timers and the like. Pointers are checked before the
body: a box with a bad pointer does nothing but error 0006; a contact reads 0 and lets no power through.

Errors:   the program has passed the checker without errors; :class:`LoweringError` for an instruction that is
          known but not executable yet, ``IrError`` for anything else (our own mistake).
"""

from __future__ import annotations

import itertools
import struct
from collections.abc import Iterator, Sequence
from types import MappingProxyType
from typing import Any, Final

from pcaccess.s7200.address import Address, AddressError, Area
from pcaccess.s7200.cpu import CpuModel
from pcaccess.s7200.memory import AREA_START, locate
from pcaccess.s7200.pointers import AREA_CODES, pointer_to
from pcaccess.s7200.types import DataType
from pcaccess.stl import ir, layout
from pcaccess.stl.builder import Place
from pcaccess.stl.define import Definition, In, InOut, OperandSpec, Out, Power, Special
from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.errors import RunTimeError
from pcaccess.stl.ir_values import TYPE_OF, IrError, IrType, Value
from pcaccess.stl.program import (
    AddressOf,
    Constant,
    Direct,
    Indirect,
    Instruction,
    Operand,
    Pou,
    PouKind,
    PouReference,
    Program,
    Section,
    Variable,
)
from pcaccess.stl.routine import Routine

_ALWAYS_ON: Final = AREA_START[Area.SM]
"""SM0.0: nothing can write it, so it is a constant."""


Target = tuple[Value, Value]
"""Of an operand behind a pointer: its checked flat address, and the pointer."""
Targets = dict[int, Target]


class LoweringError(Exception):
    """The program uses an instruction that cannot be executed yet."""


def lower(program: Program, model: CpuModel) -> ir.Module:
    """The whole program for one CPU model."""
    return _Lowering(program, model).module()


class _Lowering:
    def __init__(self, program: Program, model: CpuModel) -> None:
        self.program = program
        self.model = model
        self.edges = itertools.count()
        self.places: list[ir.Place] = []
        self.index = {(pou.kind, pou.number): n for n, pou in enumerate(program.pous)}

    def module(self) -> ir.Module:
        functions = tuple(PouBuilder(self, pou).lower() for pou in self.program.pous)
        interrupts = {number: n for (kind, number), n in self.index.items() if kind is PouKind.INT}
        return ir.Module(
            functions=functions,
            main=self.index[PouKind.MAIN, 1],
            interrupts=MappingProxyType(interrupts),
            places=tuple(self.places),
            pointers=pointer_areas(self.model),
            networks=len(self.program.main.networks),
            edges=next(self.edges),
        )

    def new_edge(self) -> int:
        number = next(self.edges)
        if number >= layout.MAX_EDGES:
            raise IrError("more than 256 edges; the checker should have said so")
        return layout.EDGES + number


def pointer_areas(model: CpuModel) -> tuple[ir.PointerArea, ...]:
    """What pointers may reach on a CPU model."""
    return tuple(
        ir.PointerArea(code, AREA_START[area], model.sizes[area] * (2 if area in (Area.T, Area.C) else 1))
        for area, code in AREA_CODES.items()
    )


def constant_number(constant: Constant, kind: DataType) -> int | float:
    """The number a constant is as an operand of type ``kind``.

    A REAL operand takes 2 as 2.0 and 16#3F800000 as the bits of 1.0; an integer operand takes 1.5 as its bits.
    """
    value = constant.value
    if isinstance(value, str):
        raise IrError("a text has no number")
    if kind is DataType.REAL:
        if isinstance(value, int) and constant.form.value in ("hexadecimal", "binary"):
            return float(struct.unpack(">f", struct.pack(">I", value & 0xFFFF_FFFF))[0])
        return float(value)
    if isinstance(value, float):
        return int(struct.unpack(">I", struct.pack(">f", value))[0])
    return value


class PouBuilder(Routine):
    """The builder of one POU of a program."""

    def __init__(self, owner: _Lowering, pou: Pou) -> None:
        super().__init__(pou.block, owner.model, observed=pou.kind is PouKind.MAIN)
        self._owner = owner
        self._pou = pou

    def lower(self) -> ir.Function:
        is_main = self._pou.kind is PouKind.MAIN
        for position, network in enumerate(self._pou.networks):
            self.poll(position if is_main else -1)
            for instruction in network.instructions:
                self.place = len(self._owner.places)
                self._owner.places.append(ir.Place(self._pou.where(), network.number, instruction.span))
                self._instruction(DEFINITIONS[instruction.mnemonic], instruction)
        return self.end()

    def new_edge(self) -> int:
        return self._owner.new_edge()

    def _instruction(self, definition: Definition, instruction: Instruction) -> None:
        if definition.body is None:
            raise LoweringError(f"{definition.mnemonic} cannot be executed yet")
        pairs = list(_pair(definition, instruction.operands))
        indirect = any(isinstance(operand, Indirect) for _, operand in pairs)
        if definition.power is Power.BOX:
            with self.power():
                self._box(definition, pairs, indirect)
        elif definition.power is Power.STACK and not pairs:
            definition.body(self, *definition.arguments)
        else:
            self.close_power()
            self._other(definition, pairs, indirect)

    def _box(self, definition: Definition, pairs: list[tuple[OperandSpec, Any]], indirect: bool) -> None:
        assert definition.body is not None
        if not indirect:
            definition.body(self, *definition.arguments, *self._resolve(pairs))
            return
        targets, good = self._pointers(pairs)
        with self.choose(good) as choice:
            definition.body(self, *definition.arguments, *self._resolve(pairs, targets))
            choice.otherwise()
            self.bad_pointer()

    def _other(self, definition: Definition, pairs: list[tuple[OperandSpec, Any]], indirect: bool) -> None:
        assert definition.body is not None
        self.valid = self.bit(True)
        if not indirect:
            definition.body(self, *definition.arguments, *self._resolve(pairs))
            return
        targets, good = self._pointers(pairs)
        if definition.power is Power.COIL:
            for level in range(definition.stack.needs):
                self.level(level)
            with self.choose(good) as choice:
                definition.body(self, *definition.arguments, *self._resolve(pairs, targets))
                choice.otherwise()
                self.fault(RunTimeError.INDIRECT_ADDRESS)
            return
        harmless = self.const(IrType.I32, layout.ZEROS)
        safe = {n: (self.select(good, a, harmless), p) for n, (a, p) in targets.items()}
        bad = self.not_(good)
        self.valid = good
        with self.when(self.and_(self.top, bad) if definition.power is Power.CONTROL else bad):
            self.fault(RunTimeError.INDIRECT_ADDRESS)
            if definition.eno_off:
                self.eno(False)
        definition.body(self, *definition.arguments, *self._resolve(pairs, safe))

    # operands

    def _pointers(self, pairs: Sequence[tuple[OperandSpec, Any]]) -> tuple[Targets, Value]:
        """Where each operand behind a pointer lies, and whether all of them are good."""
        targets: Targets = {}
        good = self.bit(True)
        for number, (spec, operand) in enumerate(pairs):
            if isinstance(operand, Indirect):
                pointer = self.load_at(IrType.U32, locate(operand.pointer)[0])
                size = 1 if spec.type is DataType.STRING or not isinstance(spec.type, DataType) else spec.type.size
                address = self.check_pointer(pointer, max(size, spec.extent))
                targets[number] = (address, pointer)
                good = self.and_(good, self.ge(address, 0))
        return targets, good

    def _resolve(self, pairs: Sequence[tuple[OperandSpec, Any]], targets: Targets | None = None) -> list[Any]:
        return [self._operand(spec, operand, (targets or {}).get(n)) for n, (spec, operand) in enumerate(pairs)]

    def _operand(self, spec: OperandSpec, operand: Any, target: Target | None) -> Any:
        if spec.type is Special.PARAMETERS:
            return operand
        if not isinstance(spec.type, DataType):
            return _special(operand)
        if isinstance(operand, Constant) and spec.type is DataType.STRING:
            text = str(operand.value).encode("latin-1", "replace")
            return bytes((len(text),)) + text
        if isinstance(operand, Constant | AddressOf):
            return self._constant(spec, operand)
        place = self.place_of(operand, spec.type, target)
        if spec.direction.writes or spec.block or spec.place or spec.type is DataType.STRING:
            return place
        if place.at == _ALWAYS_ON and spec.type is DataType.BOOL and place.bit == 0:
            return self.bit(True)
        return self.load_raw(place) if spec.raw else self.load(place)

    def _constant(self, spec: OperandSpec, operand: Constant | AddressOf) -> Value:
        assert isinstance(spec.type, DataType)
        kind = TYPE_OF[spec.type]
        if isinstance(operand, AddressOf):
            return self.const(kind, pointer_to(operand.address))
        if spec.raw and kind.real:
            bits = struct.unpack(">I", struct.pack(">f", constant_number(operand, spec.type)))[0]
            return self.const(IrType.U32, bits)
        return self.const(kind, constant_number(operand, spec.type))

    def place_of(self, operand: Direct | Indirect, kind: DataType, target: Target | None = None) -> Place:
        """Where an operand lies."""
        if isinstance(operand, Indirect):
            assert target is not None
            return Place(kind, target[0], pointer=target[1])
        at, bit = locate(_typed(operand.address, kind))
        return Place(kind, at, bit, operand.address.area, operand.address.offset)

    # subroutines

    def call_subroutine(self, number: int, operands: tuple[Operand, ...]) -> None:
        """Copy in, run, copy out; nested too deep it does nothing but error 0008."""
        callee = self._owner.program.subroutine(number)
        assert callee is not None
        pairs = list(zip(callee.parameters, operands, strict=True))
        depth, limit = self.load_at(IrType.U8, layout.CALL_DEPTH), self.load_at(IrType.U8, layout.CALL_LIMIT)
        with self.choose(self.lt(depth, limit)) as shallow:
            specs = [(_parameter_spec(variable), operand) for variable, operand in pairs]
            targets, good = self._pointers(specs)
            if targets:
                with self.choose(good) as choice:
                    self._call(self._owner.index[PouKind.SBR, number], pairs, targets)
                    choice.otherwise()
                    self.bad_pointer()
            else:
                self._call(self._owner.index[PouKind.SBR, number], pairs, targets)
            shallow.otherwise()
            self.fault(RunTimeError.CALL_TOO_DEEP)
            self.eno(False)

    def _call(self, function: int, pairs: Sequence[tuple[Variable, Operand]], targets: Targets) -> None:
        passed = []
        for n, (variable, operand) in enumerate(pairs):
            if variable.section is not Section.OUT:
                spec = _parameter_spec(variable)
                if variable.data_type is DataType.STRING:
                    value = self._pointer_value(operand, targets.get(n))
                elif isinstance(operand, Constant | AddressOf):
                    value = self._constant(spec, operand)
                else:
                    assert isinstance(operand, Direct | Indirect)
                    value = self.load_bits(self.place_of(operand, variable.data_type, targets.get(n)))
                passed.append((variable, value))
        self.emit(ir.Budget(self.place))
        self.emit(ir.PushFrame())
        for variable, value in passed:
            self.store(_local(variable), value)
        self.emit(ir.CallPou(function))
        results = [
            (variable, n, operand, self.load_bits(_local(variable)))
            for n, (variable, operand) in enumerate(pairs)
            if variable.section is not Section.IN
        ]
        self.emit(ir.PopFrame())
        for variable, n, operand, value in results:
            if isinstance(operand, Direct | Indirect):
                self.store(self.place_of(operand, variable.data_type, targets.get(n)), value)
        self.eno(True)
        self.emit(ir.Poll(-1))

    def _pointer_value(self, operand: Operand, target: Target | None) -> Value:
        """The pointer that a STRING parameter takes."""
        if isinstance(operand, Indirect):
            assert target is not None
            return target[1]
        assert isinstance(operand, Direct)
        return self.const(IrType.U32, pointer_to(operand.address))


def _pair(definition: Definition, operands: tuple[Operand, ...]) -> Iterator[tuple[OperandSpec, Any]]:
    for n, spec in enumerate(definition.operands):
        yield spec, operands[n:] if spec.type is Special.PARAMETERS else operands[n]


def _special(operand: Operand) -> int:
    if isinstance(operand, Constant):
        return int(operand.value)
    if isinstance(operand, PouReference):
        return operand.number
    assert isinstance(operand, Direct)
    return operand.address.offset


def _typed(address: Address, kind: DataType) -> Address:
    try:
        return address.as_type(kind)
    except AddressError as error:
        raise IrError(str(error)) from error


def _parameter_spec(variable: Variable) -> OperandSpec:
    make = {Section.IN: In, Section.IN_OUT: InOut, Section.OUT: Out}[variable.section]
    return make(variable.name, variable.data_type, raw=True)


def _local(variable: Variable) -> Place:
    kind = DataType.DWORD if variable.data_type is DataType.STRING else variable.data_type  # a pointer to the text
    at, bit = locate(variable.address.as_type(kind))
    return Place(kind, at, bit, Area.L, variable.address.offset)
