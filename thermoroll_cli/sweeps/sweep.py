"""A whole sweep: what is finished is found, the rest is solved, and every point becomes a row."""

from __future__ import annotations

import contextlib
import pathlib
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass, replace

from thermoroll_cli.files.atomic import remove_leftovers, write_bytes
from thermoroll_cli.interruption import safe_point
from thermoroll_cli.sweeps.axis import Axis
from thermoroll_cli.sweeps.cluster import on_cluster
from thermoroll_cli.sweeps.lock import sole_sweep
from thermoroll_cli.sweeps.points import Point, Stretch, stretches
from thermoroll_cli.sweeps.processes import in_processes
from thermoroll_cli.sweeps.resume import finished_points, named, unlisted_files
from thermoroll_cli.sweeps.stretch import Outcome, Target, solve_into
from thermoroll_cli.sweeps.table import Row, TableFile, failed_row, row_of

TABLE_NAME = "sweep.csv"

SECONDS_BETWEEN_TABLES = 2.0
"""A table of thousands of points takes longer to write than some points to solve."""


@dataclass(frozen=True)
class Sweep:
    """`points` (all of them checked) along `axes`, to be solved into `folder`.

    In `jobs` processes of this machine, or by the Dask cluster whose scheduler is at `dask`. `resume` leaves out what
    has been solved already. `threads` are those of the transforms in the only process.
    """

    points: tuple[Point, ...]
    axes: tuple[Axis, ...]
    folder: pathlib.Path
    command_line: str
    jobs: int = 1
    dask: str = ""
    resume: bool = False
    threads: int = 1


def run_sweep(sweep: Sweep, *, report: Callable[[Row, bool], None], note: Callable[[str], None]) -> list[Row]:
    """Solve `sweep`, write a result file per point and the table, and return the rows in the order of the points.

    `report` is called with each row when it is known, and whether it was solved now rather than found finished; `note`
    with remarks. Whatever ends the sweep early, finished points keep their files and rows. Raises OSError: a file cannot
    be written, another sweep works in the folder, no cluster.
    """
    with sole_sweep(sweep.folder):
        finished = finished_points(sweep.folder, sweep.points, note) if sweep.resume else {}
        points = named(sweep.points, finished)
        if unlisted := unlisted_files(sweep.folder, points):
            which = unlisted[0].name + (f" … {unlisted[-1].name}" if len(unlisted) > 1 else "")
            count = f"{len(unlisted)} file{'s' if len(unlisted) > 1 else ''}"
            note(f"{sweep.folder} has {count} of another sweep, {which}: left alone, and not in {TABLE_NAME}")
        table = TableFile(sweep.folder / TABLE_NAME, sweep.axes)
        target = Target(sweep.folder, sweep.command_line, sweep.threads)
        for point in points:
            if point.number in finished:
                table.rows[point.number] = row_of(point, target.path(point))
                report(table.rows[point.number], False)
        if finished:
            note(f"{len(finished)} of {len(points)} points are finished already")
        pending = [
            replace(stretch, finished=frozenset(p.number for p in stretch.points if p.number in finished))
            for stretch in stretches(points, sweep.axes)
        ]
        pending = [stretch for stretch in pending if stretch.pending]
        written, began = time.monotonic(), time.time()
        try:
            with contextlib.closing(_outcomes(sweep, pending, target, note)) as outcomes:
                for row in _rows(outcomes, points, target):
                    safe_point()
                    table.rows[row.point.number] = row
                    report(row, True)
                    if time.monotonic() - written > SECONDS_BETWEEN_TABLES:
                        table.write()
                        written = time.monotonic()
        except BaseException:
            with contextlib.suppress(OSError):
                # Points that other processes finished and that were not yet heard of.
                for point in points:
                    path = target.path(point)
                    if point.number not in table.rows and path.exists() and path.stat().st_mtime >= began:
                        table.rows[point.number] = row_of(point, path)
                table.write()
            raise
        table.write()
        remove_leftovers(sweep.folder)
        return table.in_order()


def _outcomes(sweep: Sweep, pending: Sequence[Stretch], target: Target, note: Callable[[str], None]) -> Generator[Outcome]:
    """The seam between a sweep and whoever does the work."""
    if not pending:
        return
    if sweep.dask:

        yield from on_cluster(pending, sweep.dask, sweep.command_line)
    elif sweep.jobs > 1:

        yield from in_processes(pending, target, sweep.jobs, note)
    else:
        for stretch in pending:
            yield from solve_into(stretch, target)


def _rows(outcomes: Iterator[Outcome], points: Sequence[Point], target: Target) -> Iterator[Row]:
    """The row of every outcome, read back from its file."""
    by_number = {point.number: point for point in points}
    for outcome in outcomes:
        point = by_number[outcome.number]
        if outcome.reason:
            yield failed_row(point, outcome.reason)
            continue
        path = target.path(point)
        if outcome.content:
            write_bytes(path, outcome.content)
        yield row_of(point, path)
