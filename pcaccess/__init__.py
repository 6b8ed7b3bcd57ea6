"""pcaccess: S7-200 PC Access, again: an OPC UA gateway and soft-PLC."""

from __future__ import annotations

from typing import Final

__version__: Final = "0.1.0"
