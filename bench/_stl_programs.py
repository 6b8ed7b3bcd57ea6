"""The same programs in two languages: STL for us, AWL (S7-300, German mnemonics) for awlsim.

A program is a row of networks drawn from templates with a fixed seed, until it has as many STL instructions as wanted.
A template does the same work in both languages; AWL often needs more instructions for it (``+I`` there works on
accumulators), so figures count each language's own.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass

BITS = 64
"""Bits I0.0 to I7.7 change every scan."""
Network = tuple[list[str], list[str]]
"""STL, AWL."""


@dataclass(frozen=True)
class Text:
    """A program with its number of instructions."""

    stl: str
    stl_count: int
    awl: str
    awl_count: int


class _Draw:
    """Operands; V memory of the S7-200 is flag memory of the S7-300."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.labels = 0

    def one_of(self, *choices: str) -> str:
        return self.random.choice(choices)

    def bit(self, areas: str = "IIQM") -> tuple[str, str]:
        area, byte, bit = self.random.choice(areas), self.random.randrange(8), self.random.randrange(8)
        german = {"I": "E", "Q": "A", "M": "M"}[area]
        return f"{area}{byte}.{bit}", f"{german} {byte}.{bit}"

    def word(self) -> tuple[str, str]:
        at = 2 * self.random.randrange(200)
        return f"VW{at}", f"MW {100 + at}"

    def double(self) -> tuple[str, str]:
        at = 400 + 4 * self.random.randrange(100)
        return f"VD{at}", f"MD {100 + at}"

    def real(self) -> tuple[str, str]:
        at = 800 + 4 * self.random.randrange(100)
        return f"VD{at}", f"MD {100 + at}"

    def label(self) -> str:
        self.labels += 1
        return f"L{self.labels:03X}"


# bit logic


def _chain(d: _Draw) -> Network:
    (a, ea), (b, eb), (c, ec), (q, eq) = d.bit(), d.bit(), d.bit(), d.bit("QM")
    return [f"LD {a}", f"A {b}", f"AN {c}", f"= {q}"], [f"U {ea}", f"U {eb}", f"UN {ec}", f"= {eq}"]


def _blocks(d: _Draw) -> Network:
    (a, ea), (b, eb), (c, ec), (e, ee), (q, eq) = d.bit(), d.bit(), d.bit(), d.bit(), d.bit("QM")
    stl = [f"LD {a}", f"O {b}", f"LD {c}", f"ON {e}", "ALD", f"= {q}"]
    return stl, ["U(", f"O {ea}", f"O {eb}", ")", "U(", f"O {ec}", f"ON {ee}", ")", f"= {eq}"]


def _branches(d: _Draw) -> Network:
    (a, ea), (b, eb), (c, ec) = d.bit(), d.bit(), d.bit()
    (p, ep), (q, eq), (r, er) = d.bit("QM"), d.bit("QM"), d.bit("QM")
    stl = [f"LD {a}", "LPS", f"A {b}", f"= {p}", "LRD", f"AN {c}", f"= {q}", "LPP", f"A {c}", f"= {r}"]
    top = "L 0.0"
    awl = [f"U {ea}", f"= {top}", f"U {top}", f"U {eb}", f"= {ep}", f"U {top}", f"UN {ec}", f"= {eq}"]
    return stl, [*awl, f"U {top}", f"U {ec}", f"= {er}"]


def _latch(d: _Draw) -> Network:
    (a, ea), (b, eb), (m, em) = d.bit("I"), d.bit(), d.bit("M")
    coil = d.one_of("S", "R")
    return [f"LDN {a}", f"A {b}", f"{coil} {m}, 1"], [f"UN {ea}", f"U {eb}", f"{coil} {em}"]


# integers


def _sums(d: _Draw) -> Network:
    (a, ea), (b, eb), (c, ec), (e, ee), (f, ef) = (d.word() for _ in range(5))
    n = d.random.randrange(50)
    stl = ["LD SM0.0", f"MOVW {a}, {b}", f"+I {c}, {e}", f"-I {n}, {f}"]
    return stl, [f"L {ea}", f"T {eb}", f"L {ee}", f"L {ec}", "+I", f"T {ee}", f"L {ef}", f"L {n}", "-I", f"T {ef}"]


def _products(d: _Draw) -> Network:
    (i, ei), (a, ea), (b, eb), (c, ec) = d.bit("I"), d.word(), d.word(), d.word()
    m, n, k, label = d.random.randrange(1, 5), d.random.randrange(1, 50), d.random.randrange(3000), d.label()
    stl = [f"LD {i}", f"*I {m}, {a}", f"/I {n}, {b}", f"MOVW {k}, {c}"]
    awl = [f"U {ei}", f"SPBN {label}", f"L {ea}", f"L {m}", "*I", f"T {ea}", f"L {eb}", f"L {n}", "/I", f"T {eb}"]
    return stl, [*awl, f"L {k}", f"T {ec}", f"{label}: NOP 0"]


def _compare(d: _Draw) -> Network:
    (a, ea), (b, eb), (c, ec), (e, ee), (f, ef) = (d.word() for _ in range(5))
    (g, eg), (h, eh) = d.double(), d.double()
    label = d.label()
    stl = [f"LDW>= {a}, {b}", f"+D {g}, {h}", f"INCW {c}", f"ANDW {e}, {f}"]
    awl = [f"L {ea}", f"L {eb}", ">=I", f"SPBN {label}", f"L {eh}", f"L {eg}", "+D", f"T {eh}", f"L {ec}", "+ 1"]
    return stl, [*awl, f"T {ec}", f"L {ef}", f"L {ee}", "UW", f"T {ef}", f"{label}: NOP 0"]


