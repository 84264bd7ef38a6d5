"""`thermoroll run`: solve cases, write their results, draw pictures, print scalars."""

from __future__ import annotations

import glob
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.progress import Progress
from thermoroll_cli.cli.streams import ExitCode
from thermoroll_cli.cli.tables import align, assembly_rows, folded, scalar_table
from thermoroll_cli.files.case import Case, CaseError, Override
from thermoroll_cli.files.result.outcome import read_result, write_result
from thermoroll_cli.problem.names import ALL_SCALARS
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.scalar_errors import listed_scalars
from thermoroll_cli.python_api import KINDS, solve
from thermoroll_cli.refinement.plan import COARSEST


def run(
    cases: Annotated[
        list[Path] | None, typer.Argument(metavar="CASE...", help="Case files, or results; - is standard input.")
    ] = None,
    output: options.Output = options.RESULTS,
    settings: options.Settings = None,
    as_json: options.AsJson = False,
    no_plots: options.NoPlots = False,
    threads: options.Threads = 1,
    from_results: Annotated[
        list[Path] | None,
        typer.Option("--from", metavar="RESULT.h5", help="Solve the case in a result file again. Repeatable."),
    ] = None,
    formats: options.Formats = None,
    dpi: options.Dpi = None,
    normalised: options.Normalised = False,
    report: options.Report = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Solve cases, write results and pictures.

    Writes DIR/NAME.h5 and DIR/NAME_*.png and prints a table of scalars with estimated errors. NAME is the name of the
    case file without .toml (stdin for standard input). All cases are checked before the first is solved. With several
    cases the exit code is that of the worst.
    """
    if not cases and not from_results:
        raise typer.BadParameter("give a case file, or --from RESULT.h5", param_hint="CASE...")
    options.check_standard_input(cases or [])
    overrides = options.parse_overrides(settings)
    drawing = {"formats": options.image_formats(formats), "dpi": dpi, "normalised": normalised}
    write_files = partial(_write_files, folder=output, drawing=None if no_plots else drawing, report=report)
    run_case = partial(_run_case, folder=output, write_files=write_files, threads=threads, as_json=as_json, quiet=quiet,
                       verbose=verbose)
    valid = _read_all(cases or [], from_results or [], overrides, as_json=as_json)
    twice = [name for name, count in Counter(case.name for case in valid).items() if count > 1]
    if twice:
        raise typer.BadParameter(f"several cases would write {twice[0]}.h5: rename one, or run them one by one")
    options.check_writable(output)
    codes = [_attempt(case, run_case, as_json=as_json) for case in valid]
    raise typer.Exit(ExitCode.BUG if ExitCode.BUG in codes else max(codes))


def _read_all(
    paths: Sequence[Path], result_paths: Sequence[Path], overrides: Sequence[Override], *, as_json: bool
) -> list[Case]:
    """All cases, checked. Ends the program (invalid case) where one cannot be solved, with the errors of all."""
    valid, errors = [], {}
    for path, stored in (*((path, False) for path in paths), *((path, True) for path in result_paths)):
        try:
            valid.append(options.read_case(path, overrides, stored=stored))
        except CaseError as cause:
            errors[path] = cause
    if errors:
        for path, error in errors.items() if as_json else ():
            streams.write_json(options.invalid_record(str(path), error))
        raise typer.Exit(streams.report_invalid(list(errors.values())))
    return valid


def _attempt(case: Case, run_case: Callable[[Case], int], *, as_json: bool) -> int:
    """Run one case; its errors do not stop the others."""
    try:
        with options.recorded(Path(case.name), as_json), options.solvable(case, case.name):
            return run_case(case)
    except CaseError as error:
        return streams.report_invalid([error], "")
    except MemoryError:
        streams.error(f"{case.name}: not enough memory; `thermoroll show` estimates the memory of a grid")
    except OSError as cause:  # of standard output: those of files are met where they are written
        streams.error(f"{case.name}: {cause.strerror or cause}")
    except Exception as cause:
        streams.report_bug(cause)
        return ExitCode.BUG
    return ExitCode.INPUT_OUTPUT


def _run_case(
    case: Case, *, folder: Path, write_files: Callable[[Case, Result], list[Path]], threads: int, as_json: bool, quiet: bool,
    verbose: bool,
) -> int:
    task = case.task
    plan = KINDS[type(task)].plan
    progress = Progress(case.name, quiet=quiet, verbose=verbose,
                        steps=tuple if plan is None else lambda: plan(task).steps,
                        at_most=task.contact.numerics.accuracy is not None)  # fmt: skip
    with progress:
        result = solve(task, threads=threads, report=progress).with_case(case.text, case.to_json())
    code, files = ExitCode.FINE if result.converged else ExitCode.NOT_CONVERGED, []
    try:
        files = write_files(case, result)
    except OSError as cause:
        # The computed scalars are still worth printing.
        streams.error(f"{case.name}: {cause}")
        code = ExitCode.INPUT_OUTPUT
    if files and not quiet:
        options.report_stale(_pictures_of(case, result, folder), files)
    if as_json:
        streams.write_json({"name": case.name, "title": case.settings.title, **result.summary(), "files": files})
        for warning in result.warnings if not quiet else ():
            streams.note(f"thermoroll: {case.name}: warning: {warning}")
    elif not quiet:
        streams.write(*_report(case, result, verbose))
        if files:
            pictures = [file for file in files[1:] if file.suffix != ".html"]
            endings = (file.suffix for file in pictures)
            kinds = ", ".join(f"{folder / case.name}_*{ending}" for ending in dict.fromkeys(endings))
            streams.write(f"  wrote {files[0]}" + (f" and {len(pictures)} pictures {kinds}" if kinds else ""),
                          *(f"  wrote {file}" for file in files[1:] if file not in pictures))
    if not result.converged and (as_json or quiet):  # else the report says so
        streams.note(f"thermoroll: {case.name} did not converge: {result.reason}")
    return code


def _write_files(
    case: Case, result: Result, *, folder: Path, drawing: Mapping[str, Any] | None, report: bool
) -> list[Path]:
    """The files of a result, written; `drawing` has the options of the pictures, None for no pictures."""
    target = folder / f"{case.name}.h5"
    write_result(target, result, options.command_line())
    files = [target]
    if drawing is not None and case.plots:
        from thermoroll_cli.plots.pictures import draw

        files += draw(result, folder / case.name, **drawing)
    if report:
        from thermoroll_cli.cli import report as page

        # The file says with what it was computed.
        stored = replace(result, attributes=read_result(target, with_fields=False).attributes)
        files.append(page.write(folder / f"{case.name}_report.html", [page.of_result(stored, case.name)]))
    return files


def _pictures_of(case: Case, result: Result, folder: Path) -> Iterator[Path]:
    """Every picture that a run of `case` may write; none where nothing is called like one, which costs no import."""
    if not any(folder.glob(f"{glob.escape(case.name)}_*.*")):
        return
    from thermoroll_cli.plots.pictures import kinds_of

    for name in kinds_of(result):
        for ending in options.ImageFormat:
            yield folder / f"{case.name}_{name}.{ending}"


def _report(case: Case, result: Result, verbose: bool) -> list[str]:
    width, summary = streams.width(), result.summary()
    names = list(ALL_SCALARS) if verbose else listed_scalars(summary, result.problem)
    title = f" ({case.settings.title})" if case.settings.title else ""
    grid = "×".join(str(side) for side in result.work.get("grid", ()))
    outcome = "converged" if result.converged else "NOT CONVERGED"
    both = result.isothermal is not result.coupled
    single, sides, patches = assembly_rows(result, names, verbose=verbose) if result.assembly else (names, [], [])
    # A reason says already why a state on one grid alone has none.
    without = result.converged and not result.assembly and all(map(math.isnan, result.uncertainty.values()))
    head = folded(f"{case.name}{title}: {outcome}" + (f", grid {grid}" if grid else ""), width, indent="")
    warnings = [line for warning in result.warnings for line in folded(f"warning: {warning}", width)]
    return [
        *(head if result.converged else streams.in_colour([*head, *folded(result.reason, width)], streams.RED)),
        *scalar_table(summary, single, both=both, width=width), *align(sides), *align(patches),
        *(folded("no error estimates: they need a coarser grid; set both sides of numerics.grid to "
                 f"{2 * COARSEST} or more", width) if without else ()),
        *streams.in_colour(warnings, streams.YELLOW),
    ]
