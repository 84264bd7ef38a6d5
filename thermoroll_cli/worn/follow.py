"""A whole evolution of a case: every step goes into a journal, from which it is resumed, and its files are written."""

from __future__ import annotations

import contextlib
import csv
import io
import math
import os
import pathlib
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from thermoroll_cli.atomic import write_bytes
from thermoroll_cli.files.case import Case, solvable
from thermoroll_cli.files.result.hdf5 import file_image
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.result import Result
from thermoroll_cli.process import safe_point
from thermoroll_cli.tasks.journal import Journal
from thermoroll_cli.tasks.runner import Workers, check_main_guard
from thermoroll_cli.wheelset.curves import Points
from thermoroll_cli.worn.evolution import REACHED, WearState, evolution, worn_apart
from thermoroll_cli.worn.service import positions_of, reached, service
from thermoroll_cli.worn.wear_files import Snapshots, record_of, resumed, table, worn_case, write_group, write_profiles


@dataclass(frozen=True)
class Evolution:
    """The wear of the profiles of a `case`.

    Attributes:

    - `rows`: a mapping per step, under the names of NAME_wear.csv, with the relative errors in `error`;
    - `snapshots`: profiles and loads of some steps over y, in SI units;
    - `result`: that of the last step, with the worn case;
    - `reason`: why it ended early, "" if it did not;
    - `files`: those that were written.
    """

    case: Case
    rows: tuple[Mapping[str, Any], ...]
    snapshots: Snapshots
    result: Result
    reason: str
    files: tuple[pathlib.Path, ...] = ()

    @property
    def converged(self) -> bool:
        """Whether it went as far as the case asks."""
        return not self.reason

    def __repr__(self) -> str:
        last = self.rows[-1]
        return (f"<Evolution {self.case.name}, {len(self.rows) - 1} steps, {last['distance_km']:.4g} km, "
                f"{self.reason or 'finished'}>")


@dataclass(frozen=True)
class ServiceEvolution:
    """The wear of a wheelset and its rails over the positions of its service.

    Attributes:

    - `rows`: a mapping per step, under the names of NAME_wear.csv;
    - `outlines`: points (y, z) in m of the new and of the worn outline by name (`wheel_right`, …), as in the case;
    - `reason`: why it ended early, "" if it did not;
    - `files`: those that were written.
    """

    case: Case
    rows: tuple[Mapping[str, Any], ...]
    outlines: Mapping[str, tuple[Points, Points]]
    reason: str
    files: tuple[pathlib.Path, ...] = ()

    converged, __repr__ = Evolution.converged, Evolution.__repr__


def wear(
    case: Case | Mapping[str, Any] | str | os.PathLike[str], folder: str | os.PathLike[str] | None = None, *,
    resume: bool = False, jobs: int = 1, threads: int = 1,
    report: Callable[[int, Mapping[str, Any]], None] | None = None, command_line: str = "Python",
) -> Evolution | ServiceEvolution:
    """Follow the profiles of both bodies as they wear, as `thermoroll wear` does, over the distance or to the depth that
    `[wear]` of a case gives.

    Parameters:

    - `case`: as of `solve`, with the table `[wear]`;
    - `folder`: receives the files of the command but for pictures, and is made if necessary; without it nothing is kept;
    - `resume`: goes on from the steps in `folder`;
    - `jobs`: processes that share the positions of a wheelset (a script then needs `if __name__ == "__main__":`);
    - `threads`: as of `solve`;
    - `report`: called with the number of each step and its row as soon as it is solved;
    - `command_line`: for the file, which records it.

    Returns an `Evolution`, of a wheelset a `ServiceEvolution`.

    Raises CaseError for an invalid case, also a conformal contact or one without a steady state, and positions that cannot be;
    ValueError if the case gives neither distance nor depth; OSError if a file cannot be written.
    """
    case = Case.of(case)
    with solvable(case, case.name):
        if case.settings.wheelset is not None:
            return _in_service(case, folder, resume, Workers(jobs), threads, report)
        return _followed(case, folder, resume, threads, report, command_line)


