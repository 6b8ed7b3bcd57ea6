"""Kepware tag tables (and our own export of them) as items of one PLC."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pcaccess.problems import Severity
from pcaccess.project.importers.draft import Draft, DraftItem, DraftPlc
from pcaccess.project.problems import Findings
from pcaccess.project.tagtable import read_tag_text
from pcaccess.project.textfile import TextError


def read_kepware(path: Path, text: str, *, link: str, plc: str) -> Draft:
    """Rows that cannot be an item are left out and told; a table without its columns is a TextError."""
    findings = Findings()
    draft = Draft(str(path), f"the tag table {path.name}")
    found = DraftPlc(link, plc)
    for row in read_tag_text(text, str(path), findings):
        found.items.append(DraftItem(tuple(row.folders), row.text, row.span))
    for problem in findings.problems:
        if problem.code == "PRJ035":
            raise TextError(f"{problem.message}; expected {problem.expected}", problem.span.line)
        message = f"{problem.message}; left out" if problem.is_error else problem.message
        draft.warnings.append(replace(problem, severity=Severity.WARNING, message=message))
    draft.left_out = len({problem.span.line for problem in findings.problems if problem.is_error})
    draft.plcs.append(found)
    return draft
