"""Timers, counters and coils over the whole program: one number twice, a timer of the wrong kind.

Source:   System Manual, "Timers" (table of numbers; TON and TOF cannot share one), "Counters"; document 004,
          section 9.17.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from pcaccess.problems import Span
from pcaccess.s7200.address import Address, Area
from pcaccess.s7200.timers import TIMER_COUNT, is_retentive, resolution
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import Direct, Instruction, Program

TIMERS: Final = ("TON", "TOF", "TONR")
COUNTERS: Final = ("CTU", "CTD", "CTUD")
COILS: Final = ("=", "=I")


def _ranges_text(mnemonic: str) -> str:
    """``T0, T64 (1 ms); T1 to T4, T65 to T68 (10 ms); …``."""
    fitting = [n for n in range(TIMER_COUNT) if is_retentive(n) is (mnemonic == "TONR")]
    parts = []
    for milliseconds in (1, 10, 100):
        numbers = [n for n in fitting if resolution(n) == milliseconds]
        starts = [n for n in numbers if n - 1 not in numbers]
        ends = [n for n in numbers if n + 1 not in numbers]
        rows = [f"T{low}" if low == high else f"T{low} to T{high}" for low, high in zip(starts, ends, strict=True)]
        parts.append(f"{', '.join(rows)} ({milliseconds} ms)")
    return "; ".join(parts)


class _Use(NamedTuple):
    mnemonic: str
    span: Span
    where: str


def check_resources(program: Program, problems: Collector) -> None:
    timers: dict[Address, _Use] = {}
    counters: dict[Address, _Use] = {}
    coils: dict[Address, _Use] = {}
    for pou in program.pous:
        in_segment = False
        for network in pou.networks:
            problems.where = pou.where(network)
            for instruction in network.instructions:
                mnemonic = instruction.mnemonic
                if mnemonic in COILS:
                    if not in_segment:
                        _check_coil(instruction, coils, problems)
                elif mnemonic in TIMERS:
                    _check_timer(instruction, timers, problems)
                elif mnemonic in COUNTERS:
                    _check_counter(instruction, counters, problems)
                elif mnemonic == "LSCR":
                    in_segment = True  # only one segment is active at a time, so its coils do not fight
                elif mnemonic == "SCRE":
                    in_segment = False
    problems.where = ""


def _first(instruction: Instruction, area: Area | None) -> Direct | None:
    operand = instruction.operands[0] if instruction.operands else None
    if isinstance(operand, Direct) and (area is None or operand.address.area is area):
        return operand
    return None


def _check_timer(instruction: Instruction, timers: dict[Address, _Use], problems: Collector) -> None:
    operand = _first(instruction, Area.T)
    if operand is None:
        return
    mnemonic, address = instruction.mnemonic, operand.address
    if is_retentive(address.offset) is not (mnemonic == "TONR"):
        kind = "TONR" if is_retentive(address.offset) else "TON and TOF"
        message = f"{address} is a timer for {kind}, not for {mnemonic}"
        problems.add("STL073", operand.span, message, expected=_ranges_text(mnemonic))
        return
    first = timers.setdefault(address, _Use(mnemonic, operand.span, problems.where))
    if first.span is operand.span:
        return
    related = ((first.span, f"{first.mnemonic} in {first.where}"),)
    if first.mnemonic != mnemonic:
        message = f"{address} is the timer of a {first.mnemonic} already and cannot be that of a {mnemonic} too"
        problems.add("STL070", operand.span, message, expected="another timer", related=related)
    else:
        message = f"{address} is used by two {mnemonic}: both start and stop it"
        problems.add("STL071", operand.span, message, expected="one timer for each", related=related)


def _check_counter(instruction: Instruction, counters: dict[Address, _Use], problems: Collector) -> None:
    operand = _first(instruction, Area.C)
    if operand is None:
        return
    first = counters.setdefault(operand.address, _Use(instruction.mnemonic, operand.span, problems.where))
    if first.span is not operand.span:
        related = ((first.span, f"{first.mnemonic} in {first.where}"),)
        message = f"{operand.address} is used by a {first.mnemonic} and by this {instruction.mnemonic}"
        problems.add("STL071", operand.span, message, expected="one counter for each", related=related)


def _check_coil(instruction: Instruction, coils: dict[Address, _Use], problems: Collector) -> None:
    operand = _first(instruction, None)
    if operand is None or operand.address.area is Area.L:
        return  # L bits are scratch: programs made in ladder use L60.0 again and again
    address = operand.address
    first = coils.setdefault(address, _Use(instruction.mnemonic, operand.span, problems.where))
    if first.span is not operand.span:
        related = ((first.span, f"in {first.where}"),)
        message = f"{operand.symbol or address} is the coil of two outputs: the last one executed counts"
        problems.add("STL072", operand.span, message, expected="one output that joins both conditions", related=related)
