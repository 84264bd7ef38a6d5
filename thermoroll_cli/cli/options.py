"""Options that several commands share, and what commands do with cases alike."""

from __future__ import annotations

import contextlib
import shlex
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from thermoroll_cli.cli import streams
from thermoroll_cli.files import case_source
from thermoroll_cli.files.case import Case, CaseError, Finding, Override, case_name
from thermoroll_cli.files.case import solvable as solvable
from thermoroll_cli.files.case_schema import entry_at, is_table, known_keys
from thermoroll_cli.files.case_source import CaseSource
from thermoroll_cli.problem.limits import Limit
from thermoroll_cli.tools.atomic import ReadError

if TYPE_CHECKING:
    from thermoroll_cli.problem.kinds import Task


ImageFormat = StrEnum("ImageFormat", "png svg pdf")
"""File types of pictures."""
Cases = Annotated[list[Path], typer.Argument(metavar="CASE...", help="Case files, or results; - is standard input.")]
OneCase = Annotated[Path, typer.Argument(metavar="CASE", help="Case file, or a result; - is standard input.")]


def keys_like(incomplete: str) -> list[str]:
    """Keys and tables of a case that begin with what was typed, for shells that complete."""
    table, dot, _ = incomplete.rpartition(".")
    path = tuple(table.split(".")) if dot else ()
    ended = (f"{table}{dot}{key}{'.' if is_table(entry_at((*path, key))) else '='}" for key in known_keys(path))
    return [key for key in ended if key.startswith(incomplete)]


Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        autocompletion=keys_like,
        help="Override a key of the case, for example load.normal_N=80. It replaces a key that it excludes "
        "(grid and accuracy). Repeatable.",
    ),
]
Output = Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the results.")]
RESULTS = Path("results")
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object per line on standard output, nothing else.")]
PlotKind = StrEnum("PlotKind", "all summary none")
"""Which pictures are drawn."""


def _one_kind(context: typer.Context, value: Any) -> Any:
    """`value` of one of the two options; a usage error where the other one says something else."""
    asked = {kind for kind in (context.params.get("plots"), context.params.get("no_plots"), value) if kind}
    if len({"none" if kind is True else str(kind) for kind in asked}) > 1:
        raise typer.BadParameter("--no-plots is --plots none, and --plots says something else")
    return value


Plots = Annotated[
    PlotKind | None, typer.Option("--plots", callback=_one_kind, help="Pictures, in place of output.plots of the case.")
]
NoPlots = Annotated[bool, typer.Option("--no-plots", callback=_one_kind, help="Short for --plots none.")]


def a_number(value: float | None) -> float | None:
    """`value`; a usage error for nan, which is in no range but which older versions of typer let pass."""
    if value != value:
        raise typer.BadParameter("nan is no number")
    return value


Threads = Annotated[int, typer.Option("--threads", min=1, metavar="N", help="Threads of the transforms.")]
Jobs = Annotated[int, typer.Option("--jobs", "-j", min=1, metavar="N", help="Processes on this machine.")]
Over = Annotated[str, typer.Option("--x", metavar="COLUMN", help="The axis of the picture: a swept key or a label; over time "
                                   "also distance_mm, time_s or a key that varies.")]
Columns = Annotated[str, typer.Option("--columns", metavar="A,B", help="Sweeps: scalars printed first, and drawn alone.")]
Limits = Annotated[
    list[str] | None,
    typer.Option("--limit", metavar="SCALAR<VALUE", help="A scalar, with its ±, must keep this (<, <=, >, >=); else the exit "
                 "code is 6. Repeatable."),
]
Force = Annotated[bool, typer.Option("--force", help="Begin anew where the output has other work in it, which is lost.")]
Dask = Annotated[str, typer.Option("--dask", metavar="ADDRESS", help="Use the Dask cluster of this scheduler.")]
DaskWait = Annotated[
    float, typer.Option("--dask-wait", min=0, metavar="S", callback=a_number,
                        help="Seconds to wait for a worker of it, and, up to 10, for its scheduler.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Errors only.")]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="More of everything; the trace of a bug.")]
Trace = Annotated[bool, typer.Option("--verbose", "-v", help="The trace of a bug.")]
"""The same of commands that have no more to say; `streams` looks for it."""
Formats = Annotated[
    list[ImageFormat] | None, typer.Option("--format", help="File type of the pictures; png if not given. Repeatable.")
]
Dpi = Annotated[
    float | None, typer.Option("--dpi", min=10, max=2400, metavar="N", callback=a_number, help="Resolution of PNG pictures.")
]
Normalised = Annotated[bool, typer.Option("--normalised", help="Pictures in the article's dimensionless quantities.")]
Compare = Annotated[
    str, typer.Option("--compare", metavar="A,B", help="Sweeps: creep forces of linear, fastsim or polach beside ours.")
]
Data = Annotated[
    Path | None, typer.Option("--measured", metavar="DATA.csv", help="Measured points in the picture, as of fit.")
]
Report = Annotated[bool, typer.Option("--report", help="Also one HTML file with everything, to be sent: NAME_report.html, of a "
                                     "sweep sweep_report.html, NAME_wear_report.html and so on.")]


def image_formats(given: Sequence[ImageFormat] | None) -> tuple[str, ...]:
    """The file types that pictures are wanted in, each once."""
    return tuple(dict.fromkeys(given or (ImageFormat.png,)))


def plots_of(case: Case, plots: PlotKind | None, no_plots: bool) -> str:
    """Which pictures are wanted: as the options say, or else the case."""
    return "none" if no_plots else str(plots or case.plots)


