"""`thermoroll table build` and `thermoroll table query`: a table of creep forces, and forces from one."""

from __future__ import annotations

import functools
import inspect
import math
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, TypeVar

import numpy as np
import typer

from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.commands import HELP_OPTIONS
from thermoroll_cli.cli.deliver import Ending, Outcome, deliver
from thermoroll_cli.cli.progress import PointsProgress
from thermoroll_cli.cli.streams import ExitCode
from thermoroll_cli.cli.tables import alike, headed
from thermoroll_cli.files.csv_table import write_rows
from thermoroll_cli.problem.columns import CONVERGED, Columns
from thermoroll_cli.problem.friction import FORMULAS, LAW_CONSTANTS, FormulaName, FrictionLaw
from thermoroll_cli.problem.names import UNCERTAINTY
from thermoroll_cli.studies.creep_table.build import TablePlan, build_table, journal_path
from thermoroll_cli.studies.creep_table.creep_force_table import CreepForceTable, Outside, OutsideTable
from thermoroll_cli.studies.creep_table.table_file import (
    DEFAULT_ASPECTS,
    TableAxes,
    TableValues,
    read_table,
    write_csv,
    write_table,
)
from thermoroll_cli.studies.sweeps.points import parse_values
from thermoroll_cli.tools.arrays import Array
from thermoroll_cli.tools.journal import ALTERNATIVES
from thermoroll_cli.tools.runner import Workers

Given = TypeVar("Given")
RANGE = "A number, v1,v2,… or START:STOP:COUNT[:log]."

table = typer.Typer(help="Build a table of creep forces, or query one.", rich_markup_mode=None,
                    add_completion=False, no_args_is_help=True, context_settings=HELP_OPTIONS)  # fmt: skip


def with_law_constants(command: Callable[..., None]) -> Callable[..., None]:
    """`command` with an option for each constant of a law of friction, after `--law`; it gets them as `constants`, by key."""
    @functools.wraps(command)
    def wrapped(**given: Any) -> None:
        constants = {key: given.pop(key) for key in LAW_CONSTANTS}
        command(**given, constants=constants)

    own = inspect.signature(command, eval_str=True)
    parameters = [parameter for name, parameter in own.parameters.items() if name != "constants"]
    added = [inspect.Parameter(key, inspect.Parameter.POSITIONAL_OR_KEYWORD, default=None, annotation=Annotated[
        float | None, typer.Option(_option(key), help=f"{constant.meaning}.")]) for key, constant in LAW_CONSTANTS.items()]
    after = 1 + [parameter.name for parameter in parameters].index("law")
    parameters[after:after] = added
    wrapped.__signature__ = own.replace(parameters=parameters)  # type: ignore[attr-defined]
    wrapped.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return wrapped


def _option(key: str) -> str:
    return f"--{key.replace('_', '-')}"


@table.command()
def build(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="Table to write.")] = Path("creep_forces.h5"),
    aspect: Annotated[
        str, typer.Option("--aspect", metavar="VALUES", help=f"Ratios a/b, a along rolling; increasing. {RANGE}")
    ] = "",
    poisson: Annotated[
        float, typer.Option("--poisson", min=0, max=0.5, metavar="NU", help="Poisson's ratio of both bodies.")
    ] = 0.28,
    accuracy: Annotated[
        float, typer.Option("--accuracy", min=2.5e-4, max=1e-2, metavar="E", help="Error of forces over μW to solve for.")
    ] = 1e-3,
    nodes: Annotated[str, typer.Option("--nodes", metavar="T,A,B", help="Magnitudes, directions, spins.")] = "25,13,41",
    checks: Annotated[int, typer.Option("--checks", min=0, metavar="N", help="Random points to measure errors at.")] = 1000,
    jobs: options.Jobs = 1,
    dask: options.Dask = "",
    dask_wait: options.DaskWait = Workers.patience,
    resume: Annotated[bool, typer.Option("--resume", help="Go on where a build was stopped.")] = False,
    force: options.Force = False,
    csv: Annotated[Path | None, typer.Option("--csv", metavar="FILE", help="Write the table as CSV, too.")] = None,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
    verbose: options.Trace = False,
) -> None:
    """Build a table of creep forces.

    Solves every point of a grid over a/b, magnitude and direction of the creepages, and as many random points again to state
    the table's errors. A table for Poisson's ratio 0.28 comes with the program: see `query`.
    """
    counts = options.numbers(nodes, 3, "three whole numbers T,A,B", "--nodes", int)
    ratios = _values(aspect, "--aspect") if aspect else DEFAULT_ASPECTS
    with options.usage("--aspect, --nodes"):
        plan = TablePlan(TableAxes(ratios, *counts), poisson, accuracy, checks)
    options.check_cluster(dask, jobs)
    options.check_not_both(resume, force)
    place = Path(os.path.realpath(output)).parent  # which a link to itself has, too
    options.check_writable(place)
    there = None
    if output.exists() and not journal_path(output).exists():
        try:
            there = read_table(output)
        except OSError as cause:
            raise typer.BadParameter(f"{cause}: it is not overwritten; remove it, or give another name",
                                     param_hint="--output") from None
    same = there and (there.axes, there.poisson_ratio, there.accuracy) == (plan.axes, plan.poisson_ratio, plan.accuracy)
    if there and not same and not force:
        raise FileExistsError(f"{output} is {_said(there)}, not {_said(plan)}: {ALTERNATIVES}")
    if resume and there:
        streams.note(f"thermoroll: {output} is built already")
        built = there
    else:
        with PointsProgress(plan.points, quiet=quiet, lines=False) as progress:
            built = build_table(plan, output, workers=Workers(jobs, dask, dask_wait), resume=resume, force=force,
                                note=progress.note,
                                report=lambda count, solved: progress.step("", count, solved=solved))  # fmt: skip
        write_table(output, built, command_line=options.command_line())
        journal_path(output).unlink(missing_ok=True)

    raise typer.Exit(deliver(Built(output, built, csv), Ending(place, as_json, quiet=quiet)))


