"""A gateway in this process and a clock that tests move by hand, for tests of the OPC UA side without a socket."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from pcaccess.gateway.gateway import Gateway
from pcaccess.project.load import load_text
from tests.clocks import HandClock

PLANT = """
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: NewPLC
        address: 2
        cpu: CPU 224
        description: The press
        items:
          - {name: Motor, address: Q0.0, type: BOOL, access: RW, description: Contactor}
          - {name: Temperature, address: VW0, type: INT, access: RW, high: 1000, low: 200, unit: °C}
          - {name: High, address: VB0, type: BYTE, access: RW}
          - {name: Setpoint, address: VW200, type: INT, access: RW, high: 100, low: 0, write_limits: refuse}
          - {name: Scaled, address: VW202, type: REAL, access: RW, scaling: {raw: [0, 32000], scaled: [0, 10]}}
          - {name: Level, address: VD204, type: REAL, access: RW, high: 200, low: 0}
          - {name: Signed, address: VB208, type: CHAR, access: RW}
          - {name: Unsigned, address: VW210, type: WORD, access: RW}
          - {name: Big, address: VD212, type: DINT, access: RW}
          - {name: Huge, address: VD216, type: DWORD, access: RW}
          - {name: Text, address: VB300, type: STRING, length: 10, access: RW}
          - {name: Row, address: "VW400[4]", type: INT, access: RW}
          - {name: Bits, address: "V500.3[11]", type: BOOL, access: RW}
          - {name: Input, address: I0.1, type: BOOL, access: R}
          - {name: Command, address: VW600, type: INT, access: W}
          - {name: Clock, address: SM0.5, type: BOOL, access: R}
        folders:
          - name: USR1
            items:
              - {name: COUNTER_1, address: VW700, type: INT, access: RW}
      - name: Dead
        address: 3
        connected: false
        items:
          - {name: Value, address: VW0, type: INT, access: RW}
          - {name: Text, address: VB100, type: STRING, length: 10, access: RW}
groups:
  - {name: Fast, update_rate: 250ms, active: true, items: [MicroWin.NewPLC.Motor]}
"""

MakeGateway = Callable[..., Gateway]


@pytest.fixture
def clock() -> HandClock:
    return HandClock()


@pytest.fixture
def make_gateway(clock: HandClock) -> MakeGateway:
    """Gateways of a project text; they show what is there, but no task runs."""

    def make(text: str = PLANT) -> Gateway:
        gateway = Gateway(load_text(text).project, clock)
        gateway.show()
        return gateway

    return make


@pytest.fixture
def gateway(make_gateway: MakeGateway) -> Gateway:
    return make_gateway()
