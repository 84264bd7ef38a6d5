"""The result of a solve: immutable states, their scalars, errors and the work done."""

from __future__ import annotations

import html
import json
import math
import os
import pathlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
import scipy

from thermoroll_cli import of_above, optional
from thermoroll_cli.problem.columns import Columns
from thermoroll_cli.problem.kinds import Kind, kind_named
from thermoroll_cli.problem.names import ALL_SCALARS, FIELDS, known_as, unit_of
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.scalar_errors import isothermal_text, listed_scalars, meaning_in, row_of, scalar_text
from thermoroll_cli.tools.arrays import AnyArray, Array

if TYPE_CHECKING:
    import xarray

Value = TypeVar("Value")


class Named(Mapping[str, Value]):
    """Values by name, which cannot be changed. A KeyError lists the names there are."""

    def __init__(self, kind: str, values: Mapping[str, Value]) -> None:
        self._kind, self._values = kind, dict(values)

    def __getitem__(self, name: str) -> Value:
        if name in self._values:
            return self._values[name]
        raise KeyError(f"no {self._kind} {name!r}; there are {', '.join(self._values) or 'none'}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return repr(self._values)


@dataclass(frozen=True)
class State:
    """One steady state on a grid.

    Attributes:

    - `fields`: read-only arrays (nx, ny), for vectors a name per component, in SI units (`names.FIELDS`);
    - `scalars`: numbers in the units of their names (`names.SCALARS`);
    - `x`, `y`: element centres in m, (nx,) and (ny,). Of a line contact `y` is empty, fields are (nx,), and scalars those of
      `names.LINE_SCALARS`.

    A field whose stage was skipped is absent, its scalars are nan. A KeyError lists the names there are.
    """

    fields: Mapping[str, AnyArray]
    scalars: Mapping[str, float]
    x: Array
    y: Array

    def __post_init__(self) -> None:
        views = {name: np.asarray(values).view() for name, values in self.fields.items()}
        for view in views.values():
            view.flags.writeable = False
        object.__setattr__(self, "fields", Named("field", views))
        object.__setattr__(self, "scalars", Named("scalar", self.scalars))

    @property
    def spots(self) -> int:
        """Parts of the contact that hang together by the sides of elements."""
        return int(scipy.ndimage.label(self.fields["pressure"] > 0.0)[1])

    def __repr__(self) -> str:
        return f"<State: fields {', '.join(self.fields)}; {len(self.scalars)} scalars>"


class Peak(NamedTuple):
    """A largest value and its place `x`, `y`, `z` (SI)."""

    value: float = math.nan
    x: float = math.nan
    y: float = math.nan
    z: float = math.nan


@dataclass(frozen=True)
class BodyStresses:
    """Stresses inside one body in SI units and single precision, by the names of `SUBSURFACE_FIELDS`.

    - `depths`: in m, (nz,), with both sides of interfaces (`within_layers`);
    - `fields`: (nz, nx, ny), as asked for;
    - `plane`: (nz, nx), on the plane y = `plane_y`;
    - `below_stressed`, `below_heated`: (nz,), below the largest von Mises stress and below the hottest point of the surface;
    - `most_stressed`: the largest von Mises stress; `hottest`: the highest temperature, None without heat;
    - `strength`: shakedown and fatigue, (nz,) or (nz, ny), if they are asked for (`STRENGTH_FIELDS`).
    """

    depths: Array
    plane_y: float
    plane: Mapping[str, AnyArray]
    most_stressed: Peak
    hottest: Peak | None
    below_stressed: Mapping[str, AnyArray]
    below_heated: Mapping[str, AnyArray] = field(default_factory=dict)
    fields: Mapping[str, AnyArray] = field(default_factory=dict)
    strength: Mapping[str, AnyArray] = field(default_factory=dict)


class SurfaceMap(NamedTuple):
    """The mean `heights` (m), (n, m), of a surface between the places `along` it and `across` (m; none across a line contact),
    the `path` (m) along it of the middle of a contact from its beginning to its end, the contact's `half` lengths (m) and its
    `centre` across (m)."""

    along: Array
    across: Array
    heights: AnyArray
    path: tuple[float, float]
    half: tuple[float, float]
    centre: float


def within_layers(depths: AnyArray) -> list[slice]:
    """Parts of `depths` between interfaces, whose lower side is the next larger number: stresses jump there."""
    jumps = np.flatnonzero(np.nextafter(depths[:-1], np.inf) == depths[1:]) + 1
    return [slice(int(start), int(stop)) for start, stop in pairwise((0, *jumps, len(depths)))]


@dataclass(frozen=True)
class Subsurface:
    """Stresses below the surface: the `bodies`, all `scalars` (names of `SUBSURFACE_SCALARS`), and `warnings`."""

    bodies: Mapping[str, BodyStresses]
    scalars: Mapping[str, float]
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Result:
    """Outcome of one solve, inside the package and for its users. `result["force_x_N"]` is a scalar.

    Attributes:

    - `problem`: the question, in SI units;
    - `coupled`, `isothermal`: the states with and without thermal deformation; the same object if heat does not change the
      contact. If the domain has followed a heated contact each has its own grid;
    - `of_problem`: scalars that belong to the problem and not to a state (`names.PROBLEM_SCALARS`);
    - `converged`, `reason`: whether the result can be trusted, and if not, why;
    - `uncertainty`: estimated discretisation error of each of the `numbers` in its own unit; nan for a given one, or without an
      estimate;
    - `work`: plain JSON types: grid, iterations, operator applications, seconds by stage, skipped stages with reasons;
    - `residuals`: arrays (iterations,) by name;
    - `warnings`: doubts about the problem or the result;
    - `case_text`, `case_json`: the case as read and with all defaults; empty for a bare `Problem`;
    - `patches`: of an assembly of contacts, as a wheelset, the `Result` of each; of bodies with profiles, a mapping for each
      patch of the coupled state, with units in the names;
    - `assembly`: the kind of assembly, "" for a contact. Its states have scalars without fields, and its `problem` is what its
      contacts have in common;
    - `name`, `record`: of a contact of an assembly, its name in it, and its numbers in the axes of the assembly;
    - `lines`: of an assembly, outlines by name (m), (2, n); of its contacts, the "surface" over `y`: places (m) and inclination
      (rad) in the axes of the assembly, (3, ny);
    - `unbounded`: scalars that grow with every refinement, at a kink or at the end of a profile;
    - `subsurface`: stresses inside the bodies (`Subsurface`); None if the problem asks for none;
    - `attributes`: of the file that the result was read from: time, versions, command line;
    - `history`: of a contact over time the `Columns` of all states, over `time_s`: `distance_mm`, inputs that change, scalars,
      and their errors as `uncertainty.NAME`; the result itself is that of the last state. None for others, and in a file;
    - `surfaces`: of a contact over time the surfaces that it has rolled over, by the names of their bodies.
    """

    problem: Problem
    coupled: State
    isothermal: State
    of_problem: Mapping[str, float]
    converged: bool
    reason: str
    uncertainty: Mapping[str, float]
    work: Mapping[str, Any]
    residuals: Mapping[str, Array] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    case_text: str = ""
    case_json: str = ""
    patches: tuple[Result, ...] | tuple[Mapping[str, float], ...] = ()
    unbounded: tuple[str, ...] = ()
    subsurface: Subsurface | None = None
    attributes: Mapping[str, Any] = field(default_factory=dict)
    assembly: str = ""
    name: str = ""
    record: Mapping[str, Any] = field(default_factory=dict)
    lines: Mapping[str, Array] = field(default_factory=dict)
    history: Columns | None = None
    surfaces: Mapping[str, SurfaceMap] = field(default_factory=dict)

    def __post_init__(self) -> None:
        every = dict.fromkeys(self.numbers, math.nan) | dict(self.uncertainty)
        object.__setattr__(self, "uncertainty", Named("scalar", every))

    @property
    def kind(self) -> Kind:
        """The kind of assembly, or that of a contact."""
        return kind_named(self.assembly)

    @property
    def contacts(self) -> tuple[Result, ...]:
        """The results of an assembly's contacts; none of a contact."""
        return tuple(patch for patch in self.patches if isinstance(patch, Result))

    @property
    def shown(self) -> tuple[Result, ...]:
        """The contacts that printed tables and pictures show: of a bearing those of the ball with the largest load."""
        if not (key := self.kind.answer.shown_by) or not self.contacts:
            return self.contacts
        largest = max(self.contacts, key=lambda contact: float(contact.record["normal_N"])).record[key]
        return tuple(contact for contact in self.contacts if contact.record[key] == largest)

    @property
    def by_suffix(self) -> dict[str, Result]:
        """The contacts of an assembly by what their files have behind the name: `_left_1`; a contact itself, which has ""."""
        return {f"_{patch.name}": patch for patch in self.contacts} if self.assembly else {"": self}

    @property
    def records(self) -> tuple[Mapping[str, Any], ...]:
        """The numbers of each of the `patches`."""
        return tuple(patch.record if isinstance(patch, Result) else patch for patch in self.patches)

    @property
    def last_of(self) -> str:
        """Of a history, whose last state this is, in words: "the last state, at 1.8 mm"; "" of another result."""
        history = json.loads(self.case_json).get("history") if self.case_json else None
        if not history:
            return ""
        place = "distance_mm" if history.get("distance_mm") else "time_s"
        return f"the last state, at {history[place][-1]:.6g} {unit_of(place)}"

    def with_case(self, text: str, resolved: str) -> Result:
        """This result and those of an assembly's contacts, with the text of their case."""
        patches = tuple(patch.with_case(text, resolved) for patch in self.contacts) or self.patches
        history = None if self.history is None else replace(self.history, case_text=text)
        return replace(self, case_text=text, case_json=resolved, patches=patches, history=history)

    @property
    def numbers(self) -> dict[str, float]:
        """Scalars of the coupled state, of the problem and below the surface; nan if not computed."""
        return {**self.coupled.scalars, **self.of_problem, **({} if self.subsurface is None else self.subsurface.scalars)}

    @property
    def scalars(self) -> Mapping[str, float]:
        """The numbers that apply to this problem and were computed, in the units of their names."""
        return Named("scalar", {name: value for name, value in self.numbers.items() if not math.isnan(value)})

    def __getitem__(self, name: str) -> float:
        if name in self.fields:
            raise KeyError(f"{name} is a field: result.fields[{name!r}]; result[NAME] is a scalar")
        return self.scalars[name]

    @property
    def fields(self) -> Mapping[str, AnyArray]:
        """Fields of the coupled state."""
        return self.coupled.fields

    @property
    def x(self) -> Array:
        """Element centres of the coupled state along x in m, (nx,)."""
        return self.coupled.x

    @property
    def y(self) -> Array:
        """Element centres of the coupled state along y in m, (ny,)."""
        return self.coupled.y

    @property
    def bodies(self) -> Mapping[str, BodyStresses]:
        """Stresses inside the bodies, by "lower" and "upper"; empty if the problem asks for none."""
        return {} if self.subsurface is None else self.subsurface.bodies

    @property
    def own_grids(self) -> bool:
        """Whether the two states live on different grids."""
        cold = self.isothermal
        return not (np.array_equal(self.x, cold.x) and np.array_equal(self.y, cold.y))

    @property
    def status(self) -> str:
        return "converged" if self.converged else "not_converged"

    def __repr__(self) -> str:
        title = f"{self.problem.title!r}, " if self.problem.title else ""
        outcome = "converged" if self.converged else f"not converged: {self.reason}"
        scalars = self.coupled.scalars
        shown = {"Q_F_W": "Q_F = {:.4g}", "force_x_N": "F_x = {:.4g}", "gamma_st": "γ_st = {:.3g}"}
        known = {known_as(name, scalars): text for name, text in shown.items()}
        numbers = [f"{text.format(scalars[name])} {unit_of(name)}".rstrip()
                   for name, text in known.items() if scalars.get(name, 0.0) != 0.0]
        count = f"{len(self.patches)} patch{'' if len(self.patches) == 1 else 'es'}"
        sides = "×".join(str(len(side)) for side in (self.x, self.y) if len(side))
        what = f"{self.assembly} with {count}" if self.assembly else sides
        return f"<Result {title}{what}, {', '.join([outcome, *numbers])}>"

    def summary(self) -> dict[str, Any]:
        """All scalars under their public names, with `status`, `reason`, `isothermal`, `uncertainty`, `work` and `warnings`, in
        plain Python types: the object that `--json` prints. Numbers that were not computed are nan."""
        return {
            "status": self.status,
            "reason": self.reason,
            **self.numbers,
            **({} if self.assembly else {"isothermal": dict(self.isothermal.scalars)}),
            "uncertainty": dict(self.uncertainty),
            "work": dict(self.work),
            "warnings": list(self.warnings),
            **({"patches": [dict(patch) for patch in self.records]} if self.patches or self.assembly else {}),
            **({"unbounded": list(self.unbounded)} if self.unbounded else {}),
            **({} if self.history is None else {"history": dict(self.history)}),
        }

    def save(self, path: str | os.PathLike[str]) -> pathlib.Path:
        """Write this result as `thermoroll run` does (docs/read_results.md), complete or not at all.

        Parameters:

        - `path`: of the HDF5 file, which is replaced if it exists; its folder must exist.

        Returns the path. The file of a result of a `Case` contains that case, which `thermoroll run --from` solves again.

        Raises OSError, with a plain message, if the file cannot be written."""
        of_above("write_result")(path, self)
        return pathlib.Path(path)

    def plot(self, kind: str = "", *, normalised: bool = False, cut_y: float | None = None, ax: Any = None) -> Any:
        """A picture as a matplotlib figure; `figure.savefig` writes it. Maps are seen from below (docs/frames.md).

        Parameters:

        - `kind`: "pressure", "traction", "heat_flux", "temperature", "centreline", "summary", … as `thermoroll run` draws them,
          or any field, as a map; of a wheelset "section", "patches" or "friction"; by default the summary, or the section;
        - `normalised`: the article's dimensionless quantities (p/p0, x/a0, …);
        - `cut_y`: the line y of the picture "centreline", in m;
        - `ax`: axes of yours, on which the map of one quantity in the last state is drawn with its colour bar (by default the
          pressure; of a line contact its curve; "subsurface_lower": the von Mises stress); their figure is returned.

        Raises ValueError for an unknown kind (the message lists them), for a cut outside the domain, and if there is nothing to
        show, as the temperature of a problem without heat."""
        if ax is not None:
            of_above("draw_on")(ax, self, kind, normalised=normalised)
            return ax.figure
        figure = of_above("figure")(self, kind, normalised=normalised, cut_y=cut_y)
        if figure is None:
            raise ValueError(f"there is nothing to show in a picture {kind!r} of this result")
        return figure

    def to_xarray(self, state: str = "coupled") -> xarray.Dataset:
        """The fields of one state as an `xarray.Dataset` with SI units, as opening its file gives; scalars are attributes.

        Parameters:

        - `state`: "coupled" or "isothermal" (without thermal deformation).

        Fields have the dimensions (x, y), element centres in m; those of a line contact x alone.

        Raises ImportError, which names the package to install, if xarray is missing; ValueError for another state."""
        dataset = optional("xarray", "to_xarray").Dataset
        if state not in ("coupled", "isothermal"):
            raise ValueError(f'a result has the states "coupled" and "isothermal", not {state!r}')
        chosen = self.coupled if state == "coupled" else self.isothermal
        sides = {name: (name, values, {"units": "m"}) for name, values in (("x", chosen.x), ("y", chosen.y)) if len(values)}
        variables = {name: (tuple(sides), values, {"units": FIELDS[name].unit, "long_name": FIELDS[name].meaning})
                     for name, values in chosen.fields.items()}
        return dataset(variables, sides, {**chosen.scalars, **self.of_problem, "converged": int(self.converged)})

    def _repr_html_(self) -> str:
        """A table of the scalars that `thermoroll run` prints, for notebooks."""
        row, both = row_of(self.summary()), self.isothermal is not self.coupled
        rows = [["scalar", "coupled", "isothermal", "unit"] if both else ["scalar", "value", "unit"]]
        for name in listed_scalars(row, self.problem):
            beside = [isothermal_text(name, row)] if both else []
            meaning = meaning_in(row, name)
            rows.append([meaning, scalar_text(name, row), *beside, ALL_SCALARS[name].unit])
        lines = ("".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows)
        return f"<table><caption>{html.escape(repr(self)[1:-1])}</caption><tr>{'</tr><tr>'.join(lines)}</tr></table>"
