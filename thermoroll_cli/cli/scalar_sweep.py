"""`thermoroll sweep --scalars-only`: many points, few files."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from thermoroll_cli.cli import streams
from thermoroll_cli.cli.exits import ExitCode
from thermoroll_cli.cli.progress import Progress, duration
from thermoroll_cli.files.environment import rare_collections

if TYPE_CHECKING:
    from thermoroll_cli.creep_table.build import BuildProgress
    from thermoroll_cli.sweeps.scalars_only import ScalarSweep, Tally

SECONDS_BETWEEN_LINES = 10.0
MOST_DRAWN = 1000
"""Points of which a picture still shows something."""


class TallyProgress:
    """How far a sweep is: a line that is redrawn on a terminal, one every few seconds elsewhere."""

    def __init__(self, *, quiet: bool) -> None:
        self._quiet = quiet
        self._live = streams.is_terminal(sys.stderr) and not quiet
        self._start = time.monotonic()
        self._last = self._start

    def __call__(self, tally: Tally | BuildProgress) -> None:
        now = time.monotonic()
        solved = tally.rows - tally.found
        left = ""
        if solved and tally.rows < tally.total:
            left = f", {duration((now - self._start) / solved * (tally.total - tally.rows))} left"
        text = f"{tally.rows}/{tally.total} points{left}"
        if self._live:
            Progress._draw(text)
        elif not self._quiet and now - self._last >= SECONDS_BETWEEN_LINES:
            self._last = now
            streams.note(text)

    def note(self, text: str) -> None:
        self.close()
        if not self._quiet:
            streams.note(f"thermoroll: {text}")

    def close(self) -> None:
        if self._live:
            Progress._draw("")


def solve_scalars_only(sweep: ScalarSweep, *, as_json: bool, picture: Path | None, quiet: bool) -> int:
    """Solve the sweep, print what came of it and return the exit code."""
    from thermoroll_cli.cli.options import tell_invalid
    from thermoroll_cli.cli.sweep_command import SHOWN_ERRORS
    from thermoroll_cli.files.case import CaseError
    from thermoroll_cli.sweeps.scalars_only import FILE_NAME, TABLE_NAME, run_scalars_only

    rare_collections()
    progress = TallyProgress(quiet=quiet)
    try:
        tally = run_scalars_only(sweep, report=progress, note=progress.note)
    except CaseError as cause:
        more = len(cause.findings) - SHOWN_ERRORS
        closing = f" of {len(cause.findings)}" if more > 0 else ""
        return tell_invalid([CaseError(cause.findings[:SHOWN_ERRORS])], f"{closing}; nothing was computed")
    finally:
        progress.close()
    drawn = picture is not None and tally.total <= MOST_DRAWN and (
        (picture.exists() and tally.rows == tally.found) or _draw(sweep, picture))
    if as_json:
        _print_json(sweep)
    elif not quiet:
        streams.write(f"{tally.converged} of {tally.total} points converged")
        also = f", {picture}" if drawn else ""
        streams.write(f"  wrote {sweep.folder / FILE_NAME}, {sweep.folder / TABLE_NAME}{also}")
        if picture is not None and tally.total > MOST_DRAWN:
            streams.write(f"  no picture: more than {MOST_DRAWN} points")
    for number, reason in tally.failures:
        streams.note(f"thermoroll: {sweep.maker.name(number)} did not converge: {reason}")
    failed = tally.rows - tally.converged
    if failed > len(tally.failures):
        streams.note(f"thermoroll: and {failed - len(tally.failures)} more, see the column reason of the table")
    return ExitCode.NOT_CONVERGED if failed else ExitCode.FINE


def _print_json(sweep: ScalarSweep) -> None:
    from thermoroll_cli.files.result.scalar_file import ScalarFile
    from thermoroll_cli.sweeps.scalars_only import FILE_NAME, records

    title = sweep.maker.point(1).problem.title
    for row in records(ScalarFile.open(sweep.folder / FILE_NAME), sweep.maker):
        over = {axis.key: row[axis.key] for axis in sweep.maker.axes}
        nested: dict[str, dict[str, Any]] = {"isothermal": {}, "error": {}, "work": {}}
        flat: dict[str, Any] = {}
        for name, value in row.items():
            group, dot, own = name.partition(".")
            if dot and group in nested and name not in over:
                nested[group][own] = value
            elif name not in (*over, "file", "number"):
                flat[name] = value
        if names := flat.pop("unbounded"):
            flat["unbounded"] = names.split()
        nested["work"]["grid"] = [int(side) for side in nested["work"]["grid"].split("x") if side]
        head = {"name": sweep.maker.name(row["number"]), "title": title, "over": over}
        streams.write_json({**head, **flat, **nested, "files": []})


def _draw(sweep: ScalarSweep, path: Path) -> bool:
    from thermoroll_cli.files.result.scalar_file import ScalarFile
    from thermoroll_cli.sweeps.scalars_only import FILE_NAME, found_below, records
    from thermoroll_cli.sweeps.table import draw_cells

    file = ScalarFile.open(sweep.folder / FILE_NAME)
    rows = list(records(file, sweep.maker))
    return draw_cells(rows, sweep.maker.axes, path, sweep.maker.point(1).problem.title, found_below(file))
