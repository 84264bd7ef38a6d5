"""The command line: every command with its name. A command is imported with its libraries when it is called; only pictures are
imported when the first is drawn."""

from __future__ import annotations

import importlib
import keyword
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from thermoroll_cli import __version__
from thermoroll_cli.cli import streams

COMMANDS = {
    "run": ("run", "Solve cases, write results and pictures."),
    "sweep": ("sweep_command", "Solve cases for many values of some of their keys."),
    "fit": ("fit", "Find values of a case from measurements."),
    "wear": ("wear", "Follow the profiles of both bodies as they wear."),
    "conicity": ("conicity", "Equivalent conicity after EN 15302 of the wheelset of a case."),
    "show": ("show", "Show what a case means and what would run."),
    "validate": ("cases", "Check cases and report all their errors."),
    "import": ("import_command", "Write the cases of an input file of CONTACT as cases."),
    "init": ("cases", "Write a case with comments, to be edited."),
    "schema": ("cases", "Print the JSON schema of case files."),
    "plot": ("results", "Draw the pictures of results and sweeps again."),
    "report": ("report", "Write results as one HTML file, to be sent."),
    "compare": ("results", "Compare two results."),
    "export": ("results", "Export a result to XDMF, VTU or CSV."),
    "table": ("creep_table", "Build a table of creep forces, or query one."),
}
"""The module of each command, which is a function or a group of commands of its name there, and the line about it in --help."""

HELP_OPTIONS = {"help_option_names": ["-h", "--help"]}


class Commands(TyperGroup):
    """The commands. The module of a command is imported when it is called."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        name, _, rest = super().resolve_command(ctx, args)
        if not name:
            return name, None, rest
        command = getattr(importlib.import_module(f"thermoroll_cli.cli.{COMMANDS[name][0]}"),
                          f"{name}_" if keyword.iskeyword(name) else name)
        if not isinstance(command, typer.Typer):
            function, command = command, typer.Typer(add_completion=False, rich_markup_mode=None, context_settings=HELP_OPTIONS)
            command.command(name)(function)
        return name, typer.main.get_command(command), rest


app = typer.Typer(
    name="thermoroll",
    cls=Commands,
    help="Thermo-elastic rolling contact with friction, heat, thermal expansion and estimated errors.",
    epilog="Exit codes: 0 fine, 1 a bug in the program, 2 usage, 3 invalid case, 4 not converged, "
    "5 input/output, 6 outside a tolerance or a limit.",
    invoke_without_command=True,
    # Rich would double the time of --help and draw boxes that scripts cannot read.
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings=HELP_OPTIONS,
)


@app.callback()
def thermoroll(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Show the version and exit.")] = False,
) -> None:
    if version:
        streams.write(f"thermoroll {__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help(), err=True)
        raise typer.Exit(2)


for _name, (_, _summary) in COMMANDS.items():
    app.command(_name, help=_summary)(lambda: None)
