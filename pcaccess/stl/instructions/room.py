"""Whether several values in a row exist."""

from __future__ import annotations

from pcaccess.stl.builder import Place
from pcaccess.stl.ir_values import Value
from pcaccess.stl.routine import Routine


def room(b: Routine, place: Place, size: Value) -> Value:
    """1 when ``size`` (I32) bytes from the place on lie in its area of this CPU model."""
    if place.pointer is not None:
        return b.ge(b.check_pointer(place.pointer, size), 0)
    assert place.area is not None
    element = 2 if place.area.is_numbered else 1
    return b.le(size, (b.model.sizes[place.area] - place.offset) * element)
