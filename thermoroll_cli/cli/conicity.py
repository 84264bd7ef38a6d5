"""`thermoroll conicity`: the equivalent conicity of a wheelset on its track."""

from __future__ import annotations

from typing import Annotated

import typer

from thermoroll_cli.atomic import write_bytes
from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.tables import folded
from thermoroll_cli.files.csv_table import csv_text
from thermoroll_cli.python_api import conicity as conicity_of
from thermoroll_cli.sweeps.points import Axis
from thermoroll_cli.wheelset.conicity import NUMBERS

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
    formats: options.Formats = None,
    report: options.Report = False,
    quiet: options.Quiet = False,
) -> None:
    """Equivalent conicity after EN 15302 of the wheelset of a case, from profiles and gauge alone: nothing is loaded.

    Writes DIR/NAME_conicity.csv (conicity over the amplitude), DIR/NAME_shifts.csv (difference of the rolling radii and places
    of contact over the lateral shift) and the picture DIR/NAME_conicity.png.
    """
    with options.usage("--amplitude"):
        amplitudes = Axis.parse(f"amplitude={amplitude}").values
    with options.recorded(case, as_json):
        read = options.read_case(case, options.parse_overrides(settings))
        with options.usage("--amplitude"), options.solvable(read, str(case)):
            found = conicity_of(read, amplitudes)  # type: ignore[arg-type]
    options.check_writable(output)
    record, files = found.record(), []
    for kind, columns in TABLES.items():
        files.append(output / f"{read.name}_{kind}.csv")
        write_bytes(files[-1], csv_text(columns, zip(*(record[name] for name in columns), strict=True)).encode())
    if read.plots and not no_plots:
        from thermoroll_cli.plots.conicity_figure import draw_conicity

        files += [draw_conicity(output / f"{read.name}_conicity.{ending}", found, read.settings.title)
                  for ending in options.image_formats(formats)]
    if report:
        from thermoroll_cli.cli import report as page

        files.append(page.write(output / f"{read.name}_conicity_report.html", [page.of_conicity(found, read)]))
    if as_json:
        streams.write_json({"name": read.name, **record, "files": [str(file) for file in files]})
    elif not quiet:
        for name, meaning in NUMBERS.items():
            streams.write(f"  {name:18} {'none' if record[name] is None else f'{record[name]:.3f}':8} {meaning}")
        for warning in found.warnings:
            streams.write(*folded(f"warning: {warning}", streams.width()))
        streams.write(*folded(f"wrote {', '.join(map(str, files))}", streams.width()))
