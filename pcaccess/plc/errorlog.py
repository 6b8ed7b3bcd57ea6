"""Run-time and fatal errors of a CPU, each counted once for each place in the program."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pcaccess.stl.errors import FatalError, RunTimeError
from pcaccess.stl.ir import Place


@dataclass(slots=True)
class ErrorRecord:
    """One error at one place."""

    code: RunTimeError | FatalError
    place: Place | None
    """None for an error of the CPU as a whole."""
    first: float
    """When it happened first, in milliseconds of the CPU's time."""
    last: float
    count: int = 1

    @property
    def is_fatal(self) -> bool:
        return isinstance(self.code, FatalError)

    def __str__(self) -> str:
        """``crossing.awl:12:1: 0006 indirect addressing error (MAIN (OB1), network 3)``"""
        if self.place is None:
            return f"{self.code} {self.code.text}"
        where = f"{self.place.pou}, network {self.place.network}"
        return f"{self.place.span}: {self.code} {self.code.text} ({where})"

    def as_json(self) -> dict[str, Any]:
        data: dict[str, Any] = {"code": str(self.code), "text": self.code.text, "fatal": self.is_fatal}
        data |= {"first": self.first, "last": self.last, "count": self.count}
        if self.place is not None:
            span = self.place.span
            data |= {"pou": self.place.pou, "network": self.place.network}
            data |= {"file": span.file, "line": span.line, "column": span.column}
        return data


class ErrorLog:
    """What went wrong since the last change to RUN, in the order in which it happened first."""

    def __init__(self) -> None:
        self._records: dict[tuple[int, Place | None, bool], ErrorRecord] = {}

    def add(self, code: RunTimeError | FatalError, place: Place | None, now: float) -> ErrorRecord:
        key = (int(code), place, isinstance(code, FatalError))
        record = self._records.get(key)
        if record is None:
            record = self._records[key] = ErrorRecord(code, place, now, now)
        else:
            record.count += 1
            record.last = now
        return record

    def clear(self) -> None:
        self._records.clear()

    def records(self) -> list[ErrorRecord]:
        return list(self._records.values())

    @property
    def fatal(self) -> ErrorRecord | None:
        return next((r for r in self._records.values() if r.is_fatal), None)
