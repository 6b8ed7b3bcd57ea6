"""The ``pcaccess`` command: its parts, and what every part does with mistakes.

Exit codes: 0 good, 1 the thing asked for failed, 2 used wrongly, 130 interrupted. A user's mistake is a message, never
a traceback. Modules that take time to import are imported by the command that needs them.
"""

from __future__ import annotations

import sys
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from pcaccess import __version__
from pcaccess.cli import check, client, control, exchange, plc, run
from pcaccess.cli.failures import Failed
from pcaccess.cli.output import complain, show_problems
from pcaccess.problems import ProblemError


class Commands(TyperGroup):
    """Turns what commands raise into messages and exit codes."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except Failed as failed:
            for line in str(failed).splitlines():
                complain(line)
            raise typer.Exit(1) from None
        except ProblemError as error:
            show_problems(error.problems, stderr=True)
            raise typer.Exit(1) from None
        except KeyboardInterrupt:
            raise typer.Exit(130) from None


def _version(wanted: bool) -> None:
    if wanted:
        print(f"pcaccess {__version__}")
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


def main() -> None:
    """Entry point of the console script."""
    for stream in (sys.stdout, sys.stderr):
        # A terminal that cannot show a sign (Windows: °, …) shows its number instead of a traceback.
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="backslashreplace")
    app(prog_name="pcaccess")
