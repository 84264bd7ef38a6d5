"""Wear of wheelsets over the positions of their service: all positions on the present outlines, then a step of all outlines.

A row of a wheel loses Σ w δ/(2πr₀) per distance rolled, a row of a rail Σ w δ/L, with the depth δ that one passage wears off at
each position, the share w of the distance that is rolled there, the nominal radius r₀ and the distance L between two passages
of a wheel. Every position is solved from nothing, so that neither their order nor who solves them changes anything.
"""

from __future__ import annotations

import contextlib
import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from thermoroll_cli.files.case import Case, CaseError
from thermoroll_cli.many_contacts.wheelset.conicity import NOMINAL, conicity_of
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.many_contacts.wheelset.wheelset_result import solve_wheelset
from thermoroll_cli.one_contact.steady_state.scalars import worn_per_passage
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import BodyName, Wear, planar
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.scalar_errors import passed_on, worst
from thermoroll_cli.studies.worn.evolution import rate_errors
from thermoroll_cli.studies.worn.outlines import ROW, WornOutline, flange, worn_off
from thermoroll_cli.studies.worn.steps import Columns, WearState, steps_of
from thermoroll_cli.tools.arrays import Array
from thermoroll_cli.tools.journal import Journal, Record
from thermoroll_cli.tools.runner import Item, Workers, run

BODY_OF: dict[str, BodyName] = {"rail": "lower", "wheel": "upper"}
MEANS = ("Q_F_W", "T_gamma_N")
"""Scalars of the wheelset of which the table has the mean over the distance."""
LARGEST = ("pressure_max_MPa", "temperature_rise_max_K", "lateral_over_vertical_left", "lateral_over_vertical_right")
"""Scalars of which the table has the one that is largest in magnitude."""
STABLE_SHARE = 0.6
"""Depth of a step over L p/E*, with the pressure p and the wavelength L of the smoothing: beyond, what a step wears too deep at
a wavelength near L would be worn too little by the next. δp = πE*δ/λ of a wave with the depth δ, times its part 2^(−L²/λ²)
that the smoothing leaves, is largest at λ = 1.18 L; there a step is as deep as it may be at 0.62 L p/E*."""
Outlines = dict[str, WornOutline]


def positions_of(case: Case, source: str = "") -> list[tuple[float, WheelsetProblem]]:
    """The positions of a wheelset's service with their shares of the distance; without any its one position. `source` is the
    case in messages, by default its name.

    Raises CaseError for keys or values that a case cannot have, Unsolvable for those that are no position."""
    given = case.settings.wear and case.settings.wear.positions
    base: Any = case.task
    if isinstance(base, WheelsetProblem):
        base.refuse_variation("the wear of outlines")
    if not given:
        return [(1.0, base)]
    total, found = math.fsum(weight for weight, _ in given), []  # type: ignore[misc]
    for number, (weight, values) in enumerate(given, 1):
        assert isinstance(weight, int | float) and isinstance(values, dict)
        try:
            task: Any = case.with_values(values).task
        except CaseError as cause:
            place = f"{source or case.name}: wear.positions, number {number}"
            raise CaseError([replace(f, source=place) for f in cause.findings]) from None
        if task.kind != base.kind or _bodies(task) != _bodies(base):
            raise Unsolvable(f"position {number} changes the wheelset, the track or the wear itself: {', '.join(values)}",
                             "wear.positions", "keys that say how the wheelset stands, moves, rubs and is loaded")
        found.append((weight / total, task))
    return found


def _bodies(problem: WheelsetProblem) -> tuple[Any, ...]:
    """What must be the same at all positions."""
    return (problem.sides, problem.contact.wear, {side: rail.profile for side, rail in problem.rails.items()}, problem.wheels)


def outlines_of(problem: WheelsetProblem) -> Outlines:
    """The outlines by name, wheel_right and so on."""
    outlines = {}
    for side in problem.sides:
        outlines[f"rail_{side}"] = WornOutline.new(problem.rails[side].profile, wheel=False)
        outlines[f"wheel_{side}"] = WornOutline.new(problem.wheels[side].profile, wheel=True)
    return outlines


