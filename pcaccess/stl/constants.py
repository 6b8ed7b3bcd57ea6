"""Constants of STL and the data block: numbers in every notation, ASCII and STRING texts with their escapes.

Source:   Micro/WIN editor grammar: ``16#1F 2#10_10 +100 1.0E-3 'AB' "text" TRUE ON B#16#0F``, escapes
          ``$$ $' $" $L $N $P $R $T $hh`` in both kinds of quotes.
Errors:   :class:`ConstantError` with what was expected; None from :func:`parse_number` when it is no number.
Not here: whether the number fits an operand (the checker does that).
"""

from __future__ import annotations

import re
from typing import Final, NamedTuple

from pcaccess.s7200.address import Width
from pcaccess.s7200.types import MAX_STRING, STRING_ENCODING
from pcaccess.stl.program import Constant, ConstantForm


class ConstantError(ValueError):
    """The text starts like a constant but is none."""


class Number(NamedTuple):
    value: int | float
    form: ConstantForm
    width: Width | None = None


_NUMBER: Final = re.compile(
    r"""(?P<decimal>[+-]?\d+)
      | (?P<real>[+-]?(?:\d+\.\d*|\.\d+)(?:E[+-]?\d+)?|[+-]?\d+E[+-]?\d+)
      | (?P<base>16|2|8|10)\#(?P<digits>[0-9A-F_]+)
      | (?P<descriptor>BYTE|WORD|DWORD|B|W|DW)\#(?P<rest>.+)""",
    re.VERBOSE | re.IGNORECASE | re.ASCII,
)
_DESCRIPTORS: Final = {
    "B": Width.BYTE,
    "BYTE": Width.BYTE,
    "W": Width.WORD,
    "WORD": Width.WORD,
    "DW": Width.DWORD,
    "DWORD": Width.DWORD,
}
_BOOLS: Final = {"TRUE": 1, "ON": 1, "FALSE": 0, "OFF": 0}
MAX_DIGITS: Final = 64
"""A number with more digits than this fits nothing; it is refused before it is computed."""


def parse_number(text: str) -> Number | None:
    """A number in any notation, or TRUE FALSE ON OFF; None when ``text`` is something else."""
    match = _NUMBER.fullmatch(text)
    if match is None:
        truth = _BOOLS.get(text.upper())
        return None if truth is None else Number(truth, ConstantForm.BOOL)
    if len(text) > MAX_DIGITS:
        raise ConstantError(f"a number of {len(text)} characters fits nothing; the largest is 4294967295")
    if match["decimal"]:
        return Number(int(text), ConstantForm.DECIMAL)
    if match["real"]:
        value = float(text)
        if value in (float("inf"), float("-inf")):
            raise ConstantError(f"{text} does not fit a REAL, which goes up to 3.402823E38")
        return Number(value, ConstantForm.REAL)
    if match["base"]:
        return _based(match["base"], match["digits"])
    inner = parse_number(match["rest"])
    if inner is None or inner.width is not None or not isinstance(inner.value, int):
        raise ConstantError(
            f"{match['descriptor']}# stands before a whole number, for example {match['descriptor']}#16#1F"
        )
    return inner._replace(width=_DESCRIPTORS[match["descriptor"].upper()])


def _based(base: str, written: str) -> Number:
    digits = written.replace("_", "")
    if base in ("8", "10"):
        raise ConstantError(f"{base}# is not a notation of the S7-200; write a decimal number, 16#… or 2#…")
    try:
        value = int(digits, int(base))
    except ValueError:
        raise ConstantError(f"{base}# takes the digits {'0 and 1' if base == '2' else '0 to 9 and A to F'}") from None
    return Number(value, ConstantForm.HEX if base == "16" else ConstantForm.BINARY)


_ESCAPE: Final = re.compile(r"\$([0-9A-F]{2}|.|$)", re.IGNORECASE)
_ESCAPED: Final = {
    "$": b"$",
    "'": b"'",
    '"': b'"',
    "L": b"\n",
    "N": b"\r\n",
    "P": b"\f",
    "R": b"\r",
    "T": b"\t",
}
_ESCAPES_OF: Final = {0x24: "$$", 0x27: "$'", 0x22: '$"', 0x0A: "$L", 0x0C: "$P", 0x0D: "$R", 0x09: "$T"}


