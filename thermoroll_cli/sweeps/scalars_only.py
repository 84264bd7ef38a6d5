"""A whole sweep without a file per point: rows into one HDF5 file while it runs, a table at the end."""

from __future__ import annotations

import contextlib
import csv
import json
import pathlib
import time
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from thermoroll_cli.files.atomic import remove_leftovers, replacing
from thermoroll_cli.files.case import CaseError
from thermoroll_cli.files.result.scalar_file import CHECKSUM, TEXTS, ResultFileError, ScalarFile, ScalarRow
from thermoroll_cli.problem.names import scalars_below
from thermoroll_cli.sweeps.lock import sole_sweep
from thermoroll_cli.sweeps.points import PointMaker, identity, stretch_numbers
from thermoroll_cli.sweeps.scalar_processes import rows_in_processes, rows_on_cluster
from thermoroll_cli.sweeps.scalar_tasks import Part, solve_rows
from thermoroll_cli.sweeps.table import CONVERGED, cell, columns, over_limit

FILE_NAME, TABLE_NAME = "sweep.h5", "sweep.csv"
SECONDS_BETWEEN_WRITES = 1.0
"""Rows wait so long in memory: what a killed sweep loses besides the tasks of its workers."""
MOST_WAITING = 250
FAILURES_KEPT = 5
MANY = 2000
"""Points whose checking takes long enough to be told."""


@dataclass(frozen=True)
class ScalarSweep:
    """The points of `maker`, to be solved into `folder`; the rest as in `Sweep`."""

    maker: PointMaker
    folder: pathlib.Path
    command_line: str
    jobs: int = 1
    dask: str = ""
    resume: bool = False
    threads: int = 1


@dataclass
class Tally:
    """What became of the `total` points: how many have `rows`, how many of these were `found` and have `converged`, and the
    number and reason of the first ones that have not."""

    total: int
    rows: int = 0
    found: int = 0
    converged: int = 0
    failures: list[tuple[int, str]] = field(default_factory=list)

    def add(self, number: int, status: str, reason: str) -> None:
        self.rows += 1
        if status == CONVERGED:
            self.converged += 1
        elif len(self.failures) < FAILURES_KEPT:
            self.failures.append((number, reason))


def run_scalars_only(sweep: ScalarSweep, *, report: Callable[[Tally], None], note: Callable[[str], None]) -> Tally:
    """Solve `sweep` and write its rows and the table.

    `report` is called with the tally as rows come in, `note` with remarks. Whatever ends the sweep early, rows that are
    written stay. Raises CaseError before anything is solved; OSError: a file cannot be written, it belongs to another sweep,
    another sweep works in the folder, no cluster.
    """
    with sole_sweep(sweep.folder):
        file = _prepared(sweep, note)
        finished = file.finished()
        tally = Tally(file.count)
        for number, status, reason in _states(file):
            tally.add(number, status, reason)
        tally.found = tally.rows
        if tally.found:
            note(f"{tally.found} of {tally.total} points are finished already")
        report(tally)
        parts = (
            Part(numbers, frozenset(n for n in numbers if finished[n - 1]))
            for numbers in stretch_numbers(sweep.maker.axes)
            if not finished[numbers.start - 1 : numbers.stop - 1].all()
        )
        waiting: list[ScalarRow] = []
        written = time.monotonic()
        try:
            with contextlib.closing(_rows(sweep, parts, note)) as groups:
                for rows in groups:
                    waiting += rows
                    for row in rows:
                        tally.add(row.number, *row.texts[:2])
                    if len(waiting) >= MOST_WAITING or time.monotonic() - written >= SECONDS_BETWEEN_WRITES:
                        file.write(waiting)
                        waiting, written = [], time.monotonic()
                        report(tally)
        finally:
            file.write(waiting)
        report(tally)
        table = sweep.folder / TABLE_NAME
        if tally.rows > tally.found or not table.exists() or table.stat().st_mtime_ns < file.path.stat().st_mtime_ns:
            write_table(file, table, sweep.maker)
        remove_leftovers(sweep.folder)
        return tally


