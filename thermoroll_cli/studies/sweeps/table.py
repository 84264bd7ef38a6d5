"""The rows of a sweep, one per point, and the table of them."""

from __future__ import annotations

import math
import pathlib
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from thermoroll_cli.problem import names
from thermoroll_cli.problem.columns import CONVERGED, TEXTS, Columns
from thermoroll_cli.problem.limits import Judged, Limit
from thermoroll_cli.problem.names import STATES
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.scalar_errors import row_of
from thermoroll_cli.studies.sweeps.points import Points, Value
from thermoroll_cli.tools.journal import Journal

if TYPE_CHECKING:
    import pandas
    import xarray


@dataclass(frozen=True)
class Row:
    """The outcome of one point. `summary` has the shape of `Result.summary()` and the columns of `OVER_LIMIT`, with nan for
    numbers that were not computed; `file` is the result file, if there is one. `worst` are the rows of a history that decide
    whether it keeps its `limits` (`worst_of`)."""

    number: int
    name: str
    over: Mapping[str, Value]
    summary: Mapping[str, Any]
    file: pathlib.Path | None
    limits: Sequence[Limit] = ()
    worst: Sequence[Mapping[str, float]] = ()

    @cached_property
    def judged(self) -> list[Judged | None]:
        """The `limits` held against a point that converged."""
        return [limit.judged(self.worst or [row_of(self.summary)]) if self.converged else None for limit in self.limits]

    @property
    def converged(self) -> bool:
        return bool(self.summary["status"] == CONVERGED)

    @property
    def reason(self) -> str:
        return str(self.summary["reason"])

    def flat(self) -> dict[str, Any]:
        """The swept values and the summary side by side, with `file`."""
        return {**self.over, **self.summary, "file": self.file}

    def cells(self) -> dict[str, Any]:
        """The values by column, numbers and texts."""
        summary, work = self.summary, self.summary["work"]
        limits = {limit.text: "" if one is None else "met" if one.met else "not met"
                  for limit, one in zip(self.limits, self.judged, strict=True)}
        return {**row_of(summary), **self.over, **limits, "unbounded": " ".join(summary["unbounded"]),
                "warnings": "; ".join(summary["warnings"]), "work.grid": "x".join(map(str, work.get("grid", ()))),
                "file": self.file.name if self.file else "", "work.applications": work.get("applications", math.nan)}


def summary_of(result: Result) -> dict[str, Any]:
    """The record of a result: what `Row.summary` is made of, in plain JSON types, without what was not computed; of a history
    its last state."""
    summary = result.summary()
    summary.pop("history", None)
    for name, value in names.over_limit(row_of(summary)).items():
        within = summary["uncertainty"] if name.startswith(names.UNCERTAINTY) else summary
        within[name.removeprefix(names.UNCERTAINTY)] = value
    known: dict[str, Any] = _known(summary)
    return known


def _known(value: Any) -> Any:
    """Without numbers that were not computed."""
    if isinstance(value, list):
        return [_known(each) for each in value]
    if not isinstance(value, Mapping):
        return value
    return {name: _known(inner) for name, inner in value.items() if not (isinstance(inner, float) and math.isnan(inner))}


def failed_summary(reason: str) -> dict[str, Any]:
    """The record of a point that has no result."""
    return {"status": "not_converged", "reason": reason}


def _whole(summary: Mapping[str, Any]) -> dict[str, Any]:
    """A record's summary with nan for everything that it lacks."""
    scalars = dict.fromkeys((*names.SCALARS, *names.PROBLEM_SCALARS, *names.OVER_LIMIT), math.nan)
    states = {state: dict.fromkeys(names.SCALARS, math.nan) | summary.get(state, {}) for state in STATES}
    return {**scalars, "work": {}, "warnings": [], "unbounded": [], **summary, **states}


@dataclass(frozen=True)
class Rows:
    """The rows known so far, read from the journal one by one, in the order of the points."""

    points: Points
    keys: Sequence[str]
    journal: Journal
    folder: pathlib.Path
    limits: Sequence[Limit] = ()

    def row(self, number: int) -> Row:
        record = self.journal[self.keys[number - 1]]
        file = self.folder / record["file"] if record["file"] else None
        name = self.points.name(number) if file is None else file.stem
        return Row(number, name, self.points.over(number), _whole(record["summary"]), file, self.limits,
                   record.get("worst", ()))

    @property
    def numbers(self) -> list[int]:
        """The numbers of the points that have a row."""
        return [number for number, key in enumerate(self.keys, 1) if key in self.journal]

    def __iter__(self) -> Iterator[Row]:
        return map(self.row, self.numbers)

    def __len__(self) -> int:
        return len(self.numbers)


def columns_of(rows: Rows, title: str = "", *, every: bool = False) -> Columns:
    """The table with all rows known now, or with `every` point, and nothing for those that have none: the swept keys, texts,
    and every number that any row has."""
    points = rows.points
    keys = tuple(axis.key for axis in points.axes)
    limits = [limit.text for limit in rows.limits]
    columns: dict[str, Any] = {name: [] for name in (*keys, *TEXTS[:-1], *limits, "work.applications", "file")}
    known = set(rows.numbers)
    for before, number in enumerate(range(1, points.count + 1) if every else sorted(known)):
        cells = rows.row(number).cells() if number in known else points.over(number) | dict.fromkeys((*TEXTS, *limits), "")
        # Arrays need a quarter of the memory of lists.
        columns |= {name: array("d", [math.nan]) * before for name, value in cells.items()
                    if name not in columns and isinstance(value, float) and not math.isnan(value)}
        for name, column in columns.items():
            column.append(cells.get(name, math.nan))
    declared = (*keys, *TEXTS[:4], *limits, *names.SCALARS, *names.LINE_SCALARS, *names.PROBLEM_SCALARS,
                *names.LINE_PROBLEM_SCALARS, *names.OVER_LIMIT, *names.SUBSURFACE_SCALARS,
                *(f"{state}.{name}" for state in STATES for name in (*names.SCALARS, *names.LINE_SCALARS)),
                *(f"uncertainty.{name}" for name in names.SUBSURFACE_SCALARS))
    last = {name: columns.pop(name) for name in ("work.grid", "work.applications", "file")}
    # Those of an assembly and of its patches are not declared.
    ordered = {name: columns.pop(name) for name in declared if name in columns}
    return Columns(ordered | columns | last, keys, ("point",) if points.listed else keys, title,
                   points.bases[0].text if len(points.bases) == 1 else "\n".join(
                       f"# {base.source}\n\n{base.text}" for base in points.bases))  # fmt: skip


class SweepTable(list[dict[str, Any]]):
    """The rows of a sweep as mappings: the swept keys, all scalars, `isothermal` and `uncertainty` as mappings, and `file`;
    their `table` has them as columns."""

    def __init__(self, rows: Rows) -> None:
        super().__init__(row.flat() for row in rows)
        self.table = columns_of(rows)

    def __repr__(self) -> str:
        converged = list(self.table["status"]).count(CONVERGED)
        return f"<sweep over {', '.join(self.table.varied)}: {len(self)} points, {converged} converged>"

    def plot(self, name: str = "", *, x: str = "", compare: Sequence[str] = (), ax: Any = None) -> Any:
        """As `Columns.plot`."""
        return self.table.plot(name, x=x, compare=compare, ax=ax)

    def to_dataframe(self) -> pandas.DataFrame:
        """As `Columns.to_dataframe`."""
        return self.table.to_dataframe()

    def to_xarray(self) -> xarray.Dataset:
        """As `Columns.to_xarray`."""
        return self.table.to_xarray()
