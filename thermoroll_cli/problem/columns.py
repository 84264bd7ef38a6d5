"""Tables of many states: of the points of a sweep, of a contact over time, of profiles that wear."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from thermoroll_cli import of_above, optional
from thermoroll_cli.problem.names import PLACES, column_of, known_as
from thermoroll_cli.tools.arrays import AnyArray

if TYPE_CHECKING:
    import pandas
    import xarray

CONVERGED = "converged"
CASE = "case"
"""The column that tells the states of several cases apart."""
TEXTS = ("status", "reason", "unbounded", "warnings", "work.grid", "file")
"""Columns of texts. `unbounded` names the scalars that have no limit at this point, where the contact reaches the end of a
profile."""


@dataclass(frozen=True, repr=False)
class Columns(Mapping[str, Sequence[Any]]):
    """Columns by name, with a value for each state: numbers, nan where not computed, and texts.

    - `varied`: columns of what was varied, of a history first the places;
    - `over`: the axes of the states: `varied` where these are all combinations of values; else one axis, the column of that
      name, or the number of the state ("point" from 1, "step" from 0);
    - `title`, `case_text`: of the case, if known; `attributes`: of the file that the table was read from;
    - `states`: the fields of some states of a history (`State`), by the number of the row from 0."""

    columns: Mapping[str, Sequence[Any]]
    varied: tuple[str, ...]
    over: tuple[str, ...]
    title: str = ""
    case_text: str = ""
    attributes: Mapping[str, Any] = field(default_factory=dict)
    states: Mapping[int, Any] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Sequence[Any]:
        if name in self.columns:
            return self.columns[name]
        raise KeyError(f"no column {name!r}; there are {', '.join(self.columns)}")

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    def __repr__(self) -> str:
        return f"<table over {', '.join(self.over)}: {self.count} states, {len(self)} columns>"

    @property
    def count(self) -> int:
        """Number of states."""
        return len(next(iter(self.columns.values())))

    def lacks(self, names: Sequence[str]) -> list[str]:
        """For each of the `names` of which no state that converged has a number, a warning."""
        lacking = [name for name in names if not any(
            status == CONVERGED and isinstance(value, int | float) and math.isfinite(value)
            for status, value in zip(self["status"], self.get(known_as(name, self), ()), strict=False))]
        instead = {name: name.replace("flash_temperature_", "temperature_rise_") for name in lacking}
        return [f"{name} was not computed at any point" + (
            f": without recirculating heat it is {rise}" if rise != name else "") for name, rise in instead.items()]

    @property
    def of_history(self) -> bool:
        """Whether the states follow each other in time."""
        return self.over == ("time_s",)

    @property
    def place(self) -> str:
        """The column of a history that says where: the distance rolled, or the time where nothing rolls."""
        return "distance_mm" if self["distance_mm"][-1] > self["distance_mm"][0] else "time_s"

    @property
    def label(self) -> tuple[str, ...]:
        """Columns by which people know a state: what was varied, of a history with one place alone."""
        if not self.of_history:
            return self.varied
        return self.place, *(name for name in self.varied if name not in PLACES)

    @property
    def coordinates(self) -> dict[str, AnyArray]:
        """The values along each axis, of which each combination has a state."""
        found = {}
        for name in self.over:
            distinct = list(dict.fromkeys(self.get(name, ())))
            words = any(isinstance(value, str) for value in distinct)
            numbers = np.arange(self.count) + (name == "point")
            found[name] = np.array(list(map(str, distinct)) if words else distinct) if distinct else numbers
        return found

    @property
    def numbers(self) -> dict[str, Sequence[float]]:
        """The computed columns without texts."""
        return {name: column for name, column in self.columns.items() if name not in (*self.varied, *TEXTS)}

    def plot(self, name: str = "", *, x: str = "", compare: Sequence[str] = (), ax: Any = None) -> Any:
        """The picture of `thermoroll plot` as a matplotlib figure: scalars over what was varied, of a history over the distance
        or time.

        Parameters:

        - `name`: this column alone, such as "force_x_N"; all diagrams if not given;
        - `x`: the column of what was varied that is the axis, as `--x` of the command;
        - `compare`: theories of creep forces: "linear", "fastsim", "polach";
        - `ax`: axes of yours, on which one column is drawn; their figure is returned.

        Raises ValueError for a column that is not there or was not varied, axes without a name, and where there is no curve."""
        if ax is not None and not name:
            raise ValueError("axes of yours take one column: give its name")
        return of_above("plot_table")(self, name, x=x, compare=compare, ax=ax)

    def _shown(self) -> dict[str, Sequence[Any]]:
        status = {CONVERGED: [one == CONVERGED for one in self["status"]]} if "status" in self else {}
        return {**status, **self.numbers}

    def to_dataframe(self) -> pandas.DataFrame:
        """A `pandas.DataFrame` with a row for each state: what was varied, `converged`, and a column for each number.

        Raises ImportError, which names the package to install, if pandas is missing."""
        varied = {key: self[key] for key in self.varied}
        return optional("pandas", "to_dataframe").DataFrame({**varied, **self._shown()})

    def to_xarray(self) -> xarray.Dataset:
        """An `xarray.Dataset` with `converged` and each number over the axes of the table.

        Raises ImportError, which names the package to install, if xarray is missing."""
        axes = self.coordinates
        shape = [len(values) for values in axes.values()]
        varied = {key: ((self.over), np.reshape(self[key], shape)) for key in self.varied if key not in axes}
        dataset = optional("xarray", "to_xarray").Dataset
        columns = {name: (self.over, np.reshape(column, shape)) for name, column in self._shown().items()}
        found = dataset(columns, {**{name: (name, values) for name, values in axes.items()}, **varied})
        for name, variable in found.variables.items():
            labels = zip(("units", "long_name"), column_of(str(name), self.varied), strict=True)
            variable.attrs.update({label: text for label, text in labels if text})
        return found
