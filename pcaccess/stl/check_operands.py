"""Operands against the definition of their instruction: number, type, memory area, range of the CPU.

As strict as Micro/WIN's compiler in SIMATIC mode: sizes must match (``VB10`` is no INT), WORD and INT are the same
size and mix; ``&`` is a double word; a bit cannot be addressed indirectly.

Source:   System Manual, operand tables of the instructions, "Indirect addressing" and "Constants";
          docs/decisions/2026-11-22-stl-checks.md for what they leave open.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Final

from pcaccess.problems import Span
from pcaccess.s7200.address import Address, AddressError, Area, Width
from pcaccess.s7200.cpu import CpuModel
from pcaccess.s7200.types import DataType
from pcaccess.stl.define import Definition, OperandSpec, Special
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import (
    AddressOf,
    Constant,
    ConstantForm,
    Direct,
    Indirect,
    Instruction,
    Operand,
    PouKind,
    PouReference,
    Unresolved,
)
from pcaccess.stl.wording import (
    AREA_TEXT,
    MAX_STRING_CONSTANT,
    SPECIAL_TEXT,
    WIDTH_TEXT,
    areas_text,
    constant_text,
    describe,
    example,
    form_text,
    limits,
    same_place,
    type_text,
)

FIRST_WRITABLE_SM: Final = 30
"""SMB0 to SMB29 are written by the CPU only (System Manual, "SM")."""
REAL_MAX: Final = 3.402823e38
POINTABLE: Final = frozenset({Area.I, Area.Q, Area.V, Area.M, Area.SM, Area.S, Area.T, Area.C, Area.AI, Area.AQ})
_WIDTHS: Final = MappingProxyType({1: Width.BYTE, 2: Width.WORD, 4: Width.DWORD})
_COUNTED: Final = MappingProxyType(
    {
        **dict.fromkeys(("S", "R", "SI", "RI"), ((0,), 1)),
        **dict.fromkeys(("BMB", "BMW", "BMD"), ((0, 1), 2)),
        "FILL": ((1,), 2),
    }
)
"""Instructions over N elements: operands that lie N long, and which operand is N."""

_MEANT: Final = MappingProxyType({("SPA", 1): "JMP"})
"""Instructions with so many operands are another one: SPA is the jump of German programs."""


class OperandChecker:
    """Checks the operands of instructions for one CPU model."""

    def __init__(self, cpu: CpuModel, problems: Collector) -> None:
        self._cpu = cpu
        self._problems = problems
        self._good: set[tuple[int, Address]] = set()
        """Direct operands that passed: (id of the spec, address). Programs name the same things again and again."""

    def check(self, instruction: Instruction, definition: Definition) -> None:
        specs = definition.operands
        operands = instruction.operands
        if definition.is_variadic:
            specs = specs[:1]
            operands = operands[:1]
        if len(operands) != len(specs):
            self._wrong_number(instruction, definition)
            return
        for number, (operand, spec) in enumerate(zip(operands, specs, strict=True), 1):
            if isinstance(operand, Direct) and (id(spec), operand.address) in self._good:
                continue
            self.check_one(operand, spec, f"operand {number} ({spec.name}) of {instruction.mnemonic}")
        counted = _COUNTED.get(instruction.mnemonic)
        if counted is not None:
            self._check_count(instruction, *counted, definition.operands[counted[1]])

    def check_one(self, operand: Operand, spec: OperandSpec, what: str, wrong_type: str = "STL021") -> None:
        """``what`` names the operand in messages; ``wrong_type`` is the code for a type that does not match."""
        if isinstance(operand, Direct):
            if self._direct(operand, spec, what, wrong_type):
                self._good.add((id(spec), operand.address))
        elif isinstance(operand, Constant):
            self._constant(operand, spec, what)
        elif isinstance(operand, Indirect):
            self._indirect(operand, spec, what)
        elif isinstance(operand, AddressOf):
            self._address_of(operand, spec, what)
        elif isinstance(operand, PouReference):
            self._pou(operand, spec, what)

    def _wrong_number(self, instruction: Instruction, definition: Definition) -> None:
        meant = _MEANT.get((instruction.mnemonic, len(instruction.operands)))
        if meant is None and any(isinstance(operand, Unresolved) for operand in instruction.operands):
            return  # what was not understood may have been several operands
        specs = definition.operands
        form = " ".join((instruction.mnemonic, ", ".join(spec.name for spec in specs))).strip()
        count = len(instruction.operands)
        message = f"{instruction.mnemonic} has {count} operand{'' if count == 1 else 's'} here"
        surplus = instruction.operands[len(specs) :]
        span = surplus[0].span if surplus else instruction.span
        self._problems.add(
            "STL023", span, message, expected=f"{len(specs)}: {form}" if specs else "none", nearest=meant
        )

    # -- direct addresses

    def _direct(self, operand: Direct, spec: OperandSpec, what: str, wrong_type: str) -> bool:
        address = operand.address
        shown = operand.symbol or str(address)
        if isinstance(spec.type, Special):
            return self._special(operand, spec, what)
        if not self._has_width(address, spec.type):
            message = f"{what} must be {type_text(spec)}; {shown} is {describe(address)}"
            nearest = same_place(address, spec)
            self._problems.add(wrong_type, operand.span, message, expected=example(spec), nearest=nearest)
            return False
        if address.area not in spec.areas:
            message = f"{what} cannot lie in {AREA_TEXT[address.area]}: {shown}"
            self._problems.add("STL022", operand.span, message, expected=areas_text(spec))
            return False
        if spec.direction.writes and address.area is Area.SM and address.offset < FIRST_WRITABLE_SM:
            message = f"{what} is written, and {shown} is read-only"
            self._problems.add("STL022", operand.span, message, expected=f"SM memory from SMB{FIRST_WRITABLE_SM} on")
            return False
        return self._exists(address, operand.span, spec.extent or None)

    def _exists(self, address: Address, span: Span, size: int | None = None) -> bool:
        try:
            self._cpu.check(address, size=size)
            return True
        except AddressError as error:
            self._problems.add("STL024", span, str(error))
            return False

    def _has_width(self, address: Address, data_type: DataType) -> bool:
        if address.area in (Area.T, Area.C):
            return data_type in (DataType.BOOL, DataType.INT, DataType.WORD)
        if address.area is Area.AC:
            return data_type is not DataType.BOOL
        if data_type is DataType.BOOL:
            return address.width is Width.BIT
        if data_type is DataType.STRING:
            return address.width is Width.BYTE
        return address.width is _WIDTHS[data_type.size]

    def _special(self, operand: Direct, spec: OperandSpec, what: str) -> bool:
        areas = {Special.TIMER: Area.T, Special.COUNTER: Area.C}
        if isinstance(spec.type, Special) and areas.get(spec.type) is operand.address.area:
            return self._exists(operand.address, operand.span)
        expected = SPECIAL_TEXT[spec.type] if isinstance(spec.type, Special) else ""
        shown = operand.symbol or str(operand.address)
        message = f"{what} must be {type_text(spec)}; {shown} is {describe(operand.address)}"
        self._problems.add("STL021", operand.span, message, expected=expected)
        return False

    def _check_count(self, instruction: Instruction, places: Sequence[int], count_at: int, spec: OperandSpec) -> None:
        """The last of N elements; a pointer or a variable N is checked when it runs."""
        count = instruction.operands[count_at]
        if not isinstance(count, Constant) or not isinstance(count.value, int):
            return
        if not 1 < count.value <= limits(spec, DataType.BYTE)[1]:
            return
        for at in places:
            operand = instruction.operands[at]
            if not isinstance(operand, Direct) or operand.address.area is Area.AC:
                continue
            address = operand.address
            try:
                self._cpu.check(address)
            except AddressError:
                continue  # reported already
            try:
                self._cpu.check(replace(address, count=count.value))
            except AddressError:
                last = self._cpu.range_text(address.area).split(" to ")[-1]
                message = f"{count.value} elements from {address} on go beyond {last}, the last of a {self._cpu.name}"
                self._problems.add("STL024", operand.span, message)

    # -- constants

    def _constant(self, constant: Constant, spec: OperandSpec, what: str) -> None:
        shown = constant.symbol or constant.text
        if spec.type in (Special.LABEL, Special.NUMBER):
            if not isinstance(constant.value, int) or constant.form is ConstantForm.ASCII:
                self._misfit(constant, f"{what} must be a whole number", spec)
            elif not (spec.low or 0) <= constant.value <= (spec.high or 0):
                self._misfit(constant, f"{what} cannot be {shown}", spec)
            return
        if isinstance(spec.type, Special):
            message = f"{what} must be {type_text(spec)}; {shown} is a constant"
            self._problems.add("STL021", constant.span, message, expected=SPECIAL_TEXT[spec.type])
            return
        if not spec.constant:
            written = "is written" if spec.direction.writes else "must be an address"
            message = f"{what} {written}; {shown} is a constant"
            self._problems.add("STL026", constant.span, message, expected=example(spec))
            return
        self._value(constant, spec, what, spec.type)

    def _value(self, constant: Constant, spec: OperandSpec, what: str, data_type: DataType) -> None:
        value, form = constant.value, constant.form
        kind = type_text(spec)
        if data_type is DataType.STRING or isinstance(value, str):
            if data_type is not DataType.STRING or not isinstance(value, str):
                self._misfit(constant, f"{what} must be {kind}; {constant.text} is {form_text(constant)}", spec)
            elif len(value) > MAX_STRING_CONSTANT:
                self._misfit(constant, f"a STRING constant of {len(value)} characters", spec)
            return
        if data_type is DataType.REAL:
            if form not in (ConstantForm.REAL, ConstantForm.DECIMAL) or constant.width is not None:
                self._misfit(constant, f"{what} must be {kind}; {constant.text} is {form_text(constant)}", spec)
            elif abs(value) > REAL_MAX:
                self._misfit(constant, f"{constant.text} does not fit a REAL", spec)
            return
        if not isinstance(value, int) or form is ConstantForm.BOOL:
            self._misfit(constant, f"{what} must be {kind}; {constant.text} is {form_text(constant)}", spec)
            return
        if constant.width is not None and constant.width.size != data_type.size:
            width = WIDTH_TEXT[constant.width]
            self._misfit(constant, f"{what} must be {kind}; {constant.text} is {width}", spec)
            return
        low, high = limits(spec, data_type)
        if not low <= value <= high:
            self._misfit(constant, f"{constant.text} does not fit {what}, {kind}", spec)

    def _misfit(self, constant: Constant, message: str, spec: OperandSpec) -> None:
        self._problems.add("STL025", constant.span, message, expected=constant_text(spec))

    # -- pointers and blocks

    def _indirect(self, operand: Indirect, spec: OperandSpec, what: str) -> None:
        if not self._exists(operand.pointer, operand.span):
            return
        if not spec.pointer:
            reason = (
                "a bit cannot be addressed indirectly" if spec.type is DataType.BOOL else "it must be written directly"
            )
            self._problems.add("STL027", operand.span, f"{what} cannot be a pointer: {reason}", expected=example(spec))

    def _address_of(self, operand: AddressOf, spec: OperandSpec, what: str) -> None:
        shown = operand.symbol or f"&{operand.address}"
        if not spec.address_of or not isinstance(spec.type, DataType) or spec.type.size != 4:
            message = f"{what} cannot be a pointer: {shown} is the address of {operand.address}, a double word"
            expected = "MOVD &VB0, VD10 to make a pointer" if spec.is_value else type_text(spec)
            self._problems.add("STL027", operand.span, message, expected=expected)
        elif operand.address.area not in POINTABLE or operand.address.width is Width.BIT:
            message = f"there is no pointer to {operand.address}"
            expected = "the address of a byte, word or double word of I, Q, V, M, SM, S, AI, AQ, or of a T or C"
            self._problems.add("STL027", operand.span, message, expected=expected)
        else:
            self._exists(operand.address, operand.span)

    def _pou(self, operand: PouReference, spec: OperandSpec, what: str) -> None:
        wanted = {Special.SBR: PouKind.SBR, Special.INT: PouKind.INT}
        if not isinstance(spec.type, Special) or wanted.get(spec.type) is not operand.kind:
            block = f"{operand.kind.value}{operand.number}"
            message = f"{what} must be {type_text(spec)}; {operand.name} is the block {block}"
            expected = SPECIAL_TEXT[spec.type] if isinstance(spec.type, Special) else example(spec)
            self._problems.add("STL021", operand.span, message, expected=expected)
