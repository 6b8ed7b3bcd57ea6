"""Interrupts."""

from __future__ import annotations

from pcaccess.stl.define import Number, Power, Special, declare, special
from pcaccess.stl.errors import RunTimeError

_SOURCE = "System Manual, Interrupts; document 004, section 9.28"

attach = declare(
    {"ATCH": ()},
    group="Interrupt",
    operands=(special("INT", Special.INT), Number("EVNT", 0, 33)),
    eno_off=(RunTimeError.INPUT_INTERRUPT_TAKEN,),
    source=_SOURCE,
    doc="""Run the interrupt routine whenever the event occurs.""",
)
detach = declare(
    {"DTCH": ()},
    group="Interrupt",
    operands=(Number("EVNT", 0, 33),),
    source=_SOURCE,
    doc="""No routine for the event any more.""",
)
enable = declare(
    {"ENI": (True,), "DISI": (False,)},
    group="Interrupt",
    eno_off=(RunTimeError.NOT_IN_INTERRUPT,),
    source=_SOURCE,
    doc="""Let interrupt routines run (DISI: keep events in their queues).""",
)
conditional_return = declare(
    {"CRETI": ()},
    group="Interrupt",
    power=Power.CONTROL,
    source=_SOURCE,
    doc="""Return from the interrupt routine while S0 is 1.""",
)
