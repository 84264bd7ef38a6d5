"""`thermoroll run`: solve cases, write their results, draw pictures, print scalars."""

from __future__ import annotations

import contextlib
import glob
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.deliver import Ending, Outcome, deliver
from thermoroll_cli.cli.progress import Progress
from thermoroll_cli.cli.streams import ExitCode
from thermoroll_cli.cli.tables import align, assembly_rows, folded, headed, scalar_table
from thermoroll_cli.files.case import Case, CaseError
from thermoroll_cli.files.result.outcome import read_result, write_result
from thermoroll_cli.files.table_file import history_files
from thermoroll_cli.one_contact.refinement.plan import COARSEST
from thermoroll_cli.problem.limits import Limit, not_there, states_of
from thermoroll_cli.problem.names import ALL_SCALARS, unit_of
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.scalar_errors import listed_scalars, row_of
from thermoroll_cli.python_api import Solver
from thermoroll_cli.tools.atomic import write_bytes
from thermoroll_cli.tools.process import Interrupted

if TYPE_CHECKING:
    from thermoroll_cli.cli.report import Section


def run(
    cases: Annotated[
        list[Path] | None, typer.Argument(metavar="CASE...", help="Case files, or results; - is standard input.")
    ] = None,
    output: options.Output = options.RESULTS,
    settings: options.Settings = None,
    as_json: options.AsJson = False,
    no_plots: options.NoPlots = False,
    plots: options.Plots = None,
    threads: options.Threads = 1,
    from_results: Annotated[
        list[Path] | None,
        typer.Option("--from", metavar="RESULT.h5", help="Solve the case in a result file again. Repeatable."),
    ] = None,
    formats: options.Formats = None,
    dpi: options.Dpi = None,
    normalised: options.Normalised = False,
    limits: options.Limits = None,
    report: options.Report = False,
    reproducible: Annotated[
        bool, typer.Option("--reproducible", help="JSON without times of computing: byte by byte the same for the same case.")
    ] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with contacts over time where DIR has them stopped.")] = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Solve cases, write results and pictures.

    Writes DIR/NAME.h5 and DIR/NAME_*.png and prints a table of scalars with estimated errors. NAME is the name of the
    case file without .toml (stdin for standard input). All cases are checked before the first is solved. With several
    cases the exit code is that of the worst. Every step of a contact over time is kept in DIR/NAME_history.jsonl until its
    result is written.
    """
    if not cases and not from_results:
        raise typer.BadParameter("give a case file, or --from RESULT.h5", param_hint="CASE...")
    options.check_standard_input(cases or [])
    kept = options.parse_limits(limits)
    overrides, valid, errors = options.parse_overrides(settings), list[Case](), dict[Path, CaseError]()
    for path, stored in (*((path, False) for path in cases or ()), *((path, True) for path in from_results or ())):
        try:
            valid.append(options.read_case(path, overrides, stored=stored))
        except CaseError as cause:
            errors[path] = cause
    if errors:
        for path, error in errors.items() if as_json else ():
            streams.write_json(options.invalid_record(str(path), error))
        raise typer.Exit(streams.report_invalid(list(errors.values())))
    twice = [name for name, count in Counter(case.name for case in valid).items() if count > 1]
    if twice:
        raise typer.BadParameter(f"several cases would write {twice[0]}.h5: rename one, or run them one by one")
    options.check_writable(output)

    codes = list[int]()
    for case in valid:
        with _alone(case, codes, as_json=as_json):
            to = Ending(output, as_json, options.plots_of(case, plots, no_plots), formats, dpi, report, quiet)
            result = _solved(case, to, resume=resume, threads=threads, verbose=verbose)
            found = Solved(case, result, normalised, verbose, reproducible, kept)
            codes.append(found.held(deliver(found, to), loud=quiet or as_json))
    raise typer.Exit(ExitCode.BUG if ExitCode.BUG in codes else max(codes))


@contextlib.contextmanager
def _alone(case: Case, codes: list[int], *, as_json: bool) -> Iterator[None]:
    """Inside, one of several cases: its errors add their exit code to `codes` and do not stop the others."""
    try:
        with options.recorded(Path(case.name), as_json), options.solvable(case, case.name):
            yield
    except CaseError as error:
        codes.append(streams.report_invalid([error], ""))
    except MemoryError:
        streams.error(f"{case.name}: not enough memory; `thermoroll show` estimates the memory of a grid")
        codes.append(ExitCode.INPUT_OUTPUT)
    except OSError as cause:  # of standard output: those of files are met where they are written
        streams.error(f"{case.name}: {cause.strerror or cause}")
        codes.append(ExitCode.INPUT_OUTPUT)
    except Exception as cause:
        streams.report_bug(cause)
        codes.append(ExitCode.BUG)


def _solved(case: Case, to: Ending, *, resume: bool, threads: int, verbose: bool) -> Result:
    """The result of a case, reported as it is solved. What was solved until a user interrupts it is kept."""
    kind, so_far = case.settings.kind, list[Callable[[], Result]]()

    def expected() -> tuple[Sequence[Any], bool]:
        planned = kind.plan(task := case.task)
        return () if planned is None else planned.steps, task.contact.numerics.accuracy is not None

    progress = Progress(case.name, quiet=to.quiet, verbose=verbose, expected=expected)

    def report(stage: str, info: Mapping[str, Any]) -> None:
        if "so_far" in info:
            so_far[:] = [info["so_far"]]
        progress(stage, {name: value for name, value in info.items() if name != "so_far"})

    if resume and kind.not_resumed:
        streams.note(f"thermoroll: {case.name}: {kind.not_resumed}")
    try:
        with progress:
            return Solver(threads).solve(case, report=report, journal=_steps(case, to.folder), resume=resume)
    except Interrupted:
        if so_far:
            kept = _write_history(so_far[0]().with_case(case.text, case.to_json()), to.folder, case.name)
            streams.note(f"thermoroll: {case.name}: interrupted; the rows up to here are in {', '.join(map(str, kept))}; "
                         "--resume goes on")
        elif kind.journal is not None:
            streams.note(f"thermoroll: {case.name}: interrupted in its coarse steps; --resume goes on")
        raise


def _steps(case: Case, folder: Path) -> Path:
    """Where the steps of a case over time are kept until its result is written."""
    return folder / f"{case.name}_history.jsonl"


@dataclass
class Solved(Outcome):
    """The result of a case."""

    case: Case
    result: Result
    normalised: bool = False
    verbose: bool = False
    reproducible: bool = False
    limits: Sequence[Limit] = ()

    def __post_init__(self) -> None:
        self.name = self.stem = self.case.name
        self.judged = [(limit, limit.judged(states_of(self.result.summary()))) for limit in self.limits]
        doubts = [f"{one.limit.text}: the error of {one.limit.scalar} is not known, and counts as none"
                  for _, one in self.judged if one is not None and not one.known]
        self.reason, self.warnings = self.result.reason, (*self.result.warnings, *doubts)

    def held(self, code: ExitCode, *, loud: bool) -> ExitCode:
        """The exit code with that of the limits, `loud` also in words; a state that did not converge keeps its own."""
        if code is not ExitCode.FINE:
            return code
        if missing := [limit for limit, one in self.judged if one is None]:
            streams.error(f"{self.name}: {not_there(missing[0], states_of(self.result.summary())[-1])}")
            return ExitCode.USAGE
        exceeded = [one for _, one in self.judged if one is not None and not one.met]
        for one in exceeded if loud else ():
            streams.error(f"{self.name}: {one}")
        return ExitCode.OUTSIDE_TOLERANCE if exceeded else code

    def write(self, folder: Path) -> list[Path]:
        target = folder / f"{self.stem}.h5"
        write_result(target, self.result, options.command_line())
        files = [target, *_write_history(self.result, folder, self.stem)]
        if self.result.history is not None:
            _steps(self.case, folder).unlink(missing_ok=True)
        return files

    def draw(self, to: Ending) -> Iterator[Path]:
        from thermoroll_cli.plots import pictures

        kinds = pictures.kinds_of(self.result)
        if to.plots == "summary":
            kinds = ("summary",) if "summary" in kinds else kinds[:1]
        yield from pictures.draw(self.result, to.folder / self.stem, kinds=kinds, formats=options.image_formats(to.formats),
                                 dpi=to.dpi, normalised=self.normalised)
        if (columns := self.result.history) is not None:
            from thermoroll_cli.studies.sweeps.table_picture import draw_table

            yield from to.drawn(f"{self.stem}_history", lambda path: draw_table(columns, path, dpi=to.dpi))

    def pictures(self, folder: Path) -> list[str]:
        # Without files that are called like pictures matplotlib is not imported for their names.
        if not any(folder.glob(f"{glob.escape(self.stem)}_*.*")):
            return []
        from thermoroll_cli.plots.pictures import kinds_of

        kinds = *kinds_of(self.result), *(("history",) if self.result.history is not None else ())
        return [f"{self.stem}_{kind}" for kind in kinds]

    def section(self, folder: Path) -> Section:
        from thermoroll_cli.cli import report as page

        # The file says with what it was computed.
        stored = replace(self.result, attributes=read_result(folder / f"{self.stem}.h5", with_fields=False).attributes)
        return page.of_result(stored, self.name) if stored.history is None else (
            page.of_history(stored, stored.history, self.name))

    def record(self) -> Mapping[str, Any]:
        record = {"title": self.case.settings.title, **self.result.summary()}
        if self.judged:
            record["limits"] = [one.record() for _, one in self.judged if one is not None]
        return _without_times(record) if self.reproducible else record

    def lines(self) -> list[str]:
        result, width, row = self.result, streams.width(), row_of(self.result.summary())
        names = list(ALL_SCALARS) if self.verbose else listed_scalars(row, result.problem)
        title = f" ({self.case.settings.title})" if self.case.settings.title else ""
        grid = "×".join(str(side) for side in result.work.get("grid", ()))
        status = "converged" if result.converged else "NOT CONVERGED"
        both = result.isothermal is not result.coupled
        single, sides, patches = assembly_rows(result, names, verbose=self.verbose) if result.assembly else (names, [], [])
        # A reason says already why a state on one grid alone has none.
        without = result.converged and not result.assembly and all(map(math.isnan, result.uncertainty.values()))
        head = folded(f"{self.name}{title}: {status}" + (f", grid {grid}" if grid else ""), width, indent="")
        if (states := result.history) is not None:
            place, unit = states.place, unit_of(states.place)
            head += folded(f"the last of {states.count} states, after {states[place][-1]:g} {unit}", width)
        return [
            *(head if result.converged else streams.in_colour(head, streams.RED)),
            *scalar_table(row, single, both=both, width=width), *headed(sides), *align(patches),
            *(folded("no error estimates: they need a coarser grid; set both sides of numerics.grid to "
                     f"{2 * COARSEST} or more", width) if without else ()),
            *(line for _, one in self.judged if one is not None
              for line in (folded(str(one), width) if one.met else streams.in_colour(folded(str(one), width), streams.RED))),
        ]


def _without_times(part: Any) -> Any:
    """A part of a record without processor seconds, at any depth."""
    if isinstance(part, Mapping):
        return {name: _without_times(value) for name, value in part.items() if name != "seconds"}
    return list(map(_without_times, part)) if isinstance(part, list) else part


def _write_history(result: Result, folder: Path, name: str) -> list[Path]:
    """Write the table of a contact over time, and return the paths; none of another result. Raises WriteError."""
    files = history_files(name, result, options.command_line())
    for file, content in files.items():
        write_bytes(folder / file, content)
    return [folder / file for file in files]