def _said(of: TablePlan | TableValues) -> str:
    """Which table it is."""
    axes = of.axes
    return (f"a table of {len(axes.aspect_ratios)} ratios a/b with {axes.magnitudes},{axes.directions},{axes.spins} nodes, "
            f"Poisson's ratio {of.poisson_ratio:g}, accuracy {of.accuracy:g}")


@dataclass
class Built(Outcome):
    """A table that has been written to `file`, and is wanted as `csv`, too."""

    file: Path
    built: TableValues
    csv: Path | None

    def __post_init__(self) -> None:
        self.name, self.stem = self.file.name, self.file.stem
        if holes := self.built.holes:
            self.reason = f"{holes} points are holes of the table, filled from their neighbours"

    def write(self, folder: Path) -> Iterator[Path]:
        yield self.file
        if self.csv is not None:
            write_csv(self.csv, self.built)
            yield self.csv

    def pictures(self, folder: Path) -> tuple[str, ...]:
        return ()

    def record(self) -> Mapping[str, Any]:
        built = self.built
        return {"file": self.file, "holes": built.holes, "points": built.errors[:, 1:].size, **vars(built.quality)}

    def lines(self) -> Iterator[str]:
        built, quality = self.built, self.built.quality
        yield f"{built.errors[:, 1:].size} points solved, {built.holes} of them without a solution"
        yield f"  errors of forces over μW: solver {quality.solver_rms:.1e} (rms), {quality.solver_max:.1e} (largest)"
        if quality.points:
            yield (f"  table against solver at {quality.points} random points: {quality.rms:.1e} (rms), "
                   f"{quality.largest:.1e} (largest)")


