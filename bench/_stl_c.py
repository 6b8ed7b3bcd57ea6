"""A program's IR as C, for gcc: what a compiler that takes its time makes of it.

One C function for each IR function, values as local variables, blocks as labels, variables as local variables too.
Memory is read and written as our own compiler does it: big-endian, any alignment, the attention byte volatile.
"""

from __future__ import annotations

import ctypes
import math
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pcaccess.stl import ir, layout
from pcaccess.stl.ir_values import BinaryOp, IrType, Relation, UnaryOp, Value

FLAGS = ("-shared", "-fPIC", "-fwrapv", "-fno-strict-aliasing", "-fno-math-errno", "-march=native", "-w")

_HEAD = """
#include <stdint.h>
#include <string.h>
#include <math.h>
typedef int (*poll_t)(int); typedef int (*budget_t)(void); typedef int (*fault_t)(int, int);
typedef struct { int64_t failed; poll_t poll; budget_t out_of_budget; fault_t fault; } env_t;
#define GET(T, B, m, at) ({ T x; memcpy(&x, (m) + (at), sizeof x); (T)B(x); })
#define PUT(T, B, m, at, v) do { T x = B((T)(v)); memcpy((m) + (at), &x, sizeof x); } while (0)
#define SAME(x) (x)
static inline float getf(const uint8_t *p) {
  uint32_t x; float f; memcpy(&x, p, 4); x = __builtin_bswap32(x); memcpy(&f, &x, 4); return f; }
static inline void putf(uint8_t *p, float f) {
  uint32_t x; memcpy(&x, &f, 4); x = __builtin_bswap32(x); memcpy(p, &x, 4); }
static inline float asf(uint32_t x) { float f; memcpy(&f, &x, 4); return f; }
static inline uint32_t asu(float f) { uint32_t x; memcpy(&x, &f, 4); return x; }
"""

_C = {
    IrType.I1: "uint8_t",
    IrType.U8: "uint8_t",
    IrType.I8: "int8_t",
    IrType.U16: "uint16_t",
    IrType.I16: "int16_t",
    IrType.U32: "uint32_t",
    IrType.I32: "int32_t",
    IrType.U64: "uint64_t",
    IrType.I64: "int64_t",
    IrType.F32: "float",
    IrType.F64: "double",
}
_SIGNS = {
    BinaryOp.ADD: "+",
    BinaryOp.SUB: "-",
    BinaryOp.MUL: "*",
    BinaryOp.DIV: "/",
    BinaryOp.REM: "%",
    BinaryOp.AND: "&",
    BinaryOp.OR: "|",
    BinaryOp.XOR: "^",
    BinaryOp.SHL: "<<",
    BinaryOp.SHR: ">>",
}
_RELATIONS = {
    Relation.EQ: "==",
    Relation.NE: "!=",
    Relation.LT: "<",
    Relation.LE: "<=",
    Relation.GT: ">",
    Relation.GE: ">=",
}
_SWAP = {8: "SAME", 16: "__builtin_bswap16", 32: "__builtin_bswap32"}
_REAL_UNARY = {UnaryOp.NEG: "-", UnaryOp.ABS: "fabs", UnaryOp.SQRT: "sqrt", UnaryOp.FLOOR: "floor"}


class _Function:
    def __init__(self, function: ir.Function, index: int) -> None:
        self.function = function
        self.index = index
        self.out: list[str] = []

    def name(self, value: Value) -> str:
        if value.constant is None:
            return f"v{value.index}"
        if value.type.real:
            suffix = "f" if value.type is IrType.F32 else ""
            return f"{float(value.constant).hex()}{suffix}" if math.isfinite(value.constant) else "NAN"
        return f"(({_C[value.type]}){int(value.constant)}LL)"

    def text(self) -> str:
        declared = [f"{_C[v.type]} v{v.index};" for v in self.function.values if v.constant is None]
        declared += [f"{_C[v.type]} x{v.index} = {v.initial};" for v in self.function.variables]
        for block in self.function.blocks:
            self.out.append(f"b{block.index}:;")
            for op in block.operations:
                self.out.append(_EMIT[type(op)](self, op))
            self.out.append(self.end(block.terminator))
        lines = [f"int f{self.index}(uint8_t *m, env_t *e) {{", *declared, *self.out, "unwind: return 1;", "}"]
        return "\n".join(lines)

    def end(self, end: ir.Terminator | None) -> str:
        if isinstance(end, ir.Jump):
            return f"goto b{end.target.index};"
        if isinstance(end, ir.Branch):
            return f"if ({self.name(end.condition)}) goto b{end.then.index}; else goto b{end.otherwise.index};"
        assert isinstance(end, ir.Return)
        return f"return {int(end.unwind)};"

    def get(self, out: Value, at: str) -> str:
        if out.type.real:
            return f"v{out.index} = getf(m + {at});"
        return f"v{out.index} = ({_C[out.type]})GET(uint{out.type.bits}_t, {_SWAP[out.type.bits]}, m, {at});"

    def put(self, value: Value, at: str) -> str:
        if value.type.real:
            return f"putf(m + {at}, {self.name(value)});"
        return f"PUT(uint{value.type.bits}_t, {_SWAP[value.type.bits]}, m, {at}, {self.name(value)});"

    def store_bits(self, op: ir.StoreBits) -> str:
        mask = 0xFF & ~sum(1 << bit for bit, _ in op.bits)
        parts = " | ".join(f"({self.name(value)} << {bit})" for bit, value in op.bits)
        return f"m[{op.at}] = (m[{op.at}] & {mask}) | {parts};"

    def unary(self, op: ir.Unary) -> str:
        a, out = self.name(op.a), f"v{op.out.index}"
        if op.op is UnaryOp.NOT:
            return f"{out} = {a} ^ 1;" if op.a.type is IrType.I1 else f"{out} = ~{a};"
        if op.a.type.real:
            return f"{out} = {_REAL_UNARY.get(op.op, 'trunc')}{'f' if op.a.type is IrType.F32 else ''}({a});"
        return f"{out} = -{a};"

    def fits(self, op: ir.Fits) -> str:
        low, high = f"{op.type.low - 1 if op.a.type.real else op.type.low}LL", op.type.high
        if op.a.type.real:
            return f"v{op.out.index} = {self.name(op.a)} > {low}.0 && {self.name(op.a)} < {high + 1}.0;".replace(
                "LL", ""
            )
        return f"v{op.out.index} = {self.name(op.a)} >= {low} && {self.name(op.a)} <= {high}LL;"

    def bitcast(self, op: ir.Bitcast) -> str:
        if op.a.type.real == op.out.type.real:
            return f"v{op.out.index} = ({_C[op.out.type]}){self.name(op.a)};"
        return f"v{op.out.index} = {'asu' if op.a.type.real else 'asf'}({self.name(op.a)});"

    def set_variables(self, op: ir.SetVariables) -> str:
        return " ".join(f"x{variable.index} = {self.name(value)};" for variable, value in op.assignments)

    def check_pointer(self, op: ir.CheckPointer) -> str:
        return f"v{op.out.index} = check_pointer({self.name(op.pointer)}, {self.name(op.size)});"


