"""`thermoroll wear`: follow the profiles of both bodies as they wear."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.deliver import Ending, Outcome, deliver
from thermoroll_cli.cli.progress import Bar
from thermoroll_cli.files.case import Case
from thermoroll_cli.one_contact.refinement.plan import extent_of
from thermoroll_cli.problem.names import UNCERTAINTY, column_of, unit_of
from thermoroll_cli.problem.scalar_errors import with_error
from thermoroll_cli.studies.worn.follow import Evolution, wearing
from thermoroll_cli.studies.worn.follow import wear as follow

if TYPE_CHECKING:
    from thermoroll_cli.cli.report import Section


def wear(
    case: options.OneCase,
    output: options.Output = options.RESULTS,
    resume: Annotated[bool, typer.Option("--resume", help="Go on from the last steps that DIR has.")] = False,
    force: options.Force = False,
    settings: options.Settings = None,
    as_json: options.AsJson = False,
    no_plots: options.NoPlots = False,
    plots: options.Plots = None,
    jobs: options.Jobs = 1,
    threads: options.Threads = 1,
    formats: options.Formats = None,
    dpi: options.Dpi = None,
    written_report: options.Report = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Follow the profiles of both bodies as they wear, over the distance or to the depth that [wear] in the case gives.

    Writes DIR/NAME_wear.csv with a row per step, DIR/NAME_wear.h5 (the last state with the group /wear), DIR/NAME_wear.png and
    the worn profiles as DIR/NAME_worn_lower.csv and _upper.csv, which a case can read. Every finished step is kept at once in
    DIR/NAME_wear.jsonl. A wheelset wears over the positions that [wear] gives: its outlines are DIR/NAME_worn_wheel_right.csv
    and so on, and DIR/NAME_wear.h5 has the first position on the worn outlines.
    """
    options.check_not_both(resume, force)
    read, _ = options.read_task(case, settings, as_json=as_json)
    with options.recorded(case, as_json), options.solvable(read, str(case)):
        what = wearing(read)
        asked = what.asked
    options.check_writable(output)
    with Bar(read.name, 1.0, quiet=quiet, verbose=verbose) as bar, options.recorded(case, as_json):

        def report(step: int, row: Mapping[str, Any]) -> None:
            deepest = max(value for name, value in row.items() if name.startswith("depth_max_"))
            words = (f"{read.name}: step {step}, {row['distance_km']:.4g} km, {deepest:.4g} µm, "
                     f"{_text(row, 'pressure_max_MPa')} MPa")
            if bar.live:
                bar.show(words, min(max(1e3 * row["distance_km"] / asked.distance, 1e-6 * deepest / asked.depth), 1.0), 1.0)
            elif not quiet and (verbose or step % 20 == 0):
                streams.note(words)

        done = follow(read, output, resume=resume, force=force, jobs=jobs, threads=threads, report=report,
                      command_line=options.command_line())
    to = Ending(output, as_json, options.plots_of(read, plots, no_plots), formats, dpi, written_report, quiet)
    raise typer.Exit(deliver(Worn(read, done, extent_of(what.task.contact.numerics)[1]), to))


@dataclass
class Worn(Outcome):
    """The evolution of the profiles of a case, with `warnings`."""

    case: Case
    done: Evolution
    warnings: Sequence[str]

    def __post_init__(self) -> None:
        self.name, self.stem, self.reason = self.case.name, f"{self.case.name}_wear", self.done.reason
        self.last, self.steps = self.done.rows[-1], len(self.done.rows) - 1

    def write(self, folder: Path) -> Iterable[Path]:
        return self.done.files

    def draw(self, to: Ending) -> list[Path]:
        return to.drawn(self.stem, lambda path: _draw(self.done, path, to.dpi))

    def section(self, folder: Path) -> Section:
        from thermoroll_cli.cli import report as page

        steps = f"{self.steps} step{'' if self.steps == 1 else 's'}"
        return page.Section(
            self.case.settings.title or self.name,
            [f"Profiles that wear over {self.last['distance_km']:.5g} km, in {steps}."], self.reason,
            tables=[page.ReportTable([(meaning, text, unit_of(name), name) for meaning, text, name in self._values()],
                               ("after the last step", "value", "unit", "name"), values=(1, 2), names=(3,))],
            pictures=page.picture("wear", lambda path: _draw(self.done, path)),
            case=self.case.text, method=page.METHOD + " Wear follows from the frictional work of each passage; the profiles "
            "change by bounded steps, and after each the contact is solved again.")  # fmt: skip

    def record(self) -> Mapping[str, Any]:
        return {"status": "not_converged" if self.reason else "converged", "reason": self.reason, "steps": self.steps,
                **self.last}

    def lines(self) -> list[str]:
        return [*(f"  {name:32} {text:22} {meaning}".rstrip() for meaning, text, name in self._values()),
                f"  {self.steps} steps"]

    def _values(self) -> list[tuple[str, str, str]]:
        """Meaning, value with its error, and name of each column after the last step."""
        return [(column_of(name)[1], _text(self.last, name), name) for name in self.last if not name.startswith(UNCERTAINTY)]


def _text(row: Mapping[str, Any], name: str) -> str:
    """A value of a row with its error."""
    return with_error(row.get(name, math.nan), row.get(f"{UNCERTAINTY}{name}", math.nan))


def _draw(done: Evolution, path: Path, dpi: float | None = None) -> Path:
    from thermoroll_cli.plots import style
    from thermoroll_cli.studies.worn.evolution_picture import evolution_figure

    with style.applied():
        return style.save(evolution_figure(done), path, dpi)
