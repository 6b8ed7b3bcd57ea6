"""L memory of POUs: 64 bytes each, of which only the running one's lie in area L."""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.address import Area
from pcaccess.s7200.memory import AREA_START
from pcaccess.stl.layout import CALL_DEPTH, FRAME_SIZE, FRAMES

_L_START: Final = AREA_START[Area.L]
_L_END: Final = _L_START + FRAME_SIZE


def push_frame(memory: bytearray | memoryview) -> None:
    """Save L memory and clear it (``ir.PushFrame``)."""
    depth = memory[CALL_DEPTH]
    saved = FRAMES + depth * FRAME_SIZE
    memory[saved : saved + FRAME_SIZE] = bytes(memory[_L_START:_L_END])
    memory[_L_START:_L_END] = bytes(FRAME_SIZE)
    memory[CALL_DEPTH] = depth + 1


def pop_frame(memory: bytearray | memoryview) -> None:
    """Bring the frame that was saved last back to L memory (``ir.PopFrame``)."""
    depth = memory[CALL_DEPTH] - 1
    saved = FRAMES + depth * FRAME_SIZE
    memory[_L_START:_L_END] = bytes(memory[saved : saved + FRAME_SIZE])
    memory[CALL_DEPTH] = depth


def unwind_to(memory: bytearray | memoryview, depth: int) -> None:
    """Give up all frames saved since there were ``depth``."""
    if memory[CALL_DEPTH] > depth:
        memory[CALL_DEPTH] = depth + 1
        pop_frame(memory)