def worn_wheelset(problem: WheelsetProblem, outlines: Mapping[str, WornOutline]) -> WheelsetProblem:
    """`problem` with the worn outlines."""
    rails = {side: replace(rail, profile=outlines[f"rail_{side}"].worn) for side, rail in problem.rails.items()}
    wheels = {side: replace(wheel, profile=outlines[f"wheel_{side}"].worn) for side, wheel in problem.wheels.items()}
    return replace(problem, rails=rails, wheels=wheels)


@dataclass(frozen=True)
class Stand:
    """A position on the outlines of a step, solved by one process. `number` counts the positions from 1."""

    step: int
    number: int
    problem: WheelsetProblem
    outlines: Outlines
    threads: int = 1

    @property
    def key(self) -> str:
        return f"{self.step}/{self.number}"

    def items(self) -> Iterator[Item]:
        """A record with the most elements of a patch, the columns of the wheelset, the depths (m) that one passage wears off
        the rows of each outline, and their errors."""
        try:
            result = solve_wheelset(worn_wheelset(self.problem, self.outlines), threads=self.threads)
        except ValueError as cause:
            yield self.given_up(str(cause)), {}
            return
        if not result.converged:
            yield self.given_up(result.reason), {}
            return
        uncertainty = result.uncertainty
        elements = max((patch.coupled.fields["pressure"].size for patch in result.contacts), default=0)
        yield {"key": self.key, "reason": "", "elements": elements,
               "columns": {name: (result[name], uncertainty[name]) for name in (*MEANS, *LARGEST) if name in result.scalars},
               "depths": {name: depth.tolist() for name, depth in depths_of(result, self.outlines).items()},
               "errors": {name: rate_errors_of(result, name) for name in self.outlines}}, {}

    def without(self, done: Callable[[str], bool]) -> Self | None:
        return None if done(self.key) else self

    def parts(self) -> list[Self]:
        return [self]

    def given_up(self, reason: str) -> Record:
        return {"key": self.key, "reason": reason, "solved": False}


def depths_of(result: Result, outlines: Mapping[str, WornOutline]) -> dict[str, Array]:
    """Depth (m) that one passage wears off the rows of each outline."""
    wear, found = result.problem.wear, {}
    assert wear is not None
    for name, outline in outlines.items():
        worn = [worn_off(outline, result.lines[name], patch, worn_per_passage(
            patch.problem, wear.bodies[_body_of(name)], patch.coupled.fields, float(patch.x[1] - patch.x[0])))
                for patch in _patches(result, name)]
        found[name] = np.sum([np.zeros(len(outline.depth)), *worn], axis=0)
    return found


def rate_errors_of(result: Result, name: str) -> tuple[float, float]:
    """Relative error of the largest depth, and error in m² of the cross-section, that one passage wears off an outline."""
    body = _body_of(name)
    area = f"wear_area_{body}_um2"
    mine = [patch for patch in _patches(result, name) if patch[area]]
    return (worst(rate_errors(patch, body)[0] for patch in mine),
            1e-12 * math.fsum(patch.uncertainty[area] for patch in mine))


def _patches(result: Result, name: str) -> list[Result]:
    return [patch for patch in result.contacts if patch.name.startswith(f"{name.partition('_')[2]}_")]


def _body_of(name: str) -> BodyName:
    return BODY_OF[name.partition("_")[0]]


def service(positions: list[tuple[float, WheelsetProblem]], start: WearState | None, journal: Journal, workers: Workers,
            threads: int) -> Iterator[WearState]:
    """The states of the evolution, from the unworn outlines or `start` until the distance is rolled or the depth is worn.
    Positions that the journal has are not solved again; one that has failed is."""
    problem = positions[0][1]
    wear, new = problem.contact.wear, outlines_of(problem)
    assert wear is not None

    def solved(state: WearState) -> WearState:
        outlines = worn_outlines(new, state)
        stands = [Stand(state.steps, k, each, outlines, threads) for k, (_, each) in enumerate(positions, 1)]
        left = [stand for stand in stands if not (stand.key in journal and journal[stand.key].get("solved", True))]
        for _ in run(left, journal, workers, lambda text: None):
            pass
        journal.update()
        return _solved(positions, state, outlines, [journal[stand.key] for stand in stands])

    begin = start or WearState.unworn({name: len(outline.depth) for name, outline in new.items()},
                                      {name: outline.size for name, outline in new.items()})
    return steps_of(wear, begin, solved, lambda state: _columns(problem, wear, state, worn_outlines(new, state)))


