"""`thermoroll conicity`: the equivalent conicity of a wheelset on its track."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from thermoroll_cli.cli import options
from thermoroll_cli.cli.deliver import Ending, Outcome, deliver
from thermoroll_cli.files.case import Case
from thermoroll_cli.files.csv_table import write_rows
from thermoroll_cli.many_contacts.wheelset.conicity import NUMBERS, Conicity
from thermoroll_cli.python_api import conicity as conicity_of
from thermoroll_cli.studies.sweeps.points import parse_values

if TYPE_CHECKING:
    from thermoroll_cli.cli.report import Section

TABLES = {"conicity": ("amplitude_mm", "conicity", "wavelength_m"),
          "shifts": ("lateral_shift_mm", "rolling_radius_difference_mm", "contact_y_rail_left_mm", "contact_y_wheel_left_mm",
                     "contact_y_rail_right_mm", "contact_y_wheel_right_mm")}  # fmt: skip
"""Columns of the files NAME_conicity.csv and NAME_shifts.csv."""


def conicity(
    case: options.OneCase,
    amplitude: Annotated[str, typer.Option("--amplitude", metavar="START:STOP:COUNT", help="Amplitudes in mm.")] = "1:7.5:66",
    output: options.Output = options.RESULTS,
    settings: options.Settings = None,
    as_json: options.AsJson = False,
    no_plots: options.NoPlots = False,
    plots: options.Plots = None,
    formats: options.Formats = None,
    dpi: options.Dpi = None,
    report: options.Report = False,
    quiet: options.Quiet = False,
    verbose: options.Trace = False,
) -> None:
    """Equivalent conicity after EN 15302 of the wheelset of a case, from profiles and gauge alone: nothing is loaded.

    Writes DIR/NAME_conicity.csv (conicity over the amplitude), DIR/NAME_shifts.csv (difference of the rolling radii and places
    of contact over the lateral shift), DIR/NAME_contacts.csv (points of contact with inclination, curvatures and Hertz's
    semi-axes, for vehicle programs) and the picture DIR/NAME_conicity.png.
    """
    with options.usage("--amplitude"):
        amplitudes = parse_values(amplitude)
    with options.recorded(case, as_json):
        read = options.read_case(case, options.parse_overrides(settings))
        with options.usage("--amplitude"), options.solvable(read, str(case)):
            found = conicity_of(read, amplitudes)  # type: ignore[arg-type]
    options.check_writable(output)
    to = Ending(output, as_json, options.plots_of(read, plots, no_plots), formats, dpi, report, quiet)
    raise typer.Exit(deliver(Found(read, found), to))


@dataclass
class Found(Outcome):
    """The equivalent conicity `found` of the wheelset of a case."""

    case: Case
    found: Conicity

    def __post_init__(self) -> None:
        self.name, self.stem, self.warnings = self.case.name, f"{self.case.name}_conicity", self.found.warnings
        if all(value is None for value in self.record()["conicity"]):
            self.reason = "no amplitude has an equivalent conicity"

    def record(self) -> Mapping[str, Any]:
        return self.found.record()

    def write(self, folder: Path) -> Iterator[Path]:
        record = self.record()
        for kind, columns in TABLES.items():
            path = folder / f"{self.name}_{kind}.csv"
            write_rows(path, columns, zip(*(record[name] for name in columns), strict=True))
            yield path
        path, points = folder / f"{self.name}_contacts.csv", record["contacts"]
        write_rows(path, points, zip(*points.values(), strict=True))
        yield path

    def draw(self, to: Ending) -> list[Path]:
        from thermoroll_cli.plots.conicity_figure import draw_conicity

        return to.drawn(self.stem, lambda path: draw_conicity(path, self.found, self.case.settings.title, to.dpi))

    def section(self, folder: Path) -> Section:
        from thermoroll_cli.cli import report as page

        return page.of_conicity(self.found, self.case)

    def lines(self) -> list[str]:
        record = self.record()
        return [f"  {name:18} {'none' if record[name] is None else f'{record[name]:.3f}':8} {meaning}"
                for name, meaning in NUMBERS.items()]
