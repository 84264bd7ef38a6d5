"""A whole sweep: finished points are found in the journal, the others are solved, and every point becomes a row."""

from __future__ import annotations

import contextlib
import glob
import itertools
import json
import os
import pathlib
import re
import tempfile
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple, Self

from thermoroll_cli.files.case import Case
from thermoroll_cli.files.case_errors import CaseError, Finding
from thermoroll_cli.files.result.labelled import image, save
from thermoroll_cli.files.result.outcome import KIND, tree_of
from thermoroll_cli.files.table_file import ENDS, SWEEP, history_files, tree_of_table, write_csv
from thermoroll_cli.problem.columns import CASE
from thermoroll_cli.problem.kinds import Kind, Task
from thermoroll_cli.problem.limits import Limit, states_of, worst_of
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import Solver
from thermoroll_cli.studies.sweeps.points import Axis, Base, Points, Value, key_of
from thermoroll_cli.studies.sweeps.table import Row, Rows, SweepTable, columns_of, failed_summary, summary_of
from thermoroll_cli.tools.journal import Journal, Record, is_whole
from thermoroll_cli.tools.process import safe_point
from thermoroll_cli.tools.runner import Item, Workers, check_main_guard, run

if TYPE_CHECKING:
    import pandas

TABLE_NAME, ARRAYS_NAME, JOURNAL_NAME = "sweep.csv", "sweep.h5", "sweep.jsonl"
JOURNAL_FORMAT = 5
FIELDS = ("key", "name", "over", "file", "solved", "summary")
"""What records have."""

SECONDS_BETWEEN_TABLES = 2.0
SHARE_OF_TABLES = 0.05
"""The table is written again while the sweep runs, for at most this share of the time."""
MANY = 2000
"""Points whose checking takes long enough to be mentioned, and whose table is not written on an interruption."""


class Pending(NamedTuple):
    """A point that is to be solved: its number, the key of its record, and the name of its file (empty: none)."""

    number: int
    key: str
    file: str


@dataclass(frozen=True)
class Batch:
    """Neighbouring points, solved one after the other by one worker, each from the one before it.

    Points that are not among `pending` are finished, or given up; they are solved again only where a pending one follows, so
    that its result is the same as if nothing had been interrupted.
    """

    points: Points
    numbers: range
    pending: tuple[Pending, ...]
    command_line: str
    threads: int = 1

    @property
    def key(self) -> str:
        return self.pending[0].key

    def items(self) -> Iterator[Item]:
        """Solve the pending points: a record, and the contents of its files, for each."""
        pending = {one.number: one for one in self.pending}
        solver = Solver(self.threads)
        for number in range(self.numbers.start, self.pending[-1].number + 1):
            case = self.points.case(number)
            result, reason = _attempt(solver, case.task)
            if result is None:
                # The state left by an exception is no start for the next point.
                solver = Solver(self.threads)
            if number not in pending:
                continue
            one = pending[number]
            if result is None:
                yield self._record(one, failed_summary(reason), solved=False), {}
                continue
            result = result.with_case(case.text, case.to_json())
            files = {one.file: image(tree_of(result), KIND, self.command_line),
                     **history_files(one.file.removesuffix(".h5"), result, self.command_line)} if one.file else {}
            worst = {} if result.history is None else {"worst": worst_of(states_of(result.summary()))}
            yield {**self._record(one, summary_of(result)), **worst}, files

    def _record(self, one: Pending, summary: dict[str, Any], *, solved: bool = True) -> Record:
        # The key comes first, so that a reader of the file finds it.
        return {"key": one.key, "name": self.points.name(one.number), "over": self.points.over(one.number),
                "file": one.file if solved else "", "solved": solved, "summary": summary}

    def without(self, done: Callable[[str], bool]) -> Self | None:
        left = tuple(one for one in self.pending if not done(one.key))
        return replace(self, pending=left) if left else None

    def parts(self) -> list[Self]:
        return [replace(self, numbers=range(p.number, p.number + 1), pending=(p,)) for p in self.pending]

    def given_up(self, reason: str) -> Record:
        return self._record(self.pending[0], failed_summary(reason), solved=False)


def _attempt(solver: Solver, problem: Task) -> tuple[Result | None, str]:
    """The result, or none and what went wrong."""
    try:
        return solver.solve(problem), ""
    except MemoryError:
        return None, "not enough memory"
    except Exception as cause:
        return None, " ".join(f"{type(cause).__name__}: {cause}".split())


