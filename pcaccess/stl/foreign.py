"""Programs that are not SIMATIC STL of an S7-200: German mnemonics, S7-300 and SMART instructions, ladder boxes.

Tables of words with what to write instead, and the recognition of a whole S7-300 source.

Source:   Micro/WIN editor grammar and document 004, section 9.26 (SBR, RET, RETI frames); ladder box names as
          documents 003 and 004 print them; STEP 7 statement list for the S7-300 words.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Final

_COMPARES: Final = ("=", "<>", ">=", "<=", ">", "<")

GERMAN: Final[Mapping[str, str]] = MappingProxyType(
    {
        "U": "A",
        "UN": "AN",
        "UI": "AI",
        "UNI": "ANI",
        "ULD": "ALD",
        "UENO": "AENO",
        "ZV": "CTU",
        "ZR": "CTD",
        "ZVR": "CTUD",
        **{f"U{kind}{sign}": f"A{kind}{sign}" for kind in "BWDRS" for sign in _COMPARES},
    }
)
"""German mnemonics and the international ones that Micro/WIN writes otherwise."""

SMART: Final[Mapping[str, str | None]] = MappingProxyType(
    {"GET": "NETR", "PUT": "NETW", **dict.fromkeys(("TCON", "TSEND", "TRECV", "TDCON", "GIP", "SIP"))}
)
"""Instructions that only the S7-200 SMART has, with what an S7-200 has in their place."""

_S7_300_WORDS: Final = (
    ("L T", "MOVB, MOVW, MOVD or MOVR move a value in one step"),
    ("JU SPL", "JMP jumps while the top of the stack is 1; LD SM0.0 before it makes it always"),
    ("SPB SPBN SPBB SPZ SPN SPP SPM JC JCN JCB JZ JN JP JM", "JMP jumps while the top of the stack is 1"),
    ("BE BEA BEU", "the end of a block needs no instruction"),
    ("BEB BEC", "END, CRET and CRETI leave a block"),
    ("AUF OPN", "there is one data block, V memory; name its addresses directly"),
    ("UC CC", "CALL calls a subroutine"),
    ("SE SD", "TON delays switching on"),
    ("SS", "TONR adds up time"),
    ("SA SF", "TOF delays switching off"),
    ("SV SP", "a TON with its own reset makes a pulse"),
    ("FP FR", "EU detects a rising edge"),
    ("FN", "ED detects a falling edge"),
    ("U( UN( A( AN( O( ON( X( XN( )", "LD … ALD and LD … OLD group conditions"),
    ("X XN", "an exclusive OR is written with A, AN and OLD"),
    ("TAK TAR1 TAR2 LAR1 LAR2", "*AC1 and &VB0 address indirectly"),
    ("==I <>I >I <I >=I <=I", "LDW=, LDW>= and so on compare and load in one step"),
    ("==D <>D >D <D >=D <=D", "LDD=, LDD>= and so on compare and load in one step"),
    ("==R <>R >R <R >=R <=R", "LDR=, LDR>= and so on compare and load in one step"),
    ("SET CLR SAVE", "LD SM0.0 loads a 1"),
    ("BLD MCR( )MCR MCRA MCRD", "it has no counterpart"),
    ("BTD DTB RND", "BCDI, IBCD and ROUND convert numbers"),
    ("NEGI NEGD NEGR", "-I, -D and -R subtract"),
    ("UW OW XOW UD OD XOD", "ANDW, ORW, XORW and so on combine words"),
)
S7_300: Final[Mapping[str, str]] = MappingProxyType(
    {word: instead for words, instead in _S7_300_WORDS for word in words.split()}
)
"""Statement list words of the S7-300 and S7-400, with what an S7-200 does instead."""

_BOX_KINDS: Final = {"B": "B", "W": "W", "DW": "D", "I": "I", "DI": "D", "R": "R"}
_BOXES: Final = {
    "ADD": ("+", "I DI R"),
    "SUB": ("-", "I DI R"),
    "MUL": ("*", "I DI R"),
    "DIV": ("/", "I DI R"),
    "INC": ("INC", "B W DW"),
    "DEC": ("DEC", "B W DW"),
    "INV": ("INV", "B W DW"),
    "WAND": ("AND", "B W DW"),
    "WOR": ("OR", "B W DW"),
    "WXOR": ("XOR", "B W DW"),
    "MOV": ("MOV", "B W DW R"),
    "BLKMOV": ("BM", "B W DW"),
    "SHL": ("SL", "B W DW"),
    "SHR": ("SR", "B W DW"),
    "ROL": ("RL", "B W DW"),
    "ROR": ("RR", "B W DW"),
}
LADDER: Final[Mapping[str, str]] = MappingProxyType(
    {
        **{
            f"{box}_{kind}": f"{stl}{_BOX_KINDS[kind]}"
            for box, (stl, kinds) in _BOXES.items()
            for kind in kinds.split()
        },
        "B_I": "BTI",
        "I_B": "ITB",
        "I_DI": "ITD",
        "DI_I": "DTI",
        "DI_R": "DTR",
        "BCD_I": "BCDI",
        "I_BCD": "IBCD",
        "FILL_N": "FILL",
        "READ_RTC": "TODR",
        "SET_RTC": "TODW",
        "BGN_ITIME": "BITIM",
        "CAL_ITIME": "CITIM",
        "MOV_BIR": "BIR",
        "MOV_BIW": "BIW",
        "AD_T_TBL": "ATT",
        "NET_READ": "NETR",
        "NET_WRITE": "NETW",
        "GET_ADDR": "GPA",
        "SET_ADDR": "SPA",
        "SCR": "LSCR",
        "DIAG_LED": "DLED",
        "STR_LEN": "SLEN",
        "STR_CPY": "SCPY",
        "STR_CAT": "SCAT",
        "STR_FIND": "SFND",
        "CHR_FIND": "CFND",
        "SSTR_CPY": "SSCPY",
    }
)
"""Names of boxes in ladder diagrams and the STL instruction of each."""

_DEFINITE: Final = re.compile(
    r"""\s*(?:
        (?:ORGANIZATION_BLOCK|FUNCTION_BLOCK|DATA_BLOCK)\s+(?:OB|FB|DB)\s+\d+
      | (?:ORGANIZATION_BLOCK|FUNCTION_BLOCK|DATA_BLOCK|FUNCTION)\s+"
      | FUNCTION\s+FC\s*\d+
      | (?:DATA_BLOCK)\s+DB\s*\d+
      | VERSION\s*:\s*\d
      | VAR_TEMP\s*$
      | (?:CALL|UC|CC)\s+(?:FC|FB|SFC|SFB)\s*\d+
      | [LT]\s+(?:[MEAIQDP]|PE|PA|PI|PQ|DB)\s*[BWD]\s*\d+
      | [LT]\s+DB\d+\.DB[BWD]\d
      | L\s+(?:S5T\#|T\#|L\#|B\#16\#|W\#16\#|P\#|C\#)
      | (?:AUF|OPN)\s+D[BI]
      | (?:U|UN|A|AN|O|ON|X|XN|S|R|=)\s+[EAMIQDL]\s+\d+\.\d+
      | (?:U|UN|A|AN|O|ON|X|XN)\(
      | (?:==|<>|>=|<=|>|<)[IDR]\s*(?:;|//|$)
      | [A-Z_]\w{0,3}:\s+(?:NOP|U|UN|A|AN|O|ON|L|T|S|R|=|BE|BEA|SET|CLR|CALL)\b
      | (?:SPA|SPB|SPBN|JU|JC|JCN)\s+[A-Z_]\w{0,3}\s*(?:;|//|$)
    )""",
    re.VERBOSE | re.IGNORECASE,
)
_S7_200: Final = re.compile(
    r"\s*(?:(?:ORGANIZATION|SUBROUTINE|INTERRUPT)_BLOCK\s+.*:|LD[NI]?\s|LD[BWDRS]\s*[=<>]|MOV[BWDR]\s|TON\s+T\d)",
    re.IGNORECASE,
)


def s7_300_lines(lines: Sequence[str]) -> list[int]:
    """Numbers of the lines that show that this is a program for an S7-300 or S7-400; empty when it is not.

    One line that no S7-200 program has is enough when nothing speaks for an S7-200; otherwise they must be many.
    """
    definite = [number for number, line in enumerate(lines, 1) if _DEFINITE.match(line)]
    if not definite:
        return []
    own = sum(1 for line in lines if _S7_200.match(line))
    return definite if len(definite) > own else []
