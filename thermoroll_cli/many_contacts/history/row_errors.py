"""Estimated errors of the rows of a history, from the same history with fewer elements, with fewer steps, or with both.

Each rule below says by how much some scalars err at least, row by row; the largest of them counts, and one that is not known
leaves the error unknown. What a row cannot have bounds it: creep forces are below μW of that row, shares are shares, and where
there are no tractions nothing of them is in error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from thermoroll_cli.many_contacts.history.course import History, When
from thermoroll_cli.many_contacts.history.history_plan import PER_STEP
from thermoroll_cli.one_contact.refinement.error_estimates import FLOOR, SPREAD
from thermoroll_cli.one_contact.refinement.outcome import rounded
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.scalars import problem_scalars
from thermoroll_cli.problem.names import ALL_SCALARS, holds, known_as, per_length
from thermoroll_cli.problem.problem import BODIES, Problem
from thermoroll_cli.problem.result import State
from thermoroll_cli.problem.scalar_errors import CREEPAGES, error_scale
from thermoroll_cli.problem.surface import Heights
from thermoroll_cli.tools.arrays import Array, Mask

SAFETY, SAFETY_LOCAL = 1.2, 1.75
"""Estimated error over the difference from half the elements and steps, as of first order, which jumps and kinks of inputs
have: of what is summed over the contact, and of `LOCAL` kinds. Of 58 histories on 24 to 64 elements 97.3 % of 10,700 pairs are
covered, and 97.6 % with 1.75 for all, which is half as wide again in the middle. Quarters of elements and steps, too, which
show the order, cover no more at the same width."""
FASTEST = 4.0
"""What twice the elements or steps divide their error by at best: it is of second order."""
LOCAL = "peak", "peak flux", "peak pressure", "relative peak pressure", "stick"
"""Kinds of scalars that one place or one border of the contact decides."""
INTERPOLATED = "force_x_N", "force_y_N", "elastic_energy_J", "heat_J", "shift_x_um", "shift_y_um"
"""What errs with a first state from another grid."""
NARROW = 2.0
"""How often the difference counts besides where nothing rolls and the slip zone is narrower than an element: on both grids it
is as wide as elements allow. Of 54 shifts by 3 to 70 % of μW 0.2 % of 3,024 pairs are then short, none by 3; 2.9 % without."""
BORDER = 0.2
"""Least error of the stick area where nothing rolls, in elements along its border: it is known to first order, and never as
small as it is. Cattaneo's has 0.04 to 0.17 on 16 to 48 elements a side."""
MIDDLE = 0.25
"""Least error of the pressure in the middle over that of the largest one: on 10 and 20 elements it may be the same."""
OF_HEAT = 0.25
"""Least error of the heat over the energy that is missing (0: 99.5 % of lines covered as well, but where it jumps)."""
OF_PATH = 1.0 / 3.0
"""Largest share of force times shift that slip along an unseen border rubs away over that border's share of the contact: 0.03
to 0.05 at a constant load, however large the force (Mindlin and Deresiewicz), and more where loads change."""
OF_TRACTIONS = ("force_x_N", "force_y_N", "spin_moment_Nmm", "shear_max_MPa", "elastic_energy_J", "Q_F_W", "T_gamma_N",
                "T_gamma_without_spin_N", "heat_flux_max_W_mm2", "gamma_st")  # fmt: skip
"""What is known exactly where there are no tractions."""
POWERS = "Q_F_W", "heat_into_lower_W", "heat_into_upper_W"
"""Means since the row before, where nothing rolls."""
SINCE_THE_START = "work_J", "heat_J"
"""Sums over all steps so far."""

Pair = tuple[Sequence["ReportedMoment"], Sequence["ReportedMoment"]]
"""Rows of the same history, the second ones of half the elements, of half the steps, or of both."""
Errors = dict[str, Array]
"""Of the rows (n,), by the names of scalars in their units."""


