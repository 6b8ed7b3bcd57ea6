"""Quality codes: OPC DA numbers, the Automation numbers of the VB samples, and OPC UA StatusCodes, both ways.

A code is 16 bits: vendor byte, then ``QQSSSSLL``. The number a user sees is the low byte without its limit bits.

Source:   OPC DA 2.05, quality flags; OPC UA Part 8, COM mapping of qualities; source document 004, section 9.29,
          for the Automation column (there 13 for DEVICE_FAILURE is 12 with the low-limit bit).
"""

from __future__ import annotations

from enum import Enum, IntEnum
from types import MappingProxyType
from typing import Final


class Limit(IntEnum):
    """Limit bits of a code: the value is stuck at a bound."""

    NONE = 0
    LOW = 1
    HIGH = 2
    CONSTANT = 3


class Quality(Enum):
    """``(DA code, Automation code, UA StatusCode)``."""

    BAD = (0, 0, 0x80000000)
    CONFIG_ERROR = (4, 4, 0x80890000)
    NOT_CONNECTED = (8, 8, 0x808A0000)
    DEVICE_FAILURE = (12, 12, 0x808B0000)
    SENSOR_FAILURE = (16, 16, 0x808C0000)
    LAST_KNOWN = (20, 20, 0x808D0000)
    COMM_FAILURE = (24, 24, 0x80310000)
    OUT_OF_SERVICE = (28, 28, 0x808D0000)
    WAITING_FOR_INITIAL_DATA = (32, 32, 0x80320000)
    UNCERTAIN = (64, 64, 0x40000000)
    LAST_USABLE = (68, 132, 0x40900000)
    SENSOR_CAL = (80, 144, 0x40930000)
    EGU_EXCEEDED = (84, 148, 0x40940000)
    SUB_NORMAL = (88, 152, 0x40950000)
    GOOD = (192, 192, 0x00000000)
    LOCAL_OVERRIDE = (216, 216, 0x00960000)

    @property
    def code(self) -> int:
        """The OPC DA code, without limit bits."""
        return self.value[0]

    @property
    def automation_code(self) -> int:
        """The number the Automation façade hands out."""
        return self.value[1]

    def status(self, limit: Limit = Limit.NONE) -> int:
        """UA StatusCode; a limit sets InfoType DataValue and the limit bits (OPC UA Part 4, StatusCode bits)."""
        return self.value[2] | (INFO_TYPE_DATA_VALUE | limit << 8 if limit else 0)

    @property
    def status_name(self) -> str:
        """The UA StatusCode's name in the specification."""
        return _STATUS_NAMES[self.value[2]]

    @property
    def is_good(self) -> bool:
        return self.code >= 192


INFO_TYPE_DATA_VALUE: Final = 0x0400
_STATUS_NAMES: Final = MappingProxyType(
    {
        0x00000000: "Good",
        0x00960000: "GoodLocalOverride",
        0x40000000: "Uncertain",
        0x40900000: "UncertainLastUsableValue",
        0x40930000: "UncertainSensorNotAccurate",
        0x40940000: "UncertainEngineeringUnitsExceeded",
        0x40950000: "UncertainSubNormal",
        0x80000000: "Bad",
        0x80310000: "BadNoCommunication",
        0x80320000: "BadWaitingForInitialData",
        0x80890000: "BadConfigurationError",
        0x808A0000: "BadNotConnected",
        0x808B0000: "BadDeviceFailure",
        0x808C0000: "BadSensorFailure",
        0x808D0000: "BadOutOfService",
    }
)
_LIMIT_BITS: Final = 0x0300

BY_CODE: Final = MappingProxyType({q.code: q for q in Quality})
_BY_AUTOMATION_CODE: Final = MappingProxyType({q.automation_code: q for q in Quality})
# OUT_OF_SERVICE and LAST_KNOWN share a StatusCode; the mapping back takes the one the UA name says.
_BY_STATUS: Final = MappingProxyType(
    {**{q.value[2]: q for q in Quality}, Quality.OUT_OF_SERVICE.value[2]: Quality.OUT_OF_SERVICE}
)
_SEVERITIES: Final = (Quality.GOOD, Quality.UNCERTAIN, Quality.BAD, Quality.BAD)
_MAJOR: Final = (Quality.BAD, Quality.UNCERTAIN, Quality.BAD, Quality.GOOD)


def split_code(code: int) -> tuple[Quality, Limit]:
    """Quality and limit of a DA or Automation code, limit bits allowed (13 is DEVICE_FAILURE at its low limit).

    A sub-status no table knows is its major quality (OPC DA: a client that does not know a sub-status uses that).
    Raises ValueError for a number that is not a quality at all (negative or over 16 bits).
    """
    if not 0 <= code <= 0xFFFF:
        raise ValueError(f"{code} is not a quality code (0 to 65535)")
    plain = code & 0xFC
    known = BY_CODE.get(plain) or _BY_AUTOMATION_CODE.get(plain)
    return known or _MAJOR[plain >> 6], Limit(code & 3)


def quality_text(code: int) -> str:
    """``192`` is ``GOOD``, ``13`` is ``DEVICE_FAILURE (low limit)``; a number that is no code is ``UNKNOWN (n)``."""
    try:
        quality, limit = split_code(code)
    except ValueError:
        return f"UNKNOWN ({code})"
    return quality.name if limit is Limit.NONE else f"{quality.name} ({limit.name.lower()} limit)"


def from_status(status: int) -> tuple[Quality, Limit]:
    """Quality and limit bits of a UA StatusCode; an unknown one is GOOD, UNCERTAIN or BAD by its severity."""
    limit = Limit((status & _LIMIT_BITS) >> 8) if status & INFO_TYPE_DATA_VALUE else Limit.NONE
    quality = _BY_STATUS.get(status & 0xFFFF0000) or _SEVERITIES[status >> 30]
    return quality, limit
