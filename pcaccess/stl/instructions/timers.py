"""Timers and interval times."""

from __future__ import annotations

from pcaccess.s7200.types import DataType
from pcaccess.stl.define import Direction, In, Out, Power, Special, declare, special
from pcaccess.stl.errors import INDIRECT_ADDRESS

INT, DWORD = DataType.INT, DataType.DWORD

on_off_delay = declare(
    {"TON": (), "TOF": ()},
    group="Timer",
    operands=(special("TXXX", Special.TIMER, Direction.INOUT, timers="TON"), In("PT", INT)),
    power=Power.COIL,
    errors=(INDIRECT_ADDRESS,),
    source="System Manual, Timers; document 004, section 9.17",
    doc="""Delay switching on (TOF: off) by PT intervals of the timer.""",
)
retentive = declare(
    {"TONR": ()},
    group="Timer",
    operands=(special("TXXX", Special.TIMER, Direction.INOUT, timers="TONR"), In("PT", INT)),
    power=Power.COIL,
    errors=(INDIRECT_ADDRESS,),
    source="System Manual, Timers; document 004, section 9.17",
    doc="""Add up the time while S0 is 1; only R clears it.""",
)
begin_interval = declare(
    {"BITIM": ()},
    group="Timer",
    operands=(Out("OUT", DWORD),),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Interval timers; document 004, section 9.25",
    doc="""Store the millisecond counter.""",
)
interval = declare(
    {"CITIM": ()},
    group="Timer",
    operands=(In("IN", DWORD, constant=False), Out("OUT", DWORD)),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Interval timers; document 004, section 9.25",
    doc="""Store how many milliseconds have passed since IN was stored by BITIM.""",
)
