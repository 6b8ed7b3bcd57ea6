"""Lines that divide a program: block headers, network headers, marks in comments.

Units:    columns count characters from 1.
Errors:   nothing raises; a line of another kind gives None.
Source:   Micro/WIN export format (docs/stl.md); document 004, section 9.26, for ``SBR n`` and ``INT n``.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from types import MappingProxyType
from typing import Final, NamedTuple

from pcaccess.stl.lexer import first_word
from pcaccess.stl.program import PouKind, Section

KEYWORDS: Final = MappingProxyType(
    {"ORGANIZATION_BLOCK": PouKind.MAIN, "SUBROUTINE_BLOCK": PouKind.SBR, "INTERRUPT_BLOCK": PouKind.INT}
)
SECTIONS: Final = MappingProxyType(
    {"VAR_INPUT": Section.IN, "VAR_IN_OUT": Section.IN_OUT, "VAR_OUTPUT": Section.OUT, "VAR": Section.TEMP}
)
OLD_ENDS: Final = MappingProxyType({"MEND": PouKind.MAIN, "RET": PouKind.SBR, "RETI": PouKind.INT})
"""What ends a block in programs without block headers."""

_HEADER: Final = re.compile(
    r"\s*(?P<keyword>[^\W\d]\w*)\s+(?P<name>.*\S)?\s*:\s*(?P<kind>OB|SBR|INT)[ _]?(?P<number>\d{1,4})\s*;?\s*",
    re.IGNORECASE,
)
_NETWORK: Final = re.compile(r"\s*NETWORK(?![A-Z_])\s*(?P<number>\d{0,9})\s*(?P<rest>.*)", re.IGNORECASE)
_OLD_START: Final = re.compile(r"\s*(?P<kind>SBR|INT)[ _]*(?P<number>\d{1,4})\s*[:;]?\s*(?://.*)?", re.IGNORECASE)
_COMMENT_START: Final = re.compile(
    r"""\s*//\W*(?:
        (?P<main>MAIN|OB1)
      | (?P<sbr>SBR|SUBROUTINE)[ _]?(?P<s>\d{1,3})
      | (?:INT|INTERRUPT(?:[ ]ROUTINE)?)[ _]?(?P<i>\d{1,3})
    )(?P<rest>\W.*)?""",
    re.IGNORECASE | re.VERBOSE,
)
_DIRECTIVE: Final = re.compile(
    r"\s*//(?P<end>END_)?(?P<name>SYMBOL_TABLE|DATA_BLOCK|CROSS_REFERENCE)\s*", re.IGNORECASE
)


def keyword_of(kind: PouKind) -> str:
    return next(keyword for keyword, of in KEYWORDS.items() if of is kind)


def header_text(kind: PouKind, number: int, name: str) -> str:
    """``SUBROUTINE_BLOCK Pump:SBR0``."""
    return f"{keyword_of(kind)} {name}:{kind.value}{number}"


_BLOCK_NAME: Final = re.compile(r"(SBR|INT)[ _]?(\d{1,4})", re.IGNORECASE | re.ASCII)


def parse_block_name(text: str) -> tuple[PouKind, int] | None:
    """``SBR_0``, ``SBR0`` and ``INT 3``: blocks by number, as CALL and ATCH name them."""
    match = _BLOCK_NAME.fullmatch(text)
    return (PouKind(match[1].upper()), int(match[2])) if match else None


class Header(NamedTuple):
    """A block header as far as it can be understood."""

    kind: PouKind
    number: int | None
    """None where the line does not say it."""
    name: str
    right: str | None
    """How it should have been written; empty when that cannot be told; None when it is right."""


def is_header(line: str) -> bool:
    """The line looks like a block header, well written or not."""
    word = first_word(line).upper()
    if word.endswith("_BLOCK"):
        return not word.startswith("END_")
    return ":" in line and _HEADER.fullmatch(line) is not None


def parse_header(code: str, keyword: str) -> Header:
    """``keyword`` is the first word of ``code`` in capitals.

    The block is known by what follows the colon; the keyword may be one of another language, but not a wrong one.
    """
    match = _HEADER.fullmatch(code)
    meant = KEYWORDS.get(keyword)
    if match is None:
        return Header(meant or PouKind.SBR, None, " ".join(code.split()[1:]), "")
    kind, number = PouKind(match["kind"].upper()), int(match["number"])
    name = match["name"] or f"{kind.value}{number}"
    right = None
    if (meant is None and keyword.endswith("_BLOCK")) or (meant is not None and meant is not kind):
        right = header_text(kind, number, name)
    if kind is PouKind.MAIN and number != 1:
        number = 1
        right = header_text(kind, number, name)
    return Header(kind, number, name, right)


def find_headers(lines: Sequence[str]) -> tuple[int, frozenset[int]]:
    """How many block headers there are, and the line numbers of those with a BEGIN before their first network."""
    count = 0
    heads = []
    header = 0
    for number, line in enumerate(lines, 1):
        word = first_word(line).upper()
        if is_header(line):
            count += 1
            header = number
        elif word == "BEGIN" and header:
            heads.append(header)
            header = 0
        elif word.startswith("NETWORK") or word.endswith("_BLOCK"):
            header = 0
    return count, frozenset(heads)


class NetworkHeader(NamedTuple):
    number: int | None
    column: int
    """Of the keyword."""
    length: int
    """Of keyword and number."""
    rest: str
    rest_column: int


def parse_network(line: str) -> NetworkHeader | None:
    match = _NETWORK.fullmatch(line)
    if match is None:
        return None
    written = line[: match.start("rest")]
    number = int(match["number"]) if match["number"] else None
    indent = len(line) - len(line.lstrip())
    return NetworkHeader(number, indent + 1, len(written.strip()), match["rest"].rstrip(), match.start("rest") + 1)


class OldStart(NamedTuple):
    kind: PouKind
    number: int
    column: int
    length: int


def parse_old_start(line: str) -> OldStart | None:
    """``SBR 0`` and ``INT 0`` as statements, which began a block before there were headers."""
    match = _OLD_START.fullmatch(line)
    if match is None:
        return None
    start = match.start("kind")
    return OldStart(PouKind(match["kind"].upper()), int(match["number"]), start + 1, match.end("number") - start)


def parse_comment_start(
    line: str, following: Sequence[str], awaited: Collection[tuple[PouKind, int]]
) -> tuple[PouKind, int] | None:
    """``// SBR 0`` as a book prints it above a block.

    It must stand alone on its line, or before a ``NETWORK 1``, or name one of the ``awaited`` blocks (called before,
    not found yet) right before a load: a comment that merely mentions a subroutine is no header.
    """
    match = _COMMENT_START.fullmatch(line)
    if match is None:
        return None
    if match["main"]:
        block = (PouKind.MAIN, 1)
    else:
        block = (PouKind.SBR, int(match["s"])) if match["sbr"] else (PouKind.INT, int(match["i"]))
    if not (match["rest"] or "").strip():
        return block
    code = next((text for text in following if text.strip() and not text.lstrip().startswith("//")), "")
    network = parse_network(code)
    if network is not None:
        return block if network.number in (None, 1) else None
    return block if block in awaited and first_word(code).upper().startswith("LD") else None


def parse_directive(line: str) -> tuple[str, bool] | None:
    """``//SYMBOL_TABLE`` and the like: its name in capitals, and whether it ends that part."""
    match = _DIRECTIVE.fullmatch(line)
    return (match["name"].upper(), match["end"] is not None) if match else None