@dataclass(frozen=True)
class ReportedMoment(When):
    """A state of a history as tables have it: scalars, the `applications` since the row before, whether all steps since then
    were solved, the longest of them (`step`, m), and with its fields the `state`. A share of the contact may stick `unseen`. If
    nothing rolls its powers are means `since` the place of the row before."""

    scalars: Mapping[str, float]
    applications: int
    converged: bool
    state: State | None = None
    step: float = 0.0
    unseen: float = 0.0
    since: float | None = None


def mean_powers(problem: Problem, heat: float, time: float) -> dict[str, float]:
    """The means of the `POWERS` (W, of lines per length) while a `heat` (J) is rubbed within a `time` (s): the first alone
    where the partition of the heat is found."""
    share, power = problem.heating.partition, heat / time
    return dict(zip(POWERS, (power,) if share == "matched" else (power, share * power, (1.0 - share) * power), strict=False))


def over_rows(places: Array, known: Array, difference: Array, alike: Array | None = None) -> Array:
    """The `difference` from a coarser history, (m,) at the places `known`, at all `places` (n,): it changes its sign, so that
    it counts no less than in the rows beside it, and than its mean over the rows that are `alike`, with weights (n, m)."""
    beside = np.interp(places, known, scipy.ndimage.maximum_filter1d(difference, 3))
    weights = np.ones((len(places), len(known))) if alike is None else alike
    # Nothing is like a row that lies very far from all known ones.
    total = np.maximum(weights.sum(axis=1), np.finfo(float).tiny)
    return np.maximum(beside, np.sqrt(weights @ difference**2 / total))


def unseen_pressure(problem: Problem, surfaces: Iterable[Heights | None], sides: tuple[float, float]) -> float:
    """E*/2 of the slopes of `surfaces` that means over elements of the `sides` (m) do not see, in MPa."""
    slopes = (each.texture.unseen(*sides) for each in surfaces if each is not None)
    return 0.5e-6 * problem.contact_modulus * math.hypot(*slopes)


def errors_of_rows(
    history: History, rows: Sequence[ReportedMoment], ways: Mapping[str, Sequence[Pair]], sides: tuple[float, float],
    interpolated: float = 0.0
) -> Errors:
    """Estimated errors of the scalars of all `rows` on elements of the `sides` (m), from what finer and coarser rows differ by
    in all `ways`: "elements", "steps", or "both". The first state has lost the share `interpolated` of its force between two
    grids."""
    compared, found = _Compared(history, rows, [*ways.values()], sides, interpolated), Errors()
    for rule, of in RULES.items():
        for name, error in rule(compared) if of in ("both", *ways) or "both" in ways else ():
            found[name] = np.maximum(found[name], error) if name in found else error
    return compared.bounded(found)


def with_rounding(history: History, rows: Sequence[ReportedMoment], errors: Errors) -> Errors:
    """`errors` with what the rounding of profiles does, as in the contact of the largest load and nearest to the surface."""
    derived, found = DerivedQuantities(history.largest), dict(errors)
    least = {name: min((row.scalars[name] for row in rows if name in row.scalars), default=math.nan) for name in errors}
    for name in (name for name in errors if name in ALL_SCALARS):
        if by_rounding := rounded(name, derived, least):
            largest = {each: np.nanmax(np.abs([row.scalars[each] for row in rows])) for each in (name, "pressure_max_MPa")}
            found[name] = errors[name] + by_rounding * error_scale(name, largest)
    return found


def within_reach(errors: Mapping[str, Array], columns: Mapping[str, Array], friction: Array) -> Errors:
    """`errors` of the `columns` of contacts, (n,), that are no larger than what the coefficient of `friction` of each row lets
    these have."""
    known = {name: columns[known_as(name, columns)] for name in ("normal_N", "pressure_max_MPa", "contact_area_mm2")}
    limit, nothing = friction * known["normal_N"], np.zeros(len(friction))
    ranges = {"force_x_N": (-limit, limit), "force_y_N": (-limit, limit), "gamma_st": (nothing, nothing + 1.0),
              "shear_max_MPa": (nothing, friction * known["pressure_max_MPa"]),
              "stick_area_mm2": (nothing, known["contact_area_mm2"])}
    found = dict(errors)
    for name, (low, high) in ((known_as(name, columns), ends) for name, ends in ranges.items()):
        if name in found:
            found[name] = np.minimum(found[name], np.maximum(columns[name] - low, high - columns[name]))
    return found


