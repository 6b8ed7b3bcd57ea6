"""Instructions for what stands around the CPU: clock, ports, high-speed counters, pulse outputs, PID."""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.types import DataType
from pcaccess.stl.define import OVERFLOW, In, InOut, Number, Out, declare
from pcaccess.stl.errors import INDIRECT_ADDRESS, OPERAND_RANGE, RunTimeError

BYTE = DataType.BYTE
_V: Final = frozenset({Area.V})
_CLOCK: Final = "System Manual, Real-time clock; document 004, section 9.24"
_PORT: Final = "System Manual, Communications; document 004, section 9.29"

read_clock = declare(
    {"TODR": (8,), "TODRX": (19,)},
    group="Clock",
    operands=(Out("T", BYTE, block=True),),
    eno_off=(INDIRECT_ADDRESS, RunTimeError.NO_CLOCK, OPERAND_RANGE),
    source=_CLOCK,
    doc="""Read date and time (TODRX: and the daylight-saving settings) into a buffer of BCD bytes.""",
)
set_clock = declare(
    {"TODW": (8,), "TODWX": (19,)},
    group="Clock",
    operands=(In("T", BYTE, constant=False, block=True),),
    eno_off=(INDIRECT_ADDRESS, RunTimeError.CLOCK_DATA, RunTimeError.NO_CLOCK, OPERAND_RANGE),
    source=_CLOCK,
    doc="""Set date and time (TODWX: and the daylight-saving settings) from a buffer of BCD bytes.""",
)
freeport = declare(
    {"XMT": (), "RCV": ()},
    group="Communication",
    operands=(InOut("TBL", BYTE, block=True), Number("PORT", 0, 1)),
    eno_off=(
        INDIRECT_ADDRESS,
        RunTimeError.PORT_0_BUSY,
        RunTimeError.PORT_1_BUSY,
        RunTimeError.NO_FREEPORT,
    ),
    source=_PORT,
    doc="""Send the buffer (RCV: receive a message into it) on a Freeport.""",
)
network = declare(
    {"NETR": (), "NETW": ()},
    group="Communication",
    operands=(InOut("TBL", BYTE, block=True), Number("PORT", 0, 1)),
    eno_off=(INDIRECT_ADDRESS,),
    source=_PORT,
    doc="""Read from another PLC (NETW: write to it) as the table says.""",
)
port_address = declare(
    {"GPA": ()},
    group="Communication",
    operands=(Out("ADDR", BYTE), Number("PORT", 0, 1)),
    eno_off=(INDIRECT_ADDRESS, RunTimeError.NOT_IN_INTERRUPT),
    source=_PORT,
    doc="""Read the station address of the port.""",
)
set_port_address = declare(
    {"SPA": ()},
    group="Communication",
    operands=(In("ADDR", BYTE), Number("PORT", 0, 1)),
    eno_off=(INDIRECT_ADDRESS, RunTimeError.NOT_IN_INTERRUPT),
    source=_PORT,
    doc="""Set the station address of the port until the CPU is switched off.""",
)
define_counter = declare(
    {"HDEF": ()},
    group="HSC",
    operands=(Number("HSC", 0, 5), Number("MODE", 0, 12)),
    eno_off=(RunTimeError.HSC_INPUT_TAKEN, RunTimeError.NOT_IN_INTERRUPT, RunTimeError.HDEF_TWICE),
    source="System Manual, High-speed counters; document 004, section 9.31",
    doc="""Choose the mode of a high-speed counter.""",
)
run_counter = declare(
    {"HSC": ()},
    group="HSC",
    operands=(Number("N", 0, 5),),
    eno_off=(RunTimeError.HSC_BEFORE_HDEF, RunTimeError.HSC_PLS_TWICE),
    source="System Manual, High-speed counters; document 004, section 9.31",
    doc="""Take over the control byte of a high-speed counter.""",
)
pulse = declare(
    {"PLS": ()},
    group="Pulse",
    operands=(Number("N", 0, 1),),
    eno_off=(RunTimeError.HSC_PLS_TWICE, RunTimeError.PULSE_ACTIVE, RunTimeError.NO_SEGMENTS),
    source="System Manual, Pulse output; document 004, section 9.30",
    doc="""Take over the control byte of a pulse output.""",
)
loop = declare(
    {"PID": ()},
    group="PID",
    operands=(InOut("TBL", BYTE, block=True, areas=_V, pointer=False, extent=36), Number("LOOP", 0, 7)),
    sm=(OVERFLOW,),
    eno_off=(OVERFLOW, INDIRECT_ADDRESS, RunTimeError.PID_TABLE),
    source="System Manual, PID; document 004, section 9.32",
    doc="""Compute one sample of a PID loop.""",
)
