"""`thermoroll sweep`: solve cases for many values of some of their keys."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.deliver import Ending, NoPicture, Outcome, deliver
from thermoroll_cli.cli.progress import PointsProgress
from thermoroll_cli.cli.streams import ExitCode
from thermoroll_cli.cli.tables import SHOWN_ROWS, folded, sweep_table, warnings_by_kind
from thermoroll_cli.exact.kalker import THEORIES
from thermoroll_cli.files.case import CaseError, Override, case_name, shown
from thermoroll_cli.files.table_file import read_table
from thermoroll_cli.problem.limits import Limit, not_there
from thermoroll_cli.problem.names import check_scalar
from thermoroll_cli.problem.scalar_errors import with_error
from thermoroll_cli.studies.sweeps.measured import Measured
from thermoroll_cli.studies.sweeps.points import MOST_POINTS, MOST_ROWS, Axis, Base, Points, parse_axes, read_points
from thermoroll_cli.studies.sweeps.sweep import ARRAYS_NAME, TABLE_NAME, Sweep
from thermoroll_cli.studies.sweeps.table import Row, Rows, columns_of
from thermoroll_cli.tools.runner import Workers

if TYPE_CHECKING:
    from thermoroll_cli.cli.report import Section

SHOWN_FAILURES = 5


def sweep(
    cases: options.Cases,
    over: Annotated[
        list[str] | None,
        typer.Option(
            "--over",
            metavar="KEY=VALUES",
            autocompletion=options.keys_like,
            help="A key of the case and its values: KEY=START:STOP:COUNT, the same with :log, or KEY=v1,v2,… with numbers or "
            "words. Repeatable: every combination is a point, the last key varies fastest.",
        ),
    ] = None,
    listed: Annotated[
        Path | None, typer.Option("--points", metavar="FILE.csv", help="A header line of keys, and a line for each point; "
                                  "columns that begin with # are labels.")
    ] = None,
    output: options.Output = options.RESULTS,
    jobs: options.Jobs = 1,
    dask: options.Dask = "",
    dask_wait: options.DaskWait = Workers.patience,
    resume: Annotated[bool, typer.Option("--resume", help="Leave out points that DIR has already.")] = False,
    force: options.Force = False,
    scalars_only: Annotated[
        bool, typer.Option("--scalars-only", help="No file per point: all rows in DIR/sweep.h5, for very many points.")
    ] = False,
    settings: options.Settings = None,
    as_json: options.AsJson = False,
    no_plots: options.NoPlots = False,
    plots: options.Plots = None,
    threads: options.Threads = 1,
    formats: options.Formats = None,
    dpi: options.Dpi = None,
    over_x: options.Over = "",
    columns: options.Columns = "",
    limits: options.Limits = None,
    compare: options.Compare = "",
    report: options.Report = False,
    data: options.Data = None,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Solve cases for many values of some of their keys.

    Writes DIR/NAME_0001.h5, …, a table DIR/sweep.csv and a picture DIR/sweep.png of the scalars. Several cases are solved at
    the same points; the first column, case, tells them apart, and the picture has a curve of each. All points are checked
    before the first is solved. A point that fails becomes a row with its reason, the sweep goes on, and the exit code is
    4. The results are the same whatever --jobs, --dask and --resume.
    """
    overrides, theories = options.parse_overrides(settings), options.words(compare)
    if unknown := next((name for name in theories if name not in THEORIES), None):
        raise typer.BadParameter(f"there are {', '.join(THEORIES)}, not {unknown!r}", param_hint="--compare")
    kept, only = options.parse_limits(limits), options.words(columns)
    with options.usage("--columns"):
        for name in only:
            check_scalar(name)
    axes = _axes(over or [], listed, overrides, scalars_only=scalars_only)
    with options.usage("--measured"):
        measured = None if data is None else Measured.read(data)
    options.check_cluster(dask, jobs)
    options.check_not_both(resume, force)
    if threads > 1 and (jobs > 1 or dask):
        raise typer.BadParameter("several processes have one thread each", param_hint="--threads")
    options.check_standard_input(cases)
    bases = list[Base]()
    for path in cases:
        with options.recorded(path, as_json):
            source = options.read_source(path)
        bases.append(Base(source.text, source.name, case_name(path)))
    with options.usage("CASE..."):
        points = Points.of(bases, axes, overrides, listed=listed is not None, origin="--points" if listed else "--over",
                           most=MOST_ROWS if scalars_only else MOST_POINTS)  # fmt: skip
    if over_x and over_x not in [axis.key for axis in points.axes if len(set(axis.values)) > 1]:
        raise typer.BadParameter(f"{over_x} is not varied, but {', '.join(axis.key for axis in points.axes)}", param_hint="--x")
    wanted = Sweep(points, output, options.command_line(), Workers(jobs, dask, dask_wait), resume, scalars_only, threads, force,
                   kept)
    try:
        with options.recorded(Path(", ".join(map(str, cases))), as_json):
            wanted.check((lambda text: None) if quiet else (lambda text: streams.note(f"thermoroll: {text}")))
    except CaseError as cause:
        closing = f" of {len(cause.findings)}" if len(cause.findings) > 10 else ""
        raise typer.Exit(streams.report_invalid([CaseError(cause.findings[:10])], f"{closing}; nothing was computed")) from None
    options.check_writable(output)
    firsts = [points.case(number) for number in range(1, points.count + 1, points.per_case)]
    rows, failures = _solved(wanted, as_json=as_json, quiet=quiet, verbose=verbose)
    to = Ending(output, as_json, options.plots_of(firsts[0], plots, no_plots), formats, dpi, report, quiet)
    asked = (*(name for first in firsts for name in first.settings.numerics.accuracy_of or ()),
             *(limit.scalar for limit in kept), *only)  # fmt: skip
    names = ", ".join(base.stem for base in bases)
    found = Swept(names, wanted, rows, failures, wanted.title, theories, measured, over_x, only, asked, as_json)
    raise typer.Exit(found.held(deliver(found, to), loud=quiet or as_json))


