"""`thermoroll wear`: follow the profiles of both bodies as they wear."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from thermoroll_cli.atomic import write_bytes
from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.progress import Bar
from thermoroll_cli.cli.streams import ExitCode
from thermoroll_cli.files.case import Case
from thermoroll_cli.files.result.hdf5 import file_image
from thermoroll_cli.process import safe_point
from thermoroll_cli.tasks.journal import Journal
from thermoroll_cli.wear.evolution import BeyondProfile, evolution
from thermoroll_cli.wear.wear_files import Snapshots, record_of, resumed, table, write_group, write_profiles


def wear(
    case: options.OneCase,
    output: options.Output = options.RESULTS,
    resume: Annotated[bool, typer.Option("--resume", help="Go on from the last steps that DIR has.")] = False,
    settings: options.Settings = None,
    as_json: options.AsJson = False,
    no_plots: options.NoPlots = False,
    threads: options.Threads = 1,
    formats: options.Formats = None,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Follow the profiles of both bodies as they wear, over the distance or to the depth that [wear] in the case gives.

    Writes DIR/NAME_wear.csv with a row per step, DIR/NAME_wear.h5 (the last state with the group /wear), DIR/NAME_wear.png and
    the worn profiles as DIR/NAME_worn_lower.csv and _upper.csv, which a case can read. Every finished step is kept at once in
    DIR/NAME_wear.jsonl.
    """
    overrides = options.parse_overrides(settings)
    read = Case.read(case, overrides)
    asked = read.problem.wear
    if asked is None or asked.distance == asked.depth:
        raise typer.BadParameter("the case needs [wear] with distance_km or depth_um", param_hint="CASE")
    options.check_writable(output)
    records, result, reason = _followed(read, output, resume=resume, threads=threads, quiet=quiet, verbose=verbose)
    files = _write(read, output, records, result, reason, () if no_plots else options.image_formats(formats))
    if as_json:
        streams.write_json({"name": read.name, "status": "not_converged" if reason else "converged", "reason": reason,
                            "steps": len(records) - 1, **records[-1]["row"], "files": [str(file) for file in files]})
    elif not quiet:
        streams.write(*(f"  {name:22} {value:.6g}" for name, value in records[-1]["row"].items()))
        streams.write(f"  {len(records) - 1} steps; wrote {', '.join(map(str, files))}")
    if reason:
        streams.note(f"thermoroll: {read.name}: {reason}")
    raise typer.Exit(ExitCode.NOT_CONVERGED if reason else ExitCode.FINE)


def _followed(
    case: Case, folder: Path, *, resume: bool, threads: int, quiet: bool, verbose: bool
) -> tuple[list[dict[str, Any]], Any, str]:
    """All records, the last result, and why the evolution ended early."""
    asked, reason, result = case.problem.wear, "", None
    assert asked is not None
    by_distance = asked.distance < float("inf")
    identity = {"kind": "wear", "case": case.to_json()}
    with (Journal(folder / f"{case.name}_wear.jsonl", identity, resume=resume) as journal,
          Bar(case.name, 1.0, quiet=quiet, verbose=verbose) as bar):  # fmt: skip
        start = resumed(journal)
        last = 0 if start is None else start.steps
        try:
            for state in evolution(case.problem, start, threads=threads):
                safe_point()
                result, last = state.result, state.steps
                record = record_of(state)
                journal.keep(record)
                done = state.distance / asked.distance if by_distance else state.deepest / asked.depth
                words = f"{case.name}: step {state.steps}, {1e-3 * state.distance:.4g} km, {1e6 * state.deepest:.4g} µm"
                if bar.live:
                    bar.show(words, min(done, 1.0), 1.0)
                elif not quiet and (verbose or state.steps % 20 == 0):
                    streams.note(words)
                if result is not None and not result.converged:
                    reason = f"step {state.steps} did not converge: {result.reason}"
        except BeyondProfile as cause:
            reason = f"{cause}; what is there is kept: give longer profiles, or a shorter distance"
        journal.update()
        records = [journal[str(step)] for step in range(last + 1)]
    if not reason and len(records) == 1:
        reason = "nothing slips, so nothing wears"
    return records, result, reason


def _write(
    case: Case, folder: Path, records: list[dict[str, Any]], result: Any, reason: str, formats: tuple[str, ...]
) -> list[Path]:
    stem = folder / f"{case.name}_wear"
    files = [stem.with_suffix(".csv"), stem.with_suffix(".h5")]
    write_bytes(files[0], table(records))
    write_bytes(files[1], file_image(result, case_text=case.text, case_json=case.to_json(), command_line=options.command_line(),
                                     more=lambda file: write_group(file, case.problem, records)))
    files += write_profiles(folder, case.name, case.problem, records[-1])
    if formats and case.plots:
        from thermoroll_cli.plots.profile_figures import draw_wear

        kept = Snapshots.of(case.problem, records)
        files += [draw_wear(stem.with_suffix(f".{ending}"), case.settings.title, kept.y, kept.profiles, kept.loads,
                            kept.distances, converged=not reason) for ending in formats]
    return files