def safety_of(name: str) -> float:
    """Estimated error of a scalar over the difference from half the elements and steps."""
    return SAFETY_LOCAL if name in ALL_SCALARS and ALL_SCALARS[name].kind in LOCAL else SAFETY


@dataclass(frozen=True)
class _Compared:
    """The `rows` of a history beside finer and coarser ones, by the `ways` in which these differ, the finest pair first."""

    history: History
    rows: Sequence[ReportedMoment]
    ways: Sequence[Sequence[Pair]]
    sides: tuple[float, float]
    interpolated: float

    @property
    def dx(self) -> float:
        """The length of an element."""
        return self.sides[0]

    @cached_property
    def unseen_pressure(self) -> float:
        """E*/2 of the slopes of surfaces that means over elements do not see, in MPa."""
        return unseen_pressure(self.history.problem, self.history.surfaces, self.sides)

    def named(self, name: str) -> str:
        """A scalar as the contact calls it: of lines per length."""
        return known_as(name, self.columns)

    @cached_property
    def columns(self) -> dict[str, Array]:
        return {name: np.array([row.scalars[name] for row in self.rows]) for name in self.rows[0].scalars}

    def __getitem__(self, name: str) -> Array:
        return self.columns[self.named(name)]

    @cached_property
    def both(self) -> list[int]:
        """The rows that all of the pairs have, too; none without pairs."""
        parts = [part for way in self._by_place for pair in way for part in pair]
        return [i for i, row in enumerate(self.rows) if parts and all(row.place in part for part in parts)]

    @cached_property
    def _by_place(self) -> list[list[tuple[dict[float, ReportedMoment], ...]]]:
        return [[tuple({row.place: row for row in part} for part in pair) for pair in way] for way in self.ways]

    def of_pairs(self, name: str) -> list[Array]:
        """A column at the rows `both`, of all pairs of each way, (pairs, 2, rows)."""
        places = [self.rows[i].place for i in self.both]
        return [np.array([[self._of_part(name, part, pair[-1], places) for part in pair] for pair in way])
                for way in self._by_place]

    def _of_part(
        self, name: str, part: Mapping[float, ReportedMoment], coarser: Mapping[float, ReportedMoment], places: Sequence[float]
    ) -> list[float]:
        """A column of one `part` of a pair at `places`. Powers that are means are those since the row before of the `coarser`
        one: means over other times are other quantities."""
        column, heat = [part[place].scalars[name] for place in places], self.named("heat_J")
        if name not in map(self.named, POWERS):
            return column
        for k, row in enumerate(part[place] for place in places):
            since = coarser[row.place].since
            if since is not None and not math.isnan(column[k]):
                rubbed, lasted = row.scalars[heat] - part[since].scalars[heat], row.time - part[since].time
                powers = {self.named(each): power for each, power in mean_powers(self.history.problem, rubbed, lasted).items()}
                column[k] = powers.get(name, column[k])
        return column

    def difference(self, name: str) -> Array:
        """What a column differs by at the rows `both`, in all ways together. That two agree may be an accident: of those before
        them at least the part counts that would be left at second order."""
        changes = [np.abs(np.diff(columns, axis=1))[:, 0] for columns in self.of_pairs(name)]
        return np.asarray(sum((each / FASTEST ** np.arange(len(each))[:, None]).max(axis=0) for each in changes))

    @cached_property
    def largest(self) -> dict[str, float]:
        """The largest of all rows, by which errors are judged."""
        known = scalars_of_problem(self.history.largest)
        return {**known, **{name: float(np.nan_to_num(np.abs(column)).max()) for name, column in self.columns.items()}}

    @cached_property
    def problems(self) -> list[Problem]:
        return [self.history.problem_at(row.place) for row in self.rows]

    @cached_property
    def half(self) -> float:
        """Half-length of the largest contact, in m."""
        return DerivedQuantities(self.history.largest).scales.semi_axis_x

    @cached_property
    def places(self) -> Array:
        return np.array([row.place for row in self.rows])

    @cached_property
    def rolled(self) -> Array:
        return np.array([row.distance for row in self.rows])

    @cached_property
    def still(self) -> Mask:
        """Rows before which nothing has rolled."""
        return np.asarray(np.diff(self.rolled, prepend=self.rolled[0]) == 0.0)

    @cached_property
    def friction(self) -> Array:
        return np.array([problem.friction.highest for problem in self.problems])

    @cached_property
    def limit(self) -> Array:
        """μW of each row."""
        return self.friction * self["normal_N"]

    @cached_property
    def without_traction(self) -> Mask:
        """Rows without any traction, on all grids."""
        untouched = self["shear_max_MPa"] == 0.0
        if self.both:
            untouched[self.both] &= [not columns.any() for columns in np.concatenate(self.of_pairs("shear_max_MPa")).T]
        return np.asarray(untouched)

    def measure(self, name: str) -> Array | None:
        """What differences of a scalar are in proportion to from row to row; None: they are as large in one as in another."""
        if name in (self.named("force_x_N"), self.named("force_y_N"), "spin_moment_Nmm"):
            return self.limit
        if name == self.named("elastic_energy_J"):
            return self.limit**2
        if name in CREEPAGES:
            # They may pass through zero, and of steps after a jump they are as large as steps are short.
            size = np.nan_to_num(np.hypot(*(self.columns[each] for each in CREEPAGES)))
            return np.asarray(scipy.ndimage.maximum_filter1d(size, 3))
        return None

    @cached_property
    def differences(self) -> Errors:
        return dict(_differences(self))

    def bounded(self, errors: Errors) -> Errors:
        """`errors` that are no larger than what their rows can have, and 0 of what is exact without tractions."""
        found, never = within_reach(errors, self.columns, self.friction), np.logical_and.accumulate(self.without_traction)
        for name in errors:
            exact = self.without_traction if name in map(self.named, OF_TRACTIONS) else never & (self.columns[name] == 0.0)
            found[name] = np.where(exact & ~np.isnan(self.columns[name]), 0.0, found[name])
        return found


