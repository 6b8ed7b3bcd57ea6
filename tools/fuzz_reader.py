"""Mutated programs against the STL reader, checker and listing: nothing a file holds may raise or take long.

``make fuzz`` runs it for a minute (SECONDS=3600 for longer); tests/stl/test_fuzz.py runs a short, fixed part.
A failing program is written to the folder given by ``--keep``, and its seed is printed.

Promises: no exception; every problem points into the file; a file without a program has an error; a program without
          errors can be lowered, and its listing reads as the same program; two seconds at most for a file of ordinary
          size.
"""

from __future__ import annotations

import argparse
import random
import re
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

from problem_pages import PAGES, read_page, registered

from pcaccess.s7200.cpu import cpu_model
from pcaccess.stl.checker import load_program
from pcaccess.stl.definitions import DEFINITIONS
from pcaccess.stl.foreign import GERMAN, LADDER, S7_300, SMART
from pcaccess.stl.listing import list_program
from pcaccess.stl.lower import lower
from pcaccess.stl.reader import read_program

ROOT: Final = Path(__file__).parent.parent
MODEL: Final = cpu_model()
SLOW: Final = 2.0
"""Seconds; generous, because the machines that run this are shared."""
MNEMONICS: Final = (*DEFINITIONS, *GERMAN, *SMART, *S7_300, *LADDER)
_NASTY_WORDS: Final = r"""
VB0 VW10239 VD99999999 I0.8 *AC0 *AC1 &VB0 & * # #x ## $ 16# 2#2 - + 1e999 -1E-999 B#B#1 W# ' " '$' "$" '$0
SBR_0 SBR99999 INT OB1 MAIN TRUE T37 C256 AIW1 DB1.DBW0 VW0[5] VW0[0] , ,, ; ;; // / //// : :OB1 = == <> ( )
NETWORK BEGIN END_VAR VAR VAR_INPUT TITLE= MEND RETI END_ORGANIZATION_BLOCK x:BOOL; //SYMBOL_TABLE //DATA_BLOCK
ß 温度 Ж ， ’ İ ﬁ ² ٣
"""
_NASTY_LINES: Final = (
    "Network 1",
    "Network 99999999999",
    "SBR 0",
    "SUBROUTINE_BLOCK a:SBR0",
    "FUNCTION_BLOCK x",
    ", ,",
)
_NASTY_CHARACTERS: Final = "\t\x0b\x0c\x1a\u2028\x85\ufeff\ud7ff\u00a0\U0001f600"
_NASTY_LENGTHS: Final = ("9" * 5000, "16#" + "F" * 500, "'" + "a" * 300 + "'")
NASTY: Final = (*_NASTY_WORDS.split(), *_NASTY_LINES, *_NASTY_CHARACTERS, *_NASTY_LENGTHS)
ENCODINGS: Final = ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252", "cp1251", "gbk", "latin-1")
_TOKEN: Final = re.compile(r"\w+|\s+|[^\w\s]")


def seeds() -> list[bytes]:
    """Good and bad programs to start from: the test data and the examples of the problem pages."""
    found = [path.read_bytes() for path in sorted((ROOT / "tests" / "data" / "stl").iterdir())]
    for code in sorted(registered()):
        if code.startswith("STL") and (PAGES / f"{code}.md").exists():
            page = read_page(code)
            found += [text.encode() for example in (page.wrong, page.right) for _, text in example.files]
    return found


def mutant(rng: random.Random, corpus: Sequence[bytes]) -> bytes:
    """One program with one to eight changes to its bytes, its words or its lines."""
    data = rng.choice(corpus)
    for _step in range(rng.choice((1, 1, 1, 2, 3, 8))):
        data = rng.choice(_CHANGES)(rng, data, corpus)
    return data[:200_000]


def _flip(rng: random.Random, data: bytes, _: Sequence[bytes]) -> bytes:
    raw = bytearray(data)
    for _step in range(rng.randint(1, 4)):
        if raw:
            raw[rng.randrange(len(raw))] = rng.randrange(256)
    return bytes(raw)


def _cut(rng: random.Random, data: bytes, _: Sequence[bytes]) -> bytes:
    start, end = sorted(rng.randint(0, len(data)) for _ in range(2))
    return rng.choice((data[:start], data[start:], data[:start] + data[end:]))


