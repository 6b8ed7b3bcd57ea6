"""Instructions for what stands around the CPU: clock, ports, high-speed counters, pulse outputs, PID.

Each asks ``runtime.peripherals``, which answers for whatever is there (``pcaccess.stl.runtime.Peripherals``).
"""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.types import DataType
from pcaccess.stl import layout
from pcaccess.stl.builder import Place
from pcaccess.stl.define import OVERFLOW, In, InOut, Number, Out, define
from pcaccess.stl.errors import INDIRECT_ADDRESS, OPERAND_RANGE, RunTimeError
from pcaccess.stl.ir_values import Effects, IrType, PythonFunction, Value
from pcaccess.stl.routine import Routine
from pcaccess.stl.runtime import Outcome, Runtime

BYTE = DataType.BYTE
NOT_IN_INTERRUPT: Final = RunTimeError.NOT_IN_INTERRUPT
_V: Final = frozenset({Area.V})
_CLOCK: Final = "System Manual, Real-time clock; document 004, section 9.24"
_PORT: Final = "System Manual, Communications; document 004, section 9.29"


def _in_interrupt(runtime: Runtime) -> bool:
    return bool(runtime.memory[layout.IN_INTERRUPT])


@define(
    {"TODR": (8,), "TODRX": (19,)},
    group="Clock",
    operands=(Out("T", BYTE, block=True),),
    eno_off=(INDIRECT_ADDRESS, RunTimeError.NO_CLOCK, OPERAND_RANGE),
    source=_CLOCK,
)
def read_clock(b: Routine, size: int, buffer: Place) -> None:
    """Read date and time (TODRX: and the daylight-saving settings) into a buffer of BCD bytes.

    Year, month, day, hour, minute, second, 0, day of the week (1 is Sunday).
    """
    effects = Effects(errors=(RunTimeError.NO_CLOCK, OPERAND_RANGE))
    b.cold(clock_to_buffer, b.address(buffer), static=(size,), effects=effects)


def clock_to_buffer(runtime: Runtime, size: int, buffer: int) -> Outcome:
    if runtime.room(buffer) < size:
        return OPERAND_RANGE
    return runtime.peripherals.read_clock(buffer, size)


@define(
    {"TODW": (8,), "TODWX": (19,)},
    group="Clock",
    operands=(In("T", BYTE, constant=False, block=True),),
    eno_off=(INDIRECT_ADDRESS, RunTimeError.CLOCK_DATA, RunTimeError.NO_CLOCK, OPERAND_RANGE),
    source=_CLOCK,
)
def set_clock(b: Routine, size: int, buffer: Place) -> None:
    """Set date and time (TODWX: and the daylight-saving settings) from a buffer of BCD bytes."""
    effects = Effects(errors=(RunTimeError.CLOCK_DATA, RunTimeError.NO_CLOCK, OPERAND_RANGE))
    b.cold(buffer_to_clock, b.address(buffer), static=(size,), effects=effects)


def buffer_to_clock(runtime: Runtime, size: int, buffer: int) -> Outcome:
    if runtime.room(buffer) < size:
        return OPERAND_RANGE
    return runtime.peripherals.set_clock(buffer, size)


_BUSY: Final = (RunTimeError.PORT_0_BUSY, RunTimeError.PORT_1_BUSY, RunTimeError.NO_FREEPORT)


def transmit(runtime: Runtime, port: int, table: int) -> Outcome:
    return runtime.peripherals.transmit(table, port)


def receive(runtime: Runtime, port: int, table: int) -> Outcome:
    return runtime.peripherals.receive(table, port)


def net_read(runtime: Runtime, port: int, table: int) -> Outcome:
    return runtime.peripherals.net_read(table, port)


def net_write(runtime: Runtime, port: int, table: int) -> Outcome:
    return runtime.peripherals.net_write(table, port)


@define(
    {"XMT": (transmit,), "RCV": (receive,)},
    group="Communication",
    operands=(InOut("TBL", BYTE, block=True), Number("PORT", 0, 1)),
    eno_off=(INDIRECT_ADDRESS, *_BUSY),
    source=_PORT,
)
def freeport(b: Routine, function: PythonFunction, table: Place, port: int) -> None:
    """Send the buffer (RCV: receive a message into it) on a port in Freeport mode."""
    b.cold(function, b.address(table), static=(port,), effects=Effects(errors=_BUSY))


@define(
    {"NETR": (net_read,), "NETW": (net_write,)},
    group="Communication",
    operands=(InOut("TBL", BYTE, block=True), Number("PORT", 0, 1)),
    eno_off=(INDIRECT_ADDRESS,),
    source=_PORT,
)
def network(b: Routine, function: PythonFunction, table: Place, port: int) -> None:
    """Read from another PLC (NETW: write to it) as the table says; how it went stands in the table."""
    b.cold(function, b.address(table), static=(port,), effects=Effects())


