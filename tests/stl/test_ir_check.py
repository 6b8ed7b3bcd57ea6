"""The rules of the IR: what verify refuses."""

from __future__ import annotations

import pytest

from pcaccess.stl import ir
from pcaccess.stl.builder import Builder
from pcaccess.stl.ir_check import listing, verify
from pcaccess.stl.ir_values import BinaryOp, IrError, IrType


def finished(b: Builder) -> ir.Function:
    b.terminate(ir.Return())
    return b.function


def test_a_sum_stored_is_well_formed() -> None:
    b = Builder("SUM")
    b.store_at(2, b.add(b.load_at(IrType.I16, 0), 1))
    verify(finished(b))


def test_a_block_without_an_end_is_refused() -> None:
    with pytest.raises(IrError, match="has no end"):
        verify(Builder("OPEN").function)


def test_a_value_of_one_side_is_refused_behind_the_join() -> None:
    b = Builder("SIDE")
    with b.when(b.load_bit(0, 0)):
        inside = b.load_at(IrType.U8, 1)
    b.store_at(2, inside)
    with pytest.raises(IrError, match="may not be defined"):
        verify(finished(b))


def test_a_value_used_before_its_definition_is_refused() -> None:
    b = Builder("EARLY")
    late = b.new_value(IrType.U8)
    b.store_at(0, late)
    b.emit(ir.Load(late, 1))
    with pytest.raises(IrError, match="may not be defined"):
        verify(finished(b))


def test_a_value_defined_twice_is_refused() -> None:
    b = Builder("TWICE")
    out = b.load_at(IrType.U8, 1)
    b.emit(ir.Load(out, 2))
    with pytest.raises(IrError, match="defined twice"):
        verify(finished(b))


def test_operands_of_two_types_are_refused() -> None:
    b = Builder("TYPES")
    out = b.new_value(IrType.I16)
    b.emit(ir.Binary(BinaryOp.ADD, out, b.load_at(IrType.I16, 0), b.load_at(IrType.U16, 0)))
    with pytest.raises(IrError, match="types of"):
        verify(finished(b))


def test_a_shift_by_the_whole_width_is_refused() -> None:
    b = Builder("SHIFT")
    out = b.new_value(IrType.U8)
    b.emit(ir.Binary(BinaryOp.SHL, out, b.load_at(IrType.U8, 0), b.const(IrType.U8, 8)))
    with pytest.raises(IrError, match="types of"):
        verify(finished(b))


def test_constants_are_folded() -> None:
    b = Builder("FOLD")
    assert b.add(b.const(IrType.I16, 32767), 1).constant == -32768
    assert b.fits(b.const(IrType.I32, 40000), IrType.I16).constant == 0
    assert not b.block.operations


def test_minus_zero_is_a_constant_of_its_own() -> None:
    b = Builder("ZERO")
    assert b.const(IrType.F32, 0.0) is not b.const(IrType.F32, -0.0)


def test_a_listing_names_every_operation() -> None:
    b = Builder("LIST")
    b.store_bit(3, 1, b.load_bit(0, 7))
    assert listing(finished(b)).splitlines() == [
        "function LIST",
        "block0:",
        "    %0:I1 := LoadBit at=0, bit=7",
        "    StoreBits at=3, bits=((1, %0:I1),)",
        "    Return unwind=False",
    ]