def _shift(d: _Draw) -> Network:
    (a, ea), (b, eb), (c, ec), (g, eg) = d.word(), d.word(), d.word(), d.double()
    stl = ["LD SM0.0", f"ITD {a}, {g}", f"SLW {b}, 2", f"MOVW {a}, {c}"]
    return stl, [f"L {ea}", "ITD", f"T {eg}", f"L {eb}", "SLW 2", f"T {eb}", f"L {ea}", f"T {ec}"]


# reals


def _real_sums(d: _Draw) -> Network:
    (a, ea), (b, eb), (c, ec), (e, ee) = d.real(), d.real(), d.real(), d.real()
    x, y = f"{d.random.uniform(-9, 9):.3f}", f"{d.random.uniform(0.5, 1.5):.3f}"
    stl = ["LD SM0.0", f"MOVR {x}, {a}", f"+R {b}, {c}", f"*R {y}, {e}"]
    return stl, [f"L {x}", f"T {ea}", f"L {ec}", f"L {eb}", "+R", f"T {ec}", f"L {ee}", f"L {y}", "*R", f"T {ee}"]


def _real_compare(d: _Draw) -> Network:
    (a, ea), (b, eb), (c, ec), (e, ee), (f, ef) = (d.real() for _ in range(5))
    y, label = f"{d.random.uniform(1, 2):.3f}", d.label()
    stl = [f"LDR> {a}, {b}", f"-R {c}, {e}", f"/R {y}, {f}"]
    awl = [f"L {ea}", f"L {eb}", ">R", f"SPBN {label}", f"L {ee}", f"L {ec}", "-R", f"T {ee}"]
    return stl, [*awl, f"L {ef}", f"L {y}", "/R", f"T {ef}", f"{label}: NOP 0"]


def _real_root(d: _Draw) -> Network:
    (a, ea), (b, eb), (c, ec), (g, eg) = d.real(), d.real(), d.real(), d.double()
    stl = ["LD SM0.0", f"SQRT {a}, {b}", f"MOVR {b}, {c}", f"DTR {g}, {a}"]
    return stl, [f"L {ea}", "SQRT", f"T {eb}", f"L {eb}", f"T {ec}", f"L {eg}", "DTR", f"T {ea}"]


# timers, counters, pointers


def _timer(d: _Draw) -> Network:
    (i, ei), number = d.bit("I"), d.random.randrange(60)
    return [f"LD {i}", f"TON T{101 + number}, 20"], [f"U {ei}", "L S5T#2S", f"SE T {number}"]


def _counter(d: _Draw) -> Network:
    (i, ei), (r, er), number = d.bit("I"), d.bit("I"), d.random.randrange(60)
    return [f"LD {i}", f"LD {r}", f"CTU C{number}, 100"], [f"U {ei}", f"ZV Z {number}", f"U {er}", f"R Z {number}"]


def _pointer(d: _Draw) -> Network:
    (a, ea), at = d.word(), 2 * d.random.randrange(100)
    stl = ["LD SM0.0", f"MOVD &VB{at}, AC1", "+D 4, AC1", f"MOVW *AC1, {a}"]
    return stl, [f"L P#{100 + at}.0", "LAR1", "L MW [AR1, P#4.0]", f"T {ea}"]


_BOOLEAN = [_chain, _blocks, _branches, _latch]
_INTEGER = [_sums, _products, _compare, _shift]
_REAL = [_real_sums, _real_compare, _real_root]
_OTHER = [_timer, _counter, _pointer]
KINDS: dict[str, list[Callable[[_Draw], Network]]] = {
    "boolean": _BOOLEAN,
    "mixed": [*_BOOLEAN * 6, *_INTEGER * 3, *_REAL, *_OTHER * 2],
    "integer": _INTEGER,
    "real": _REAL,
}


def networks(kind: str, size: int, seed: int = 1) -> Iterator[Network]:
    """Templates of ``kind`` until there are ``size`` STL instructions."""
    draw, count = _Draw(seed), 0
    while count < size:
        network = draw.random.choice(KINDS[kind])(draw)
        count += len(network[0])
        yield network


def program(kind: str, size: int) -> Text:
    stl, awl = ["ORGANIZATION_BLOCK MAIN:OB1", "TITLE=", "BEGIN"], ["ORGANIZATION_BLOCK OB 1", "BEGIN"]
    stl_count = awl_count = 0
    for number, (ours, theirs) in enumerate(networks(kind, size), 1):
        stl += [f"NETWORK {number}", *ours]
        awl += [f"{line};" for line in theirs]
        stl_count += len(ours)
        awl_count += len(theirs)
    stl.append("END_ORGANIZATION_BLOCK")
    awl.append("END_ORGANIZATION_BLOCK")
    return Text("\n".join(stl) + "\n", stl_count, "\n".join(awl) + "\n", awl_count)


def inputs(count: int = 64) -> list[bytes]:
    """What the first eight input bytes are in turn."""
    source = random.Random(7)
    return [source.randbytes(BITS // 8) for _ in range(count)]


def first_memory() -> list[tuple[int, bytes]]:
    """(offset in V memory, bytes) at the beginning: words, double words, sensible reals."""
    import struct

    source = random.Random(2)
    reals = b"".join(struct.pack(">f", source.uniform(-50, 50)) for _ in range(100))
    return [(0, source.randbytes(800)), (800, reals)]
