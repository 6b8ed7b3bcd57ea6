"""Faults that somebody could make in what executes programs, for ``tools/mutants.py``."""

from faults.catalogue import ALL

__all__ = ["ALL"]
