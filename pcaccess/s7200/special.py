"""Special memory without a CPU behind it: which SM bytes are still true.

A memory-only PLC has no scan, so clocks, error bits and status bytes have nobody who keeps them; SM0.0, the CPU's
identity and the registers that only hold what was written are true of memory alone.

Source:   source document 000, appendix C (tables C-1 to C-19).
"""

from __future__ import annotations

from typing import Final

from pcaccess.s7200.address import Address, Area, Width
from pcaccess.s7200.cpu import CpuModel
from pcaccess.s7200.memory import AREA_START

LAST_READ_ONLY_SM: Final = 29
"""SMB0..SMB29 cannot be written."""

_MADE_BY_CPU: Final = frozenset(
    {
        *range(6),  # scan clocks, instruction flags, freeport, queues, I/O errors
        *range(22, 28),  # scan times
        *(36, 46, 56, 136, 146, 156),  # high-speed counter status
        *(66, 76, 166, 176),  # pulse output status and active profile step
        *(86, 186),  # receive message status
        *(98, 99),  # expansion bus error count
    }
)


def true_of_memory_alone(address: Address, size: int | None = None) -> bool:
    """Whether an SM address means anything while no CPU runs. Addresses of other areas always do.

    ``size``: bytes of one element where it is not the address's own width.
    """
    if address.area is not Area.SM:
        return True
    if address.width is Width.BIT:
        last = address.offset + (address.bit + address.count - 1) // 8
        if (address.offset, address.bit, address.count) == (0, 0, 1):
            return True
    else:
        last = address.offset + (size or address.width.size) * address.count - 1
    return _MADE_BY_CPU.isdisjoint(range(address.offset, last + 1))


def power_up(memory: bytearray | memoryview, cpu: CpuModel) -> None:
    """Write what SM holds from power-up on: SM0.0 and the CPU's identity, no expansion modules."""
    sm = AREA_START[Area.SM]
    memory[sm] |= 1
    memory[sm + 6] = cpu.id_register << 4
    for module in range(7):
        memory[sm + 8 + 2 * module] = 0xFF  # bit 7 is "not present" (table C-8)
