"""A whole evolution of a case: every step goes into a journal, from which it is resumed, and its files are written."""

from __future__ import annotations

import contextlib
import json
import math
import os
import pathlib
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from thermoroll_cli import of_above
from thermoroll_cli.files.case import Case, solvable
from thermoroll_cli.files.result.labelled import save
from thermoroll_cli.files.result.outcome import KIND, tree_of
from thermoroll_cli.files.table_file import write_csv
from thermoroll_cli.many_contacts.wheelset.curves import Points
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.problem.columns import Columns
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.studies.worn.steps import WearState, reached
from thermoroll_cli.studies.worn.wear_of_contact import WearOfContact
from thermoroll_cli.studies.worn.wear_of_wheelset import WearOfWheelset
from thermoroll_cli.studies.worn.wearing import Snapshots, Wearing, wear_node, write_profiles
from thermoroll_cli.tools.journal import Journal
from thermoroll_cli.tools.process import safe_point
from thermoroll_cli.tools.runner import Workers, check_main_guard

LAYOUT = 4
"""Raised whenever records of the journal change."""


@dataclass(frozen=True)
class Evolution:
    """The wear of the profiles of a `case`, of one contact or of a wheelset.

    Attributes:

    - `rows`: a mapping per step, under the names of NAME_wear.csv; `uncertainty.NAME` is the estimated error in its unit; as
      columns they are the `table`;
    - `snapshots`: profiles and loads of some steps over y, or the worn depths of a wheelset's outlines, in SI units;
    - `outlines`: of a wheelset, points (y, z) in m of the new and of the worn outline by name (`wheel_right`, …);
    - `result`: that of the last step, with the worn case; of a wheelset at the first of its positions; None if that is none;
    - `reason`: why it ended early, "" if it did not;
    - `files`: those that were written.
    """

    case: Case
    rows: tuple[Mapping[str, Any], ...]
    snapshots: Snapshots
    outlines: Mapping[str, tuple[Points, Points]]
    result: Result | None
    reason: str
    files: tuple[pathlib.Path, ...] = ()

    @property
    def converged(self) -> bool:
        """Whether it went as far as the case asks."""
        return not self.reason

    @property
    def table(self) -> Columns:
        """The rows as columns, also `to_dataframe` and `to_xarray`."""
        names = list(self.rows[0])
        return Columns({name: [row.get(name, math.nan) for row in self.rows] for name in names}, (names[0],), ("step",))

    def plot(self, name: str = "", *, ax: Any = None) -> Any:
        """The picture of `thermoroll wear` as a matplotlib figure.

        Parameters:

        - `name`: in its place this column of the `table` over the distance, such as "pressure_max_MPa";
        - `ax`: axes of yours for that column; their figure is returned.

        Raises ValueError for a column that is not there, and axes without a name."""
        return self.table.plot(name, ax=ax) if name or ax is not None else of_above("evolution_figure")(self)

    def __repr__(self) -> str:
        last = self.rows[-1]
        return (f"<Evolution {self.case.name}, {len(self.rows) - 1} steps, {last['distance_km']:.4g} km, "
                f"{self.reason or 'finished'}>")


def wear(
    case: Case | Mapping[str, Any] | str | os.PathLike[str], folder: str | os.PathLike[str] | None = None, *,
    resume: bool = False, force: bool = False, jobs: int = 1, threads: int = 1,
    report: Callable[[int, Mapping[str, Any]], None] | None = None, command_line: str = "Python",
) -> Evolution:
    """Follow the profiles of both bodies as they wear, as `thermoroll wear` does, over the distance or to the depth that
    `[wear]` of a case gives.

    Parameters:

    - `case`: as of `solve`, with the table `[wear]`;
    - `folder`: receives the files of the command but for pictures, and is made if necessary; without it nothing is kept;
    - `resume`: goes on from the steps in `folder`, also with other `[numerics]`;
    - `force`: begins anew in a folder that has steps of another case of this name;
    - `jobs`: processes that share the positions of a wheelset (a script then needs `if __name__ == "__main__":`);
    - `threads`: as of `solve`;
    - `report`: called with the number of each step and its row as soon as it is solved;
    - `command_line`: for the file, which records it.

    Returns an `Evolution`.

    Raises CaseError for an invalid case, also a conformal contact or one without a steady state, and positions that cannot be,
    or neither distance nor depth; OSError if a file cannot be written, or the folder has steps of another case of this name.
    """
    case = Case.of(case)
    with solvable(case, case.name):
        what = wearing(case)
        if what.shares_work and jobs > 1:
            check_main_guard()
        asked = what.asked
        with contextlib.ExitStack() as stack:
            place = pathlib.Path(folder or stack.enter_context(tempfile.TemporaryDirectory(prefix="thermoroll-")))
            place.mkdir(parents=True, exist_ok=True)
            # Worn depths lie on rows of their own, so that any grid goes on with them.
            content = {key: value for key, value in json.loads(case.to_json()).items() if key != "numerics"}
            journal = stack.enter_context(Journal(place / f"{case.name}_wear.jsonl",
                                                  {"kind": "wear", "layout": LAYOUT, "case": content}, resume=resume,
                                                  lost=None if force else lambda steps: ""))
            state: WearState | None = None
            for state in what.states(what.resumed(journal), journal, Workers(jobs), threads):
                safe_point()
                journal.keep(what.record_of(state))
                if report is not None:
                    report(state.steps, state.row)
            assert state is not None
            journal.update()
            records = [journal[str(step)] for step in range(state.steps + 1)]
            reason = state.reason or ("" if reached(asked, state) else "nothing slips, so nothing wears")
            done = Evolution(case, tuple(record["row"] for record in records), what.snapshots(records), what.outlines(state),
                             what.result(state, what.worn_case(state), threads), reason)
            return done if folder is None else replace(done, files=_written(done, place, what, state, command_line))


WAYS: Mapping[str, type[Wearing]] = {Problem.kind: WearOfContact, WheelsetProblem.kind: WearOfWheelset}
"""How each kind of problem wears that does."""


def wearing(case: Case) -> Wearing:
    """What wears in a case. Raises Unsolvable for kinds whose wear is not followed."""
    kind = case.settings.kind
    if kind.name not in WAYS:
        raise kind.without_wear
    return WAYS[kind.name](case)


def _written(
    done: Evolution, folder: pathlib.Path, what: Wearing, state: WearState, command_line: str
) -> tuple[pathlib.Path, ...]:
    stem = folder / f"{done.case.name}_wear"
    files = [stem.with_suffix(".csv")]
    write_csv(files[0], done.table)
    if done.result is not None:
        files.append(stem.with_suffix(".h5"))
        tree = tree_of(done.result)
        save(files[1], replace(tree, nodes={**tree.nodes, "wear": wear_node(done.table, done.snapshots)}), KIND, command_line)
    return (*files, *write_profiles(folder, what, state))
