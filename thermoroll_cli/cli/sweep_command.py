"""`thermoroll sweep`: solve a case for every combination of values of some of its keys."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.exits import ExitCode
from thermoroll_cli.cli.sweep_progress import SweepProgress
from thermoroll_cli.files.environment import rare_collections
from thermoroll_cli.interruption import import_in_steps

if TYPE_CHECKING:
    from thermoroll_cli.files.case import Override
    from thermoroll_cli.sweeps.axis import Axis
    from thermoroll_cli.sweeps.points import Point
    from thermoroll_cli.sweeps.scalars_only import ScalarSweep
    from thermoroll_cli.sweeps.sweep import Sweep
    from thermoroll_cli.sweeps.table import Row

SHOWN_ERRORS = 10
SHOWN_FAILURES = 5


def sweep(
    case: options.OneCase,
    over: Annotated[
        list[str],
        typer.Option(
            "--over",
            metavar="KEY=VALUES",
            help="A numeric key of the case and its values: KEY=START:STOP:COUNT, the same with :log, or KEY=v1,v2,… "
            "Repeatable: every combination is a point, the last key varies fastest.",
        ),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the results.")] = Path("results"),
    jobs: Annotated[int, typer.Option("--jobs", "-j", min=1, metavar="N", help="Processes on this machine.")] = 1,
    dask: Annotated[str, typer.Option("--dask", metavar="ADDRESS", help="Use the Dask cluster of this scheduler.")] = "",
    resume: Annotated[bool, typer.Option("--resume", help="Leave out points that DIR has already.")] = False,
    scalars_only: Annotated[
        bool, typer.Option("--scalars-only", help="No file per point: all rows in DIR/sweep.h5, for very many points.")
    ] = False,
    settings: options.Settings = None,
    as_json: options.AsJson = False,
    no_plots: Annotated[bool, typer.Option("--no-plots", help="Draw no picture.")] = False,
    threads: Annotated[int, typer.Option("--threads", min=1, metavar="N", help="Threads of the transforms.")] = 1,
    image_format: options.Format = options.ImageFormat.png,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Solve a case for many values of some of its keys.

    Writes DIR/NAME_0001.h5, …, a table DIR/sweep.csv and a picture DIR/sweep.png of the scalars. All points are checked
    before the first is solved. A point that fails becomes a row with its reason, the sweep goes on, and the exit code is
    4. The results are the same whatever --jobs, --dask and --resume.
    """
    axes, overrides = _asked(over, settings, jobs=jobs, dask=dask, threads=threads, scalars_only=scalars_only)
    if scalars_only:
        from thermoroll_cli.cli.scalar_sweep import solve_scalars_only

        picture_path = None if no_plots else output / f"sweep.{image_format.value}"
        rows_only = _scalar_sweep(case, axes, overrides, output, jobs=jobs, dask=dask, resume=resume, threads=threads)
        raise typer.Exit(solve_scalars_only(rows_only, as_json=as_json, picture=picture_path, quiet=quiet))
    points = _points(case, axes, overrides)
    options.check_writable(output)
    import_in_steps("numpy", "h5py")
    from thermoroll_cli.sweeps.sweep import Sweep

    command_line = shlex.join(["thermoroll", *sys.argv[1:]])
    wanted = Sweep(points, axes, output, command_line, jobs=jobs, dask=dask, resume=resume, threads=threads)
    rows = _solved(wanted, as_json=as_json, quiet=quiet, verbose=verbose)
    picture = None
    if not no_plots and _plots_wanted(points[0]):
        picture = _draw(rows, axes, output / f"sweep.{image_format.value}")
    if not quiet:
        options.tell_stale((output / f"sweep.{each.value}" for each in options.ImageFormat), [picture] if picture else [])
    if not (as_json or quiet):
        for line in _report(rows, axes, output, picture):
            streams.write(line)
    raise typer.Exit(_tell_failures(rows))


def _solved(sweep: Sweep, *, as_json: bool, quiet: bool, verbose: bool) -> list[Row]:
    """The rows of all points, reported as they are solved."""
    from thermoroll_cli.sweeps.sweep import run_sweep

    rare_collections()
    progress = SweepProgress(len(sweep.points), quiet=quiet, verbose=verbose)
    printer = _JsonPrinter(sweep.axes) if as_json else None

    def report(row: Row, solved: bool) -> None:
        outcome = "converged" if row.converged else f"NOT CONVERGED: {row.reason}"
        progress.step(row.point.name, _values(row, sweep.axes), outcome, solved=solved)
        if printer is not None:
            printer.add(row)

    try:
        return run_sweep(sweep, report=report, note=progress.note)
    finally:
        progress.close()