def worn_outlines(new: Outlines, state: WearState) -> Outlines:
    """The outlines of a state."""
    return {name: replace(outline, depth=state.worn[name]) for name, outline in new.items()}


def _solved(positions: list[tuple[float, WheelsetProblem]], state: WearState, outlines: Outlines,
            records: Sequence[Mapping[str, Any]]) -> WearState:
    """`state` with what follows from the `records` of its positions."""
    failed = [f"step {state.steps}, position {k}: {record['reason']}" for k, record in enumerate(records, 1)
              if record["reason"]]
    if failed:
        return replace(state, reason=f"{'; '.join(failed)}; resume with another numerics.grid")
    problem, weights = positions[0][1], [weight for weight, _ in positions]
    wear = problem.contact.wear
    assert wear is not None
    rates, errors = {}, {}
    for name, outline in outlines.items():
        total = np.asarray(sum(weight * np.array(record["depths"][name])
                               for weight, record in zip(weights, records, strict=True)))
        rates[name] = outline.smoothed(total, wear.smoothing) / track_length(problem, wear, name)
        area = float(total.sum()) * outline.size
        error = float(passed_on([record["errors"][name][1] for record in records], weights))
        errors[name] = worst(record["errors"][name][0] for record in records), error / area if area else 0.0
    lightest = min(1e6 * record["columns"]["pressure_max_MPa"][0] for record in records)
    stable = STABLE_SHARE * max(wear.smoothing, ROW) * lightest / problem.contact.contact_modulus
    fastest = max(float(rate.max()) for rate in rates.values())
    # Means of some scalars of the positions, and the largest of others, with their errors.
    found = [record["columns"] for record in records]
    columns: Columns = {"elements": (max(record["elements"] for record in records), None)}
    for name in MEANS:
        values, unsure = zip(*(each[name] for each in found), strict=True)
        columns[name] = math.fsum(map(operator.mul, weights, values)), float(passed_on(unsure, weights))
    columns |= {name: max((each[name] for each in found if name in each), key=lambda column: abs(column[0]))
                for name in LARGEST if any(name in each for each in found)}
    return replace(state, rates=rates, rate_errors=errors, longest=min(wear.step, stable) / fastest if fastest else 0.0,
                   columns=columns)


def track_length(problem: WheelsetProblem, wear: Wear, name: str) -> float:
    """Distance (m) rolled between two passages of a point: given, or the nominal circumference of the wheel itself."""
    body, _, side = name.partition("_")
    given = wear.bodies[_body_of(name)].track_length
    if body == "wheel" and given == 2.0 * math.pi * planar(problem.contact).upper_radius_x:
        return 2.0 * math.pi * problem.wheels["left" if side == "left" else "right"].radius
    return given


def _columns(problem: WheelsetProblem, wear: Wear, state: WearState, outlines: Outlines) -> Columns:
    """What is worn off each outline, the sizes of flanges, and the conicity."""
    columns: Columns = {}
    for name, outline in outlines.items():
        body, _, side = name.partition("_")
        if body == "rail":
            columns |= state.wear_columns(name, problem.contact.lower.density or wear.density, None)
            continue
        wheel = problem.wheels["left" if side == "left" else "right"]
        density = problem.contact.upper.density or wear.density
        columns |= state.wear_columns(name, density, 2.0 * math.pi * wheel.radius)
        sizes = flange(outline.worn, wheel.flange_back)
        columns |= {f"flange_{size}_{side}_mm": (1e3 * value, None)
                    for size, value in zip(("height", "thickness", "qR"), sizes, strict=True)}
    conicity = math.nan  # of a single wheel, and beyond the profiles
    if len(problem.sides) == 2:
        with contextlib.suppress(Unsolvable):
            conicity = conicity_of(worn_wheelset(problem, outlines), np.array([NOMINAL])).conicity_at(NOMINAL)
    return columns | {"conicity_3mm": (conicity, None)}
