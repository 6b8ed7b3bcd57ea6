"""``pcaccess import``: whatever the file is, to the text of a project file that has been read back and is right.

Errors:   ProblemError when the file is none of the known kinds; nothing is written then.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from pcaccess.problems import Problem, ProblemError, Span
from pcaccess.project.importers.draft import Draft, clean
from pcaccess.project.importers.kepware import read_kepware
from pcaccess.project.importers.pca import SIGNATURE, read_pca
from pcaccess.project.importers.symbols import read_symbols
from pcaccess.project.importers.write import yaml_of
from pcaccess.project.load import load_text
from pcaccess.project.model import Folder, Project
from pcaccess.project.problems import Findings
from pcaccess.project.tagtable import has_tag_columns
from pcaccess.project.textfile import MAX_SIZE, TextError, decode_table, read_bytes


class Kind(Enum):
    """What is imported; AUTO looks into the file."""

    AUTO = "auto"
    PCA = "pca"
    SYMBOLS = "symbols"
    KEPWARE = "kepware"


@dataclass(frozen=True, slots=True)
class Counts:
    plcs: int
    folders: int
    items: int
    left_out: int
    """Items of the source that no S7-200 could have."""


@dataclass(frozen=True, slots=True)
class ImportResult:
    kind: Kind
    yaml_text: str
    warnings: tuple[Problem, ...]
    counts: Counts


def import_file(
    source: Path,
    *,
    kind: Kind = Kind.AUTO,
    link: str = "MicroWin",
    plc: str = "NewPLC",
    folder: str | None = None,
    encoding: str | None = None,
    max_size: int = MAX_SIZE,
    target: str = "items.yaml",
) -> ImportResult:
    """The project that ``source`` describes.

    ``link``, ``plc`` and ``folder`` name what symbol tables and tag tables do not say; a symbol table goes into a
    folder of its file's name unless ``folder`` says otherwise (empty: none). ``encoding`` is for files whose letters
    come out wrong. ``target`` is the file that problems of the new project name.
    """
    try:
        found, draft = _read(source, read_bytes(source, max_size), kind, link, plc, folder, encoding)
    except TextError as error:
        raise ProblemError(_refusal(source, error)) from None
    clean(draft)
    if not any(each.items for each in draft.plcs):
        raise ProblemError(
            [*_refusal(source, TextError("there is no item in it that an S7-200 could have")), *draft.warnings]
        )
    text = yaml_of(draft, source.stem)
    loaded = load_text(text, target)
    warnings = sorted((*draft.warnings, *loaded.warnings), key=lambda problem: problem.span)
    return ImportResult(found, text, tuple(warnings), _counts(loaded.project, draft.left_out))


def _refusal(source: Path, error: TextError) -> list[Problem]:
    findings = Findings()
    findings.report("PRJ001", Span(str(source), error.line, error.column), str(error))
    return findings.problems


def _read(
    source: Path, data: bytes, kind: Kind, link: str, plc: str, folder: str | None, encoding: str | None
) -> tuple[Kind, Draft]:
    if kind is Kind.PCA or (kind is Kind.AUTO and (data.startswith(SIGNATURE) or source.suffix.lower() == ".pca")):
        return Kind.PCA, read_pca(source, data)
    text = decode_table(data, encoding)
    if not text.strip():
        raise TextError("the file is empty")
    if kind is Kind.KEPWARE or (kind is Kind.AUTO and has_tag_columns(text)):
        return Kind.KEPWARE, read_kepware(source, text, link=link, plc=plc)
    where = source.stem if folder is None else folder
    return Kind.SYMBOLS, read_symbols(source, text, link=link, plc=plc, folder=where)


def _counts(project: Project, left_out: int) -> Counts:
    plcs = list(project.all_plcs())
    folders = sum(_folders(plc.folders) for plc in plcs)
    return Counts(len(plcs), folders, sum(1 for _ in project.all_items()), left_out)


def _folders(folders: tuple[Folder, ...]) -> int:
    return sum(1 + _folders(folder.folders) for folder in folders)
