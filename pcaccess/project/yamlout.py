"""Texts and numbers as YAML that every reader takes for what they are, on one line."""

from __future__ import annotations

from typing import Final

import yaml

_PLAIN_START: Final = frozenset("-?:,[]{}#&*!|>'\"%@` ")
_FLOW: Final = frozenset(",[]{}\"'#?")  # PyYAML ends a plain text in braces at a question mark
_GUESS: Final = yaml.resolver.Resolver()
_STR: Final = "tag:yaml.org,2002:str"


def scalar(value: str | float | bool) -> str:
    """``value`` for a flow mapping: plain where no reader could misread it, else in double quotes."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        text = f"{value:.0f}" if float(value).is_integer() and abs(value) < 1e15 else repr(float(value))
        return text.replace("e", ".0e") if "e" in text and "." not in text else text  # 1e+300 is a text to many
    if _is_plain(value):
        return value
    return '"' + "".join(_escaped(character) for character in value) + '"'


def mapping(pairs: dict[str, str | float | bool]) -> str:
    """``{name: Motor, address: Q0.0}``"""
    return "{" + ", ".join(f"{key}: {scalar(value)}" for key, value in pairs.items()) + "}"


def _is_plain(text: str) -> bool:
    if not text or text != text.strip() or text[0] in _PLAIN_START or not text.isprintable():
        return False
    if any(character in _FLOW for character in text) or ": " in text or text.endswith(":"):
        return False
    return bool(_GUESS.resolve(yaml.ScalarNode, text, (True, False)) == _STR)  # type: ignore[no-untyped-call]


def _escaped(character: str) -> str:
    if character in '"\\':
        return "\\" + character
    if character.isprintable():
        return character
    code = ord(character)
    return f"\\x{code:02X}" if code < 0x100 else f"\\u{code:04X}" if code < 0x10000 else f"\\U{code:08X}"