@dataclass
class Swept(Outcome):
    """All `rows` of a sweep over the case `name`, or over several, with the number of `failures` among them. The picture is
    drawn over `x`, of `only` some scalars; what is `asked` for is printed first. With `as_json` rows and warnings have been
    printed."""

    name: str
    sweep: Sweep
    rows: Rows
    failures: int
    title: str
    theories: Sequence[str]
    measured: Measured | None
    x: str
    only: Sequence[str]
    asked: Sequence[str]
    as_json: bool

    def __post_init__(self) -> None:
        self.stem = "sweep"
        if self.failures:
            self.reason = (f"{self.failures} of {len(self.rows)} points: see the column reason of "
                           f"{self.sweep.folder / TABLE_NAME}")
        if not self.as_json:
            self.warnings = list(warnings_by_kind((row.name, row.summary["warnings"]) for row in self.rows))
        self.warnings = [*self.warnings, *(columns_of(self.rows, self.title).lacks(self.only) if self.only else ())]
        if files := len({row.file for row in self.rows if row.file is not None}):
            self.also = f" and {files} result file{'s' if files != 1 else ''}"

    def write(self, folder: Path) -> list[Path]:
        return [folder / name for name in ((ARRAYS_NAME, TABLE_NAME) if self.sweep.scalars_only else (TABLE_NAME,))]

    def draw(self, to: Ending) -> list[Path]:
        from thermoroll_cli.studies.sweeps.table_picture import draw_table

        table = columns_of(self.rows, self.title)
        try:
            return to.drawn(self.stem, lambda path: draw_table(table, path, compare=self.theories, dpi=to.dpi,
                                                               measured=self.measured, x=self.x, only=self.only))
        except ValueError as cause:
            raise NoPicture(cause) from None

    def section(self, folder: Path) -> Section:
        from thermoroll_cli.cli import report as page

        return page.of_columns(read_table(folder / (ARRAYS_NAME if self.sweep.scalars_only else TABLE_NAME)), self.name)

    def record(self) -> None:
        return None

    def lines(self) -> Iterator[str]:
        if len(self.rows) <= SHOWN_ROWS:
            yield from sweep_table(list(self.rows), self.sweep.points, streams.width(), self.asked)
        yield f"{len(self.rows) - self.failures} of {len(self.rows)} points converged"
        for limit, exceeded, count, _ in self._limits():
            text = f"{limit.text}: " + (f"NOT MET at {len(exceeded)} of {count} points: {'; '.join(exceeded[:SHOWN_FAILURES])}"
                                        if exceeded else f"met at {count} point{'s' if count != 1 else ''}")
            yield from streams.in_colour(folded(text, streams.width()), streams.RED) if exceeded else folded(
                text, streams.width())

    def _limits(self) -> Iterator[tuple[Limit, list[str], int, str]]:
        """Each limit with the points where it is exceeded, in words, the number of those that it is held against, and what is
        wrong with it, if there is none."""
        for place, limit in enumerate(self.sweep.limits):
            known = [(row.name, one) for row in self.rows if (one := row.judged[place]) is not None]
            exceeded = [f"{name} ({with_error(one.value, one.error)})" for name, one in known if not one.met]
            some = next((row for row in self.rows if row.converged), None)
            yield limit, exceeded, len(known), "" if known or some is None else not_there(limit, some.cells())

    def held(self, code: ExitCode, *, loud: bool) -> ExitCode:
        """The exit code with that of the limits, `loud` also in words; points that did not converge keep their own."""
        limits = [*self._limits()] if code is ExitCode.FINE else []
        for _, _, _, fault in limits:
            if fault:
                streams.error(f"{self.name}: {fault}")
                return ExitCode.USAGE
        for limit, exceeded, _, _ in limits:
            if exceeded and loud:
                streams.error(f"{self.name}: {limit.text}: NOT MET at {'; '.join(exceeded[:SHOWN_FAILURES])}")
        return ExitCode.OUTSIDE_TOLERANCE if any(exceeded for _, exceeded, _, _ in limits) else code