def summaries(points: Points, numbers: range) -> list[dict[str, Any] | str]:
    """Summaries of the points with these `numbers`, each solved from the one before it, of a history with its columns; what is
    wrong with invalid ones."""
    solver, found = Solver(), list[dict[str, Any] | str]()
    for number in numbers:
        safe_point()
        try:
            result, reason = _attempt(solver, points.case(number).task)
        except CaseError as cause:
            result, reason = None, "; ".join(finding.message for finding in cause.findings)
        over_time = {} if result is None or result.history is None else {"history": dict(result.history)}
        found.append(reason if result is None else summary_of(result) | over_time)
    return found


@dataclass
class Sweep:
    """`points` to be solved into `folder` by `workers`, with a result file for each, or with `scalars_only` none.

    `resume` leaves out the points that the folder has already; without it `force` begins anew in a folder that has a sweep of
    other points. `threads` are those of the transforms in the only process. Rows say which `limits` they keep.
    """

    points: Points
    folder: pathlib.Path
    command_line: str
    workers: Workers = field(default_factory=Workers)
    resume: bool = False
    scalars_only: bool = False
    threads: int = 1
    force: bool = False
    limits: Sequence[Limit] = ()
    _keys: list[str] = field(default_factory=list)

    def check(self, note: Callable[[str], None] = lambda text: None) -> None:
        """Check all points. Raises CaseError with the errors of all of them, each once, or where cases are of unlike kinds,
        which have no scalars in common."""
        if self.points.count > MANY:
            note(f"checking {self.points.count} points")
        self.points = self.points.with_one_decision()
        self._keys, kinds = [], dict[str, Kind]()
        for case in self.points.checked():
            self._keys.append(key_of(case))
            kinds.setdefault(case.name, case.settings.kind)
        (first, kind), *others = kinds.items()
        if unlike := next(((name, other) for name, other in others if other is not kind), None):
            this, that = (one.words + ("" if one.base else " over time") for one in (unlike[1], kind))
            raise CaseError([Finding(f"this is {this}, and {first} {that}: sweep them one by one", source=unlike[0])])

    def run(self, *, report: Callable[[Row, bool], None], note: Callable[[str], None]) -> Rows:
        """Solve the points, write a result file for each unless `scalars_only`, and the tables, and return the rows.

        `report` is called with each row when it is known, and whether it was solved now rather than found finished; `note`
        with remarks. Whatever ends the sweep early, finished points keep their records and files.

        Raises CaseError before anything is solved; OSError: a file cannot be written, another sweep works in the folder or has
        left other points in it, no cluster.
        """
        if not self._keys:
            self.check(note)
        # Points that differ in their labels alone are solved once.
        numbers = dict[str, list[int]]()
        for number, key in enumerate(self._keys, 1):
            numbers.setdefault(key, []).append(number)
        with Journal(self.folder / JOURNAL_NAME, {"kind": "sweep", "format": JOURNAL_FORMAT}, resume=self.resume,
                     fields=FIELDS, lost=None if self.force else self._lost) as journal:
            owners = {record["file"]: key for key, record in journal.items() if record["file"]}
            finished = self._finished(journal, owners, note)
            if finished:
                note(f"{sum(len(numbers[key]) for key in finished)} of {self.points.count} points are finished already")
            rows = Rows(self.points, self._keys, journal, self.folder, self.limits)
            for number in itertools.chain.from_iterable(numbers[key] for key in finished):
                report(rows.row(number), False)
            written, wait = time.monotonic(), SECONDS_BETWEEN_TABLES
            try:
                with contextlib.closing(run(self._batches(finished, owners), journal, self.workers, note)) as keys:
                    for key in keys:
                        safe_point()
                        for number in numbers[key]:
                            report(rows.row(number), True)
                        if (now := time.monotonic()) - written > wait:
                            write_csv(self.folder / TABLE_NAME, columns_of(rows))
                            written = time.monotonic()
                            wait = max(SECONDS_BETWEEN_TABLES, (written - now) / SHARE_OF_TABLES)
            except BaseException:
                journal.update()
                if journal and self.points.count <= MANY:
                    with contextlib.suppress(OSError):
                        self._write(rows)
                raise
            self._write(rows)
            self._clear(rows, journal.replaced(), note)
            return rows

    def _lost(self, journal: Mapping[str, Record]) -> str:
        """Which points of the sweep in a `journal` are none of this one, "" if all are."""
        own = {*self._keys}
        others = [key for key in journal if key not in own]
        if not others:
            return ""
        last, count = journal[others[-1]], len(journal)
        stems = dict.fromkeys(record["name"].rpartition("_")[0] for record in journal.values())
        there = (f"{count} point{'s' if count > 1 else ''} of {' and '.join(stems)} over "
                 f"{', '.join(key for key in last['over'] if key != CASE)}")
        here = (f"{self.points.count} of {' and '.join(base.stem for base in self.points.bases)} over "
                f"{', '.join(axis.key for axis in self.points.axes if axis.key != CASE)}")
        return f"{self.folder} has a sweep of {there}, {len(others)} of which are not among the {here} asked for now"

    @property
    def titles(self) -> dict[str, str]:
        """Titles of the cases by their names."""
        firsts = range(1, self.points.count + 1, self.points.per_case)
        return {self.points.base(number).stem: self.points.case(number).settings.title for number in firsts}

    @property
    def title(self) -> str:
        """That of the case, or of all cases if it is the same."""
        titles = {*self.titles.values()}
        return titles.pop() if len(titles) == 1 else ""

    def _write(self, rows: Rows) -> None:
        table = columns_of(rows, self.title)
        write_csv(self.folder / TABLE_NAME, table)
        if self.scalars_only:
            settings = json.dumps([override.text for override in self.points.settings])
            tree = tree_of_table(columns_of(rows, table.title, every=True), settings=settings)
            save(self.folder / ARRAYS_NAME, tree, SWEEP, self.command_line)

    def _finished(self, journal: Journal, owners: Mapping[str, str], note: Callable[[str], None]) -> list[str]:
        """The keys of points that have a result, in a file that is the latest of its name: `owners` are the keys of the records
        by the names of their files."""
        found = []
        for key in dict.fromkeys(self._keys):
            if key not in journal or not (record := journal[key])["solved"]:
                continue
            safe_point()
            if not self.scalars_only:
                if owners.get(record["file"]) != key:  # of a sweep with --scalars-only, or overwritten
                    continue
                if not is_whole(self.folder, record):
                    note(f"{self.folder / record['file']}: not there, or not as it was written; solved again")
                    continue
            found.append(key)
        return found

    def _batches(self, finished: Collection[str], owners: Mapping[str, str]) -> Iterator[Batch]:
        """Batches with points that are still to be solved. A name that the record of another point has is not given again."""
        taken, free, done = dict(owners), self.points.per_case, {*finished}  # with what is pending
        for numbers in self.points.batches():
            pending = []
            for number in numbers:
                key = self._keys[number - 1]
                if key in done:
                    continue
                stem, _, digits = self.points.name(number).rpartition("_")
                file = "" if self.scalars_only else f"{stem}_{digits}.h5"
                while file and taken.get(file, key) != key:
                    free += 1
                    file = f"{stem}_{free:0{len(digits)}d}.h5"
                taken[file] = key
                pending.append(Pending(number, key, file))
                done.add(key)
            if pending:
                yield Batch(self.points, numbers, tuple(pending), self.command_line, self.threads)

    def _clear(self, rows: Rows, replaced: set[str], note: Callable[[str], None]) -> None:
        """Remove the files that the sweep before this one, whose table is `replaced`, had for further points of this case; tell
        of others that are called like points of this one."""
        if self.scalars_only:
            return
        names = {row.file.name for row in rows if row.file is not None}
        numbered = (path for end in (".h5", ENDS[0]) for base in self.points.bases
                    for path in self.folder.glob(f"{glob.escape(base.stem)}_[0-9][0-9][0-9][0-9]*{end}"))
        result_of = {path: f"{re.sub('(_history)?[.](h5|csv)$', '', path.name)}.h5" for path in numbered}
        unlisted = sorted(path for path, result in result_of.items() if result not in names)
        stale, others = ([path for path in unlisted if (result_of[path] in replaced) is own] for own in (True, False))
        for path in stale:
            path.unlink(missing_ok=True)
        for files, what in ((stale, "of the sweep before, removed"),
                            (others, f"of another sweep, not touched, not in {TABLE_NAME}")):  # fmt: skip
            if files:
                which = files[0].name + (f" … {files[-1].name}" if len(files) > 1 else "")
                note(f"{self.folder}: {len(files)} file{'s' if len(files) > 1 else ''} {what}: {which}")


