"""LLVM text to an object file, and an object file into this process. The only module that names llvmlite.

An object file has no address of this process in it, so that another process can make it (``optimise``).

Errors:   :class:`Unavailable` when there is no llvmlite for this machine, or LLVM does not work on it.
"""

from __future__ import annotations

import functools
import itertools
import os
import platform
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import Any, Final

_RELOCATIONS: Final = {"codemodel": "small", "reloc": "pic"}
_WINDOWS: Final = {"codemodel": "jitdefault", "reloc": "default"}
"""LLVM links its own ELF objects on Windows, with addresses of any distance."""
_numbers = itertools.count()


class Unavailable(Exception):
    """No compiled code on this machine; the message says why."""


class Tier(Enum):
    """How much LLVM does. The value is the level of its code generator."""

    QUICK = 0
    """No optimisation: ready at once."""
    OPTIMISED = 2
    """Half the time for a scan, twenty times the time to compile."""


@functools.cache
def _binding() -> Any:
    try:
        from llvmlite import binding  # a third of a second and 47 MB: only where something is compiled

        binding.initialize_native_target()
        binding.initialize_native_asmprinter()
    except ImportError as error:
        raise Unavailable(f"llvmlite is not installed ({platform.machine()}): {error}") from error
    except (OSError, RuntimeError) as error:
        raise Unavailable(f"LLVM does not work here ({platform.machine()}): {error}") from error
    return binding


def why_unavailable() -> str | None:
    """None when programs can be compiled here, else the reason."""
    try:
        _binding()
    except Unavailable as error:
        return str(error)
    return None


def _target_machine(level: int) -> Any:
    binding = _binding()
    options = _WINDOWS if os.name == "nt" else _RELOCATIONS
    features = binding.get_host_cpu_features().flatten()
    target = binding.Target.from_default_triple()
    return target.create_target_machine(
        cpu=binding.get_host_cpu_name(), features=features, opt=level, jit=True, **options
    )


def object_code(text: str, tier: Tier) -> bytes:
    """Compile LLVM text for this machine. RuntimeError: the text is wrong, which is our own mistake."""
    binding = _binding()
    machine = _target_machine(tier.value)
    module = binding.parse_assembly(text, binding.create_context())
    if tier is Tier.OPTIMISED:
        _optimise(module, machine)
    return bytes(machine.emit_object(module))


def _optimise(module: Any, machine: Any) -> None:
    """Few passes: what is left to win is in the code generator (docs/decisions/2026-11-22-compiler.md)."""
    binding = _binding()
    passes = binding.create_new_module_pass_manager()
    passes.add_always_inliner_pass()
    passes.add_sroa_pass()
    passes.add_simplify_cfg_pass()
    passes.add_instruction_combine_pass()
    passes.add_simplify_cfg_pass()
    passes.run(module, binding.create_pass_builder(machine, binding.create_pipeline_tuning_options(speed_level=1)))


@dataclass(slots=True)
class Loaded:
    """Machine code in this process. It goes when nobody holds this object."""

    addresses: dict[str, int]
    _tracker: Any
    _jit: Any


def load(code: bytes, symbols: Iterable[str]) -> Loaded:
    """Link an object file into this process and find the ``symbols`` it exports."""
    binding = _binding()
    library = binding.JITLibraryBuilder().add_object_img(code).add_current_process()
    names = tuple(symbols)
    for name in names:
        library.export_symbol(name)
    jit = binding.create_lljit_compiler(_target_machine(0), use_jit_link=os.name != "nt")
    tracker = library.link(jit, f"program{next(_numbers)}")
    return Loaded({name: int(tracker[name]) for name in names}, tracker, jit)