def _followed(case: Case, folder: str | os.PathLike[str] | None, resume: bool, threads: int,
              report: Callable[[int, Mapping[str, Any]], None] | None, command_line: str) -> Evolution:
    asked = case.problem.wear
    if asked is None or asked.distance == asked.depth:
        raise ValueError("the case needs [wear] with distance_km or depth_um")
    with contextlib.ExitStack() as stack:
        place = pathlib.Path(folder or stack.enter_context(tempfile.TemporaryDirectory(prefix="thermoroll-")))
        place.mkdir(parents=True, exist_ok=True)
        journal = stack.enter_context(
            Journal(place / f"{case.name}_wear.jsonl", {"kind": "wear", "case": case.to_json()}, resume=resume))
        start, state = resumed(journal), None
        for state in evolution(case.problem, start, threads=threads):
            safe_point()
            record = record_of(state)
            journal.keep(record)
            if report is not None:
                report(state.steps, record["row"])
        assert state is not None and state.result is not None
        journal.update()
        records = [journal[str(step)] for step in range(state.steps + 1)]
        result, reason = state.result, ""
        if not result.converged:
            reason = f"step {state.steps} did not converge: {result.reason}"
        elif state.distance < asked.distance and state.deepest < (1.0 - REACHED) * asked.depth:
            reason = ("the bodies wear apart at the given distance: "
                      f"{result.coupled.scalars['normal_N']:.3g} N are left" if worn_apart(case.problem, state)
                      else "nothing slips, so nothing wears")
        worn = worn_case(case, state)
        result = replace(result, case_text=worn.text, case_json=worn.to_json())
        done = Evolution(case, tuple(record["row"] for record in records), Snapshots.of(case.problem, records), result, reason)
        return done if folder is None else replace(done, files=_written(done, place, state, command_line))


def _in_service(case: Case, folder: str | os.PathLike[str] | None, resume: bool, workers: Workers, threads: int,
                report: Callable[[int, Mapping[str, Any]], None] | None) -> ServiceEvolution:
    positions = positions_of(case)
    asked = positions[0][1].contact.wear
    if asked is None or asked.distance == asked.depth:
        raise ValueError("the case needs [wear] with distance_km or depth_um")
    if asked.lower.wears and math.isinf(asked.lower.track_length):
        raise Unsolvable("a rail has no circumference", "wear.lower",
                         "track_length_m, the distance between two passages of a wheel")
    if workers.jobs > 1:
        check_main_guard()
    rows: list[Mapping[str, Any]] = []
    with contextlib.ExitStack() as stack:
        place = pathlib.Path(folder or stack.enter_context(tempfile.TemporaryDirectory(prefix="thermoroll-")))
        place.mkdir(parents=True, exist_ok=True)
        journal = stack.enter_context(
            Journal(place / f"{case.name}_wear.jsonl", {"kind": "wear", "case": case.to_json()}, resume=resume))
        for state in service(positions, journal, workers, threads):
            safe_point()
            rows.append(state.row)
            if report is not None:
                report(state.steps, state.row)
        reason = state.reason or ("" if reached(asked, state) else "nothing slips, so nothing wears")
        done = ServiceEvolution(case, tuple(rows), {name: (outline.points, outline.worn) for name, outline in
                                                    state.outlines.items()}, reason)
        return done if folder is None else replace(done, files=_written_service(done, place))


def _written_service(done: ServiceEvolution, folder: pathlib.Path) -> tuple[pathlib.Path, ...]:
    """A table of the steps, and the outlines that wear as files that a case reads as rail_profile and wheel_profile."""
    text, files = io.StringIO(), [folder / f"{done.case.name}_wear.csv"]
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(done.rows[0])
    writer.writerows([f"{value:.7g}" for value in row.values()] for row in done.rows)
    write_bytes(files[0], text.getvalue().encode())
    for name, (new, worn) in done.outlines.items():
        if worn is not new:
            files.append(folder / f"{done.case.name}_worn_{name}.csv")
            lines = "".join(f"{1e3 * y:.9g},{1e3 * z:.9g}\n" for y, z in worn)
            write_bytes(files[-1], ("# y in mm to the field side, z in mm down\n" + lines).encode())
    return tuple(files)


def _written(done: Evolution, folder: pathlib.Path, state: WearState, command_line: str) -> tuple[pathlib.Path, ...]:
    stem = folder / f"{done.case.name}_wear"
    files = stem.with_suffix(".csv"), stem.with_suffix(".h5")
    write_bytes(files[0], table(done.rows))
    write_bytes(files[1], file_image(done.result, command_line, more=lambda file: write_group(file, done.rows, done.snapshots)))
    return (*files, *write_profiles(folder, done.case.name, done.case.problem, state))