AnyCase = Case | Mapping[str, Any] | str | os.PathLike[str]


def sweep(
    case: AnyCase | Sequence[AnyCase],
    over: Mapping[str, Iterable[Value]] | Sequence[Mapping[str, Value]] | pandas.DataFrame,
    folder: str | os.PathLike[str] | None = None,
    *,
    jobs: int = 1,
    dask: str = "",
    resume: bool = False,
    force: bool = False,
    report: Callable[[dict[str, Any]], None] | None = None,
) -> SweepTable:
    """Solve one or several cases for many values of some of their keys, as `thermoroll sweep` does; neighbours start from each
    other.

    Parameters:

    - `case`: as of `solve`, or a list of them, of which each is solved at all points; rows then have their names in `case`;
    - `over`: values by key, of which every combination is solved, the last key varying fastest
      (`{"rolling.speed_m_s": [1, 2, 5]}`, in the units of the keys); or a list of points, mappings from the same keys to values
      or the rows of a `DataFrame`;
    - `folder`: receives a result file per point and sweep.csv; without it nothing is kept and `file` is None;
    - `jobs`: processes that share the work (a script then needs `if __name__ == "__main__":`);
    - `dask`: address of the scheduler of a Dask cluster, which then does the work;
    - `resume`: leaves out points that `folder` has already;
    - `force`: begins anew in a folder that has a sweep of other points;
    - `report`: called with each row as soon as it is known.

    Returns a list with a row per point: the swept keys, all scalars under their public names and in the units of these,
    `isothermal` and `uncertainty` as mappings, `status` and `reason`, and `file`, the path of its result. Its `to_dataframe()`
    and `to_xarray()` have the numbers in flat columns.

    Raises CaseError, with the errors of all points, before anything is solved; ValueError for values that are no list, for the
    same value or point twice, for several cases of one name, and for too many points; OSError if a file cannot be written,
    another sweep works in the folder or has left other points in it, or there is no cluster; RuntimeError for a script without
    that line.
    """
    cases = [Case.of(one) for one in (case if isinstance(case, Sequence) and not isinstance(case, str) else [case])]
    if jobs > 1:
        check_main_guard()
    if not isinstance(over, Mapping) and hasattr(over, "to_dict"):
        over = over.to_dict("records")
    listed = not isinstance(over, Mapping)
    if isinstance(over, Mapping):
        columns: Mapping[str, Iterable[Value]] = over
    else:
        if not over or any(set(point) != set(over[0]) for point in over):
            raise ValueError("a list of points needs at least one, and the same keys in each of them")
        columns = {key: _values_of(key, [point[key] for point in over]) for key in over[0]}
        if len(set(zip(*columns.values(), strict=True))) < len(over):
            raise ValueError("the same point occurs more than once")
    axes = tuple(Axis(key, _values_of(key, values)) for key, values in columns.items())
    for axis in axes:
        if not axis.values or (not listed and len(set(axis.values)) < len(axis.values)):
            raise ValueError(f"{axis.key} has no values, or the same value more than once")
    points = Points.of([Base(one.to_toml(), one.name, one.name) for one in cases], axes, listed=listed, origin="sweep over")
    with contextlib.ExitStack() as stack:
        place = pathlib.Path(folder or stack.enter_context(tempfile.TemporaryDirectory(prefix="thermoroll-")))
        place.mkdir(parents=True, exist_ok=True)
        wanted = Sweep(points, place, "Python", Workers(jobs, dask), resume, scalars_only=folder is None, force=force)

        def reported(row: Row, solved: bool) -> None:
            if report is not None:
                report(row.flat())

        return SweepTable(wanted.run(report=reported, note=lambda text: None))


def _values_of(key: str, values: Iterable[Value]) -> tuple[Value, ...]:
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise ValueError(f"{key} needs a list of values, as [{values!r}], not {values!r} alone")
    plain = tuple(value.item() if hasattr(value, "item") else value for value in values)
    for value in plain:
        if not isinstance(value, bool | int | float | str):
            raise ValueError(f"values of {key} must be numbers, words or true and false, not {value!r}")
    return plain
