"""Results go to standard output, everything else to standard error, both without characters that steer a terminal; exit codes
say how the program ends."""

from __future__ import annotations

import codecs
import contextlib
import json
import os
import shutil
import sys
import traceback
import unicodedata
from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import Any, Self, TextIO

from thermoroll_cli.files.case_errors import CaseError, printable


class ExitCode(IntEnum):
    """Exit codes and their meanings. Scripts depend on these."""

    FINE = 0
    BUG = 1
    USAGE = 2
    INVALID_CASE = 3
    NOT_CONVERGED = 4
    INPUT_OUTPUT = 5
    OUTSIDE_TOLERANCE = 6
    CLOSED_OUTPUT = 128 + 13
    """The reader of our output has gone (`thermoroll … | head`). The signal of a broken pipe gives the same exit code."""


class ClosedOutput(BaseException):
    """Standard output was closed by its reader."""


PLAIN = {"±": "+-", "×": "x", "µ": "u", "−": "-", "–": "-", "→": "->", "“": '"', "”": '"'}
"""Letters for terminals that have only those of ASCII; others by what Unicode says is the same."""


def prepare() -> None:
    """Let no character that the terminal's encoding lacks stop the program."""

    def in_plain_letters(fault: UnicodeError) -> tuple[str, int]:
        assert isinstance(fault, UnicodeEncodeError)
        lacking = fault.object[fault.start : fault.end]
        known = "".join(PLAIN.get(letter) or unicodedata.normalize("NFKD", letter) for letter in lacking)
        return known.encode("ascii", "replace").decode(), fault.end

    codecs.register_error("thermoroll", in_plain_letters)
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="thermoroll")


class Coloured(str):
    """A line for standard output, in a colour where that is a terminal."""

    colour: int

    def __new__(cls, line: str, colour: int) -> Self:
        made = super().__new__(cls, line)
        made.colour = colour
        return made


RED, YELLOW = 31, 33
"""Colours of a terminal."""


def in_colour(lines: Sequence[str], colour: int) -> list[Coloured]:
    """`lines` for `write`, in a colour if that is a terminal."""
    return [Coloured(line, colour) for line in lines]


LAYOUT = "\n\t"
"""What lines and tables need besides printable characters."""


def write(*lines: str) -> None:
    """Write `lines` to standard output, now. Raises ClosedOutput if nobody reads it, OSError if its disk is full."""
    if sys.stdout is None:  # started with standard output closed
        return
    try:
        colours = coloured(sys.stdout)
        for line in lines:
            text = printable(line, LAYOUT)
            sys.stdout.write(f"\033[{line.colour}m{text}\033[0m\n" if colours and isinstance(line, Coloured) else f"{text}\n")
        sys.stdout.flush()
    except BrokenPipeError:
        raise ClosedOutput from None
    except OSError as cause:
        raise OSError(f"cannot write to standard output: {cause.strerror or cause}") from None


def note(text: str) -> None:
    """Write `text` and a line end to standard error, if anybody can read it."""
    _tell(printable(text, LAYOUT))


def _tell(text: str) -> None:
    if sys.stderr is not None:
        with contextlib.suppress(OSError):
            sys.stderr.write(text + "\n")
            sys.stderr.flush()


def error(text: str) -> None:
    """Report an error."""
    note(f"thermoroll: error: {text}")


def report_invalid(errors: Sequence[CaseError], closing: str = "; nothing was computed") -> int:
    """Report all errors of invalid cases, each once. Returns the exit code for invalid cases."""
    colour = coloured(sys.stderr)
    texts = list(dict.fromkeys(finding.render(colour) for error in errors for finding in error.findings))
    for text in texts:  # printable already, but for our colours
        _tell(text)
    note(f"thermoroll: {len(texts)} error{'s' if len(texts) > 1 else ''}{closing}")
    return ExitCode.INVALID_CASE


def report_bug(cause: BaseException, arguments: Sequence[str] | None = None) -> None:
    """Report a `cause` that should not have happened; with its trace if `-v` was given."""
    error(f"this is a bug in thermoroll, please report it: {type(cause).__name__}: {' '.join(str(cause).split())}")
    if {"-v", "--verbose"} & set(sys.argv[1:] if arguments is None else arguments):
        note("".join(traceback.format_exception(cause)).rstrip())
    else:
        note("  -v shows where it happened")


def abandon_output() -> None:
    """Discard the buffer of standard output: writing it at exit would fail again, with a trace."""
    if sys.stdout is not None:
        with contextlib.suppress(OSError, ValueError), open(os.devnull, "wb") as nowhere:
            os.dup2(nowhere.fileno(), sys.stdout.fileno())


def is_terminal(stream: TextIO | None) -> bool:
    """Whether `stream` is a terminal that can redraw a line."""
    try:
        return stream is not None and stream.isatty() and os.environ.get("TERM") != "dumb"
    except ValueError:  # closed
        return False


def width() -> int:
    """Characters of a line on standard output: of the terminal, or as COLUMNS says, or 80."""
    return shutil.get_terminal_size((80, 24)).columns


def coloured(stream: TextIO | None) -> bool:
    """Whether to write colours to `stream` (https://no-color.org)."""
    return is_terminal(stream) and not os.environ.get("NO_COLOR")


def write_json(content: Mapping[str, Any]) -> None:
    """Write `content` to standard output as one line of strict JSON; nan and infinity become null. Raises as `write`,
    and OSError where the program was started with standard output closed: who asks for JSON wants it."""
    if sys.stdout is None:
        raise OSError("cannot write to standard output: it is closed")
    text = json.dumps(content, default=_plain)
    write(json.dumps(json.loads(text, parse_constant=lambda name: None), allow_nan=False))


def _plain(value: Any) -> Any:
    """NumPy's numbers and arrays as Python's, mappings of our own as dictionaries, paths as texts."""
    if hasattr(value, "tolist"):  # NumPy, which is not imported for this
        return value.tolist()
    return dict(value) if isinstance(value, Mapping) else str(value)
