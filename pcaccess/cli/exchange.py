"""``pcaccess import`` and ``pcaccess export``: projects from PC Access, Micro/WIN and Kepware, and back."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pcaccess.cli.endpoint import PROJECT_FILE
from pcaccess.cli.failures import Failed
from pcaccess.cli.options import AsJson, MaxSize, known_encoding
from pcaccess.cli.output import json_line, note, show, show_problems, working, write_file
from pcaccess.cli.projects import load
from pcaccess.cli.streams import put
from pcaccess.counting import counted

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pcaccess.project.model import Plc, Project


class Source(StrEnum):
    """Kinds of files that can be imported."""

    AUTO = "auto"
    PCA = "pca"
    SYMBOLS = "symbols"
    KEPWARE = "kepware"


def import_(
    source: Annotated[Path, typer.Argument(help="A .pca project, a symbol table, or a Kepware tag list (CSV).")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write here; left out: print.", metavar="FILE")
    ] = None,
    kind: Annotated[Source, typer.Option(help="What the file is; auto looks into it.")] = Source.AUTO,
    link: Annotated[str, typer.Option(help="The link, where the file names none.")] = "MicroWin",
    plc: Annotated[str, typer.Option(help="The PLC, where the file names none.")] = "NewPLC",
    folder: Annotated[
        str | None, typer.Option(help="Folder for a symbol table; left out: the file's name; empty: none.")
    ] = None,
    encoding: Annotated[
        str | None, typer.Option(help="Code page, when letters come out wrong.", metavar="NAME")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
    as_json: AsJson = False,
    max_size: MaxSize = None,
) -> None:
    """Turn a PC Access project, a Micro/WIN symbol table or a Kepware tag list into a project file.

    What cannot come along is told as a warning. Nothing is written when the file is not what it should be. --json
    (with -o) tells what was written.
    """
    from pcaccess.project.importers.run import Kind, import_file
    from pcaccess.project.textfile import MAX_SIZE

    if output is not None and output.is_file() and not force:
        raise Failed(f"{output} exists; name another file, or replace it with --force")
    if as_json and output is None:
        raise typer.BadParameter("--json needs -o FILE, as the project itself is printed without it")
    code_page = known_encoding(encoding)
    target = PROJECT_FILE if output is None else str(output)
    with working(f"reading {source}"):
        result = import_file(
            source,
            target=target,
            kind=Kind(kind.value),
            link=link,
            plc=plc,
            folder=folder,
            encoding=code_page,
            max_size=MAX_SIZE if max_size is None else max_size * 1_000_000,
        )
    show_problems(result.warnings, stderr=True, texts={target: result.yaml_text})
    content = {"plcs": result.counts.plcs, "folders": result.counts.folders, "items": result.counts.items}
    left_out = result.counts.left_out
    if output is None:
        put(result.yaml_text)
    else:
        write_file(output, result.yaml_text)
    if as_json:
        json_line({"file": str(output), "kind": result.kind.value, **content, "left_out": left_out})
        return
    words = counted(content, "plcs", "folders", "items")
    lost = f"; {counted({'items': left_out}, 'items')} left out" if left_out else ""
    if output is None:
        note(f"{source}: {words}{lost}")
    else:
        show(f"{output}: {words}{lost}", meaning="good")


def export(
    project: Annotated[Path, typer.Argument(help="The project file.")] = Path(PROJECT_FILE),
    plc: Annotated[str | None, typer.Option(help="The PLC as Link.PLC; needed when there are several.")] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Write here; a folder takes a file for each PLC.", metavar="FILE"),
    ] = None,
    ours: Annotated[bool, typer.Option(help="Add columns for limits, which Kepware does not have.")] = False,
    max_size: MaxSize = None,
) -> None:
    """Write the items of a PLC as a tag list in Kepware's form (CSV), which import and items_from read back."""
    from pcaccess.project.export import export_tags

    loaded = load(project, max_size)
    many = output is not None and output.is_dir()
    chosen = _plcs(loaded.project, plc, many=many)
    for one in chosen:
        table = export_tags(one, ours=ours)
        target = output / f"{one.item_id}.csv" if output is not None and many else output
        if target is None:
            put(table.text)
        else:
            write_file(target, table.text)
            show(f"{target}: {counted({'items': table.items}, 'items') or 'no items'}", meaning="good")
        if table.lost:
            note(f"{one.item_id}: the limits of {counted({'items': table.lost}, 'items')} are not in it; see --ours")


def _plcs(project: Project, name: str | None, *, many: bool) -> Sequence[Plc]:
    """The PLCs to export."""
    plcs = list(project.all_plcs())
    names = ", ".join(plc.item_id for plc in plcs)
    if name is not None:
        found = project.plc(name)
        if found is None:
            raise Failed(f"there is no PLC {name}; the project has {names or 'none'}")
        return [found]
    if not plcs:
        raise Failed("the project has no PLC")
    if len(plcs) > 1 and not many:
        raise Failed(f"there are several PLCs; name one with --plc, or a folder with -o: {names}")
    return plcs
