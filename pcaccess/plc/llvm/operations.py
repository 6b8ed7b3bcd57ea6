"""IR operations as LLVM text.

Written straight down in one pass, because a program must be ready at once: every operation appends its lines, results
are numbered as LLVM numbers them, and what rarely runs (a poll that finds something, an empty budget, a failed call)
goes into blocks behind the function so that the usual way falls through.

Source:   ``pcaccess.stl.ir`` says what each operation means; ``tests/differential`` compares.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from typing import Any, Final

from pcaccess.plc.llvm.abi import Sites
from pcaccess.stl import ir, layout
from pcaccess.stl.ir_values import BinaryOp, IrError, IrType, Relation, UnaryOp, Value

NAMES: Final[Mapping[IrType, str]] = {
    IrType.I1: "i1",
    IrType.U8: "i8",
    IrType.I8: "i8",
    IrType.U16: "i16",
    IrType.I16: "i16",
    IrType.U32: "i32",
    IrType.I32: "i32",
    IrType.U64: "i64",
    IrType.I64: "i64",
    IrType.F32: "float",
    IrType.F64: "double",
}
"""What LLVM calls each type; it keeps no signs."""

_COMMON: Final = {
    BinaryOp.ADD: "add",
    BinaryOp.SUB: "sub",
    BinaryOp.MUL: "mul",
    BinaryOp.AND: "and",
    BinaryOp.OR: "or",
    BinaryOp.XOR: "xor",
    BinaryOp.SHL: "shl",
}
_SIGNED: Final = _COMMON | {BinaryOp.DIV: "sdiv", BinaryOp.REM: "srem", BinaryOp.SHR: "ashr"}
_UNSIGNED: Final = _COMMON | {BinaryOp.DIV: "udiv", BinaryOp.REM: "urem", BinaryOp.SHR: "lshr"}
_REAL: Final = {BinaryOp.ADD: "fadd", BinaryOp.SUB: "fsub", BinaryOp.MUL: "fmul", BinaryOp.DIV: "fdiv"}
_REAL_RELATION: Final = {Relation.NE: "une"} | {r: f"o{r.value}" for r in Relation if r is not Relation.NE}
_EXPONENT: Final = {IrType.F32: 0x7F80_0000, IrType.F64: 0x7FF0_0000_0000_0000}
_EQUALITY: Final = (Relation.EQ, Relation.NE)
_INTRINSICS: Final = {UnaryOp.ABS: "fabs", UnaryOp.SQRT: "sqrt", UnaryOp.FLOOR: "floor", UnaryOp.TRUNC: "trunc"}


class Tables:
    """Constant tables of a module (``ir.Lookup``), each once."""

    def __init__(self) -> None:
        self._names: dict[str, str] = {}

    def name(self, kind: str, numbers: tuple[int, ...]) -> str:
        text = f"[{len(numbers)} x {kind}] [{', '.join(f'{kind} {n}' for n in numbers)}]"
        return self._names.setdefault(text, f"@table{len(self._names)}")

    def text(self) -> str:
        return "".join(f"{name} = internal constant {text}\n" for text, name in self._names.items())


class Parts:
    """What the functions of a module have in common."""

    def __init__(self) -> None:
        self.sites = Sites()
        self.tables = Tables()


def constant(value: Value) -> str:
    """How LLVM writes a constant."""
    number = value.constant
    if value.type.real:
        return _double(number)  # type: ignore[arg-type]
    return str(int(number))  # type: ignore[arg-type]


class Writer:
    """Writes operations of one IR function into one LLVM function."""

    def __init__(self, function: ir.Function, names: list[str], parts: Parts) -> None:
        """``names``: LLVM's names of the function's values; what is written here adds to them."""
        self._function = function
        self._parts = parts
        self._names = names
        self.out: list[str] = []
        self.rare: list[str] = []
        """Blocks that seldom run, behind the others; their values have names instead of numbers."""
        self._next = 0
        """Number of the next result."""
        self._splits = 0
        self._raw: dict[int, str] = {}
        """Values that were loaded, as they lie in memory; a move needs no swapping of bytes."""
        self.variables: frozenset[int] = frozenset()
        """Variables that somebody reads; the others are not kept."""

    def name(self, value: Value) -> str:
        return self._names[value.index]

    def rename(self, value: Value, name: str) -> None:
        """What follows finds the value under another name."""
        self._names[value.index] = name

    def operation(self, op: ir.Operation) -> None:
        _STEPS[type(op)](self, op)

    def _define(self, out: Value, text: str) -> None:
        """One line that computes ``out``."""
        self.out.append(f"%{self._next} = {text}\n")
        self._names[out.index] = f"%{self._next}"
        self._next += 1

    def line(self, text: str) -> str:
        """One line that computes something on the way; returns its name."""
        name = f"%{self._next}"
        self.out.append(f"{name} = {text}\n")
        self._next += 1
        return name

    # memory

    def load(self, op: ir.Load) -> None:
        self._load(op.out, self.line(f"getelementptr i8, ptr %m, i64 {op.at}"))

    def load_from(self, op: ir.LoadFrom) -> None:
        self._load(op.out, self._pointer(op.address))

    def _load(self, out: Value, pointer: str) -> None:
        kind, n = out.type, self._next
        if kind.bits == 8:
            self._define(out, f"load i8, ptr {pointer}")
            return
        lines = (
            f"%{n} = load i{kind.bits}, ptr {pointer}, align 1\n"
            f"%{n + 1} = call i{kind.bits} @llvm.bswap.i{kind.bits}(i{kind.bits} %{n})\n"
        )
        self._raw[out.index] = f"%{n}"
        if kind.real:
            lines += f"%{n + 2} = bitcast i32 %{n + 1} to float\n"
            n += 1
        self.out.append(lines)
        self._names[out.index] = f"%{n + 1}"
        self._next = n + 2

    def store(self, op: ir.Store) -> None:
        self._store(op.value, self.line(f"getelementptr i8, ptr %m, i64 {op.at}"))

    def store_to(self, op: ir.StoreTo) -> None:
        self._store(op.value, self._pointer(op.address))

    def _store(self, value: Value, pointer: str) -> None:
        kind, name = value.type, self._names[value.index]
        if kind.bits == 8:
            self.out.append(f"store i8 {name}, ptr {pointer}\n")
            return
        if value.index in self._raw:
            self.out.append(f"store i{kind.bits} {self._raw[value.index]}, ptr {pointer}, align 1\n")
            return
        if value.constant is not None:
            self.out.append(f"store i{kind.bits} {_swapped(value)}, ptr {pointer}, align 1\n")
            return
        if kind.real:
            name = self.line(f"bitcast float {name} to i32")
        n = self._next
        self.out.append(
            f"%{n} = call i{kind.bits} @llvm.bswap.i{kind.bits}(i{kind.bits} {name})\n"
            f"store i{kind.bits} %{n}, ptr {pointer}, align 1\n"
        )
        self._next = n + 1

    def load_bit(self, op: ir.LoadBit) -> None:
        """Shifted down and cut off: whoever uses the bit masks it anyway."""
        n = self._next
        self.out.append(f"%{n} = getelementptr i8, ptr %m, i64 {op.at}\n%{n + 1} = load i8, ptr %{n}\n")
        if op.bit:
            self.out.append(f"%{n + 2} = lshr i8 %{n + 1}, {op.bit}\n")
            n += 1
        self.out.append(f"%{n + 2} = trunc i8 %{n + 1} to i1\n")
        self._names[op.out.index] = f"%{n + 2}"
        self._next = n + 3

    def store_bits(self, op: ir.StoreBits) -> None:
        pointer = self.line(f"getelementptr i8, ptr %m, i64 {op.at}")
        keep, ones = 0xFF, 0
        for bit, value in op.bits:
            keep &= ~(1 << bit)
            if value.constant:
                ones |= 1 << bit
        byte = "0"
        if keep:
            byte = self.line(f"load i8, ptr {pointer}")
            if keep | ones != 0xFF:  # a bit that becomes a constant 1 need not be cleared
                byte = self.line(f"and i8 {byte}, {keep | ones}")
        for bit, value in op.bits:
            if value.constant is None:
                one = self.line(f"zext i1 {self._names[value.index]} to i8")
                if bit:
                    one = self.line(f"shl i8 {one}, {bit}")
                byte = self.line(f"or i8 {byte}, {one}")
        if ones:
            byte = self.line(f"or i8 {byte}, {ones}")
        self.out.append(f"store i8 {byte}, ptr {pointer}\n")

    def copy_bytes(self, op: ir.CopyBytes) -> None:
        to, source = self._pointer(op.to), self._pointer(op.source)
        count = self.line(f"sext i32 {self._names[op.count.index]} to i64")
        self.out.append(f"call void @llvm.memmove.p0.p0.i64(ptr {to}, ptr {source}, i64 {count}, i1 false)\n")

    def fill_words(self, op: ir.FillWords) -> None:
        to = self._pointer(op.to)
        if op.value.constant is None:
            word = self.line(f"call i16 @llvm.bswap.i16(i16 {self._names[op.value.index]})")
        else:
            word = str(_swapped(op.value))
        self.out.append(f"call void @fill_words(ptr {to}, i16 {word}, i32 {self._names[op.count.index]})\n")

    def _pointer(self, address: Value) -> str:
        return self.line(f"getelementptr i8, ptr %m, i32 {self._names[address.index]}")

    def check_pointer(self, op: ir.CheckPointer) -> None:
        pointer, size = self._names[op.pointer.index], self._names[op.size.index]
        self._define(op.out, f"call i32 @check_pointer(i32 {pointer}, i32 {size})")

    # arithmetic

    def binary(self, op: ir.Binary) -> None:
        kind = op.a.type
        words = _REAL if kind.real else _SIGNED if kind.signed else _UNSIGNED
        self._define(op.out, f"{words[op.op]} {NAMES[kind]} {self._names[op.a.index]}, {self._names[op.b.index]}")

    def unary(self, op: ir.Unary) -> None:
        kind, name, a = op.a.type, NAMES[op.a.type], self._names[op.a.index]
        if op.op is UnaryOp.NOT:
            self._define(op.out, f"xor {name} {a}, -1" if kind.bits > 1 else f"xor i1 {a}, true")
        elif op.op is UnaryOp.NEG:
            self._define(op.out, f"fneg {name} {a}" if kind.real else f"sub {name} 0, {a}")
        elif op.op is UnaryOp.TRAILING_ZEROS:
            self._trailing_zeros(op)
        else:
            self._define(op.out, f"call {name} @llvm.{_INTRINSICS[op.op]}.f{kind.bits}({name} {a})")

    def _trailing_zeros(self, op: ir.Unary) -> None:
        kind, a = op.a.type, self._names[op.a.index]
        if kind.bits < 32:
            a = self.line(f"zext {NAMES[kind]} {a} to i32")
            count = self.line(f"call i32 @llvm.cttz.i32(i32 {a}, i1 true)")
            self._define(op.out, f"trunc i32 {count} to {NAMES[kind]}")
        else:
            self._define(op.out, f"call i32 @llvm.cttz.i32(i32 {a}, i1 true)")

    def compare(self, op: ir.Compare) -> None:
        kind = op.a.type
        operands = f"{NAMES[kind]} {self._names[op.a.index]}, {self._names[op.b.index]}"
        if kind.real:
            self._define(op.out, f"fcmp {_REAL_RELATION[op.relation]} {operands}")
        else:
            sign = "" if op.relation in _EQUALITY else "s" if kind.signed else "u"
            self._define(op.out, f"icmp {sign}{op.relation.value} {operands}")

    def convert(self, op: ir.Convert) -> None:
        source, target, a = op.a.type, op.out.type, self._names[op.a.index]
        if source.bits == target.bits and source.real == target.real:
            self._names[op.out.index] = a
            return
        if source.real and target.real:
            word = "fpext" if target.bits > source.bits else "fptrunc"
        elif source.real:
            word = "fptosi" if target.signed else "fptoui"
        elif target.real:
            word = "sitofp" if source.signed else "uitofp"
        elif target.bits < source.bits:
            word = "trunc"
        else:
            word = "sext" if source.signed else "zext"
        self._define(op.out, f"{word} {NAMES[source]} {a} to {NAMES[target]}")

    def bitcast(self, op: ir.Bitcast) -> None:
        source, target, a = op.a.type, op.out.type, self._names[op.a.index]
        if source.real == target.real:
            self._names[op.out.index] = a
        else:
            self._define(op.out, f"bitcast {NAMES[source]} {a} to {NAMES[target]}")

    def select(self, op: ir.Select) -> None:
        kind, names = NAMES[op.a.type], self._names
        condition, a, b = names[op.condition.index], names[op.a.index], names[op.b.index]
        self._define(op.out, f"select i1 {condition}, {kind} {a}, {kind} {b}")

    def fits(self, op: ir.Fits) -> None:
        source, target, a = op.a.type, op.type, self._names[op.a.index]
        if source.real:
            self._real_fits(op, a)
            return
        low, high = max(source.low, target.low), min(source.high, target.high)
        name = NAMES[source]
        if low != source.low:  # shifted so that the whole range is one unsigned comparison
            a = self.line(f"sub {name} {a}, {low}") if low else a
            self._define(op.out, f"icmp ule {name} {a}, {high - low}")
        elif high != source.high:
            self._define(op.out, f"icmp {'sle' if source.signed else 'ule'} {name} {a}, {high}")
        else:
            self._define(op.out, "icmp eq i1 true, true")

    def _real_fits(self, op: ir.Fits, a: str) -> None:
        """Compared as doubles, which hold every 32-bit bound and its neighbours exactly."""
        if op.type.bits > 32:
            raise IrError(f"{self._function.name}: whether a real fits {op.type}")
        if op.a.type is IrType.F32:
            a = self.line(f"fpext float {a} to double")
        low = self.line(f"fcmp ogt double {a}, {_double(op.type.low - 1)}")
        high = self.line(f"fcmp olt double {a}, {_double(op.type.high + 1)}")
        self._define(op.out, f"and i1 {low}, {high}")

    def finite(self, op: ir.Finite) -> None:
        """Infinity and NaN have an exponent of ones."""
        name, a, whole = NAMES[op.a.type], self._names[op.a.index], f"i{op.a.type.bits}"
        mask = _EXPONENT[op.a.type]
        bits = self.line(f"bitcast {name} {a} to {whole}")
        exponent = self.line(f"and {whole} {bits}, {mask}")
        self._define(op.out, f"icmp ne {whole} {exponent}, {mask}")

    def lookup(self, op: ir.Lookup) -> None:
        kind, index = NAMES[op.out.type], op.index
        table = self._parts.tables.name(kind, op.table)
        wide = self.line(f"zext {NAMES[index.type]} {self._names[index.index]} to i64")
        at = self.line(f"getelementptr {kind}, ptr {table}, i64 {wide}")
        self._define(op.out, f"load {kind}, ptr {at}")

    def get_variable(self, op: ir.GetVariable) -> None:
        self._define(op.out, f"load {NAMES[op.variable.type]}, ptr %x{op.variable.index}")

    def set_variables(self, op: ir.SetVariables) -> None:
        for variable, value in op.assignments:
            if variable.index in self.variables:
                self.out.append(f"store {NAMES[variable.type]} {self._names[value.index]}, ptr %x{variable.index}\n")

    # the program and the CPU

    def push_frame(self, op: ir.PushFrame) -> None:
        self.out.append("call void @push_frame(ptr %m)\n")

    def pop_frame(self, op: ir.PopFrame) -> None:
        self.out.append("call void @pop_frame(ptr %m)\n")

    def _split(self) -> int:
        self._splits += 1
        return self._splits

    def _unwind_if(self, condition: str) -> None:
        """Leave the function when ``condition`` is 1; go on in a new block."""
        s = self._split()
        self.out.append(f"br i1 {condition}, label %unwind, label %s{s}\ns{s}:\n")

    def call_pou(self, op: ir.CallPou) -> None:
        self._unwind_if(self.line(f"call zeroext i1 @f{op.function}(ptr %m, ptr %e)"))

    def call_python(self, op: ir.CallPython) -> None:
        site, signature = self._parts.sites.add(op)
        arguments = "".join(f", {self._argument(a)}" for a in op.arguments)
        call = f"@python_{signature}(ptr %e, i32 {site}{arguments})"
        if op.out is None:
            self.out.append(f"call void {call}\n")
        elif op.out.type.real:
            result = self.line(f"call double {call}")
            if op.out.type is IrType.F32:
                result = self.line(f"fptrunc double {result} to float")
            self._names[op.out.index] = result
        else:
            result, name = self.line(f"call i64 {call}"), NAMES[op.out.type]
            self._names[op.out.index] = result if name == "i64" else self.line(f"trunc i64 {result} to {name}")
        failed = self.line("load i64, ptr %e")
        self._unwind_if(self.line(f"icmp ne i64 {failed}, 0"))

    def _argument(self, value: Value) -> str:
        kind, name = value.type, self._names[value.index]
        if kind is IrType.F64:
            return f"double {name}"
        if kind is IrType.F32:
            return f"double {self.line(f'fpext float {name} to double')}"
        if kind.bits == 64:
            return f"i64 {name}"
        word = "sext" if kind.signed else "zext"
        return f"i64 {self.line(f'{word} {NAMES[kind]} {name} to i64')}"

    def fault(self, op: ir.Fault) -> None:
        code = self._names[op.code.index]
        self._unwind_if(self.line(f"call i1 @fault(ptr %e, i32 {code}, i32 {op.place})"))

    def poll(self, op: ir.Poll) -> None:
        n, s = self._next, self._split()
        self.out.append(
            f"%{n} = getelementptr i8, ptr %m, i64 {layout.ATTENTION}\n%{n + 1} = load volatile i8, ptr %{n}\n"
            f"%{n + 2} = icmp eq i8 %{n + 1}, 0\nbr i1 %{n + 2}, label %s{s}, label %r{s}, !prof !0\ns{s}:\n"
        )
        self._next = n + 3
        self.rare.append(
            f"r{s}:\n%u{s} = call i1 @poll(ptr %e, i32 {op.network})\nbr i1 %u{s}, label %unwind, label %s{s}\n"
        )

    def budget(self, op: ir.Budget) -> None:
        n, s = self._next, self._split()
        self.out.append(
            f"%{n} = getelementptr i8, ptr %m, i64 {layout.BUDGET}\n%{n + 1} = load i32, ptr %{n}, align 1\n"
            f"%{n + 2} = icmp eq i32 %{n + 1}, 0\nbr i1 %{n + 2}, label %r{s}, label %q{s}, !prof !1\nq{s}:\n"
            f"%{n + 3} = call i32 @llvm.bswap.i32(i32 %{n + 1})\n%{n + 4} = sub i32 %{n + 3}, 1\n"
            f"%{n + 5} = call i32 @llvm.bswap.i32(i32 %{n + 4})\nstore i32 %{n + 5}, ptr %{n}, align 1\n"
            f"br label %s{s}\ns{s}:\n"
        )
        self._next = n + 6
        self.rare.append(
            f"r{s}:\n%u{s} = call i1 @out_of_budget(ptr %e, i32 {op.place})\nbr i1 %u{s}, label %unwind, label %s{s}\n"
        )


def _swapped(value: Value) -> int:
    """A constant's bytes in the other order, as LLVM writes the integer they are."""
    number = value.constant
    assert number is not None
    if value.type.real:
        return int.from_bytes(struct.pack(">f", number), "little")
    size = value.type.size
    return int.from_bytes((int(number) & (1 << value.type.bits) - 1).to_bytes(size, "big"), "little")


