"""``pcaccess plc``: programs of an S7-200 in STL, without any gateway."""

from __future__ import annotations

import asyncio
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pcaccess.cli import control
from pcaccess.cli.failures import Failed
from pcaccess.cli.options import AsJson, Execution, duration, known_encoding
from pcaccess.cli.output import json_list, note, show, show_problems, write_file
from pcaccess.cli.streams import put, stdout_console
from pcaccess.counting import counted

if TYPE_CHECKING:
    from pcaccess.cli.scanning import View

Cpu = Annotated[str, typer.Option("--cpu", metavar="MODEL", help="The CPU that the program is for.")]
Encoding = Annotated[
    str | None, typer.Option(metavar="NAME", help="Code page of the file; left out: found by looking at it.")
]
How = Annotated[
    Execution,
    typer.Option(
        "--execution",
        help="Machine code or interpreter; the results are the same. auto: machine code, where it is sooner done.",
    ),
]
DEFAULT_CPU = "CPU 226"

app = typer.Typer(no_args_is_help=True, help="Check, list, run and test S7-200 programs (STL, .awl).")


@app.command()
def check(
    files: Annotated[list[Path], typer.Argument(help="Programs as Micro/WIN exports them.")],
    cpu: Cpu = DEFAULT_CPU,
    encoding: Encoding = None,
    as_json: AsJson = False,
) -> None:
    """Say what is wrong with programs: every mistake at once, with line and column, block and network.

    Warnings alone leave the exit code at 0.
    """
    from pcaccess.cli.programs import check as check_one
    from pcaccess.cli.programs import model_of

    model, code_page = model_of(cpu), known_encoding(encoding)
    results = [check_one(path, model, code_page) for path in files]
    if as_json:
        json_list([result.as_json() for result in results])
    else:
        for result in results:
            show_problems(result.problems, stderr=False, texts={result.file: result.text})
            show(result.summary, meaning="good" if result.is_good else "bad")
    if not all(result.is_good for result in results):
        raise typer.Exit(1)


@app.command("list")
def list_(
    file: Annotated[Path, typer.Argument(help="A program as Micro/WIN exports it.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write to a file.", metavar="FILE")] = None,
    references: Annotated[bool, typer.Option(help="End with the cross reference.")] = True,
    cpu: Cpu = DEFAULT_CPU,
    encoding: Encoding = None,
) -> None:
    """Print a program as a clean listing with its symbols, data block and cross reference.

    Reading the listing again gives the same program. Mistakes that only checking finds are told and do not stop it.
    """
    from pcaccess.cli.programs import check as check_one
    from pcaccess.cli.programs import model_of, read
    from pcaccess.stl.listing import list_program

    code_page = known_encoding(encoding)
    program = read(file, code_page).unwrap()
    checked = check_one(file, model_of(cpu), code_page)
    show_problems(checked.problems, stderr=True, texts={checked.file: checked.text})
    text = list_program(program, references=references)
    if output is None:
        put(text)
        return
    if output.exists() and output.samefile(file):
        raise Failed(f"{output} is the program itself; write the listing to another file")
    write_file(output, text)


@app.command()
def scenario(
    files: Annotated[list[Path], typer.Argument(help="Scenarios (YAML), each with its program and expectations.")],
    junit: Annotated[Path | None, typer.Option(help="Also write the results as JUnit XML.", metavar="FILE")] = None,
    execution: How = Execution.AUTO,
    as_json: AsJson = False,
) -> None:
    """Test programs: inputs over time, expected outputs, in virtual time.

    The exit code is 1 when anything is not as expected, and every difference is told.
    """
    from pcaccess.cli.execution import Executions
    from pcaccess.cli.scenarios import Played, as_junit, play

    def tell(one: Played) -> None:
        show_problems(one.problems, stderr=False)
        show(one.summary, meaning="good" if one.passed else "bad")
        for failure in one.outcome.failures if one.outcome is not None else ():
            show(f"  {failure}")
        for record in one.outcome.unexpected if one.outcome is not None else ():
            if not record.is_fatal:
                show(f"  {record}", meaning="uncertain")

    played = []
    executions = Executions(execution)
    for path in files:
        played.append(play(path, executions))
        if not as_json:
            tell(played[-1])
    if as_json:
        json_list([one.as_json() for one in played])
    elif len(played) > 1:
        failed = sum(not one.passed for one in played)
        verdict = f"{failed} failed" if failed else "all passed"
        show(f"{counted({'scenarios': len(played)}, 'scenarios')}, {verdict}", meaning="bad" if failed else "good")
    if junit is not None:
        write_file(junit, as_junit(played))
    if not all(one.passed for one in played):
        raise typer.Exit(1)


@app.command()
def run(
    file: Annotated[Path, typer.Argument(help="A program as Micro/WIN exports it.")],
    watch: Annotated[
        list[str] | None,
        typer.Option(
            metavar="Q0.0,VW10", help="Places to show, with a type where it matters: VD20:REAL. Default: those it uses."
        ),
    ] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="I0.0=1", help="Set an input or memory before the first scan.")
    ] = None,
    scan: Annotated[str, typer.Option(metavar="TIME", help="Time from scan to scan, or free.")] = "10ms",
    period: Annotated[str | None, typer.Option("--for", help="End after a time such as 5s.", metavar="TIME")] = None,
    cpu: Cpu = DEFAULT_CPU,
    encoding: Encoding = None,
    execution: How = Execution.AUTO,
    as_json: AsJson = False,
) -> None:
    """Scan a program in real time and show chosen places of its memory.

    On a terminal they stand in one table, live; else every change is a line. Ctrl-C ends it. To let clients in, name
    the program in a project file (program:) and use pcaccess run.
    """
    from pcaccess.cli.execution import Executions
    from pcaccess.cli.programs import check as check_one
    from pcaccess.cli.programs import model_of
    from pcaccess.cli.scanning import ScanJson, ScanLines, Scanner, ScanTable, parse_place, places_of, write_setting
    from pcaccess.clock import SystemClock

    model = model_of(cpu)
    cycle = None if scan.strip().lower() == "free" else duration(scan)
    limit = duration(period)
    checked = check_one(file, model, known_encoding(encoding))
    show_problems(checked.problems, stderr=True, texts={checked.file: checked.text})
    if checked.program is None or not checked.is_good:
        raise typer.Exit(1)
    program = checked.program
    words = [word for text in watch or () for word in text.split(",") if word.strip()]
    places = [parse_place(word, program, model) for word in words] or places_of(program)
    scanner = Scanner(model, program, SystemClock(), Executions(execution).choose())
    for setting in settings or ():
        write_setting(scanner.cpu, setting, program, model)
    with ExitStack() as stack, suppress(KeyboardInterrupt):
        stack.callback(scanner.cpu.close)
        view: View
        if as_json:
            view = ScanJson()
        elif (out := stdout_console()).is_terminal:
            title = f"{file} on a {model.name} ({scanner.cpu.executor_name})"
            view = stack.enter_context(ScanTable(title, places, out))
        else:
            view = ScanLines(places)
        asyncio.run(scanner.run(places, view, cycle, limit))
    note(f"{scanner.status} ({scanner.cpu.executor_name})")
    if scanner.cpu.fatal is not None:
        raise Failed(f"the CPU stopped: {scanner.cpu.fatal}")


app.command()(control.status)
app.command()(control.start)
app.command()(control.stop)
app.command()(control.download)