def _simple(form: str) -> Callable[[_Function, Any], str]:
    """Operations that are one expression of their operands."""

    def emit(f: _Function, op: Any) -> str:
        names = {key: f.name(getattr(op, key)) for key in ("a", "b", "condition") if hasattr(op, key)}
        return f"v{op.out.index} = {form.format(**names)};"

    return emit


_EMIT: dict[type, Callable[[_Function, Any], str]] = {
    ir.Load: lambda f, op: f.get(op.out, str(op.at)),
    ir.Store: lambda f, op: f.put(op.value, str(op.at)),
    ir.LoadBit: lambda f, op: f"v{op.out.index} = m[{op.at}] >> {op.bit} & 1;",
    ir.StoreBits: _Function.store_bits,
    ir.LoadFrom: lambda f, op: f.get(op.out, f.name(op.address)),
    ir.StoreTo: lambda f, op: f.put(op.value, f.name(op.address)),
    ir.CheckPointer: _Function.check_pointer,
    ir.Binary: lambda f, op: f"v{op.out.index} = {f.name(op.a)} {_SIGNS[op.op]} {f.name(op.b)};",
    ir.Unary: _Function.unary,
    ir.Compare: lambda f, op: f"v{op.out.index} = {f.name(op.a)} {_RELATIONS[op.relation]} {f.name(op.b)};",
    ir.Convert: lambda f, op: f"v{op.out.index} = ({_C[op.out.type]}){f.name(op.a)};",
    ir.Bitcast: _Function.bitcast,
    ir.Select: _simple("{condition} ? {a} : {b}"),
    ir.Fits: _Function.fits,
    ir.Finite: _simple("isfinite({a})"),
    ir.GetVariable: lambda f, op: f"v{op.out.index} = x{op.variable.index};",
    ir.SetVariables: _Function.set_variables,
    ir.Fault: lambda f, op: f"if (e->fault({f.name(op.code)}, {op.place})) goto unwind;",
    ir.Poll: lambda _, op: (
        f"if (__builtin_expect(*(volatile uint8_t *)(m + {layout.ATTENTION}), 0) && e->poll({op.network})) goto unwind;"
    ),
}


def c_text(module: ir.Module) -> str:
    """Raises KeyError for operations that the benchmark's programs do not have."""
    areas = {area.code: area for area in module.pointers}
    last = max(areas)
    starts = ", ".join(str(areas[n].start if n in areas else 0) for n in range(last + 1))
    sizes = ", ".join(str(areas[n].size if n in areas else -1) for n in range(last + 1))
    check = f"""
static const int32_t starts[] = {{{starts}}}, sizes[] = {{{sizes}}};
static int32_t check_pointer(uint32_t p, int32_t size) {{
  uint32_t code = p >> 24; int32_t offset = p & 0xFFFFFF;
  return code <= {last} && offset + size <= sizes[code] ? starts[code] + offset : -1; }}
"""
    functions = [_Function(function, n).text() for n, function in enumerate(module.functions)]
    return "\n".join([_HEAD, check, *functions]) + "\n"


class CProgram:
    """A module compiled by gcc and loaded; ``seconds``: how long gcc took."""

    def __init__(self, module: ir.Module, folder: Path, name: str, level: str = "-O1") -> None:
        source, library = folder / f"{name}.c", folder / f"{name}{level}.so"
        source.write_text(c_text(module))
        start = time.perf_counter()
        subprocess.run(["gcc", level, *FLAGS, "-o", str(library), str(source), "-lm"], check=True)
        self.seconds = time.perf_counter() - start
        self._library = ctypes.CDLL(str(library))
        self.main = self._library[f"f{module.main}"]
        self.main.argtypes = (ctypes.c_void_p, ctypes.c_void_p)
        callback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int, ctypes.c_int)
        self._nothing = callback(lambda *_: 0)
        address = ctypes.cast(self._nothing, ctypes.c_void_p).value
        self._environment = (ctypes.c_int64 * 4)(0, address, address, address)
        self.environment = ctypes.addressof(self._environment)


def has_gcc() -> bool:
    try:
        subprocess.run(["gcc", "--version"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        return False
    return True
