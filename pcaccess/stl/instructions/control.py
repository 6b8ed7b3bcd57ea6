"""Program control: jumps, loops, subroutines, sequence control relays, end and stop."""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.types import DataType
from pcaccess.stl.builder import Place
from pcaccess.stl.define import In, InOut, Power, Special, StackUse, define, special
from pcaccess.stl.errors import INDIRECT_ADDRESS, RunTimeError
from pcaccess.stl.ir_values import Value
from pcaccess.stl.program import Operand
from pcaccess.stl.routine import Routine
from pcaccess.stl.runtime import OK, Outcome, Runtime

BOOL, BYTE, INT = DataType.BOOL, DataType.BYTE, DataType.INT
_SEQUENCE: Final = frozenset({Area.S})
_NONE: Final = StackUse(0, 0)


@define(
    {"END": ()},
    group="Program control",
    power=Power.CONTROL,
    source="System Manual, END",
)
def end(b: Routine) -> None:
    """End the scan of the main program while S0 is 1."""
    b.leave_if_powered()


@define(
    {"MEND": ()},
    group="Program control",
    power=Power.MARK,
    stack=_NONE,
    source="Programs for STEP 7-Micro/WIN before version 3",
)
def end_always(b: Routine) -> None:
    """End of the main program, whatever the stack says."""
    b.leave()


def request_stop(runtime: Runtime) -> None:
    runtime.request_stop()


def _stop_now(b: Routine) -> None:
    b.call(request_stop)


@define(
    {"STOP": ()},
    group="Program control",
    power=Power.CONTROL,
    source="System Manual, STOP; document 003, section 6.2.3",
)
def stop(b: Routine) -> None:
    """Put the CPU to STOP while S0 is 1: the program ends here, outputs are written, then the CPU stops.

    In an interrupt routine only that routine ends, waiting interrupts are ignored, and the rest of the main
    program still runs.
    """
    b.leave_if_powered(lambda: _stop_now(b), unwind=True)


def reset_watchdog(runtime: Runtime) -> Outcome:
    runtime.reset_watchdog()
    return OK


@define(
    {"WDR": ()},
    group="Program control",
    source="System Manual, Watchdog reset; document 003, section 6.2.4",
)
def watchdog(b: Routine) -> None:
    """Give the scan its full time again.

    Once it has lasted three times that, WDR does nothing: a loop with WDR in it does not last for ever.
    """
    b.call(reset_watchdog)
    b.eno(True)


def diagnosis(runtime: Runtime, value: int) -> None:
    runtime.peripherals.diagnosis_led(value != 0)


@define(
    {"DLED": ()},
    group="Program control",
    operands=(In("IN", BYTE),),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Diagnosis LED",
)
def diagnosis_led(b: Routine, value: Value) -> None:
    """Switch the diagnosis LED on when IN is not 0, off when it is."""
    b.call(diagnosis, value)
    b.eno(True)


@define(
    {"JMP": ()},
    group="Program control",
    operands=(special("N", Special.LABEL, low=0, high=255),),
    power=Power.CONTROL,
    source="System Manual, Jump",
)
def jump(b: Routine, label: int) -> None:
    """Go on at LBL N while S0 is 1. What is jumped over does not run: its timers stand still or lose time."""
    b.jump_to_label(label)


@define(
    {"LBL": ()},
    group="Program control",
    operands=(special("N", Special.LABEL, low=0, high=255),),
    power=Power.MARK,
    stack=_NONE,
    source="System Manual, Jump",
)
def label_here(b: Routine, label: int) -> None:
    """A place to jump to, in the same POU."""
    b.label(label)


@define(
    {"CALL": ()},
    group="Program control",
    operands=(special("SBR", Special.SBR), special("PARAMETERS", Special.PARAMETERS)),
    eno_off=(RunTimeError.CALL_TOO_DEEP, INDIRECT_ADDRESS),
    source="System Manual, Subroutines; document 003, section 6.3",
)
def call(b: Routine, number: int, parameters: tuple[Operand, ...]) -> None:
    """Call a subroutine while S0 is 1.

    It gets 64 bytes of L memory of its own, all 0 but for the IN and IN_OUT parameters; OUT and IN_OUT are
    copied back when it returns. Its logic stack starts with S0 on; the caller's is as it was afterwards. At most
    8 calls deep (from an interrupt routine: 1), else error 0008.
    """
    b.call_subroutine(number, parameters)


@define(
    {"CRET": ()},
    group="Program control",
    power=Power.CONTROL,
    source="System Manual, Subroutines",
)
def conditional_return(b: Routine) -> None:
    """Return from the subroutine while S0 is 1."""
    b.leave_if_powered()


@define(
    {"FOR": ()},
    group="Program control",
    operands=(InOut("INDX", INT), In("INIT", INT), In("FINAL", INT, place=True)),
    power=Power.CONTROL,
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, FOR and NEXT; document 003, section 6.2.1",
)
def for_loop(b: Routine, index: Place, first: Value, final: Place | Value) -> None:
    """While S0 is 1, run what stands up to NEXT once for each value of INDX from INIT to FINAL.

    INIT above FINAL: not at all. INDX and FINAL are looked at after each round, so the loop can change them; INIT
    is used once. Behind the loop INDX is one above FINAL (after 32767: -32768).
    """
    b.begin_loop(index, first, lambda: final if isinstance(final, Value) else b.load(final), b.valid)


@define(
    {"NEXT": ()},
    group="Program control",
    power=Power.MARK,
    stack=_NONE,
    source="System Manual, FOR and NEXT",
)
def next_loop(b: Routine) -> None:
    """End of a FOR loop. It sets the top of the logic stack to 1."""
    b.end_loop()


@define(
    {"LSCR": ()},
    group="SCR",
    operands=(In("S_BIT", BOOL, areas=_SEQUENCE, place=True),),
    power=Power.MARK,
    stack=StackUse(0, 1),
    source="System Manual, Sequence control relay; document 004, section 9.27",
)
def load_sequence(b: Routine, bit: Place) -> None:
    """Begin an SCR segment; it runs while its S bit is 1. The top of the logic stack becomes that bit.

    While the segment is not active it has no power: nothing in it runs, but its coils (=) are 0, its TON and TOF
    are cleared, its TONR stand still, and its edges and counter inputs see 0.
    """
    b.begin_segment(bit)


@define(
    {"SCRT": ()},
    group="SCR",
    operands=(InOut("S_BIT", BOOL, areas=_SEQUENCE),),
    power=Power.CONTROL,
    source="System Manual, Sequence control relay; document 004, section 9.27",
)
def transition(b: Routine, bit: Place) -> None:
    """Set the S bit and reset that of this segment, while S0 is 1. This segment still runs to its end."""
    segment, powered = b.segment, b.top
    with b.when(powered):
        if segment is not None:
            b.store(segment.bit, b.bit(False))
        b.store(bit, b.bit(True))


@define(
    {"SCRE": ()},
    group="SCR",
    power=Power.MARK,
    stack=_NONE,
    source="System Manual, Sequence control relay",
)
def end_sequence(b: Routine) -> None:
    """End of an SCR segment."""
    b.end_segment()


@define(
    {"CSCRE": ()},
    group="SCR",
    power=Power.CONTROL,
    source="System Manual, Sequence control relay",
)
def conditional_end(b: Routine) -> None:
    """Leave the SCR segment while S0 is 1; S bits do not change."""
    b.leave_segment()