@define(
    {"GPA": ()},
    group="Communication",
    operands=(Out("ADDR", BYTE), Number("PORT", 0, 1)),
    eno_off=(INDIRECT_ADDRESS,),
    source=_PORT,
)
def port_address(b: Routine, out: Place, port: int) -> None:
    """Read the station address of the port."""
    address = b.call(get_port_address, static=(port,), effects=Effects(), result=IrType.I32)
    assert address is not None
    b.store(out, b.convert(address, IrType.U8))
    b.eno(True)


def get_port_address(runtime: Runtime, port: int) -> int:
    return runtime.peripherals.port_address(port)


@define(
    {"SPA": ()},
    group="Communication",
    operands=(In("ADDR", BYTE), Number("PORT", 0, 1)),
    eno_off=(INDIRECT_ADDRESS, NOT_IN_INTERRUPT),
    source=_PORT,
)
def set_port_address(b: Routine, address: Value, port: int) -> None:
    """Set the station address of the port until the CPU is switched off. In an interrupt routine: error 0004."""
    b.cold(change_port_address, address, static=(port,), effects=Effects(errors=(NOT_IN_INTERRUPT,)))


def change_port_address(runtime: Runtime, port: int, address: int) -> Outcome:
    return NOT_IN_INTERRUPT if _in_interrupt(runtime) else runtime.peripherals.set_port_address(address, port)


_HDEF: Final = (RunTimeError.HSC_INPUT_TAKEN, NOT_IN_INTERRUPT, RunTimeError.HDEF_TWICE)
_HSC: Final = (RunTimeError.HSC_BEFORE_HDEF, RunTimeError.HSC_PLS_TWICE)
_PLS: Final = (RunTimeError.HSC_PLS_TWICE, RunTimeError.PULSE_ACTIVE, RunTimeError.NO_SEGMENTS)


@define(
    {"HDEF": ()},
    group="HSC",
    operands=(Number("HSC", 0, 5), Number("MODE", 0, 12)),
    eno_off=_HDEF,
    source="System Manual, High-speed counters; document 004, section 9.31",
)
def define_counter(b: Routine, counter: int, mode: int) -> None:
    """Choose the mode of a high-speed counter, once. In an interrupt routine: error 0004."""
    b.cold(set_counter_mode, static=(counter, mode), effects=Effects(errors=_HDEF))


def set_counter_mode(runtime: Runtime, counter: int, mode: int) -> Outcome:
    return NOT_IN_INTERRUPT if _in_interrupt(runtime) else runtime.peripherals.define_counter(counter, mode)


@define(
    {"HSC": ()},
    group="HSC",
    operands=(Number("N", 0, 5),),
    eno_off=_HSC,
    source="System Manual, High-speed counters; document 004, section 9.31",
)
def run_counter(b: Routine, counter: int) -> None:
    """Take over the control byte of a high-speed counter, with its new direction, preset and value."""
    b.cold(take_counter_control, static=(counter,), effects=Effects(errors=_HSC))


def take_counter_control(runtime: Runtime, counter: int) -> Outcome:
    return runtime.peripherals.run_counter(counter)


@define(
    {"PLS": ()},
    group="Pulse",
    operands=(Number("N", 0, 1),),
    eno_off=_PLS,
    source="System Manual, Pulse output; document 004, section 9.30",
)
def pulse(b: Routine, output: int) -> None:
    """Take over the control byte of a pulse output: a pulse train, or pulses of a width."""
    b.cold(take_pulse_control, static=(output,), effects=Effects(errors=_PLS))


def take_pulse_control(runtime: Runtime, output: int) -> Outcome:
    return runtime.peripherals.pulse(output)


@define(
    {"PID": ()},
    group="PID",
    operands=(InOut("TBL", BYTE, block=True, areas=_V, pointer=False, extent=36), Number("LOOP", 0, 7)),
    sm=(OVERFLOW,),
    eno_off=(OVERFLOW, RunTimeError.PID_TABLE),
    source="System Manual, PID; document 004, section 9.32",
)
def loop(b: Routine, table: Place, number: int) -> None:
    """Compute one sample of a PID loop from its table of 36 bytes (80 with auto-tune)."""
    effects = Effects(sm=(OVERFLOW,), errors=(RunTimeError.PID_TABLE,))
    b.cold(compute_loop, b.address(table), static=(number,), effects=effects)


def compute_loop(runtime: Runtime, number: int, table: int) -> Outcome:
    return runtime.peripherals.pid(table, number)