@table.command()
@with_law_constants
def query(
    file: Annotated[
        Path | None, typer.Argument(metavar="[TABLE.h5]", help="A table; without it the one that comes with the program.")
    ] = None,
    longitudinal: Annotated[str, typer.Option("--longitudinal", metavar="VALUES", help=f"Creepage. {RANGE}")] = "0",
    lateral: Annotated[str, typer.Option("--lateral", metavar="VALUES", help=f"Creepage. {RANGE}")] = "0",
    spin: Annotated[str, typer.Option("--spin-rad-mm", metavar="VALUES", help=f"Spin. {RANGE}")] = "0",
    semi_axes: Annotated[str, typer.Option("--semi-axes-mm", metavar="A,B", help="a along rolling, b.")] = "",
    modulus: Annotated[float | None, typer.Option("--shear-modulus-GPa", help="Combined shear modulus.")] = None,
    friction: Annotated[float | None, typer.Option("--friction", help="Coefficient of friction, without slip.")] = None,
    load: Annotated[float | None, typer.Option("--normal-N", help="Normal force.")] = None,
    law: Annotated[FormulaName | None, typer.Option("--law", help="Friction that falls with slip; approximately.")] = None,
    constants: Mapping[str, float | None] = MappingProxyType({}),
    speed: Annotated[float | None, typer.Option("--speed-m-s", help="Rolling speed, for a law of friction.")] = None,
    outside: Annotated[Outside, typer.Option("--outside", help="a/b not in the table.")] = "error",
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Write the forces as CSV; without a contact, the table.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Picture of the forces over the creepage with most values "
                                  "(.png, .svg, .pdf).")
    ] = None,
    as_json: options.AsJson = False,
) -> None:
    """Print the forces at given creepages.

    Every combination of the values is a row; the last creepage varies fastest.

    Errors are the largest of the table, measured at random points; they are smaller if the forces are small beside μW.

    With a law of friction, the table is queried with an equivalent coefficient. The errors include that of this approximation,
    up to 0.2 of the loss of friction (with spin 0.6).
    """
    table = CreepForceTable.default() if file is None else CreepForceTable.read(file)
    if csv is not None and not semi_axes:
        write_csv(csv, table.values)
        raise typer.Exit
    a, b = options.numbers(_given("--semi-axes-mm", semi_axes or None), 2, "two numbers A,B", "--semi-axes-mm")
    stiffness, at_rest, pressing = (
        _given("--shear-modulus-GPa", modulus), _given("--friction", friction), _given("--normal-N", load))
    try:
        falling, rolling = None, math.nan
        own = [] if law is None else [constant.key for constant in FORMULAS[law].constants]
        for key in (key for key, value in constants.items() if value is not None and key not in own):
            raise ValueError(f"{_option(key)} belongs to no law" if law is None else f"{_option(key)} is none of --law {law}")
        if law is not None:
            falling, rolling = _falling(law, constants, at_rest), _given("--speed-m-s", speed)
        elif speed is not None:
            raise ValueError("--speed-m-s belongs to no law")
        given = _values(longitudinal, "--longitudinal"), _values(lateral, "--lateral"), _values(spin, "--spin-rad-mm")
        xi, eta, phi = (np.asarray(grid, dtype=float).ravel() for grid in np.meshgrid(*given, indexing="ij"))
        forces = table.forces(xi, eta, phi * 1e3, semi_axes=(a * 1e-3, b * 1e-3), shear_modulus=stiffness * 1e9,
                              friction=at_rest, load=pressing, outside=outside, law=falling, speed=rolling)
    except OutsideTable as cause:
        streams.error(f"{file or 'the table that comes with the program'}: {cause}")
        raise typer.Exit(ExitCode.INVALID_CASE) from None
    except ValueError as cause:
        raise typer.BadParameter(f"{cause}: --semi-axes-mm, --shear-modulus-GPa, --friction, --normal-N, --law") from None
    columns = {
        "creepage_longitudinal": xi, "creepage_lateral": eta, "creepage_spin_rad_mm": phi, "force_x_N": forces.force_x,
        "force_y_N": forces.force_y, "force_error_N": forces.error, "spin_moment_Nmm": forces.spin_moment * 1e3,
        "spin_moment_error_Nmm": forces.spin_moment_error * 1e3, "T_gamma_N": forces.t_gamma,
        "T_gamma_error_N": forces.t_gamma_error, "gamma_st": forces.stick_fraction,
        "poisson_ratio": np.full_like(xi, table.values.poisson_ratio)}
    if plot is not None:
        with options.usage("--plot"):
            _draw(plot, columns, f"a = {a:g} mm, b = {b:g} mm, μ = {at_rest:g}, W = {pressing:g} N")
    # Symmetry leaves −0, which reads as a number that is not 0.
    rows = list(zip(*((values + 0.0).tolist() for values in columns.values()), strict=True))
    if csv is not None:
        write_rows(csv, columns, rows)
    if as_json:
        for row in rows:
            streams.write_json(dict(zip(columns, row, strict=True)))
    else:
        texts = (alike([f"{value:.6g}" for value in column]) for column in zip(*rows, strict=True))
        streams.write(*headed([[*columns], *zip(*texts, strict=True)]))


def _draw(path: Path, columns: Mapping[str, Array], contact: str) -> None:
    """The forces of a query as the picture of a sweep. Raises ValueError where there is nothing to draw, or no such format."""
    from thermoroll_cli.studies.sweeps.table_picture import draw_table

    keys = {"creepage.longitudinal": "creepage_longitudinal", "creepage.lateral": "creepage_lateral",
            "creepage.spin_rad_mm": "creepage_spin_rad_mm"}
    errors = {"force_x_N": "force_error_N", "force_y_N": "force_error_N", "spin_moment_Nmm": "spin_moment_error_Nmm"}
    shown = {**{key: columns[name] for key, name in keys.items()},
             **{name: columns[name] for name in (*errors, "gamma_st")},
             **{f"{UNCERTAINTY}{name}": columns[error] for name, error in errors.items()}}
    table = {name: column.tolist() for name, column in shown.items()} | {"status": [CONVERGED] * len(columns["force_x_N"])}
    if why_not := draw_table(Columns(table, (*keys,), (*keys,), f"Table of creep forces: {contact}"), path):
        raise ValueError(why_not)


def _given(option: str, value: Given | None) -> Given:
    """The value of an option that is needed. Ends the program (usage) where it is missing."""
    if value is None:
        raise typer.BadParameter("is missing", param_hint=option)
    return value


def _falling(law: FormulaName, given: Mapping[str, float | None], at_rest: float) -> FrictionLaw:
    """The law with the constants `given` by key; `at_rest` is the coefficient without slip, the largest that a table knows."""
    constants: dict[str, Any] = {}
    for constant in FORMULAS[law].constants:
        option = _option(constant.key)
        value, most = _given(option, given[constant.key]), at_rest if constant.of_friction else constant.most
        if not (constant.least <= value <= most and at_rest > 0.0):
            raise ValueError(f"a law needs {option} from {constant.least:g} to "
                             f"{'--friction' if constant.of_friction else format(most, 'g')}")
        constants[constant.name] = value / at_rest if constant.of_friction else value
    return FrictionLaw(law, **constants)


def _values(text: str, hint: str) -> tuple[float, ...]:
    with options.usage(hint):
        values = parse_values(text)
        if any(isinstance(value, bool | str) for value in values):
            raise ValueError(f'"{text}" is not a number')
        return tuple(map(float, values))
