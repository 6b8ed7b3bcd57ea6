"""LLVM text that every compiled program begins with: what several operations share as small functions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

from pcaccess.plc.llvm import abi
from pcaccess.s7200.address import Area
from pcaccess.s7200.memory import AREA_START
from pcaccess.stl import layout
from pcaccess.stl.ir import PointerArea

_LETTERS: Final = {"i": "i64", "u": "i64", "d": "double", "v": "void"}

_FIXED: Final = f"""
declare i16 @llvm.bswap.i16(i16)
declare i32 @llvm.bswap.i32(i32)
declare i32 @llvm.cttz.i32(i32, i1)
declare float @llvm.fabs.f32(float)
declare double @llvm.fabs.f64(double)
declare float @llvm.sqrt.f32(float)
declare double @llvm.sqrt.f64(double)
declare float @llvm.floor.f32(float)
declare double @llvm.floor.f64(double)
declare float @llvm.trunc.f32(float)
declare double @llvm.trunc.f64(double)
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)
declare void @llvm.memmove.p0.p0.i64(ptr, ptr, i64, i1)
declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)

define internal i1 @poll(ptr %e, i32 %network) nounwind {{
  %at = getelementptr i8, ptr %e, i64 {abi.POLL}
  %f = load ptr, ptr %at
  %r = call i32 %f(i32 %network)
  %u = icmp ne i32 %r, 0
  ret i1 %u
}}

define internal i1 @out_of_budget(ptr %e, i32 %place) nounwind {{
  %at = getelementptr i8, ptr %e, i64 {abi.OUT_OF_BUDGET}
  %f = load ptr, ptr %at
  %r = call i32 %f(i32 %place)
  %u = icmp ne i32 %r, 0
  ret i1 %u
}}

define internal i1 @fault(ptr %e, i32 %code, i32 %place) nounwind {{
  %at = getelementptr i8, ptr %e, i64 {abi.FAULT}
  %f = load ptr, ptr %at
  %r = call i32 %f(i32 %code, i32 %place)
  %u = icmp ne i32 %r, 0
  ret i1 %u
}}

define internal ptr @frame(ptr %m, i8 %depth) nounwind {{
  %high = icmp ugt i8 %depth, {layout.MAX_FRAMES - 1}
  %safe = select i1 %high, i8 {layout.MAX_FRAMES - 1}, i8 %depth
  %n = zext i8 %safe to i64
  %size = mul i64 %n, {layout.FRAME_SIZE}
  %start = add i64 %size, {layout.FRAMES}
  %at = getelementptr i8, ptr %m, i64 %start
  ret ptr %at
}}

define internal void @push_frame(ptr %m) nounwind {{
  %d = getelementptr i8, ptr %m, i64 {layout.CALL_DEPTH}
  %depth = load i8, ptr %d
  %frame = call ptr @frame(ptr %m, i8 %depth)
  %l = getelementptr i8, ptr %m, i64 {AREA_START[Area.L]}
  call void @llvm.memcpy.p0.p0.i64(ptr %frame, ptr %l, i64 {layout.FRAME_SIZE}, i1 false)
  call void @llvm.memset.p0.i64(ptr %l, i8 0, i64 {layout.FRAME_SIZE}, i1 false)
  %deeper = add i8 %depth, 1
  store i8 %deeper, ptr %d
  ret void
}}

define internal void @pop_frame(ptr %m) nounwind {{
  %d = getelementptr i8, ptr %m, i64 {layout.CALL_DEPTH}
  %depth = load i8, ptr %d
  %outer = sub i8 %depth, 1
  %frame = call ptr @frame(ptr %m, i8 %outer)
  %l = getelementptr i8, ptr %m, i64 {AREA_START[Area.L]}
  call void @llvm.memcpy.p0.p0.i64(ptr %l, ptr %frame, i64 {layout.FRAME_SIZE}, i1 false)
  store i8 %outer, ptr %d
  ret void
}}

define internal void @fill_words(ptr %at, i16 %word, i32 %count) nounwind {{
entry:
  %some = icmp sgt i32 %count, 0
  br i1 %some, label %body, label %done
body:
  %n = phi i32 [ 0, %entry ], [ %next, %body ]
  %p = getelementptr i16, ptr %at, i32 %n
  store i16 %word, ptr %p, align 1
  %next = add i32 %n, 1
  %more = icmp slt i32 %next, %count
  br i1 %more, label %body, label %done
done:
  ret void
}}
"""


def prelude(pointers: Iterable[PointerArea], sites: abi.Sites) -> str:
    """Declarations and shared functions for a module."""
    calls = "".join(_signature(signature, sites.offset(signature)) for signature in sites.signatures)
    return _FIXED + _check_pointer(pointers) + calls


def _check_pointer(pointers: Iterable[PointerArea]) -> str:
    """``ir.CheckPointer``: an area code that names nothing has the size -1."""
    by_code = {area.code: area for area in pointers}
    codes = range(max(by_code, default=0) + 1)
    starts = [by_code[code].start if code in by_code else 0 for code in codes]
    sizes = [by_code[code].size if code in by_code else -1 for code in codes]
    return f"""
@area_start = internal constant {_array(starts)}
@area_size = internal constant {_array(sizes)}

define internal i32 @check_pointer(i32 %pointer, i32 %size) alwaysinline nounwind {{
  %code = lshr i32 %pointer, 24
  %known = icmp ult i32 %code, {len(codes)}
  br i1 %known, label %look, label %bad
look:
  %n = zext i32 %code to i64
  %limits = getelementptr i32, ptr @area_size, i64 %n
  %limit = load i32, ptr %limits
  %offset = and i32 %pointer, {0xFF_FFFF}
  %end = add i32 %offset, %size
  %good = icmp sle i32 %end, %limit
  br i1 %good, label %inside, label %bad
inside:
  %starts = getelementptr i32, ptr @area_start, i64 %n
  %start = load i32, ptr %starts
  %flat = add i32 %start, %offset
  ret i32 %flat
bad:
  ret i32 -1
}}
"""


def _array(numbers: Sequence[int]) -> str:
    return f"[{len(numbers)} x i32] [{', '.join(f'i32 {n}' for n in numbers)}]"


def _signature(signature: str, offset: int) -> str:
    result, arguments = _LETTERS[signature[0]], [_LETTERS[letter] for letter in signature[1:]]
    parameters = "".join(f", {kind} %a{n}" for n, kind in enumerate(arguments))
    answer, give = ("", "ret void") if result == "void" else ("%r = ", f"ret {result} %r")
    return f"""
define internal {result} @python_{signature}(ptr %e, i32 %site{parameters}) nounwind {{
  %at = getelementptr i8, ptr %e, i64 {offset}
  %f = load ptr, ptr %at
  {answer}call {result} %f(i32 %site{parameters})
  {give}
}}
"""
