"""The ``pcaccess`` command: its parts, and what every part does with mistakes.

Exit codes: 0 good, 1 the thing asked for failed, 2 used wrongly, 130 interrupted, 141 nobody reads the output any
more. A user's mistake is a message, never a traceback. Modules that take time to import are imported by the command
that needs them.
"""

from __future__ import annotations

import sys
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from pcaccess import __version__
from pcaccess.cli import check, client, control, exchange, plc, run, sheet
from pcaccess.cli.failures import Failed
from pcaccess.cli.output import complain, show_problems
from pcaccess.cli.streams import NO_READER, NoReader, finish, prepare, put
from pcaccess.problems import ProblemError


class Commands(TyperGroup):
    """Turns what commands raise into messages and exit codes."""

    def main(self, *args: Any, **extra: Any) -> Any:
        try:
            try:
                return super().main(*args, **extra)
            except SystemExit:
                finish()
                raise
        except NoReader:
            sys.exit(NO_READER)
        except Failed as failed:
            for line in str(failed).splitlines():
                complain(line)
        except ProblemError as error:
            show_problems(error.problems, stderr=True)
        except OSError as error:  # a file that went away or refuses where nobody expects it
            complain(f"{error.filename}: {error.strerror}" if error.filename else str(error))
        sys.exit(1)


def _version(wanted: bool) -> None:
    if wanted:
        put(f"pcaccess {__version__}\n")
        raise typer.Exit


def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """S7-200 PC Access, again: an OPC UA gateway and soft-PLC."""


app = typer.Typer(cls=Commands, callback=_root, no_args_is_help=True, pretty_exceptions_enable=False)
app.command()(run.run)
app.command()(check.check)
app.command()(check.schema)
app.command()(client.browse)
app.command()(client.read)
# A negative number is a value, not an option.
app.command(context_settings={"ignore_unknown_options": True})(client.write)
app.command()(client.watch)
app.command()(control.reload)
app.command("import")(exchange.import_)
app.command()(exchange.export)
app.add_typer(plc.app, name="plc")
app.add_typer(sheet.app, name="sheet")


def main() -> None:
    """The command, from its arguments to its exit code; ``pcaccess.__main__`` starts it."""
    prepare()
    app(prog_name="pcaccess")