# --- by how much rows err at least -----------------------------------------------------------------------------------


def _of_difference(rows: _Compared) -> Iterator[tuple[str, Array]]:
    """What `differences` say."""
    yield from rows.differences.items()


def _differences(rows: _Compared) -> Iterator[tuple[str, Array]]:
    """The difference between finer and coarser rows counts `SAFETY` or `SAFETY_LOCAL` times, and `NARROW` times more where slip
    is not resolved; beside it the `FLOOR` of tolerances. Rows are alike in so far as the contact has not rolled over its own
    length from one to the other: that makes it forget."""
    gamma, line = rows["gamma_st"], rows.history.problem.line
    narrow = rows.still & ((1.0 - (gamma if line else np.sqrt(gamma))) * rows.half < rows.dx)
    for name, column in rows.columns.items() if rows.both else ():
        scalar = ALL_SCALARS.get(name)
        difference = rows.difference(name)
        known = ~np.isnan(difference)
        if not (known.any() and difference[known].any()) or (scalar and holds(scalar.given, rows.problems[-1])):
            continue
        safety = safety_of(name) * np.where(narrow, NARROW, 1.0)
        at = np.array(rows.both)[known]
        difference, measure = difference[known], rows.measure(name)
        if name in map(rows.named, SINCE_THE_START):
            difference = np.maximum.accumulate(difference)
        if measure is not None:
            own = measure[at]
            # A difference above its own measure says nothing about those of other rows.
            difference = np.minimum(np.divide(difference, own, out=np.zeros(len(at)), where=own > 0.0), 1.0)
        apart = np.abs(rows.rolled[:, None] - rows.rolled[at])
        error = over_rows(rows.places, rows.places[at], difference, np.exp(-apart / (2.0 * rows.half)))
        error = error if measure is None else measure * error
        yield name, np.where(np.isnan(column), math.nan, safety * error + FLOOR * error_scale(name, rows.largest))


