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
from thermoroll_cli.problem.names import PATCH_SCALARS, unit_of
from thermoroll_cli.problem.scalar_errors import error_scale, scalar_text, with_error
from thermoroll_cli.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.wheelset.wheelset_result import IN_CONTACT, WheelsetPatch, WheelsetResult, solve_wheelset


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
    summary, left = {**result.scalars, "error": result.error}, [name for name in result.scalars if "_left" in name]
    sided = {name: name.replace("_left", "_right") for name in left}
    single = [name for name in result.scalars if name not in (*sided, *sided.values())]
    yield from scalar_table(summary, single, both=False, width=width)
    yield from align([("", "left", "right", ""), *(
        (name.replace("_left", "_SIDE"), scalar_text(name, summary), scalar_text(other, summary), unit_of(name))
        for name, other in sided.items())])
    if result.patches:
        patches = result.patches
        rows = [("patch", *(f"{patch.side} {patch.number}" for patch in patches), "")]
        for name in (name for name, scalar in PATCH_SCALARS.items() if scalar.listed):
            if any(name in patch.record for patch in patches):
                rows.append((name, *(_text(name, patch) for patch in patches), unit_of(name)))
        yield from align(rows)
    for warning in result.warnings:
        yield from folded(f"warning: {warning}", width)


def _text(name: str, patch: WheelsetPatch) -> str:
    """A scalar of a patch with its error, which the contact has in its own axes."""
    if name not in patch.record:
        return ""
    error: float = patch.record["error"].get(name, math.nan)
    return with_error(patch.record[name], error * error_scale(IN_CONTACT.get(name, name), patch.result.summary()))
