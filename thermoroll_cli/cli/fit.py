"""`thermoroll fit`: values of a case from measurements."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.deliver import Ending, Outcome, deliver
from thermoroll_cli.cli.tables import align
from thermoroll_cli.files.case import Case, case_name
from thermoroll_cli.plots import style
from thermoroll_cli.problem.names import unit_of
from thermoroll_cli.studies.sweeps import fit as fitting
from thermoroll_cli.studies.sweeps.measured import Measured

if TYPE_CHECKING:
    from thermoroll_cli.cli.report import Section


def fit(
    case: options.OneCase,
    data: Annotated[
        Path,
        typer.Argument(metavar="DATA.csv", help="Measured points: columns of keys that were varied, of scalars that were "
                       "measured (also force_x_over_load), and NAME_error for standard deviations."),
    ],
    free: Annotated[
        list[str],
        typer.Option("--free", metavar="KEY[=LOW:HIGH]", autocompletion=options.keys_like,
                     help="A key whose value is sought, in its range. It begins at the value in the case. Repeatable."),
    ],
    output: options.Output = options.RESULTS,
    jobs: options.Jobs = 1,
    skip_failed: Annotated[
        bool, typer.Option("--skip-failed", help="Leave out measured points that have no steady state in the case.")
    ] = False,
    force: options.Force = False,
    settings: options.Settings = None,
    as_json: options.AsJson = False,
    no_plots: options.NoPlots = False,
    plots: options.Plots = None,
    formats: options.Formats = None,
    dpi: options.Dpi = None,
    written_report: options.Report = False,
    quiet: options.Quiet = False,
    verbose: options.Trace = False,
) -> None:
    """Find values of a case from measurements: least squares, with 95 % intervals.

    Writes DIR/NAME_fit.toml (the case with the values found), DIR/NAME_fit.json and DIR/NAME_fit.png. A value that the data
    do not determine is named in a warning and has no interval. The exit code is 4 if the fit does not converge.
    """
    with options.recorded(case, as_json), options.usage("--free"):
        read = fitting.case_of_fit(options.read_source(case, options.parse_overrides(settings)), case_name(case), free)
        with options.solvable(read, str(case)):
            read.task  # noqa: B018  # asked for its errors
        fitting.Free.parse_all(free, read)
    with options.read_data(data, as_json):
        measured = Measured.read(data)
    asked = fitting.asked_of(read, measured, free)
    if not force:
        fitting.check_replaced(output / f"{read.name}_fit.json", asked)
    options.check_writable(output)

    def report(count: int) -> None:
        if not quiet:
            streams.note(f"thermoroll: {read.name}: {count} cases solved")

    with options.read_data(data, as_json), options.recorded(case, as_json):
        found = fitting.fit(read, measured, free, jobs=jobs, skip_failed=skip_failed, report=report)
    to = Ending(output, as_json, options.plots_of(read, plots, no_plots), formats, dpi, written_report, quiet)
    raise typer.Exit(deliver(Fitted(read, found, asked), to))


@dataclass
class Fitted(Outcome):
    """The values `found` for a case, of which this was `asked`."""

    case: Case
    found: fitting.Fit
    asked: Mapping[str, Any]

    def __post_init__(self) -> None:
        self.name, self.stem = self.case.name, f"{self.case.name}_fit"
        self.reason, self.warnings = self.found.reason, self.found.warnings

    def write(self, folder: Path) -> Iterable[Path]:
        return self.found.save(folder, self.name, self.asked)

    def draw(self, to: Ending) -> list[Path]:
        return to.drawn(self.stem, lambda path: self._draw(path, to.dpi))

    def _draw(self, path: Path, dpi: float | None = None) -> Path:
        with style.applied():
            return style.save(self.found.figure(), path, dpi)

    def section(self, folder: Path) -> Section:
        from thermoroll_cli.cli import report as page

        found = self.found
        return page.Section(
            self.case.settings.title or self.name,
            [f"A fit of {', '.join(found.parameters)} to {len(found.measured)} measured points."], found.reason, found.warnings,
            [page.ReportTable(_values(found), ("", "value ± 95 %", "unit"), values=(1, 2))],
            page.picture("fit", self._draw),
            self.case.text, page.METHOD + " The values are those of least squares; the number behind ± is their 95 % interval.",
            estimated=False)  # fmt: skip

    def record(self) -> Mapping[str, Any]:
        return self.found.record()

    def lines(self) -> list[str]:
        found = self.found
        state = "converged" if found.converged else "NOT CONVERGED"
        if doubtful := [f"{key} {one.doubt}" for key, one in found.parameters.items() if one.doubt]:
            state += f" ({', '.join(doubtful)})"
        free = found.degrees_of_freedom
        return [f"{self.name}: fit {state}, {len(found.measured)} points, {free} degree{'s' * (free != 1)} of freedom",
                *align([("value", "± 95 %", ""), *_values(found)])]


def _values(found: fitting.Fit) -> list[tuple[str, str, str]]:
    """Key, value with its interval, and unit of each value; then what is left of each scalar."""
    values = [(key, one.text + one.remark, unit_of(key)) for key, one in found.parameters.items()]
    return values + [(f"rms of {scalar}", f"{value:.4g}", unit_of(scalar)) for scalar, value in found.rms.items()]
