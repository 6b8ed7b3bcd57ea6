"""CPU models 221 to 226XM: which addresses exist, and how much of each thing there is.

Source:   source document 002, table A-4 (newest hardware generation); source document 000, CPU specifications,
          and document 004, table 9.3 (generation 1). AI/AQ of the CPU 221: table A-4 says none, the older
          table has AIW0..AIW30; SM sizes from document 004. HC: the manual's register map numbers HSC0..HSC5
          on every model; which of them a model can run is the CPU's business, not the address's.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final

from pcaccess.s7200.address import Address, AddressError, Area, Width

GENERATIONS: Final = (1, 2)


class CpuError(ValueError):
    """No such CPU model or generation."""


@dataclass(frozen=True, slots=True)
class CpuModel:
    """One CPU model of one hardware generation."""

    name: str
    generation: int
    sizes: Mapping[Area, int] = field(repr=False)
    """Bytes of byte-addressed and analog areas, elements of T, C, HC, AC."""
    inputs: int = 0
    """Digital inputs on the CPU itself."""
    outputs: int = 0
    analog_inputs: int = 0
    analog_outputs: int = 0
    ports: int = 1
    program_bytes: int = 0
    max_modules: int = 0
    id_register: int = 0
    """SMB6 bits 4..7 (document 000, table C-7; models it does not list use the value of their family)."""

    def check(self, address: Address, *, size: int | None = None) -> None:
        """Raise AddressError when some of the address lies beyond this model.

        ``size``: bytes of one element where the address does not say it (a STRING at VB100).
        """
        limit = self.sizes[address.area]
        if limit == 0:
            raise AddressError(f"{address}: a {self.name} has no {_AREA_WORDS[address.area]}")
        if address.area.is_numbered:
            last = address.offset + address.count - 1
        elif address.width is Width.BIT:
            last = address.offset + (address.bit + address.count - 1) // 8
        else:
            last = address.offset + address.count * (size or address.width.size) - 1
        if last >= limit:
            raise AddressError(f"{address}: a {self.name} has {self.range_text(address.area)}")

    def range_text(self, area: Area) -> str:
        """For messages: ``VB0 to VB2047``, ``T0 to T255``, ``AIW0 to AIW62``."""
        size = self.sizes[area]
        if area.is_numbered:
            return f"{area.value}0 to {area.value}{size - 1}"
        if area.is_analog:
            return f"{area.value}W0 to {area.value}W{size - 2}"
        return f"{area.value}B0 to {area.value}B{size - 1}"


_AREA_WORDS: Final = {
    Area.I: "inputs",
    Area.Q: "outputs",
    Area.V: "V memory",
    Area.M: "M memory",
    Area.SM: "SM memory",
    Area.S: "S memory",
    Area.L: "L memory",
    Area.T: "timers",
    Area.C: "counters",
    Area.HC: "high-speed counters",
    Area.AC: "accumulators",
    Area.AI: "analog inputs",
    Area.AQ: "analog outputs",
}


def _sizes(v: int, sm: int, analog_words: int) -> Mapping[Area, int]:
    return MappingProxyType(
        {
            Area.I: 16,
            Area.Q: 16,
            Area.V: v,
            Area.M: 32,
            Area.SM: sm,
            Area.S: 32,
            Area.L: 64,
            Area.T: 256,
            Area.C: 256,
            Area.HC: 6,
            Area.AC: 4,
            Area.AI: 2 * analog_words,
            Area.AQ: 2 * analog_words,
        }
    )


_MODELS: Final = (
    CpuModel("CPU 221", 2, _sizes(2048, 180, 0), 6, 4, 0, 0, 1, 4096, 0, 0b0110),
    CpuModel("CPU 222", 2, _sizes(2048, 300, 16), 8, 6, 0, 0, 1, 4096, 2, 0b0000),
    CpuModel("CPU 224", 2, _sizes(8192, 550, 32), 14, 10, 0, 0, 1, 12288, 7, 0b0010),
    CpuModel("CPU 224XP", 2, _sizes(10240, 550, 32), 14, 10, 2, 1, 2, 16384, 7, 0b0010),
    CpuModel("CPU 226", 2, _sizes(10240, 550, 32), 24, 16, 0, 0, 2, 24576, 7, 0b1001),
    CpuModel("CPU 226XM", 2, _sizes(10240, 550, 32), 24, 16, 0, 0, 2, 24576, 7, 0b1001),
    CpuModel("CPU 221", 1, _sizes(2048, 180, 16), 6, 4, 0, 0, 1, 4096, 0, 0b0110),
    CpuModel("CPU 222", 1, _sizes(2048, 300, 16), 8, 6, 0, 0, 1, 4096, 2, 0b0000),
    CpuModel("CPU 224", 1, _sizes(5120, 550, 32), 14, 10, 0, 0, 1, 8192, 7, 0b0010),
    CpuModel("CPU 226", 1, _sizes(5120, 550, 32), 24, 16, 0, 0, 2, 8192, 7, 0b1001),
    CpuModel("CPU 226XM", 1, _sizes(10240, 550, 32), 24, 16, 0, 0, 2, 16384, 7, 0b1001),
)
CPU_MODELS: Final[Mapping[tuple[str, int], CpuModel]] = MappingProxyType({(m.name, m.generation): m for m in _MODELS})
CPU_NAMES: Final = tuple(dict.fromkeys(m.name for m in _MODELS))
DEFAULT_CPU: Final = "CPU 226"


def cpu_model(name: str = DEFAULT_CPU, generation: int = 2) -> CpuModel:
    """Find a model by name: ``CPU 224``, ``cpu224`` and ``224`` are the same.

    Raises CpuError naming the nearest model, or saying that the generation never had it.
    """
    plain = "".join(name.upper().split()).removeprefix("CPU")
    found = next((n for n in CPU_NAMES if n.removeprefix("CPU ") == plain), None)
    if found is None:
        near = difflib.get_close_matches(f"CPU {plain}", CPU_NAMES, n=1, cutoff=0.6)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise CpuError(f"there is no {name!r}; the models are {', '.join(CPU_NAMES)}{hint}")
    if generation not in GENERATIONS:
        raise CpuError(f"generation {generation} does not exist; it is 1 (before 2004) or 2")
    try:
        return CPU_MODELS[found, generation]
    except KeyError:
        raise CpuError(f"{found} exists only in generation 2") from None
