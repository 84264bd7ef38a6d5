"""What is said when the program itself is at fault."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from thermoroll_cli.cli import streams


def report_bug(cause: BaseException, arguments: Sequence[str] | None = None) -> None:
    """Tell that `cause` should not have happened; with its trace if `-v` was given."""
    arguments = sys.argv[1:] if arguments is None else arguments
    message = " ".join(str(cause).split())
    streams.error(f"this is a bug in thermoroll, please report it: {type(cause).__name__}: {message}")
    if {"-v", "--verbose"} & set(arguments):
        import traceback

        streams.note("".join(traceback.format_exception(cause)).rstrip())
    else:
        streams.note("  -v shows where it happened")