def _prepared(sweep: ScalarSweep, note: Callable[[str], None]) -> ScalarFile:
    """The file of the sweep: the one that is there if it is to be resumed, or a new one after all points are checked."""
    maker, path = sweep.maker, sweep.folder / FILE_NAME
    own = _identity(maker)
    coordinates = {axis.key: axis.values for axis in maker.axes}
    old = None
    if sweep.resume and path.exists():
        old = ScalarFile.open(path)
        if old.identity != own or set(old.coordinates) != set(coordinates):
            raise ResultFileError(f"{path}: of another case, or over other keys; use another folder, or leave --resume out")
        if list(old.coordinates) == list(coordinates) and all(
                list(old.coordinates[key]) == list(values) for key, values in coordinates.items()):
            return old
    if maker.count > MANY:
        note(f"checking {maker.count} points")
    for _ in maker.points():
        pass
    first = maker.point(1).problem
    settings = json.dumps([override.text for override in maker.settings])
    return ScalarFile.create(path, coordinates, own, texts={"case_text": maker.text, "settings": settings},
                             command_line=sweep.command_line, title=first.title, below=scalars_below(first.subsurface), old=old)


def _identity(maker: PointMaker) -> str:
    """What tells the case apart, without the swept keys."""
    try:
        content = json.loads(identity(maker.point(1).case_json))
    except CaseError:
        # Told with the errors of all the other points.
        for _ in maker.points():
            pass
        raise
    for axis in maker.axes:
        table = content
        for part in axis.path[:-1]:
            table = table.get(part, {})
        table.pop(axis.path[-1], None)
    return json.dumps(content, sort_keys=True)


def _rows(
    sweep: ScalarSweep, parts: Iterator[Part], note: Callable[[str], None]
) -> Generator[tuple[ScalarRow, ...]]:
    """The seam between a sweep and whoever does the work."""
    if sweep.dask:

        yield from rows_on_cluster(sweep.maker, parts, sweep.dask)
    elif sweep.jobs > 1:

        yield from rows_in_processes(sweep.maker, parts, sweep.jobs, note)
    else:
        for part in parts:
            for row in solve_rows(sweep.maker, part, sweep.threads):
                yield (row,)


def _states(file: ScalarFile) -> Iterator[tuple[int, str, str]]:
    """Number, status and reason of each row there is."""
    number = 0
    for block in file.blocks():
        for right, status, reason in zip(block[CHECKSUM], block["status"], block["reason"], strict=True):
            number += 1
            if right:
                yield number, status.decode(), reason.decode("utf-8", "replace")


def records(file: ScalarFile, maker: PointMaker) -> Iterator[dict[str, Any]]:
    """The rows in order, each by the names of the table's columns."""
    number = 0
    for block in file.blocks():
        numbers = [block[name].tolist() for name in file.numbers]
        for row, right in enumerate(block[CHECKSUM]):
            number += 1
            if not right:
                continue
            record: dict[str, Any] = {axis.key: v for axis, v in zip(maker.axes, maker.values(number), strict=True)}
            record |= {name: values[row] for name, values in zip(file.numbers, numbers, strict=True)}
            record |= {name: block[name][row].decode("utf-8", "replace") for name in TEXTS}
            applications = record["work.applications"]
            record["work.applications"] = int(applications) if applications == applications else ""
            yield record | over_limit(record) | {"file": "", "number": number}


def found_below(file: ScalarFile) -> list[str]:
    """The scalars below the surface that any of the rows has."""
    found: set[str] = set()
    for block in file.blocks() if file.below else ():
        found |= {name for name in file.below if not np.isnan(block[name][block[CHECKSUM]]).all()}
    return [name for name in file.below if name in found]


def write_table(file: ScalarFile, path: pathlib.Path, maker: PointMaker) -> None:
    """The rows as CSV, with the columns of every sweep's table. Raises WriteError."""
    names = columns(maker.axes, found_below(file))
    with replacing(path) as temporary, open(temporary, "w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(names)
        for record in records(file, maker):
            writer.writerow([cell(record[name]) for name in names])
