"""Which Windows code page a text was written in, where nothing in the file says so.

Micro/WIN and spreadsheets write the ANSI code page of their PC. cp1252, cp1251 and GBK compete with a score over the
non-ASCII runs; that is a guess, so whoever asks also lets the user name an encoding.

Source:   exports of Micro/WIN seen in these code pages.
"""

from __future__ import annotations

from itertools import zip_longest
from typing import Final

_SAMPLE: Final = 20_000
"""Bytes of non-ASCII lines that the code page is judged by."""
_FREQUENT: Final = frozenset(
    "的一是在不和有大中为以上下到时用可分子程序主网络标题注释段块始停止启动电机开关输入出初化控制数据值"
    "定时器计水泵温度压力阀门报警故障运行手自复位正反转速灯红绿黄按钮信号传感模式总当前设置次间秒第断"
)


def guess_code_page(data: bytes) -> str:
    """``cp1252``, ``cp1251`` or ``gbk``; for bytes that are neither ASCII nor UTF-8."""
    sample = b"\n".join(line for line in data.splitlines() if not line.isascii())[:_SAMPLE]
    scores = {"gbk": _score_gbk(sample), "cp1251": _score_cyrillic(sample), "cp1252": _score_western(sample)}
    return max(scores, key=lambda name: scores[name])


def _score_gbk(data: bytes) -> float:
    """Plausible Chinese: pairs of the common characters (GB 2312 level 1) and of full-width punctuation."""
    try:
        text = data.decode("gbk")
    except UnicodeDecodeError as error:
        if error.start < len(data) - 1:  # a file cut off in the middle of a character is still Chinese
            return float("-inf")
        text = data[: error.start].decode("gbk")
    score = 0.0
    for character in text:
        if character > "\x7f":
            lead, trail = character.encode("gbk")
            if trail < 0xA1:  # beyond GB 2312: rarely Chinese, often an accented letter and the ASCII one behind it
                score -= 1.0
            else:
                score += (
                    3.0 if character in _FREQUENT else 1.5 if 0xB0 <= lead <= 0xD7 else 1.0 if lead <= 0xA3 else -0.5
                )
    return score


def _score_cyrillic(data: bytes) -> float:
    """Plausible Russian: letters stand in words, never beside Latin ones, and no capital inside a word."""
    score, before = 0.0, " "
    for character in data.decode("cp1251", errors="replace"):
        if character > "\x7f":
            if "а" <= character <= "я" or character == "ё":
                score += 1.0 if not before.isascii() or not before.isalnum() else -1.0
            elif "А" <= character <= "Я" or character == "Ё":
                score += -1.0 if "а" <= before <= "я" or (before.isascii() and before.isalpha()) else 1.0
            else:
                score += 0.3 if character in "№«»–—…°" else -1.0
        before = character
    return score


def _score_western(data: bytes) -> float:
    """Plausible Western European: single accented letters among Latin ones, hardly ever two in a row."""
    score, before = 0.0, " "
    text = data.decode("cp1252", errors="replace")
    for character, after in zip_longest(text, text[1:], fillvalue=" "):
        if character > "\x7f":
            if not character.isalpha():
                score += 0.5 if character in "°²³µ±«»“”„–—…¿¡€ºª" else -0.5
            elif before > "\x7f":
                score -= 1.0
            else:
                score += 1.2 if _is_latin(before) or _is_latin(after) else -0.2
        before = character
    return score


def _is_latin(character: str) -> bool:
    return character.isascii() and character.isalpha()
