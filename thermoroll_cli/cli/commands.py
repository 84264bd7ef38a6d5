"""The command line: every command with its name. A command is imported when it is called, and its libraries when it runs."""

from __future__ import annotations

import importlib
import re
from collections.abc import Sequence
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from thermoroll_cli import __version__
from thermoroll_cli.cli import streams

COMMANDS = {
    "run": "run", "sweep": "sweep_command", "wear": "wear", "table": "creep_table", "show": "show", "validate": "cases",
    "init": "cases", "schema": "cases", "plot": "results", "compare": "results", "export": "results",
}  # fmt: skip
"""The module of each command, which is a function or a group of commands of its name there."""

_WORDING = (
    (r"^Value error, ", ""),
    (r"^Input should be a valid integer.*", "must be a whole number"),
    (r"^Input should be a valid number.*", "must be a number"),
    (r"^Input should be greater than or equal to (.*)", r"must be \1 or more"),
)
"""Messages of the parser's validator, and the words that fit our own messages."""


class Commands(TyperGroup):
    """The commands, with our own words for wrong options."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except typer.BadParameter as cause:
            for pattern, words in _WORDING:
                cause.message = re.sub(pattern, words, cause.message)
            raise


app = typer.Typer(
    name="thermoroll",
    cls=Commands,
    help="Three-dimensional thermo-elastic rolling contact in the steady state.",
    epilog="Exit codes: 0 fine, 1 a bug in the program, 2 usage, 3 invalid case, 4 not converged, "
    "5 input/output, 6 comparison outside tolerance.",
    invoke_without_command=True,
    # Rich would double the time of --help and draw boxes that scripts cannot read.
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
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


def app_for(arguments: Sequence[str]) -> typer.Typer:
    """The program with the command that `arguments` begin with; with all of them where they begin with something else."""
    app.registered_commands.clear()
    app.registered_groups.clear()
    first = arguments[0] if arguments else ""
    for name in (first,) if first in COMMANDS else COMMANDS:
        module = importlib.import_module(f"thermoroll_cli.cli.{COMMANDS[name]}")
        command = getattr(module, name)
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=name)
        else:
            app.command(name)(command)
    return app
