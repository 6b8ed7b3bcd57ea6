"""Code pages are told apart by what people write in them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.codepage import guess_code_page


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        ("Öffner, Schließer, Temperatur °C", "cp1252"),
        ("TÍTULO DE SEGMENTO (una línea)", "cp1252"),
        ("Débit d'eau à la sortie", "cp1252"),
        ("Насос 1: пуск", "cp1251"),
        ("ДВИГАТЕЛЬ", "cp1251"),
        ("网络标题", "gbk"),
        ("程序注释 // 电机启动", "gbk"),
    ],
)
def test_texts_of_real_programs_are_recognised(text: str, encoding: str) -> None:
    assert guess_code_page(text.encode(encoding)) == encoding


@given(st.binary())
def test_bytes_of_any_kind_get_some_code_page(data: bytes) -> None:
    assert data.decode(guess_code_page(data), errors="replace") is not None