def _of_interpolation(rows: _Compared) -> Iterator[tuple[str, Array]]:
    """Forces, energies and the shift err by the share of the first force that was interpolated, until rolling over the
    contact's length has made the material forget it."""
    forgotten = np.exp((rows.rolled[0] - rows.rolled) / (2.0 * rows.half))
    for name in INTERPOLATED if rows.interpolated else ():
        size = np.hypot(rows["force_x_N"], rows["force_y_N"])[0] if name.startswith("force") else np.nanmax(np.abs(rows[name]))
        yield rows.named(name), rows.interpolated * float(size) * forgotten


def _of_border(rows: _Compared) -> Iterator[tuple[str, Array]]:
    """Where nothing rolls stick has a least error of `BORDER`. Where it does and all sticks, what slips along the trailing edge
    is narrower than an element."""
    gamma = rows["gamma_st"]
    moved = (rows["elastic_energy_J"] > 0.0) & np.where(rows.still, gamma > 0.0, gamma == 1.0)
    share = np.where(rows.still, BORDER * 2.0, 0.5) * rows.dx / rows.half
    for name in dict.fromkeys(("gamma_st", rows.named("stick_area_mm2"))) if rows.both else ():
        yield name, np.where(moved, share * rows.columns[name] / np.where(moved, gamma, 1.0), 0.0)


def _of_balance(rows: _Compared) -> Iterator[tuple[str, Array]]:
    """The difference of the heat may vanish by chance in all rows: it is no better known than `OF_HEAT` of what is missing
    between work, heat and the stored energy. Heat is a sum of rates at the ends of steps, which work is not."""
    missing = np.abs(rows["work_J"] - rows["heat_J"] - (rows["elastic_energy_J"] - rows["elastic_energy_J"][0]))
    yield rows.named("heat_J"), OF_HEAT * np.maximum.accumulate(missing)


def _of_unseen_slip(rows: _Compared) -> Iterator[tuple[str, Array]]:
    """Where nothing rolls and all elements stick, a border that slips unseen rubs away a share of the largest force times the
    shift: `OF_PATH` of that which slips in Cattaneo's line contact, and no more than an element."""
    stuck = rows.still & (rows["gamma_st"] >= 1.0)
    if not (rows.both and stuck[1:].any()):
        return
    most = np.maximum.accumulate(np.hypot(rows["force_x_N"], rows["force_y_N"]))
    carried = np.minimum(1.0, most / np.maximum(rows.limit, np.finfo(float).tiny))
    share = np.minimum(rows.dx / rows.half, 1.0 - np.sqrt(1.0 - carried))
    path = 1e-6 * np.hypot(*(np.diff(rows[name], prepend=rows[name][0]) for name in ("shift_x_um", "shift_y_um")))
    rubbed = np.where(stuck, OF_PATH * share * most * path, 0.0)
    lasted = np.diff([row.time for row in rows.rows], prepend=rows.rows[0].time)
    yield rows.named("heat_J"), np.cumsum(rubbed)
    yield rows.named("Q_F_W"), rubbed / np.where(lasted > 0.0, lasted, math.inf)


def _of_unseen_stick(rows: _Compared) -> Iterator[tuple[str, Array]]:
    """Where no element sticks, a place may between two in which slip turns (`sharp_places.unseen_stick`)."""
    unseen = np.array([row.unseen for row in rows.rows])
    if rows.both and unseen.any():
        yield "gamma_st", unseen
        yield rows.named("stick_area_mm2"), unseen * rows["contact_area_mm2"]


