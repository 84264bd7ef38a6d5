"""A whole evolution of a case: every step goes into a journal, from which it is resumed, and its files are written."""

from __future__ import annotations

import contextlib
import os
import pathlib
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from thermoroll_cli.atomic import write_bytes
from thermoroll_cli.files.case import Case, solvable
from thermoroll_cli.files.result.hdf5 import file_image
from thermoroll_cli.problem.result import Result
from thermoroll_cli.process import safe_point
from thermoroll_cli.tasks.journal import Journal
from thermoroll_cli.worn.evolution import REACHED, WearState, evolution, worn_apart
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


def wear(
    case: Case | Mapping[str, Any] | str | os.PathLike[str], folder: str | os.PathLike[str] | None = None, *,
    resume: bool = False, threads: int = 1, report: Callable[[int, Mapping[str, Any]], None] | None = None,
    command_line: str = "Python",
) -> Evolution:
    """Follow the profiles of both bodies as they wear, as `thermoroll wear` does, over the distance or to the depth that
    `[wear]` of a case gives.

    Parameters:

    - `case`: as of `solve`, with the table `[wear]`;
    - `folder`: receives the files of the command but for pictures, and is made if necessary; without it nothing is kept;
    - `resume`: goes on from the steps in `folder`;
    - `threads`: as of `solve`;
    - `report`: called with the number of each step and its row as soon as it is solved;
    - `command_line`: for the file, which records it.

    Raises CaseError for an invalid case, also a wheelset, a conformal contact or one without a steady state; ValueError if the
    case gives neither distance nor depth; OSError if a file cannot be written.
    """
    case = Case.of(case)
    with solvable(case, case.name):
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


def _written(done: Evolution, folder: pathlib.Path, state: WearState, command_line: str) -> tuple[pathlib.Path, ...]:
    stem = folder / f"{done.case.name}_wear"
    files = stem.with_suffix(".csv"), stem.with_suffix(".h5")
    write_bytes(files[0], table(done.rows))
    write_bytes(files[1], file_image(done.result, command_line, more=lambda file: write_group(file, done.rows, done.snapshots)))
    return (*files, *write_profiles(folder, done.case.name, done.case.problem, state))