def _axes(over: Sequence[str], listed: Path | None, overrides: Sequence[Override], *, scalars_only: bool) -> tuple[Axis, ...]:
    """The swept keys with their values. Ends the program (usage) where they make no sense."""
    if bool(over) == (listed is not None):
        raise typer.BadParameter("give either --over KEY=VALUES or --points FILE.csv", param_hint="--over")
    hint = "--points" if listed else "--over"
    with options.usage(hint):
        axes = read_points(listed) if listed else parse_axes(over, MOST_ROWS if scalars_only else MOST_POINTS)
    both = next((axis.key for axis in axes if any(item.path == axis.path for item in overrides)), None)
    if both is not None:
        raise typer.BadParameter(f"{both} is swept with {hint}", param_hint="--set")
    return axes


def _solved(sweep: Sweep, *, as_json: bool, quiet: bool, verbose: bool) -> tuple[Rows, int]:
    """The rows of all points, reported as they are solved, and how many did not converge."""
    progress = PointsProgress(sweep.points.count, quiet=quiet, verbose=verbose)
    failures = printed = 0
    waiting: dict[int, Row] = {}
    titles = sweep.titles

    def report(row: Row, solved: bool) -> None:
        nonlocal failures, printed
        where = ", ".join(f"{key} = {shown(value)}" for key, value in row.over.items())
        progress.step(f"{row.name}: {where}: {'converged' if row.converged else 'NOT CONVERGED'}", solved=solved)
        if not row.converged:
            failures += 1
            if failures <= SHOWN_FAILURES:
                streams.note(f"thermoroll: {row.name} did not converge: {row.reason}")
        if as_json:  # in the order of the points, each as soon as all before it are known
            waiting[row.number] = row
        while printed + 1 in waiting:
            printed += 1
            row = waiting.pop(printed)
            limits = {"limits": [one.record() for one in row.judged if one is not None]} if row.limits else {}
            streams.write_json({"name": row.name, "title": titles[sweep.points.base(row.number).stem],
                                "over": row.over, **row.summary, **limits,
                                "files": [row.file] if row.file else []})

    with progress:
        return sweep.run(report=report, note=progress.note), failures