def _of_narrow_slip(rows: _Compared) -> Iterator[tuple[str, Array]]:
    """The heat of a slip zone narrower than an element is spread over all of it, on both grids: fluxes and temperatures are
    larger than they say, as in a steady state (`error_estimates.Resolution`)."""
    gamma, elements = rows["gamma_st"], 2.0 * rows.half / rows.dx
    narrow = np.where(rows.still, 0.0, gamma / np.maximum(1.0, (1.0 - gamma) * elements) ** 2)
    flux = "heat_flux_max_W_mm2"
    unseen = {flux: narrow / np.maximum(1.0 - gamma, 1.0 / elements) * rows[flux]}
    for body in BODIES if "temperature_rise_max_lower_K" in rows.columns else ():
        largest, mean = (SPREAD * narrow * np.abs(rows[f"temperature_rise_{which}_{body}_K"]) for which in ("max", "mean"))
        unseen |= {f"temperature_rise_max_{body}_K": largest, f"surface_temperature_max_{body}_K": largest,
                   f"temperature_rise_centre_{body}_K": largest, f"temperature_rise_mean_{body}_K": mean}
    yield from ((name, rows.differences[name] + more) for name, more in unseen.items() if name in rows.differences)


def _of_heights(rows: _Compared) -> Iterator[tuple[str, Array]]:
    """Slopes that means over elements do not see raise the largest pressure."""
    for name, per in (("pressure_max_MPa", 1.0), ("gamma_p", rows.columns["gamma_p"] / rows.columns["pressure_max_MPa"])):
        if rows.unseen_pressure and name in rows.differences:
            yield name, rows.differences[name] + rows.unseen_pressure * per


def _of_long_steps(rows: _Compared) -> Iterator[tuple[str, Array]]:
    """Over steps that are long beside the waves of a surface tractions do not feel what passes between them: they err as much
    as they change from one row to another there, and the heat by the change of what is stored meanwhile, too."""
    shortest = min((each.texture.shortest for each in rows.history.surfaces if each is not None), default=math.inf)
    long = np.array([row.step > PER_STEP * shortest for row in rows.rows])[1:]
    if not (rows.both and long.any()):
        return

    def change(name: str, over: Array | float = 1.0) -> Array:
        changes = np.abs(np.diff(np.nan_to_num(rows[name]))) / over
        return np.append(0.0, SAFETY_LOCAL * scipy.ndimage.maximum_filter1d(np.where(long, changes, 0.0), 3))

    for name in (*OF_TRACTIONS, "stick_area_mm2"):
        if rows.named(name) in rows.columns:
            yield rows.named(name), change(name)
    lasted = np.diff([row.time for row in rows.rows])
    yield rows.named("Q_F_W"), change("Q_F_W") + change("elastic_energy_J", lasted)


def _of_middle(rows: _Compared) -> Iterator[tuple[str, Array]]:
    """The pressure in the middle errs as the largest one does, by `MIDDLE`."""
    if {"pressure_centre_MPa", "pressure_max_MPa"} <= rows.differences.keys():
        yield "pressure_centre_MPa", MIDDLE * (rows.differences["pressure_max_MPa"] + rows.unseen_pressure)


RULES: Mapping[Callable[[_Compared], Iterator[tuple[str, Array]]], str] = {
    _of_difference: "both", _of_interpolation: "both", _of_border: "elements", _of_balance: "steps",
    _of_unseen_slip: "elements", _of_unseen_stick: "elements", _of_narrow_slip: "elements", _of_heights: "elements",
    _of_long_steps: "steps", _of_middle: "both"}
"""Rules, and of what the error is: an error of elements is none that shorter steps would better."""


def scalars_of_problem(problem: Problem) -> dict[str, float]:
    """Scalars of a problem; of a line contact per length."""
    known = problem_scalars(DerivedQuantities(problem))
    return per_length(known) if problem.line else known