def parse_text(written: str, encoding: str) -> bytes:
    """The bytes of a quoted text, quotes included in ``written``. Raises ConstantError.

    Characters beyond ASCII become bytes of the file's own code page, as they do on the PC that Micro/WIN runs on.
    """
    quote = written[0]
    if len(written) < 2 or written[-1] != quote or _open(written):
        raise ConstantError(f"the closing {quote} is missing")
    raw = bytearray()
    at = 1
    for match in _ESCAPE.finditer(written, 1, len(written) - 1):
        raw += plc_bytes(written[at : match.start()], encoding)
        code = match[1].upper()
        if len(code) == 2:
            raw.append(int(code, 16))
        elif code in _ESCAPED:
            raw += _ESCAPED[code]
        else:
            raise ConstantError(f"{match[0]!r} is no escape; $$ $' $\" $L $N $P $R $T and $hh (two hex digits) are")
        at = match.end()
    raw += plc_bytes(written[at:-1], encoding)
    return bytes(raw)


def _open(written: str) -> bool:
    """The last quote is escaped: an odd number of ``$`` stands before it."""
    body = written[:-1]
    return (len(body) - len(body.rstrip("$"))) % 2 == 1


def plc_bytes(text: str, encoding: str) -> bytes:
    """``text`` as a PLC holds it: one or more bytes of an ANSI code page per character."""
    if text.isascii():
        return text.encode("ascii")
    pages = (encoding,) if encoding not in ("ascii", "utf-8") and not encoding.startswith("utf-16") else ()
    for page in (*pages, "cp1252", "cp1251", "gbk"):
        try:
            return text.encode(page)
        except (UnicodeEncodeError, LookupError):
            continue
    raise ConstantError(f"a PLC text has characters of one code page; {text!r} has not")


def spell_text(raw: bytes, quote: str) -> str:
    """The quoted text that :func:`parse_text` reads as ``raw``, whatever the encoding: escapes beyond ASCII."""
    parts = []
    for byte in raw:
        if byte in _ESCAPES_OF and not (byte in (0x22, 0x27) and byte != ord(quote)):
            parts.append(_ESCAPES_OF[byte])
        else:
            parts.append(chr(byte) if 0x20 <= byte < 0x7F else f"${byte:02X}")
    return f"{quote}{''.join(parts)}{quote}"


_ASCII_WIDTHS: Final = {1: Width.BYTE, 2: Width.WORD, 4: Width.DWORD}


def ascii_value(raw: bytes) -> tuple[int, Width]:
    """``'AB'`` as a number and its width. Raises ConstantError unless there are 1, 2 or 4 bytes."""
    width = _ASCII_WIDTHS.get(len(raw))
    if width is None:
        raise ConstantError(f"'…' holds 1, 2 or 4 characters (a byte, word or double word), not {len(raw)}")
    return int.from_bytes(raw, "big"), width


def string_value(raw: bytes) -> str:
    """``"text"`` as a value: one character per byte. Raises ConstantError when it is too long."""
    if len(raw) > MAX_STRING:
        raise ConstantError(f"a STRING has at most {MAX_STRING} characters, not {len(raw)}")
    return raw.decode(STRING_ENCODING)


def spell(constant: Constant) -> str:
    """A constant as Micro/WIN would read it: the same value, form and width, whatever ``text`` says."""
    value, form = constant.value, constant.form
    if isinstance(value, str):
        return spell_text(value.encode(STRING_ENCODING), '"')
    if isinstance(value, float) or form is ConstantForm.REAL:
        return _spell_real(float(value))
    if form is ConstantForm.ASCII:
        size = constant.width.size if constant.width else 1
        return spell_text(value.to_bytes(size, "big"), "'")
    if form is ConstantForm.BOOL:
        return "TRUE" if value else "FALSE"
    prefix = {Width.BYTE: "B#", Width.WORD: "W#", Width.DWORD: "DW#"}[constant.width] if constant.width else ""
    if form is ConstantForm.HEX:
        return f"{prefix}16#{value:X}"
    if form is ConstantForm.BINARY:
        return f"{prefix}2#{value:b}"
    return f"{prefix}{value}"


def _spell_real(value: float) -> str:
    text = repr(value).upper()
    if "E" in text and "." not in text:
        mantissa, exponent = text.split("E")
        return f"{mantissa}.0E{exponent}"
    return text
