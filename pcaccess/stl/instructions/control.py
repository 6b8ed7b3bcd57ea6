"""Program control: jumps, loops, subroutines, sequence control relays, interrupts."""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.types import DataType
from pcaccess.stl.define import In, InOut, Power, Special, StackUse, declare, special
from pcaccess.stl.errors import INDIRECT_ADDRESS, RunTimeError

BOOL, BYTE, INT = DataType.BOOL, DataType.BYTE, DataType.INT
_SEQUENCE: Final = frozenset({Area.S})
_NONE: Final = StackUse(0, 0)

end = declare(
    {"END": ()},
    group="Program control",
    power=Power.CONTROL,
    source="System Manual, END",
    doc="""End the scan of the main program while S0 is 1.""",
)
end_always = declare(
    {"MEND": ()},
    group="Program control",
    power=Power.MARK,
    stack=_NONE,
    source="Programs for STEP 7-Micro/WIN before version 3",
    doc="""End of the main program, whatever the stack says.""",
)
stop = declare(
    {"STOP": ()},
    group="Program control",
    power=Power.CONTROL,
    source="System Manual, STOP; document 003, section 6.2.3",
    doc="""Put the CPU to STOP at the end of this scan.""",
)
watchdog = declare(
    {"WDR": ()},
    group="Program control",
    power=Power.BOX,
    source="System Manual, Watchdog reset; document 003, section 6.2.4",
    doc="""Give the scan its full time again.""",
)
diagnosis_led = declare(
    {"DLED": ()},
    group="Program control",
    operands=(In("IN", BYTE),),
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, Diagnosis LED",
    doc="""Switch the diagnosis LED on when IN is not 0.""",
)
jump = declare(
    {"JMP": ()},
    group="Program control",
    operands=(special("N", Special.LABEL, low=0, high=255),),
    power=Power.CONTROL,
    source="System Manual, Jump",
    doc="""Go on at LBL N while S0 is 1.""",
)
label = declare(
    {"LBL": ()},
    group="Program control",
    operands=(special("N", Special.LABEL, low=0, high=255),),
    power=Power.MARK,
    stack=_NONE,
    source="System Manual, Jump",
    doc="""A place to jump to.""",
)
call = declare(
    {"CALL": ()},
    group="Program control",
    operands=(special("SBR", Special.SBR), special("PARAMETERS", Special.PARAMETERS)),
    eno_off=(RunTimeError.CALL_TOO_DEEP, INDIRECT_ADDRESS),
    source="System Manual, Subroutines",
    doc="""Call a subroutine while S0 is 1.""",
)
conditional_return = declare(
    {"CRET": ()},
    group="Program control",
    power=Power.CONTROL,
    source="System Manual, Subroutines",
    doc="""Return from the subroutine while S0 is 1.""",
)
for_loop = declare(
    {"FOR": ()},
    group="Program control",
    operands=(InOut("INDX", INT), In("INIT", INT), In("FINAL", INT)),
    power=Power.CONTROL,
    eno_off=(INDIRECT_ADDRESS,),
    source="System Manual, FOR and NEXT; document 003, section 6.2.1",
    doc="""Run what stands up to NEXT once for each value of INDX from INIT to FINAL.""",
)
next_loop = declare(
    {"NEXT": ()},
    group="Program control",
    power=Power.MARK,
    stack=_NONE,
    source="System Manual, FOR and NEXT",
    doc="""End of a FOR loop.""",
)
load_sequence = declare(
    {"LSCR": ()},
    group="SCR",
    operands=(In("S_BIT", BOOL, areas=_SEQUENCE),),
    power=Power.MARK,
    stack=StackUse(0, 1),
    source="System Manual, Sequence control relay",
    doc="""Begin an SCR segment; it is active while its S bit is 1.""",
)
transition = declare(
    {"SCRT": ()},
    group="SCR",
    operands=(InOut("S_BIT", BOOL, areas=_SEQUENCE),),
    power=Power.CONTROL,
    source="System Manual, Sequence control relay",
    doc="""Set the S bit and reset that of this segment, while S0 is 1.""",
)
end_sequence = declare(
    {"SCRE": ()},
    group="SCR",
    power=Power.MARK,
    stack=_NONE,
    source="System Manual, Sequence control relay",
    doc="""End of an SCR segment.""",
)
conditional_end = declare(
    {"CSCRE": ()},
    group="SCR",
    power=Power.CONTROL,
    source="System Manual, Sequence control relay",
    doc="""Leave the SCR segment while S0 is 1.""",
)