def words(text: str) -> tuple[str, ...]:
    """The parts of a list with commas, each once."""
    return tuple(dict.fromkeys(part.strip() for part in text.split(",") if part.strip()))


def command_line() -> str:
    """The command that runs, as result files record it."""
    return shlex.join(["thermoroll", *sys.argv[1:]])


def check_standard_input(cases: Sequence[Path]) -> None:
    """End the program (usage) where several of `cases` are standard input, of which there is only one."""
    if sum(str(path) == "-" for path in cases) > 1:
        raise typer.BadParameter("standard input can be read only once", param_hint="CASE...")


def read_source(path: Path, overrides: Sequence[Override] = (), *, stored: bool = False) -> CaseSource:
    """The text of a case: of its file, or of the case that a result carries (NAME.h5; if `stored`, whatever it is called).
    Raises CaseError, OSError."""
    if not (stored or path.suffix == ".h5"):
        return case_source.read_source(path, overrides)
    from thermoroll_cli.files.result.outcome import read_result

    carried = Case.from_json(read_result(path, with_fields=False).case_json, name=str(path))
    return case_source.parse_source(carried.to_toml(), str(path), overrides)


def read_case(path: Path, overrides: Sequence[Override] = (), *, stored: bool = False) -> Case:
    """The case of a file or of a result, as by `read_source`."""
    return Case.from_source(read_source(path, overrides, stored=stored), case_name(path))


def parse_overrides(settings: Sequence[str] | None) -> list[Override]:
    """The overrides given with `--set`. Ends the program (usage) where one is not of the form key=value."""
    with usage("--set"):
        return [Override.parse(text) for text in settings or ()]


@contextlib.contextmanager
def usage(option: str) -> Iterator[None]:
    """Inside, a ValueError ends the program (usage), as a fault of `option`."""
    try:
        yield
    except ValueError as cause:
        raise typer.BadParameter(str(cause), param_hint=option) from None


def parse_limits(texts: Sequence[str] | None) -> list[Limit]:
    """The limits given with `--limit`. Ends the program (usage) where one is none."""
    with usage("--limit"):
        return [Limit.parse(text) for text in texts or ()]


def numbers(text: str, count: int, words: str, option: str, kind: Callable[[str], Any] = float) -> list[Any]:
    """The `count` numbers of a list with commas. Ends the program (usage) where `text` is not that, as `words` say."""
    with contextlib.suppress(ValueError):
        values = [kind(part) for part in text.split(",")]
        if len(values) == count:
            return values
    raise typer.BadParameter(f'"{text}" is not {words}', param_hint=option)


def check_not_both(resume: bool, force: bool) -> None:
    """End the program (usage) where work is to be kept and to be lost."""
    if resume and force:
        raise typer.BadParameter("--resume keeps what is there, and --force does not", param_hint="--force")


def check_cluster(address: str, jobs: int) -> None:
    """End the program (usage) if a cluster is asked for that cannot be used, or one whose workers are counted here."""
    if jobs > 1 and address:
        raise typer.BadParameter("the cluster decides how many workers there are", param_hint="--jobs")
    if address:
        from thermoroll_cli.tools.runner import check_dask

        try:
            check_dask()
        except ImportError as cause:
            raise typer.BadParameter(str(cause), param_hint="--dask") from None


@contextlib.contextmanager
def recorded(source: Path, as_json: bool) -> Iterator[None]:
    """Inside, a CaseError of the case read from `source` is also printed as a JSON object, if `as_json`."""
    try:
        yield
    except CaseError as cause:
        if as_json:
            streams.write_json(invalid_record(str(source), cause))
        raise


@contextlib.contextmanager
def read_data(data: Path, as_json: bool) -> Iterator[None]:
    """Inside, what is wrong with the measured `data` is reported as a CaseError of that file, `recorded`."""
    try:
        yield
    except CaseError:
        raise
    except (ValueError, ReadError) as cause:
        text = str(cause).removeprefix(str(data)).lstrip(",: ")
        with recorded(data, as_json):
            raise CaseError([Finding(text, source=str(data))]) from None


def read_task(case: Path, settings: Sequence[str] | None, *, as_json: bool) -> tuple[Case, Task]:
    """A case with a problem that may have a solution. Raises CaseError, see `recorded`."""
    with recorded(case, as_json):
        read = read_case(case, parse_overrides(settings))
        with solvable(read, str(case)):
            return read, read.task


def invalid_record(source: str, error: CaseError | None, warnings: Sequence[str] = ()) -> dict[str, Any]:
    """The JSON object of a checked case: its errors (none where it is valid) and warnings."""
    findings = [finding.record() for finding in error.findings] if error else []
    return {"case": source, "valid": error is None, "errors": findings, "warnings": list(warnings)}


def report_stale(pictures: Iterable[Path], written: Iterable[Path]) -> None:
    """Report which of `pictures` were there before and do not show what has been `written` beside them now."""
    stale = sorted(str(path) for path in set(pictures) - set(written) if path.exists())
    if stale:
        streams.note(f"thermoroll: left from an earlier run, not updated: {', '.join(stale)}")


def check_writable(folder: Path) -> None:
    """Create `folder` if need be and check that files can be written there. Raises OSError with a plain message."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Permission bits are not enough (root, read-only mounts), so a file is tried.
        with tempfile.TemporaryFile(dir=folder):
            pass
    except FileExistsError:
        raise OSError(f"cannot write to {folder}: that is a file, not a folder") from None
    except OSError as cause:
        raise OSError(f"cannot write to {folder}: {cause.strerror or cause}") from None
