"""Where a CPU keeps what no address reaches: behind the areas, in the same buffer.

A CPU is one buffer of ``BUFFER_SIZE`` bytes: the areas (``pcaccess.s7200.memory``) up to ``MEMORY_SIZE``, then
these cells. So a CPU can be copied, compared, saved and shared whole. All numbers are big-endian.

Units:    offsets and sizes in bytes.
Not here: what the cells mean in time (``pcaccess.plc.timers``, ``pcaccess.plc.cpu``).
"""

from __future__ import annotations

from enum import IntEnum
from typing import Final

from pcaccess.s7200.memory import MEMORY_SIZE

MAX_EDGES: Final = 256
"""EU and ED instructions in one program (System Manual, Positive and negative transition)."""
MAX_CALL_DEPTH: Final = 8
"""Subroutines nested below the main program."""
FRAME_SIZE: Final = 64
"""Bytes of L memory each running POU has."""
STACK_LEVELS: Final = 9

PHYSICAL_INPUTS: Final = MEMORY_SIZE
"""16 bytes: the input terminals, bit for bit as I memory."""
PHYSICAL_OUTPUTS: Final = PHYSICAL_INPUTS + 16
"""16 bytes: the output terminals."""
LOGIC_STACK: Final = PHYSICAL_OUTPUTS + 16
"""Word: the logic stack when OB1 ended, bit n is level n."""
ENO: Final = LOGIC_STACK + 2
"""Byte: ENO when OB1 ended."""
FIRST_SCAN: Final = ENO + 1
"""Byte: 1 while edges only take over the state: in the first scan after the change to RUN or to a new program."""
ATTENTION: Final = FIRST_SCAN + 1
"""Byte: not 0 when a poll has something to do."""
CALL_DEPTH: Final = ATTENTION + 1
"""Byte: frames that are saved in ``FRAMES``."""
CALL_LIMIT: Final = CALL_DEPTH + 1
"""Byte: as many frames may be saved while what runs now runs."""
IN_INTERRUPT: Final = CALL_LIMIT + 1
"""Byte: 1 while an interrupt routine runs."""
TICKS_100: Final = IN_INTERRUPT + 1
"""Double word: whole 100 ms between the starts of the scan before and of this one."""
MILLISECONDS: Final = TICKS_100 + 4
"""Double word: the millisecond counter of BITIM."""
BUDGET: Final = MILLISECONDS + 4
"""Double word: backward jumps and calls left until the watchdog wants to know."""
ZEROS: Final = BUDGET + 4
"""8 bytes that are always 0: what a contact reads where its pointer names nothing."""
EDGES: Final = ZEROS + 8
"""One byte for each EU or ED: what S0 was before."""
COUNT_UP: Final = EDGES + MAX_EDGES
"""One byte for each counter: what its CU input was before."""
COUNT_DOWN: Final = COUNT_UP + 256
TIMER_STATE: Final = COUNT_DOWN + 256
"""One byte for each timer, a :class:`TimerState`."""
TIMER_PRESET: Final = TIMER_STATE + 256
"""One word for each timer: PT as the instruction last said it."""
FRAMES: Final = TIMER_PRESET + 512
"""L memory of the POUs that wait for the one that runs."""
MAX_FRAMES: Final = 2 * (MAX_CALL_DEPTH + 1)
BUFFER_SIZE: Final = (FRAMES + MAX_FRAMES * FRAME_SIZE + 15) // 16 * 16


class TimerState(IntEnum):
    """What a timer does between two executions of its instruction."""

    IDLE = 0
    ON_DELAY = 1
    """TON or TONR with its input on: the value counts up, the bit comes at PT."""
    OFF_READY = 2
    """TOF with its input on: the next fall starts it."""
    OFF_DELAY = 3
    """TOF after the fall: the value counts up to PT, then the bit goes."""
