"""``pcaccess sheet``: workbooks for LibreOffice Calc and Excel."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pcaccess.cli.endpoint import PROJECT_FILE, default_web
from pcaccess.cli.failures import Failed
from pcaccess.cli.options import AsJson, MaxSize, duration
from pcaccess.cli.output import json_line, note, show
from pcaccess.cli.projects import load
from pcaccess.counting import counted

if TYPE_CHECKING:
    from pcaccess.sheet.entries import Chosen
    from pcaccess.sheet.formulas import Program
    from pcaccess.sheet.sources import Source

app = typer.Typer(no_args_is_help=True, help="Workbooks with live values, for LibreOffice Calc and Excel.")

Group = Annotated[str | None, typer.Option("--group", help="The items of a group.", metavar="NAME")]
Items = Annotated[
    list[str] | None,
    typer.Option("--items", help="Item IDs, PLCs or folders, patterns with * and ?; as often as you like."),
]
Pick = Annotated[bool, typer.Option("--pick", help="Choose items on the terminal: the Formula wizard.")]
Web = Annotated[
    str | None,
    typer.Option(
        "--url", envvar="PCACCESS_WEB", metavar="URL", help="A gateway that runs, such as http://127.0.0.1:8080."
    ),
]
ProjectFile = Annotated[
    Path | None, typer.Option("--project", help="The project file, if not ./items.yaml.", metavar="FILE")
]


@app.command()
def new(
    book: Annotated[Path, typer.Argument(help="The workbook: .ods for LibreOffice Calc, .xlsx for Excel.")],
    group: Group = None,
    items: Items = None,
    pick: Pick = False,
    every: Annotated[str, typer.Option(help="Time between two refreshes (.ods), in whole seconds.")] = "1s",
    project: ProjectFile = None,
    url: Web = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
    as_json: AsJson = False,
    max_size: MaxSize = None,
) -> None:
    """Make a workbook that shows items live and writes them.

    Items come from the project file, or with --url from a gateway that runs. Without --group, --items and --pick: those
    of the first group, or all.
    """
    from pcaccess.clock import SystemClock
    from pcaccess.sheet.entries import SheetError
    from pcaccess.sheet.files import opened_by, replacing
    from pcaccess.sheet.ods.book import ods_book
    from pcaccess.sheet.ods.sheets import Book
    from pcaccess.sheet.xlsx.book import xlsx_book

    kind = _kind(book, ".ods", ".xlsx")
    seconds = duration(every) or 1.0
    if seconds != int(seconds):
        raise typer.BadParameter(f"{every}: Calc refreshes at whole seconds, 1s at best")
    if book.exists() and not force:
        raise Failed(f"{book} exists; name another file, or replace it with --force")
    try:
        if book.exists() and (who := opened_by(book)):
            raise SheetError(f"{book} is open in {who}; close it there first")
        source = source_of(project, url, max_size)
        chosen = chosen_of(source, group, items, pick=pick)
        if kind == ".ods":
            content = ods_book(Book(source.title, source.gateway, chosen, int(seconds)))
        else:
            content = xlsx_book(source.title, source.gateway, chosen, SystemClock().now())
        with replacing(book) as file:
            file.write(content)
    except SheetError as error:
        raise Failed(str(error)) from None
    counts = {"items": len(chosen.entries), "writable": len(chosen.writable)}
    if as_json:
        json_line({"file": str(book), "gateway": source.gateway, "group": chosen.group, **counts})
        return
    show(f"{book}: {counted(counts, 'items')}, {counts['writable']} writable, from {source.gateway}", meaning="good")
    if kind == ".xlsx":
        note("Excel fetches at F9; rows over time: pcaccess sheet collect")


@app.command()
def formulas(
    group: Group = None,
    items: Items = None,
    pick: Pick = False,
    program: Annotated[str, typer.Option("--for", help="calc or excel.", metavar="PROGRAM")] = "calc",
    project: ProjectFile = None,
    url: Web = None,
    max_size: MaxSize = None,
) -> None:
    """Print formulas for items, to paste into a workbook that `sheet new` made: the Formula wizard.

    Columns are separated by tabs, so a paste fills the cells beside each other.
    """
    from pcaccess.sheet.entries import SheetError
    from pcaccess.sheet.formulas import COLUMNS, Program

    whose = _program(program, Program)
    try:
        chosen = chosen_of(source_of(project, url, max_size), group, items, pick=pick)
    except SheetError as error:
        raise Failed(str(error)) from None
    columns = COLUMNS[whose]
    typer.echo("\t".join(columns))
    for entry in chosen.readable:
        typer.echo("\t".join(make(entry) for make in columns.values()))


@app.command()
def collect(
    book: Annotated[Path, typer.Argument(help="The workbook (.xlsx); made when it does not exist.")],
    group: Group = None,
    items: Items = None,
    every: Annotated[str, typer.Option(help="Time between two rows.")] = "1s",
    period: Annotated[str | None, typer.Option("--for", help="End after a time such as 10min.", metavar="TIME")] = None,
    rows: Annotated[
        int, typer.Option(min=1, max=1_000_000, help="Rows in one workbook; the next is BOOK-2.xlsx.")
    ] = 200_000,
    url: Web = None,
    as_json: AsJson = False,
) -> None:
    """Fill a workbook with values, qualities and time stamps, a row at a time, with a chart; Excel need not be there.

    Every row is on the disk at once, in BOOK.xlsx.journal, and in the workbook about twice a minute and at the end. A
    workbook that exists gets further rows of its own items. Ctrl-C ends it and saves.
    """
    from pcaccess.cli.collecting import chosen_again
    from pcaccess.cli.collecting import collect as run
    from pcaccess.sheet.choosing import choose
    from pcaccess.sheet.client import GatewayClient
    from pcaccess.sheet.entries import SheetError
    from pcaccess.sheet.sources import GatewaySource

    _kind(book, ".xlsx")
    interval = duration(every) or 1.0
    try:
        source = GatewaySource(GatewayClient(_gateway(url)))
        again = chosen_again(book, source) if group is None and not items else None
        chosen = again or choose(source, group, items or [])
        done = run(book, source, chosen, interval, duration(period), rows)
    except SheetError as error:
        raise Failed(str(error)) from None
    if as_json:
        books = [str(path) for path in done.books]
        json_line({"files": books, "rows": done.rows, "items": done.items, "missed": done.missed})
    else:
        names = ", ".join(map(str, done.books)) or str(book)
        missed = f", {done.missed:,} missed" if done.missed else ""
        show(f"{names}: {done.rows:,} rows of {counted({'items': done.items}, 'items')}{missed}", meaning="good")
    if done.failure is not None:
        raise Failed(done.failure)


@app.command()
def merge(
    book: Annotated[Path, typer.Argument(help="The workbook whose journal was left behind.")],
    rows: Annotated[int, typer.Option(min=1, max=1_000_000, help="Rows in one workbook.")] = 200_000,
) -> None:
    """Put rows that wait in BOOK.xlsx.journal into the workbook, after a crash or while it was open elsewhere."""
    from pcaccess.cli.collecting import merge as run
    from pcaccess.clock import SystemClock
    from pcaccess.sheet.entries import SheetError

    try:
        count = run(book, SystemClock().now(), rows)
    except SheetError as error:
        raise Failed(str(error)) from None
    show(f"{book}: {counted({'rows': count}, 'rows') or 'no rows were missing'}", meaning="good")


def source_of(project: Path | None, url: str | None, max_size: int | None) -> Source:
    """A gateway when it is named without a project file, otherwise the project file; raises SheetError."""
    from pcaccess.sheet.client import GatewayClient, check_gateway
    from pcaccess.sheet.sources import GatewaySource, ProjectSource

    if url is not None and project is None:
        return GatewaySource(GatewayClient(url))
    path = project or Path(PROJECT_FILE)
    if project is None and not path.exists():
        raise Failed(f"there is no {PROJECT_FILE} here; name a project file with --project, or a gateway with --url")
    loaded = load(path, max_size)
    return ProjectSource(loaded.project, None if url is None else check_gateway(url))


def chosen_of(source: Source, group: str | None, items: list[str] | None, *, pick: bool) -> Chosen:
    """The items of the options, or those that somebody picks on the terminal; raises SheetError."""
    from pcaccess.sheet.choosing import choose
    from pcaccess.sheet.entries import Chosen
    from pcaccess.sheet.picker import Picker

    if not pick:
        return choose(source, group, items or [])
    offered = choose(source, group, items or ["*"])
    picker = Picker(offered.entries)
    for line in picker.begin():
        note(line)
    while not picker.done:
        # Not typer.prompt: it writes a blank to standard output, which is what was asked for and nothing else.
        typer.echo("items> ", nl=False, err=True)
        for line in picker.command(sys.stdin.readline()):
            note(line)
    if not picker.chosen:
        raise Failed("nothing was chosen")
    return Chosen(picker.chosen)


def _gateway(url: str | None) -> str:
    """The gateway to collect from: named, or that of ``./items.yaml``."""
    from pcaccess.sheet.links import gateway_url

    if url is not None:
        return url
    web = default_web()
    if web is None:
        raise Failed("the project has no web server (server: web: off), which spreadsheets need; name one with --url")
    return gateway_url(web)


def _program(word: str, programs: type[Program]) -> Program:
    try:
        return programs(word.lower())
    except ValueError:
        raise typer.BadParameter(f"{word}: expected calc or excel") from None


def _kind(book: Path, *known: str) -> str:
    kind = book.suffix.lower()
    if kind not in known:
        raise typer.BadParameter(f"{book}: expected a name that ends with {' or '.join(known)}")
    return kind
