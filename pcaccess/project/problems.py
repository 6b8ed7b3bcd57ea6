"""Everything that can be wrong with a project file, with its code. Each has a page in docs/problems."""

from __future__ import annotations

from typing import Final

from pcaccess.problems import Kind, Problem, Register, Severity, Span

PROJECT: Final = Register(
    {
        "PRJ001": Kind("a file cannot be used"),
        "PRJ002": Kind("not YAML"),
        "PRJ003": Kind("a tab in the indentation"),
        "PRJ004": Kind("a YAML tag"),
        "PRJ005": Kind("an alias without end"),
        "PRJ006": Kind("a key used twice"),
        "PRJ007": Kind("an empty file"),
        "PRJ008": Kind("an unknown key"),
        "PRJ009": Kind("a missing key"),
        "PRJ010": Kind("a value of the wrong kind"),
        "PRJ011": Kind("an unknown word"),
        "PRJ012": Kind("a number out of range"),
        "PRJ013": Kind("not a duration"),
        "PRJ014": Kind("a name that cannot be used"),
        "PRJ015": Kind("an item ID used twice"),
        "PRJ016": Kind("a PLC address used twice"),
        "PRJ017": Kind("not an address"),
        "PRJ018": Kind("an address the CPU does not have"),
        "PRJ019": Kind("a type that does not fit the address"),
        "PRJ020": Kind("no such CPU"),
        "PRJ021": Kind("limits the wrong way round", Severity.WARNING),
        "PRJ022": Kind("limits that are no range"),
        "PRJ023": Kind("write limits without limits"),
        "PRJ024": Kind("a scaling that cannot be computed"),
        "PRJ025": Kind("keys that do not go together"),
        "PRJ026": Kind("read-only by nature", Severity.WARNING),
        "PRJ027": Kind("an endpoint open to the network"),
        "PRJ028": Kind("not an endpoint"),
        "PRJ029": Kind("a group names an item that does not exist"),
        "PRJ030": Kind("not a simulated value"),
        "PRJ031": Kind("not a TSAP"),
        "PRJ032": Kind("not served by this version", Severity.WARNING),
        "PRJ033": Kind("items of an unconnected PLC", Severity.WARNING),
        "PRJ034": Kind("an item that can never be good", Severity.WARNING),
        "PRJ035": Kind("a tag table without its columns"),
        "PRJ036": Kind("something in a tag table that items do not have", Severity.WARNING),
        "PRJ037": Kind("limits beyond what the type holds", Severity.WARNING),
    }
)


class Findings:
    """The problems found so far in one project."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []
        self.errors = 0
        self._told: set[tuple[str, Span, str]] = set()

    def report(
        self,
        code: str,
        span: Span,
        message: str,
        *,
        expected: str = "",
        nearest: str | None = None,
        related: tuple[tuple[Span, str], ...] = (),
    ) -> None:
        if (code, span, message) in self._told:
            return  # an alias uses the same place again
        self._told.add((code, span, message))
        problem = PROJECT.problem(code, span, message, expected=expected, nearest=nearest, related=related)
        self.problems.append(problem)
        self.errors += problem.is_error

    @property
    def warnings(self) -> list[Problem]:
        return [problem for problem in self.problems if not problem.is_error]
