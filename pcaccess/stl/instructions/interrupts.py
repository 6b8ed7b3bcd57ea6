"""Interrupts: attach, detach, enable, return."""

from __future__ import annotations

from typing import Final

from pcaccess.stl.define import Number, Power, Special, define, special
from pcaccess.stl.errors import RunTimeError
from pcaccess.stl.ir_values import Effects
from pcaccess.stl.routine import Routine
from pcaccess.stl.runtime import Outcome, Runtime

_SOURCE: Final = "System Manual, Interrupts; document 004, section 9.28"


@define(
    {"ATCH": ()},
    group="Interrupt",
    operands=(special("INT", Special.INT), Number("EVNT", 0, 33)),
    eno_off=(RunTimeError.INPUT_INTERRUPT_TAKEN,),
    source=_SOURCE,
)
def attach(b: Routine, routine: int, event: int) -> None:
    """Run the interrupt routine whenever the event occurs.

    An event has one routine, a routine may serve several events. The intervals of the timed interrupts (SMB34,
    SMB35) are taken over here.
    """
    effects = Effects(errors=(RunTimeError.INPUT_INTERRUPT_TAKEN,))
    b.cold(attach_routine, static=(event, routine), effects=effects)


def attach_routine(runtime: Runtime, event: int, routine: int) -> Outcome:
    return runtime.attach(event, routine)


@define(
    {"DTCH": ()},
    group="Interrupt",
    operands=(Number("EVNT", 0, 33),),
    source=_SOURCE,
)
def detach(b: Routine, event: int) -> None:
    """No routine for the event any more."""
    b.cold(detach_event, static=(event,), effects=Effects())


def detach_event(runtime: Runtime, event: int) -> Outcome:
    return runtime.detach(event)


@define(
    {"ENI": (True,), "DISI": (False,)},
    group="Interrupt",
    eno_off=(RunTimeError.NOT_IN_INTERRUPT,),
    source=_SOURCE,
)
def enable(b: Routine, on: bool) -> None:
    """Let interrupt routines run (DISI: keep events in their queues until ENI).

    After the change to RUN interrupts are off. In an interrupt routine it is error 0004.
    """
    b.cold(enable_interrupts, static=(on,), effects=Effects(errors=(RunTimeError.NOT_IN_INTERRUPT,)))


def enable_interrupts(runtime: Runtime, on: bool) -> Outcome:
    return runtime.enable_interrupts(on)


@define(
    {"CRETI": ()},
    group="Interrupt",
    power=Power.CONTROL,
    source=_SOURCE,
)
def conditional_return(b: Routine) -> None:
    """Return from the interrupt routine while S0 is 1."""
    b.leave_if_powered()
