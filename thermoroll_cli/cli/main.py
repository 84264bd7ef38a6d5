"""Entry point: runs the command line and turns every outcome into a message and an exit code."""

from __future__ import annotations

import difflib
import gc
import io
import signal
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

import typer

from thermoroll_cli.cli import streams
from thermoroll_cli.cli.commands import app
from thermoroll_cli.cli.streams import ClosedOutput, ExitCode
from thermoroll_cli.files.case_errors import CaseError
from thermoroll_cli.tools.process import Interrupted, noted, one_thread, safe_point, stoppable

UsageError: Any = typer.BadParameter.mro()[1]
"""Of click, or of what typer has in its place."""


def program() -> NoReturn:
    """The process `thermoroll`, once `thermoroll_cli.__main__` has it end by signals."""
    # A run makes half a million objects that live until it ends (modules, figures) and hardly any cycles: looking for garbage
    # among them after every 700 new ones, as Python does, costs 7 % of its time.
    gc.set_threshold(50_000)
    sys.exit(main())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `thermoroll` with `arguments` (default: those of the process) and return its exit code."""
    arguments = sys.argv[1:] if arguments is None else list(arguments)
    one_thread()
    streams.prepare()
    with stoppable():
        try:
            code = _dispatch(arguments)
            streams.write()
            safe_point()
        except Interrupted as stop:
            streams.note(f"thermoroll: stopped by {signal.Signals(stop.number).name}; what was written is complete")
            streams.abandon_output()
        except ClosedOutput:
            streams.abandon_output()
            code = ExitCode.CLOSED_OUTPUT
        except OSError as cause:
            streams.error(str(cause))
            streams.abandon_output()
            code = ExitCode.INPUT_OUTPUT
        except CaseError as cause:
            code = streams.report_invalid([cause])
        except MemoryError:
            streams.error("not enough memory")
            code = ExitCode.INPUT_OUTPUT
        except Exception as cause:
            streams.report_bug(cause, arguments)
            code = ExitCode.BUG
    return 128 + noted() if noted() else code


def _dispatch(arguments: Sequence[str]) -> int:
    before = sys.stdout
    try:
        code = app(list(arguments), prog_name="thermoroll", standalone_mode=False)
    except UsageError as fault:
        message = io.StringIO()
        if possible := getattr(fault, "possibilities", None):
            # The parser counts the dashes, which all options have in common.
            near = difflib.get_close_matches(fault.option_name.lstrip("-"), [name.lstrip("-") for name in possible])
            fault.possibilities = [name for name in possible if name.lstrip("-") in near]
        fault.show(message)
        # Some versions of typer pass on what pydantic puts before a message.
        streams.note(message.getvalue().rstrip().replace(": Value error, ", ": "))
        return ExitCode.USAGE
    except SystemExit as end:
        if sys.stdout is not before:
            # The parser's own way to report that the reader of its help has gone.
            sys.stdout = before
            raise ClosedOutput from None
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    return code if isinstance(code, int) else ExitCode.FINE