def _double(number: float) -> str:
    return "0x" + struct.pack(">d", number).hex().upper()


_STEPS: Final[dict[type, Callable[[Writer, Any], None]]] = {
    ir.Load: Writer.load,
    ir.Store: Writer.store,
    ir.LoadBit: Writer.load_bit,
    ir.StoreBits: Writer.store_bits,
    ir.LoadFrom: Writer.load_from,
    ir.StoreTo: Writer.store_to,
    ir.CopyBytes: Writer.copy_bytes,
    ir.FillWords: Writer.fill_words,
    ir.CheckPointer: Writer.check_pointer,
    ir.Binary: Writer.binary,
    ir.Unary: Writer.unary,
    ir.Compare: Writer.compare,
    ir.Convert: Writer.convert,
    ir.Bitcast: Writer.bitcast,
    ir.Select: Writer.select,
    ir.Fits: Writer.fits,
    ir.Finite: Writer.finite,
    ir.Lookup: Writer.lookup,
    ir.GetVariable: Writer.get_variable,
    ir.SetVariables: Writer.set_variables,
    ir.PushFrame: Writer.push_frame,
    ir.PopFrame: Writer.pop_frame,
    ir.CallPou: Writer.call_pou,
    ir.CallPython: Writer.call_python,
    ir.Fault: Writer.fault,
    ir.Poll: Writer.poll,
    ir.Budget: Writer.budget,
}