def _asked(
    over: Sequence[str], settings: Sequence[str] | None, *, jobs: int, dask: str, threads: int, scalars_only: bool = False
) -> tuple[tuple[Axis, ...], list[Override]]:
    """What the options ask for. Ends the program (usage) where they make no sense."""
    from thermoroll_cli.sweeps.axis import MOST_POINTS, MOST_ROWS, parse_axes

    overrides = options.parse_overrides(settings)
    try:
        axes = parse_axes(over, MOST_ROWS if scalars_only else MOST_POINTS)
    except ValueError as cause:
        raise typer.BadParameter(str(cause), param_hint="--over") from None
    both = next((axis.key for axis in axes if any(item.path == axis.path for item in overrides)), None)
    if both is not None:
        raise typer.BadParameter(f"{both} is swept with --over", param_hint="--set")
    options.check_cluster(dask, jobs)
    if threads > 1 and (jobs > 1 or dask):
        raise typer.BadParameter("several processes have one thread each", param_hint="--threads")
    return axes, overrides


def _scalar_sweep(path: Path, axes: Sequence[Axis], overrides: Sequence[Override], folder: Path, **wishes: Any) -> ScalarSweep:
    """The sweep without files for points. Ends the program (invalid case) if the case cannot be read."""
    from thermoroll_cli.files.case import CaseError, case_name
    from thermoroll_cli.files.case_source import read_source
    from thermoroll_cli.sweeps.points import PointMaker
    from thermoroll_cli.sweeps.scalars_only import ScalarSweep

    try:
        source = read_source(path)
    except CaseError as cause:
        raise typer.Exit(options.tell_invalid([cause], "; nothing was computed")) from None
    options.check_writable(folder)
    maker = PointMaker(source.text, source.name, case_name(path), tuple(axes), tuple(overrides))
    return ScalarSweep(maker, folder, shlex.join(["thermoroll", *sys.argv[1:]]), **wishes)


def _points(path: Path, axes: Sequence[Axis], overrides: Sequence[Override]) -> tuple[Point, ...]:
    """All points. Ends the program (invalid case) if any of them is none that can be solved."""
    from thermoroll_cli.files.case import CaseError, case_name
    from thermoroll_cli.files.case_source import read_source
    from thermoroll_cli.sweeps.points import make_points

    try:
        source = read_source(path)
        return make_points(source.text, source.name, case_name(path), axes, overrides)
    except CaseError as cause:
        more = len(cause.findings) - SHOWN_ERRORS
        closing = f" of {len(cause.findings)}" if more > 0 else ""
        shown = CaseError(cause.findings[:SHOWN_ERRORS])
        raise typer.Exit(options.tell_invalid([shown], f"{closing}; nothing was computed")) from None


def _plots_wanted(point: Point) -> bool:
    import json

    return bool(json.loads(point.case_json).get("output", {}).get("plots", True))


def _draw(rows: Sequence[Row], axes: Sequence[Axis], path: Path) -> Path | None:
    from thermoroll_cli.sweeps.table import draw

    return path if draw(rows, axes, path, rows[0].point.problem.title) else None


class _JsonPrinter:
    """Prints rows as JSON in the order of the points, each as soon as all before it are known."""

    def __init__(self, axes: Sequence[Axis]) -> None:
        self._axes = axes
        self._waiting: dict[int, Row] = {}
        self._next = 1

    def add(self, row: Row) -> None:
        self._waiting[row.point.number] = row
        while self._next in self._waiting:
            streams.write_json(_record(self._waiting.pop(self._next), self._axes))
            self._next += 1


def _record(row: Row, axes: Sequence[Axis]) -> dict[str, Any]:
    head = {"name": row.point.name, "title": row.point.problem.title, "over": _values(row, axes)}
    return {**head, **row.summary, "files": [row.file] if row.file else []}


def _values(row: Row, axes: Sequence[Axis]) -> dict[str, int | float]:
    return {axis.key: value for axis, value in zip(axes, row.point.values, strict=True)}


def _report(rows: Sequence[Row], axes: Sequence[Axis], folder: Path, picture: Path | None) -> Iterator[str]:
    from thermoroll_cli.cli.sweep_table import table_lines
    from thermoroll_cli.sweeps.sweep import TABLE_NAME

    yield from table_lines(rows, axes, streams.width())
    converged = sum(row.converged for row in rows)
    yield f"{converged} of {len(rows)} points converged"
    files = sum(row.file is not None for row in rows)
    also = f", {picture}" if picture else ""
    yield f"  wrote {folder / TABLE_NAME}{also} and {files} result file{'s' if files != 1 else ''}"


def _tell_failures(rows: Sequence[Row]) -> int:
    failed = [row for row in rows if not row.converged]
    for row in failed[:SHOWN_FAILURES]:
        streams.note(f"thermoroll: {row.point.name} did not converge: {row.reason}")
    if len(failed) > SHOWN_FAILURES:
        streams.note(f"thermoroll: and {len(failed) - SHOWN_FAILURES} more, see the column reason of the table")
    return ExitCode.NOT_CONVERGED if failed else ExitCode.FINE
