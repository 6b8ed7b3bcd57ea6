"""Gateways without sockets, on a clock that tests move by hand."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from pcaccess.gateway.gateway import Gateway
from pcaccess.project.load import load_text
from tests.clocks import HandClock

MakeGateway = Callable[[str], Gateway]


@pytest.fixture
def clock() -> HandClock:
    return HandClock()


@pytest.fixture
def gateway(clock: HandClock) -> MakeGateway:
    def make(text: str) -> Gateway:
        made = Gateway(load_text(text).project, clock)
        made.show()
        return made

    return make
