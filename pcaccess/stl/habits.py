"""What people write from habit: words of IEC 61131-3 and of other makers' PLCs, families with another type letter.

Tables of words with what to write here. Words that a whole dialect of SIMATIC has are in ``pcaccess.stl.foreign``.

Source:   IEC 61131-3 for the instruction list; the instruction lists of Mitsubishi FX, Omron C and Allen-Bradley
          Logix for theirs; System Manual, "STEP 7-Micro/WIN instruction set", for what stands here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Final, NamedTuple

from pcaccess.problems import either
from pcaccess.s7200.address import AddressError, Width, parse_address
from pcaccess.stl.definitions import DEFINITIONS


class Advice(NamedTuple):
    expected: str
    nearest: str | None = None
    """The instruction that is meant, where it is one."""


def advice(mnemonic: str, written: str, operands: Sequence[str]) -> Advice | None:
    """What to write in place of an instruction that there is not; None when nothing is known of the word.

    ``mnemonic`` in capitals, without blanks; ``written`` as it stands in the line, with what follows it without a
    blank; ``operands`` the words behind it.
    """
    if operands and mnemonic in BITS_ELSEWHERE:
        return BITS_ELSEWHERE[mnemonic]
    if len(operands) > _MOST_OPERANDS and all(_width(text) is None for text in operands):
        return None  # a comment that lacks its slashes
    known = _WORDS.get(mnemonic) or _family(mnemonic, operands) or _compare(mnemonic, operands)
    return known or _without_blank(written)


_MOST_OPERANDS: Final = 3


# ---------------------------------------------------------------------- families of one instruction per type

_MATH: Final = {"I": "I", "W": "I", "D": "D", "R": "R"}
_LOGIC: Final = {"B": "B", "I": "W", "W": "W", "D": "D"}
_FAMILIES: Final = (
    ("MOV MOVE", "MOV", {**_LOGIC, "R": "R"}),
    ("ADD +", "+", _MATH),
    ("SUB -", "-", _MATH),
    ("MUL MULT *", "*", _MATH),
    ("DIV /", "/", _MATH),
    ("INC", "INC", _LOGIC),
    ("DEC", "DEC", _LOGIC),
    ("INV", "INV", _LOGIC),
    ("AND WAND UND", "AND", _LOGIC),
    ("OR WOR ODER", "OR", _LOGIC),
    ("XOR WXOR EXOR", "XOR", _LOGIC),
    ("SHL SL", "SL", _LOGIC),
    ("SHR SR", "SR", _LOGIC),
    ("ROL RL", "RL", _LOGIC),
    ("ROR RR", "RR", _LOGIC),
    ("BLKMOV BMOV BM", "BM", _LOGIC),
)
"""Words for a family, its stem here, and the letter of each type."""
_TYPE_WORDS: Final = {
    "B": "B BYTE",
    "I": "I INT",
    "W": "W WORD",
    "D": "D DW DWORD DI DINT L",
    "R": "R REAL F FLOAT",
}
_LETTER_OF: Final = MappingProxyType({Width.BYTE: "B", Width.WORD: "W", Width.DWORD: "D"})


class _Member(NamedTuple):
    members: tuple[str, ...]
    """Every instruction of the family."""
    right: str | None
    """The one of the type that the word names; None when it names none."""


def _members() -> Iterator[tuple[str, _Member]]:
    for words, stem, letters in _FAMILIES:
        members = tuple(dict.fromkeys(stem + letter for letter in letters.values()))
        for word in words.split():
            yield word, _Member(members, None)
            for kind, letter in letters.items():
                for name in _TYPE_WORDS[kind].split():
                    yield word + name, _Member(members, stem + letter)
                    yield f"{word}_{name}", _Member(members, stem + letter)


_MEMBERS: Final[Mapping[str, _Member]] = MappingProxyType(
    {word: member for word, member in _members() if word not in DEFINITIONS}
)
_BIT_WORDS: Final = MappingProxyType({"AND": "A", "UND": "A", "OR": "O", "ODER": "O"})
"""Words that elsewhere combine bits as well as words."""


def _family(mnemonic: str, operands: Sequence[str]) -> Advice | None:
    member = _MEMBERS.get(mnemonic)
    if member is None:
        return None
    widths = [width for text in operands if (width := _width(text)) is not None]
    if mnemonic in _BIT_WORDS and (not widths or Width.BIT in widths):
        right = _BIT_WORDS[mnemonic]
        return Advice(f"{right} for bits; {either(member.members)} for values", right)
    of_widths = [member.members[0][:-1] + _LETTER_OF[width] for width in widths if width in _LETTER_OF]
    by_operand = next((one for one in of_widths if one in member.members), None)
    return Advice(either(member.members), member.right or by_operand)


def _width(text: str) -> Width | None:
    try:
        return parse_address(text).width
    except AddressError:
        return None


# ---------------------------------------------------------------------- compares

_COMPARE: Final = re.compile(r"(?P<load>LD|A|O|U)(?P<not>N?)(?P<type>DI|DW|[BWIDRS])(?P<sign><>|>=|<=|!=|=|<|>)?")
_OPPOSITES: Final = MappingProxyType({"=": "<>", "<>": "=", ">": "<=", "<=": ">", "<": ">=", ">=": "<"})
_SIGNS: Final = MappingProxyType({"!=": "<>", "==": "=", "=>": ">=", "=<": "<="})


def _compare(mnemonic: str, operands: Sequence[str]) -> Advice | None:
    match = _COMPARE.fullmatch(mnemonic)
    if match is None:
        return None
    load, letter = ("A" if match["load"] == "U" else match["load"]), match["type"]
    letter = {"I": "W", "DI": "D", "DW": "D"}.get(letter, letter)
    stem = load + letter
    every = either([stem + sign for sign in _OPPOSITES if stem + sign in DEFINITIONS])
    written = match["sign"] or next((word for word in operands if set(word) <= set("=<>!")), "")
    sign = _SIGNS.get(written, written)
    if match["not"]:
        sign = _OPPOSITES.get(sign, "")
        every = f"the opposite sign, as a compare is not negated: {every}"
    return Advice(every, stem + sign if stem + sign in DEFINITIONS else None)


# ---------------------------------------------------------------------- a blank that is missing


def _without_blank(written: str) -> Advice | None:
    """``LDI0.0``, ``TONT37``: an instruction and its operand."""
    for size in range(len(written) - 1, 0, -1):
        if written[:size].upper() in DEFINITIONS and _width(written[size:]) is not None:
            return Advice("a blank behind the instruction", f"{written[:size]} {written[size:]}")
    return None


# ---------------------------------------------------------------------- words

_EU: Final = "EU detects a rising edge of what is loaded before it"
_ED: Final = "ED detects a falling edge of what is loaded before it"
_COMPARES: Final = "LDW=, LDW>= and so on, which compare and load in one step"
_ROWS: Final = (
    # IEC 61131-3, Mitsubishi, Omron, Allen-Bradley: bits
    ("LOAD", "LD", "LD, which loads a bit"),
    ("LDNOT LOADN LOADNOT ", "LDN", "LDN, which loads an inverted bit"),
    ("XIC", "LD", "LD to begin, A in series, O in parallel"),
    ("XIO", "LDN", "LDN to begin, AN in series, ON in parallel"),
    ("ANDN ANDNOT ANOT", "AN", "AN"),
    ("ORN ORNOT", "ON", "ON"),
    ("XORN", None, "A, AN and OLD, which make an exclusive OR"),
    ("ST STO STORE OUT OUTPUT OTE", "=", "=, which writes a bit"),
    ("STN OUTN OUTNOT", None, "NOT and then ="),
    ("OTL LATCH", "S", "S with a bit and how many: S Q0.0, 1"),
    ("RST RES RESET OTU UNLATCH", "R", "R with a bit and how many: R Q0.0, 1"),
    ("KEEP RS", None, "S and R in networks of their own"),
    ("MPS", "LPS", "LPS"),
    ("MRD", "LRD", "LRD"),
    ("MPP", "LPP", "LPP"),
    ("ANB ANDLD ANDSTR", "ALD", "ALD"),
    ("ORLD ORSTR", "OLD", "OLD"),
    ("P LDP ANDP ORP PLSR DIFU UP POS RE ONS OSR OSRI R_TRIG", "EU", _EU),
    ("N LDF ANDF ORF PLF DIFD DN NEG FE OSF OSFI F_TRIG", "ED", _ED),
    ("INVERT CPL", "NOT", "NOT"),
    # timers, counters, compares
    ("TMR TIM TIMER TP TIMH", "TON", "TON, TOF or TONR with a timer and its time"),
    ("TOFF", "TOF", "TOF"),
    ("RTO TMRA TONM", "TONR", "TONR"),
    ("CNT CTR CU COUNTER", "CTU", "CTU, CTD or CTUD with a counter and its limit"),
    ("CD", "CTD", "CTD"),
    ("CNTR CUD UDCNT", "CTUD", "CTUD"),
    ("CMP EQ NE GT GE LT LE EQU NEQ GRT GEQ LES LEQ", None, _COMPARES),
    ("FND", None, "FND=, FND<>, FND< or FND>"),
    ("FND>= FND<=", None, "FND=, FND<>, FND< or FND>"),
    # program control
    ("JMPC JPC CJ JUMP GOTO", "JMP", "JMP, which jumps while the top of the stack is 1"),
    ("JMPCN JPCN", None, "NOT and then JMP"),
    ("LABEL LBLN", "LBL", "LBL"),
    ("CAL CALC CALLC JSR GOSUB", "CALL", "CALL, which calls while the top of the stack is 1"),
    ("CALCN", None, "NOT and then CALL"),
    ("RETC RETURN SRET", "CRET", "CRET; a subroutine returns at its end by itself"),
    ("RETCN", None, "NOT and then CRET"),
    ("IRET", "CRETI", "CRETI; an interrupt routine returns at its end by itself"),
    ("FEND", "END", "nothing at the end of the main program; END ends it while the top of the stack is 1"),
    ("EI", "ENI", "ENI"),
    ("DI", "DISI", "DISI"),
    ("ATTACH", "ATCH", "ATCH"),
    ("DETACH", "DTCH", "DTCH"),
    ("WDT WDOG", "WDR", "WDR"),
    ("NOOP", "NOP", "NOP with a number: NOP 0"),
    # arithmetic and conversions
    ("MOD REM", "DIV", "DIV, which leaves the quotient in the low word and the remainder in the high word"),
    ("ABS", None, "a compare with 0 and a subtraction from 0; there is no instruction for it"),
    ("SQR SQUARE", "SQRT", "SQRT for the square root, *R for the square"),
    ("LOG", "LN", "LN; /R by 2.302585 makes it a decimal logarithm"),
    ("POW EXPT XPY", None, "LN, *R and EXP, which raise to a power together"),
    ("ASIN ACOS ATAN", None, "SIN, COS and TAN; there are no inverse ones"),
    ("ITR I_R INT_TO_REAL FLT", None, "ITD and then DTR"),
    ("BTR B_R BYTE_TO_REAL", None, "BTI, ITD and then DTR"),
    ("RTD R_DI REAL_TO_DINT RDI", "ROUND", "ROUND, or TRUNC to cut off"),
    ("RTI R_I REAL_TO_INT", None, "ROUND (or TRUNC) and then DTI"),
    ("CEIL FLOOR FIX", None, "ROUND or TRUNC"),
    ("BTW BYTE_TO_INT", "BTI", "BTI"),
    ("WTB ITBYTE INT_TO_BYTE", "ITB", "ITB"),
    ("INT_TO_DINT", "ITD", "ITD"),
    ("DINT_TO_INT", "DTI", "DTI"),
    ("DINT_TO_REAL", "DTR", "DTR"),
    ("BIN BCDTI BCD_TO_INT FRD", "BCDI", "BCDI, in place"),
    ("BCD ITBCD INT_TO_BCD TOD", "IBCD", "IBCD, in place"),
    # texts, tables, clock, pulses
    ("LEN STRLEN", "SLEN", "SLEN"),
    ("STRCPY MOVS MOV_S", "SCPY", "SCPY"),
    ("CONCAT STRCAT", "SCAT", "SCAT"),
    ("FIND INSTR", "SFND", "SFND for a text, CFND for one of several characters"),
    ("MID LEFT RIGHT", "SSCPY", "SSCPY"),
    ("FMOV FLL MEMSET", "FILL", "FILL"),
    ("COP MEMCPY", None, "BMB, BMW or BMD"),
    ("TRD RTC RTCR READRTC", "TODR", "TODR"),
    ("TWR RTCW SETRTC", "TODW", "TODW"),
    ("PTO PWM PULS PLSY", "PLS", "PLS, with its control byte in SMB67 or SMB77"),
)
_WORDS: Final[Mapping[str, Advice]] = MappingProxyType(
    {word: Advice(expected, nearest) for words, nearest, expected in _ROWS for word in words.split()}
)
BITS_ELSEWHERE: Final[Mapping[str, Advice]] = MappingProxyType({"SET": _WORDS["LATCH"], "CLR": _WORDS["RST"]})
"""Words with a bit behind them. On an S7-300 they stand alone and mean something else."""
