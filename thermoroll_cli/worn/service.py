"""Wear of wheelsets over the positions of their service: all positions on the present outlines, then a step of all outlines.

A row of a wheel loses Σ w δ/(2πr₀) per distance rolled, a row of a rail Σ w δ/L, with the depth δ that one passage wears off at
each position, the share w of the distance that is rolled there, the nominal radius r₀ and the distance L between two passages
of a wheel. Every position is solved from nothing, so that neither their order nor who solves them changes anything.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.files.case import Case, CaseError
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import BodyName, Wear, planar
from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.scalars import worn_per_passage
from thermoroll_cli.tasks.journal import Journal, Record
from thermoroll_cli.tasks.runner import Item, Workers, run
from thermoroll_cli.wheelset.conicity import NOMINAL, conicity_of
from thermoroll_cli.wheelset.wheelset_problem import SideName, WheelsetProblem
from thermoroll_cli.wheelset.wheelset_result import solve_wheelset
from thermoroll_cli.worn.outlines import ROW, Outline, flange, worn_off

BODY_OF: dict[str, BodyName] = {"rail": "lower", "wheel": "upper"}
MEANS = ("Q_F_W", "T_gamma_N")
"""Scalars of the wheelset of which the table has the mean over the distance."""
LARGEST = ("pressure_max_MPa", "temperature_rise_max_K", "lateral_over_vertical_left", "lateral_over_vertical_right")
"""Scalars of which the table has the one that is largest in magnitude."""
STABLE_SHARE = 0.6
"""Depth of a step over L p/E*, with the pressure p and the wavelength L of the smoothing: beyond, what a step wears too deep at
a wavelength near L would be worn too little by the next. δp = πE*δ/λ of a wave with the depth δ, times its part 2^(−L²/λ²)
that the smoothing leaves, is largest at λ = 1.18 L; there a step is as deep as it may be at 0.62 L p/E*."""
ROUNDING = 1e-9
"""Part of the wanted distance or depth that may be missing in the end."""

Outlines = dict[str, Outline]


def positions_of(case: Case) -> list[tuple[float, WheelsetProblem]]:
    """The positions of a wheelset's service with their shares of the distance; without any its one position.

    Raises CaseError for keys or values that a case cannot have, Unsolvable for those that are no position."""
    given = case.settings.wear and case.settings.wear.positions
    base = case.task
    assert isinstance(base, WheelsetProblem)
    if not given:
        return [(1.0, base)]
    total, found = math.fsum(weight for weight, _ in given), []  # type: ignore[misc]
    for number, (weight, values) in enumerate(given, 1):
        assert isinstance(weight, int | float) and isinstance(values, dict)
        try:
            task = case.with_values(values).task
        except CaseError as cause:
            place = f"{case.name}: wear.positions, number {number}"
            raise CaseError([replace(f, source=place) for f in cause.findings]) from None
        if not isinstance(task, WheelsetProblem) or _bodies(task) != _bodies(base):
            raise Unsolvable(f"position {number} changes the wheelset, the track or the wear itself: {', '.join(values)}",
                             "wear.positions", "keys that say how the wheelset stands, moves, rubs and is loaded")
        found.append((weight / total, task))
    return found


def _bodies(problem: WheelsetProblem) -> tuple[Any, ...]:
    """What must be the same at all positions."""
    return (problem.sides, problem.contact.wear, {side: rail.profile for side, rail in problem.rails.items()}, problem.wheels)


def outlines_of(problem: WheelsetProblem) -> Outlines:
    """The unworn outlines by name, wheel_right and so on."""
    outlines = {}
    for side in problem.sides:
        outlines[f"rail_{side}"] = Outline.new(problem.rails[side].profile, wheel=False)
        outlines[f"wheel_{side}"] = Outline.new(problem.wheels[side].profile, wheel=True)
    return outlines


def worn_wheelset(problem: WheelsetProblem, outlines: Mapping[str, Outline]) -> WheelsetProblem:
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
        """A record with the scalars of the wheelset and the depths (m) that one passage wears off the rows of each outline."""
        try:
            result = solve_wheelset(worn_wheelset(self.problem, self.outlines), threads=self.threads)
        except ValueError as cause:
            yield self.given_up(str(cause)), b""
            return
        scalars = {name: result.coupled.scalars[name] for name in (*MEANS, *LARGEST) if name in result.coupled.scalars}
        yield {"key": self.key, "reason": result.reason if not result.converged else "", "scalars": scalars,
               "depths": {name: depth.tolist() for name, depth in depths_of(result, self.outlines).items()}}, b""

    def without(self, done: Callable[[str], bool]) -> Self | None:
        return None if done(self.key) else self

    def parts(self) -> list[Self]:
        return [self]

    def given_up(self, reason: str) -> Record:
        return {"key": self.key, "reason": reason, "scalars": {}, "depths": {}}


def depths_of(result: Result, outlines: Mapping[str, Outline]) -> dict[str, Array]:
    """Depth (m) that one passage wears off the rows of each outline."""
    found = {}
    for name, outline in outlines.items():
        body, side = name.split("_")
        mine: list[Array] = []
        for patch in result.contacts:
            wear = patch.problem.wear
            assert wear is not None
            if patch.record["side"] == side:
                dx = float(patch.x[1] - patch.x[0])
                mine.append(worn_per_passage(patch.problem, getattr(wear, BODY_OF[body]), patch.coupled.fields, dx))
        side_name: SideName = "left" if side == "left" else "right"
        found[name] = worn_off(result, outline, body, side_name, mine)
    return found


@dataclass(frozen=True)
class ServiceState:
    """The outlines after so many `steps` and a `distance` (m), the depths worn per metre rolled (`rates`) on their
    rows, and the largest depth (m) of the next step that is `stable`."""

    steps: int
    distance: float
    outlines: Outlines
    rates: dict[str, Array]
    row: dict[str, Any]
    stable: float
    reason: str = ""

    @property
    def deepest(self) -> float:
        return max(float(outline.depth.max()) for outline in self.outlines.values())

    def moved(self, step: float) -> Outlines:
        """The outlines `step` (m) further."""
        return {name: replace(outline, depth=outline.depth + step * self.rates[name])
                for name, outline in self.outlines.items()}


def service(positions: list[tuple[float, WheelsetProblem]], journal: Journal, workers: Workers,
            threads: int) -> Iterator[ServiceState]:
    """The states of the evolution, each solved, until the distance is rolled or the depth is worn. What the journal has is not
    solved again."""
    wear = positions[0][1].contact.wear
    assert wear is not None
    outlines, steps, distance = outlines_of(positions[0][1]), 0, 0.0
    while True:
        stands = [Stand(steps, k, problem, outlines, threads) for k, (_, problem) in enumerate(positions, 1)]
        for _ in run((stand for stand in stands if stand.key not in journal), journal, workers, lambda text: None):
            pass
        journal.update()
        records = [journal[stand.key] for stand in stands]
        state = _state(positions, steps, distance, outlines, records)
        yield state
        step = _step(wear, state)
        if state.reason or step == 0.0:
            return
        outlines, steps, distance = state.moved(step), steps + 1, distance + step


def _state(positions: list[tuple[float, WheelsetProblem]], steps: int, distance: float, outlines: Outlines,
           records: Sequence[Mapping[str, Any]]) -> ServiceState:
    problem = positions[0][1]
    wear = problem.contact.wear
    assert wear is not None
    failed = [f"step {steps}, position {k}: {record['reason']}" for k, record in enumerate(records, 1) if record["reason"]]
    rates = {name: np.zeros(len(outline.depth)) for name, outline in outlines.items()}
    for name, outline in outlines.items() if not failed else ():
        length = track_length(problem, wear, name)
        total = sum(weight * np.array(record["depths"][name]) for (weight, _), record in zip(positions, records, strict=True))
        rates[name] = outline.smoothed(np.asarray(total), wear.smoothing) / length
    weights = [weight for weight, _ in positions]
    lightest = min((1e6 * record["scalars"]["pressure_max_MPa"] for record in records if record["scalars"]), default=0.0)
    stable = STABLE_SHARE * max(wear.smoothing, ROW) * lightest / problem.contact.contact_modulus
    return ServiceState(steps, distance, outlines, rates, _row(problem, wear, distance, outlines, weights, records), stable,
                        "; ".join(failed))


def track_length(problem: WheelsetProblem, wear: Wear, name: str) -> float:
    """Distance (m) rolled between two passages of a point: given, or the nominal circumference of the wheel itself."""
    body, _, side = name.partition("_")
    given = float(getattr(wear, BODY_OF[body]).track_length)
    if body == "wheel" and given == 2.0 * math.pi * planar(problem.contact).upper_radius_x:
        return 2.0 * math.pi * problem.wheels["left" if side == "left" else "right"].radius
    return given


def _row(problem: WheelsetProblem, wear: Wear, distance: float, outlines: Outlines, weights: list[float],
         records: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    row: dict[str, Any] = {"distance_km": 1e-3 * distance}
    for name, outline in outlines.items():
        body, _, side = name.partition("_")
        row |= {f"depth_max_{name}_um": 1e6 * float(outline.depth.max()), f"worn_area_{name}_mm2": 1e6 * outline.area}
        if body == "rail":
            row[f"worn_mass_{name}_kg_m"] = wear.density * outline.area
            continue
        wheel = problem.wheels["left" if side == "left" else "right"]
        volume = 2.0 * math.pi * wheel.radius * outline.area
        sizes = flange(outline.worn, wheel.flange_back)
        row |= {f"worn_volume_{name}_cm3": 1e6 * volume, f"worn_mass_{name}_kg": wear.density * volume}
        row |= {f"{size}_{side}_mm": 1e3 * value for size, value in
                zip(("flange_height", "flange_thickness", "flange_qR"), sizes, strict=True)}
    row["conicity_3mm"] = _conicity(worn_wheelset(problem, outlines))
    for name in MEANS:
        row[name] = math.fsum(weight * record["scalars"].get(name, math.nan)
                              for weight, record in zip(weights, records, strict=True))
    for name in LARGEST:
        row[name] = max((record["scalars"].get(name, math.nan) for record in records),
                        key=lambda value: -1.0 if math.isnan(value) else abs(value))
    return row


def _conicity(problem: WheelsetProblem) -> float:
    """Equivalent conicity at 3 mm; nan for a single wheel and beyond the profiles."""
    if len(problem.sides) < 2:
        return math.nan
    try:
        return conicity_of(problem, np.array([NOMINAL])).conicity_at(NOMINAL)
    except Unsolvable:
        return math.nan


def reached(wear: Wear, state: ServiceState) -> bool:
    """Whether the distance is rolled or the depth is worn."""
    return state.distance >= (1.0 - ROUNDING) * wear.distance or state.deepest >= (1.0 - ROUNDING) * wear.depth


def _step(wear: Wear, state: ServiceState) -> float:
    """Distance (m) of the next step; 0 at the end, and where nothing wears."""
    fastest = max(float(rate.max()) for rate in state.rates.values())
    if fastest <= 0.0 or reached(wear, state):
        return 0.0
    to_depth = min(float(((wear.depth - outline.depth)[worn] / rate[worn]).min()) for name, outline in state.outlines.items()
                   if (worn := (rate := state.rates[name]) > 0.0).any())
    return max(0.0, min(min(wear.step, state.stable) / fastest, to_depth, wear.distance - state.distance))
