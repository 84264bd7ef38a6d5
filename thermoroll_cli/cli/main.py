"""Entry point: runs the command line and turns whatever happens into a message and an exit code."""

from __future__ import annotations

import atexit
import contextlib
import os
import signal
import sys
from collections.abc import Sequence
from typing import NoReturn

from thermoroll_cli.cli import streams
from thermoroll_cli.cli.bug_report import report_bug
from thermoroll_cli.cli.exits import ClosedOutput, ExitCode, catch_signals
from thermoroll_cli.files.environment import one_thread
from thermoroll_cli.interruption import Interrupted, end_at_once, forget, last_point, noted


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `thermoroll` with `arguments` (default: those of the process) and return its exit code."""
    forget()
    restore_signals = catch_signals()
    try:
        return _stoppable(sys.argv[1:] if arguments is None else list(arguments))
    finally:
        restore_signals()


def program() -> NoReturn:
    """The process `thermoroll`."""
    catch_signals()
    code = _stoppable(sys.argv[1:])
    # Nothing is left to be cleared up: from here on a signal just ends the process.
    catch_signals(end_at_once)
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError, AttributeError):  # closed, or none at all
            stream.flush()
    # Not sys.exit: while Python takes itself apart it takes signals and forgets them.
    os._exit(128 + noted() if noted() else code)


def _stoppable(arguments: Sequence[str]) -> int:
    one_thread()
    streams.prepare()
    try:
        code = _guarded(arguments)
        last_point()
        return code
    except Interrupted as stop:
        streams.note(f"thermoroll: stopped by {signal.Signals(stop.number).name}; what was written is complete")
        streams.abandon_output()
        return stop.exit_code


def _guarded(arguments: Sequence[str]) -> int:
    try:
        code = _dispatch(arguments)
        streams.flush()
        return code
    except ClosedOutput:
        streams.abandon_output()
        return ExitCode.CLOSED_OUTPUT
    except OSError as cause:
        streams.error(str(cause))
        streams.abandon_output()
        return ExitCode.INPUT_OUTPUT
    except MemoryError:
        streams.error("not enough memory")
        return ExitCode.INPUT_OUTPUT
    except Exception as cause:
        report_bug(cause, arguments)
        return ExitCode.BUG


def _dispatch(arguments: Sequence[str]) -> int:
    from thermoroll_cli.cli.commands import app_for

    before = sys.stdout
    try:
        app_for(arguments)(list(arguments), prog_name="thermoroll")
    except SystemExit as end:
        if sys.stdout is not before:
            # The parser's own way to say that the reader of its help has gone.
            sys.stdout = before
            raise ClosedOutput from None
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    return ExitCode.FINE
