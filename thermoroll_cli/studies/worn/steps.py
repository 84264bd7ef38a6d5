"""Explicit steps of wear, of one contact or of a wheelset: the loop over them, their end, their errors and their columns."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self, TypeVar

import numpy as np
import scipy

from thermoroll_cli.physics.numerics.grid import peak_value
from thermoroll_cli.problem.names import UNCERTAINTY
from thermoroll_cli.problem.problem import Wear
from thermoroll_cli.tools.arrays import Array

REACHED = 1e-6
"""Part of the wanted distance or depth that may be missing in the end: rounding must not ask for one more step."""
Columns = dict[str, tuple[float, float | None]]
"""Value and estimated error of each column in its unit, nan if unknown; None for what never has an error."""


@dataclass(frozen=True, kw_only=True)
class WearState:
    """A moment of an evolution, by the names of what wears:

    - `steps`: number of steps before it, and `distance` rolled in m;
    - `worn`: depths in m on rows of the widths `sizes` (m);
    - `error_shares`: shares of the errors of the largest depth (m) and of the worn cross-section (m²), (3, 2): by the grid, by
      the steps, their difference to the trapezoidal rule, and by the shape of one passage's wear;

    and once it is solved

    - `rates`: depths worn per metre rolled on the rows, with the relative errors of their largest and of their sum in
      `rate_errors`;
    - `longest`: the distance (m) of the next step at most, 0 where nothing wears;
    - `columns`: what results say of it;
    - `reason`: why the evolution cannot go on, "" if it can.
    """

    steps: int = 0
    distance: float = 0.0
    worn: dict[str, Array]
    sizes: dict[str, float]
    error_shares: dict[str, Array]
    rates: dict[str, Array] = field(default_factory=dict)
    rate_errors: dict[str, tuple[float, float]] = field(default_factory=dict)
    longest: float = 0.0
    columns: Columns = field(default_factory=dict)
    reason: str = ""

    @classmethod
    def unworn(cls, counts: Mapping[str, int], sizes: dict[str, float], **others: Any) -> Self:
        """Before the first step, with these numbers of rows."""
        return cls(worn={name: np.zeros(count) for name, count in counts.items()}, sizes=sizes,
                   error_shares={name: np.zeros((3, 2)) for name in counts}, **others)

    @property
    def deepest(self) -> float:
        """Largest worn depth of all in m."""
        return max(map(self.worn_depth, self.worn))

    def worn_depth(self, name: str) -> float:
        """Largest worn depth in m; rows have averages."""
        return peak_value(self.worn[name][None])

    def worn_area(self, name: str) -> float:
        """Worn cross-section in m²."""
        return float(self.worn[name].sum()) * self.sizes[name]

    def errors(self, name: str) -> tuple[float, float]:
        """Estimated errors of the largest depth (m) and of the worn cross-section (m²)."""
        depth, area = np.abs(self.error_shares[name]).sum(axis=0)
        return float(depth), float(area)

    def moved(self, step: float) -> Self:
        """The next state, `step` (m) further, not solved."""
        worn = {name: depth + step * self.rates[name] for name, depth in self.worn.items()}
        return replace(self, steps=self.steps + 1, distance=self.distance + step, worn=worn, rates={}, rate_errors={},
                       longest=0.0, columns={})

    def wear_columns(self, name: str, density: float, length: float | None) -> Columns:
        """Depth, cross-section, volume and mass worn off over the `length` (m); without it the mass per metre."""
        (depth_error, area_error), area = self.errors(name), self.worn_area(name)
        found: Columns = {f"depth_max_{name}_um": (1e6 * self.worn_depth(name), 1e6 * depth_error),
                          f"worn_area_{name}_mm2": (1e6 * area, 1e6 * area_error)}
        if length is None:
            return found | {f"worn_mass_{name}_kg_m": (density * area, density * area_error)}
        volumes = (area * length, area_error * length) if area else (0.0, 0.0)
        return found | {f"worn_volume_{name}_cm3": (1e6 * volumes[0], 1e6 * volumes[1]),
                        f"worn_mass_{name}_kg": (density * volumes[0], density * volumes[1])}

    @property
    def row(self) -> dict[str, float]:
        """Values of all columns, then their errors."""
        columns: Columns = {"distance_km": (1e-3 * self.distance, None)} | self.columns
        return ({name: value for name, (value, _) in columns.items()}
                | {f"{UNCERTAINTY}{name}": error for name, (_, error) in columns.items() if error is not None})


State = TypeVar("State", bound=WearState)


def steps_of(wear: Wear, start: State, solved: Callable[[State], State],
             columns: Callable[[State], Columns]) -> Iterator[State]:
    """The states from `start` on, each `solved` and with its `columns`: until the distance is rolled or the depth is worn,
    where nothing wears any more, and after one that is not solved."""
    state, before = solved(start), None
    while True:
        if before is not None:
            state = replace(state, error_shares=_error_shares(before, state))
        state = replace(state, columns=columns(state) | state.columns)
        yield state
        if state.reason or state.longest == 0.0 or reached(wear, state):
            return
        before, state = state, solved(state.moved(_step(wear, state)))


def reached(wear: Wear, state: WearState) -> bool:
    """Whether the distance is rolled or the depth is worn."""
    return state.distance >= (1.0 - REACHED) * wear.distance or state.deepest >= (1.0 - REACHED) * wear.depth


def _step(wear: Wear, state: WearState) -> float:
    """Distance (m) of the next step."""
    step = min(state.longest, wear.distance - state.distance)
    if state.moved(step).deepest <= wear.depth:
        return step
    return float(scipy.optimize.brentq(lambda part: state.moved(part).deepest - wear.depth, 0.0, step, rtol=1e-9))


def _error_shares(before: WearState, state: WearState) -> dict[str, Array]:
    """The shares of the errors of `state`, one step after `before`. Errors of the worn area add up. A row that wears too much
    carries less from then on, so that the depth has the error of the area and of one passage's shape, at most as deep as one
    step wears."""
    if not state.rates:
        return before.error_shares
    step, errors = state.distance - before.distance, {}
    for name, shares in before.error_shares.items():
        old, new = (np.array([each.rates[name].max(), each.rates[name].sum() * each.sizes[name]]) for each in (before, state))
        shape, area = before.rate_errors[name]
        added = shares + np.array([step * old * area, 0.5 * step * (new - old), [0.0, 0.0]])
        added[2, 0] = max(added[2, 0], step * old[0] * shape)
        errors[name] = added
    return errors
