"""Engineering limits and scalings of items: whether they are a range, and one that the item's type can have.

Errors:   reported. Limits that a type never reaches do no harm and are warnings; those that would refuse every write
          are mistakes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container

from pcaccess.problems import Span
from pcaccess.project.model import Scaling, WriteLimits
from pcaccess.project.problems import Findings
from pcaccess.s7200.types import DataType

Where = Callable[[str], Span]
"""From a key (``address``) to the place of its value."""


def read_limits(
    low: float | None, high: float | None, where: Where, broken: Container[str], findings: Findings
) -> tuple[float, float] | None:
    """Both ends in their order; None for none. ``broken``: keys already reported and taken out."""
    if (low is None and high is None) or (low == 0 and high == 0) or "low" in broken or "high" in broken:
        return None
    if low is None or high is None:
        there, missing = ("high", "low") if low is None else ("low", "high")
        findings.report("PRJ022", where(there), f"{there} without {missing}; a range has both ends")
        return None
    if low == high:
        message = f"high and low are both {high:g}"
        findings.report("PRJ022", where("high"), message, expected="a range, or both left out")
        return None
    if low > high:
        findings.report("PRJ021", where("high"), f"high {high:g} is below low {low:g}; taken the other way round")
        low, high = high, low
    return low, high


def check_limits(
    low: float | None,
    high: float | None,
    data_type: DataType,
    write_limits: WriteLimits,
    where: Where,
    findings: Findings,
) -> bool:
    """Whether an item of that type can have these limits, as they are written."""
    if not data_type.is_numeric:
        findings.report("PRJ025", where("high"), f"high and low belong to numbers; this is {data_type.name}")
        return False
    ends = {key: value for key, value in (("low", low), ("high", high)) if value is not None}
    bottom, top = min(ends.values()), max(ends.values())
    if write_limits is not WriteLimits.NONE and not _holds_one(data_type, bottom, top):
        message = f"no {data_type.name} lies between {bottom:g} and {top:g}, so that nothing could be written"
        findings.report("PRJ022", where("high"), message, expected=_range(data_type))
        return False
    for key, value in ends.items():
        if not _fits(data_type, value):
            findings.report("PRJ037", where(key), _beyond(key, value, data_type), expected=_range(data_type))
    return True


def check_scaling(scaling: Scaling, raw_type: DataType, span: Span, findings: Findings) -> None:
    """Ends of a scaling that the type in the PLC, or the REAL that clients see, never reaches."""
    raw, scaled = (scaling.raw_low, scaling.raw_high), (scaling.scaled_low, scaling.scaled_high)
    other = _alike(raw_type, raw)
    expected = _range(raw_type) + (f", or raw_type: {other.name}" if other is not None else "")
    for end in raw:
        if not _fits(raw_type, end):
            findings.report("PRJ037", span, _beyond("raw", end, raw_type), expected=expected)
    for end in scaled:
        if not _fits(DataType.REAL, end):
            findings.report("PRJ037", span, _beyond("scaled", end, DataType.REAL), expected=_range(DataType.REAL))


def _fits(data_type: DataType, *values: float) -> bool:
    return all(data_type.lowest <= value <= data_type.highest for value in values)


def _holds_one(data_type: DataType, low: float, high: float) -> bool:
    """Whether the type has a value from ``low`` to ``high``."""
    low, high = max(low, data_type.lowest), min(high, data_type.highest)
    return low <= high and (data_type is DataType.REAL or math.ceil(low) <= math.floor(high))


def _alike(data_type: DataType, values: tuple[float, ...]) -> DataType | None:
    """Another integer type of the same size, which holds the values."""
    others = (t for t in DataType if t.is_integer and t.size == data_type.size and t is not data_type)
    return next((t for t in others if _fits(t, *values)), None)


def _beyond(key: str, value: float, data_type: DataType) -> str:
    article = "an" if data_type is DataType.INT else "a"
    return f"{key} {value:.9g} is beyond what {article} {data_type.name} holds"


def _range(data_type: DataType) -> str:
    return f"{data_type.lowest:.12g} to {data_type.highest:.12g}"
