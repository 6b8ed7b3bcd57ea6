"""Checks IR against its own rules, and prints it. For tests and for whoever writes a back end.

Errors:   ``verify`` raises ``IrError`` with the function, the block and the operation.
"""

from __future__ import annotations

from pcaccess.stl import ir
from pcaccess.stl.ir import Function
from pcaccess.stl.ir_values import BinaryOp, IrError, IrType, Value


def verify(function: Function) -> None:
    """Every block ends; values are defined once, before use on every way, and have the types they must have."""
    defined = _definitions(function)
    dominators = _dominators(function)
    for block in function.blocks:
        if block.terminator is None:
            raise IrError(f"{function.name}: {block} has no end")
        before: set[int] = set()
        for op in [*block.operations, block.terminator]:
            for value in ir.uses(op):
                _check_use(function, block, value, before, defined, dominators)
            if not isinstance(op, ir.Jump | ir.Branch | ir.Return):
                _check_types(function, block, op)
                out = ir.result(op)
                if out is not None:
                    before.add(out.index)


def _definitions(function: Function) -> dict[int, int]:
    defined: dict[int, int] = {}
    for block in function.blocks:
        for op in block.operations:
            out = ir.result(op)
            if out is None:
                continue
            if out.index in defined or out.constant is not None:
                raise IrError(f"{function.name}: {block}: {out} is defined twice")
            defined[out.index] = block.index
    return defined


def _dominators(function: Function) -> list[set[int] | None]:
    """For each block the blocks that every way to it passes; None for a block that no way reaches."""
    entries: list[set[int]] = [set() for _ in function.blocks]
    for block in function.blocks:
        for successor in block.successors():
            entries[successor.index].add(block.index)
    found: list[set[int] | None] = [None] * len(function.blocks)
    found[0] = {0}
    changed = True
    while changed:
        changed = False
        for block in function.blocks[1:]:
            ways = [way for n in entries[block.index] if (way := found[n]) is not None]
            if ways:
                now = set.intersection(*ways) | {block.index}
                if now != found[block.index]:
                    found[block.index] = now
                    changed = True
    return found


def _check_use(
    function: Function,
    block: ir.Block,
    value: Value,
    before: set[int],
    defined: dict[int, int],
    dominators: list[set[int] | None],
) -> None:
    if value.constant is not None or value.index in before:
        return
    where = defined.get(value.index)
    passed = dominators[block.index]
    if where is None or where == block.index or (passed is not None and where not in passed):
        raise IrError(f"{function.name}: {block}: {value} is used where it may not be defined")


def _check_types(function: Function, block: ir.Block, op: ir.Operation) -> None:
    if not _well_typed(op):
        raise IrError(f"{function.name}: {block}: types of {op}")


def _well_typed(op: ir.Operation) -> bool:
    match op:
        case ir.Binary():
            if op.op in (BinaryOp.SHL, BinaryOp.SHR) and not _shift_fits(op):
                return False
            return op.a.type is op.b.type is op.out.type and (not op.out.type.real or op.op in _REAL)
        case ir.Compare():
            return op.a.type is op.b.type and op.out.type is IrType.I1
        case ir.Unary():
            return op.a.type is op.out.type
        case ir.Select():
            return op.condition.type is IrType.I1 and op.a.type is op.b.type is op.out.type
        case ir.StoreBits():
            numbers = [n for n, _ in op.bits]
            return len(set(numbers)) == len(numbers) and all(v.type is IrType.I1 for _, v in op.bits)
        case ir.SetVariables():
            return all(variable.type is value.type for variable, value in op.assignments)
        case ir.GetVariable():
            return op.variable.type is op.out.type
        case ir.Fits():
            return op.out.type is IrType.I1 and not op.type.real
        case ir.Finite():
            return op.out.type is IrType.I1 and op.a.type.real
        case ir.Bitcast():
            return op.a.type.bits == op.out.type.bits
        case ir.Load() | ir.LoadFrom():
            return op.out.type not in _REGISTER_ONLY
        case ir.Store() | ir.StoreTo():
            return op.value.type not in _REGISTER_ONLY
        case ir.CheckPointer():
            return (op.pointer.type, op.size.type, op.out.type) == (IrType.U32, IrType.I32, IrType.I32)
        case _:
            return True


_REAL = (BinaryOp.ADD, BinaryOp.SUB, BinaryOp.MUL, BinaryOp.DIV)
_REGISTER_ONLY = (IrType.I1, IrType.I64, IrType.U64, IrType.F64)


def _shift_fits(op: ir.Binary) -> bool:
    return op.b.constant is None or 0 <= op.b.constant < op.a.type.bits


def listing(function: Function) -> str:
    """The function as text, one operation in a line."""
    lines = [f"function {function.name}"]
    for block in function.blocks:
        lines.append(f"{block}:")
        lines += [f"    {_text(op)}" for op in block.operations]
        lines.append(f"    {_text(block.terminator)}")
    return "\n".join(lines)


def _text(op: ir.Operation | ir.Terminator | None) -> str:
    if op is None:
        return "(no end)"
    fields = [(name, getattr(op, name)) for name in op.__slots__]
    shown = ", ".join(f"{name}={_short(value)}" for name, value in fields if name != "out")
    out = getattr(op, "out", None)
    return f"{f'{out} := ' if out is not None else ''}{type(op).__name__} {shown}".rstrip()


def _short(value: object) -> str:
    return getattr(value, "value", None) or getattr(value, "__name__", None) or repr(value)
