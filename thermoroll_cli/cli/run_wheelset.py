"""`thermoroll run` of a wheelset: all its patches, the whole as JSON and a table, its pictures, and what is printed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.progress import Progress
from thermoroll_cli.cli.streams import ExitCode
from thermoroll_cli.cli.tables import align, folded, scalar_table
from thermoroll_cli.files.case import Case
from thermoroll_cli.files.result.wheelset_files import wheelset_record, write_wheelset
from thermoroll_cli.problem.names import unit_of
from thermoroll_cli.problem.scalar_errors import scalar_text
from thermoroll_cli.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.wheelset.wheelset_result import WheelsetResult, solve_wheelset

SIDED = ("track_force_x_{}_N", "track_force_y_{}_N", "track_force_z_{}_N", "lateral_over_vertical_{}", "rolling_radius_{}_mm")
"""Scalars of each side, one line for both."""
PATCH_LINES = ("x_mm", "y_mm", "angle_mrad", "y_rail_mm", "y_wheel_mm", "normal_N", "force_x_N", "force_s_N", "creepage_x",
               "creepage_s", "spin_rad_mm", "pressure_max_MPa", "contact_area_mm2", "T_gamma_N", "temperature_rise_max_lower_K",
               "temperature_rise_max_upper_K")  # fmt: skip
"""Lines of the table of patches."""


def run_wheelset(
    case: Case, task: WheelsetProblem, folder: Path, *, drawing: Mapping[str, Any] | None, threads: int, as_json: bool,
    quiet: bool, verbose: bool,
) -> int:
    """Solve a wheelset, write its files into `folder`, print what was found, and return the exit code. Raises Unsolvable."""
    with Progress(case.name, quiet=quiet, verbose=verbose) as progress:
        result = solve_wheelset(task, threads=threads, report=progress)
    code, files = ExitCode.FINE if result.converged else ExitCode.NOT_CONVERGED, []
    stem, title = folder / case.name, case.settings.title
    try:
        files = write_wheelset(stem, result, name=case.name, title=title, case_text=case.text, case_json=case.to_json(),
                               command_line=options.command_line())
        if drawing is not None and case.plots:
            from thermoroll_cli.plots.wheelset_figures import draw_wheelset

            files += draw_wheelset(result, stem, title, formats=drawing["formats"], dpi=drawing["dpi"])
    except OSError as cause:
        # The computed scalars are still worth printing.
        streams.error(f"{case.name}: {cause}")
        code = ExitCode.INPUT_OUTPUT
    if as_json:
        names = {patch.name: f"{case.name}_{patch.name}.h5" for patch in result.patches} if files else {}
        streams.write_json({"name": case.name, "title": title, **wheelset_record(result, names), "files": files})
    elif not quiet:
        streams.write(*_report(case, result, streams.width()))
        if files:
            streams.write(*folded(f"wrote {', '.join(map(str, files))}", streams.width()))
    if not quiet and as_json:
        for warning in result.warnings:
            streams.note(f"thermoroll: {case.name}: warning: {warning}")
    if not result.converged and (as_json or quiet):
        streams.note(f"thermoroll: {case.name} did not converge: {result.reason}")
    return code


def _report(case: Case, result: WheelsetResult, width: int) -> Iterator[str]:
    title = f" ({case.settings.title})" if case.settings.title else ""
    yield from folded(f"{case.name}{title}: {'converged' if result.converged else 'NOT CONVERGED'}", width, indent="")
    yield from folded(result.reason, width)
    sided = {name.format(side): name for name in SIDED for side in ("left", "right")}
    summary = {**result.scalars, "error": result.error}
    yield from scalar_table(summary, [name for name in result.scalars if name not in sided], both=False, width=width)
    yield from align([("", "left", "right", ""), *(
        (name.format("SIDE"), *(scalar_text(name.format(side), summary) for side in ("left", "right")), unit_of(name))
        for name in SIDED)])
    if result.patches:
        patches = result.patches
        rows = [("patch", *(f"{patch.side} {patch.number}" for patch in patches), "")]
        for name in PATCH_LINES:
            values = [patch.record.get(name, math.nan) for patch in patches]
            if not all(math.isnan(value) for value in values):
                rows.append((name, *map(_number, values), unit_of(name)))
        yield from align(rows)
    for warning in result.warnings:
        yield from folded(f"warning: {warning}", width)


def _number(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.5g}"