def _splice(rng: random.Random, data: bytes, corpus: Sequence[bytes]) -> bytes:
    other = rng.choice(corpus)
    return data[: rng.randint(0, len(data))] + other[rng.randint(0, len(other)) :]


def _as_text(rng: random.Random, data: bytes, change: Callable[[str], str]) -> bytes:
    encoding = rng.choice(ENCODINGS)
    text = data.decode("utf-8", errors="replace") if rng.random() < 0.8 else data.decode("gbk", errors="replace")
    return change(text).encode(encoding, errors="replace")


def _lines(rng: random.Random, data: bytes, corpus: Sequence[bytes]) -> bytes:
    def change(text: str) -> str:
        lines = text.split("\n")
        for _ in range(rng.randint(1, 5)):
            at = rng.randrange(len(lines))
            kind = rng.randrange(6)
            if kind == 0 and len(lines) > 1:
                del lines[at]
            elif kind == 1:
                lines.insert(at, lines[rng.randrange(len(lines))])
            elif kind == 2:
                lines[at] = rng.choice(NASTY)
            elif kind == 3:
                lines[at] += rng.choice((";", ",", " ", "//")) + lines[rng.randrange(len(lines))]
            elif kind == 4:
                lines[at] = lines[at] * rng.choice((2, 3, 50))
            else:
                rng.shuffle(lines)
        return rng.choice(("\n", "\r\n", "\r")).join(lines)

    return _as_text(rng, data, change)


def _words(rng: random.Random, data: bytes, corpus: Sequence[bytes]) -> bytes:
    def change(text: str) -> str:
        tokens = _TOKEN.findall(text) or [""]
        for _ in range(rng.randint(1, 8)):
            at = rng.randrange(len(tokens))
            new = (rng.choice(MNEMONICS), rng.choice(NASTY), tokens[rng.randrange(len(tokens))], "")
            tokens[at] = rng.choice(new)
            if rng.random() < 0.3:
                tokens.insert(at, rng.choice(NASTY))
        return "".join(tokens)

    return _as_text(rng, data, change)


def _repeat(rng: random.Random, data: bytes, corpus: Sequence[bytes]) -> bytes:
    start = rng.randint(0, len(data))
    piece = data[start : start + rng.randint(1, 40)]
    return data[:start] + piece * rng.choice((2, 10, 1000)) + data[start:]


_CHANGES: Final = (_flip, _cut, _splice, _lines, _lines, _words, _words, _words, _repeat)


def complaint(data: bytes, slow: float = SLOW) -> str | None:
    """What promise this file breaks; None when all are kept."""
    started = time.perf_counter()
    try:
        result = load_program(data, file="fuzz.awl")
        if result.program is not None:
            listing = list_program(result.program)
            if result.ok:
                lower(result.program, MODEL)
                again = read_program(listing.encode(), file="again.awl")
                if again.program != result.program:
                    return "the listing does not read as the same program"
    except Exception:  # the whole point: whatever it is, it is a mistake
        return traceback.format_exc()
    lines = result.text.count("\n") + 1
    for problem in result.problems:
        if not (1 <= problem.span.line <= lines and problem.span.column >= 1 and problem.span.length >= 1):
            return f"the problem points outside of the file: {problem}"
    if result.program is None and not any(problem.is_error for problem in result.problems):
        return "there is no program and nothing that says why"
    seconds = time.perf_counter() - started
    if seconds > slow:
        return f"{len(data)} bytes took {seconds:.1f} s"
    return None


def main() -> int:
    parser = argparse.ArgumentParser(description="Mutated programs against the STL reader.")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=None, help="start of the series; random unless given")
    parser.add_argument("--keep", type=Path, default=Path(tempfile.gettempdir()), help="folder for failing programs")
    options = parser.parse_args()
    seed = options.seed if options.seed is not None else random.randrange(1_000_000)
    corpus = seeds()
    end = time.perf_counter() + options.seconds
    count = failures = 0
    while time.perf_counter() < end:
        data = mutant(random.Random(seed + count), corpus)
        wrong = complaint(data)
        if wrong is not None:
            failures += 1
            path = options.keep / f"fuzz-{seed + count}.awl"
            path.write_bytes(data)
            print(f"seed {seed + count}: {path}\n{wrong}")
            if failures == 10:
                break
        count += 1
    print(f"{count} programs from seed {seed} on, {failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
