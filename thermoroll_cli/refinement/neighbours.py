"""Predicted starts: the state of a problem from those of the last two that were solved.

With the last states x₁ and x₀ of a grid, and the changes Δ from one problem to the next on the coarser grid, a state starts
from

    x = x₁ + t (x₁ − x₀) + P(Δ_coarse − t Δ_coarse,old)

in Hertz's units: pressures over their peak, tractions over their bound, displacements over the approach, places over the sides
of the domain, so that neighbours may differ in load and profile, too. t is the step of the problem's numbers over the step
before; it is 0 if they do not go on in the same direction, or go much further. Whatever was solved counts: points of a sweep,
steps of wear, a loop over `Solver`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace

import numpy as np

from thermoroll_cli.arrays import Array, Mask
from thermoroll_cli.numerics.grid import Grid, Prolongation
from thermoroll_cli.problem.contact import Contact, Pressure, Traction
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.refinement.outcome import RefinementLevel
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.discretisation import Discretisation
from thermoroll_cli.steady_state.fixed_point import UNKNOWNS, SteadyState, unknowns_of

LONGEST = 3.0
"""Largest |t|. Without: 12 % more transforms after a step that is ten times the one before it."""
ASIDE = 0.1
"""Part of a step that may lie aside of the step before; more is a corner of a sweep over several keys."""

Fields = dict[str, Array]


def step_length(problems: tuple[Problem, Problem, Problem]) -> float:
    """t: the last step between three problems over the one before it, 0 where that does not predict it."""
    parts = ([getattr(problem, field.name) for problem in problems] for field in fields(Problem))
    changed = [part for part in parts if not part[0] == part[1] == part[2]]
    groups = [[group for value in values for group in _numbers(value)] for values in zip(*changed, strict=True)]
    if len({tuple(group.shape for group in one) for one in groups}) > 1:
        return 0.0
    old, new = [], []
    for first, second, third in zip(*groups, strict=True):
        scale = max(float(np.abs(group).max(initial=0.0)) for group in (first, second, third)) or 1.0
        old.append((second - first) / scale)
        new.append((third - second) / scale)
    before, step = np.concatenate([*old, np.zeros(1)]), np.concatenate([*new, np.zeros(1)])
    size = float(before @ before)
    if size == 0.0:
        return 0.0
    t = float(step @ before) / size
    aside = float(np.linalg.norm(step - t * before))
    return t if abs(t) <= LONGEST and aside <= ASIDE * float(np.linalg.norm(step)) else 0.0


def _numbers(value: object) -> Iterator[Array]:
    """The finite numbers of a problem as arrays of those with one scale: one each, but for columns and rows of tables."""
    if isinstance(value, tuple) and value and isinstance(value[0], tuple):
        yield from np.array(value, dtype=float).T
    elif isinstance(value, tuple) and value and all(isinstance(part, float) for part in value):
        yield np.array(value)
    elif isinstance(value, tuple) or is_dataclass(value):
        for part in value if isinstance(value, tuple) else (getattr(value, field.name) for field in fields(value)):
            yield from _numbers(part)
    elif isinstance(value, int | float) and not isinstance(value, bool) and np.isfinite(value):
        yield np.array([float(value)])


class SolvedBefore:
    """The last two solved problems, newest first, and the step from them to `problem`."""

    def __init__(self, problem: Problem, solved: Sequence[tuple[Problem, list[RefinementLevel]]]) -> None:
        self._levels = [levels for _, levels in solved]
        self._t = step_length((solved[1][0], solved[0][0], problem)) if len(solved) > 1 else 0.0

    def neighbours(
        self, shape: tuple[int, int], extent: float, coarse: RefinementLevel | None, coarser: Neighbours | None
    ) -> Neighbours | None:
        """Those on a grid of `shape`; `coarse` is the next coarser one, and `coarser` are the neighbours there. None if the
        last problem was not solved on such a grid."""
        same_grid = [next((level for level in levels if level.discretisation.grid.shape == shape
                       and level.discretisation.extent == extent), None) for levels in self._levels]
        last, before = (*same_grid, None, None)[:2]
        if last is None:
            return None
        return Neighbours(last, before, coarse, None if coarser is None else coarser.last,
                          None if coarser is None else coarser.before, self._t if before is not None else 0.0)


@dataclass(frozen=True)
class Prediction:
    """A predicted state: its `fields` and `creepage` in Hertz's units; only `inside`, the last contact, has pressure."""

    derived: DerivedQuantities
    fields: Fields
    creepage: Array
    inside: Mask

    def pressure(self, name: str = "start") -> Array:
        """Pressure in Pa, (nx, ny), from which the solver starts; with the name "pressure" that of partly covered elements."""
        peak = self.derived.scales.peak_pressure
        return np.where(self.inside, np.maximum(self.fields[name] * peak, 0.0), 0.0)

    def contact(self, isothermal: Pressure, *, coupled: bool) -> Contact:
        """The predicted state as a first guess; its pressure is the `isothermal` one if nothing acts back on that."""
        derived, normal = self.derived, isothermal
        unknowns = {name: field * UNKNOWNS[name](derived) for name, field in self.fields.items() if name in UNKNOWNS}
        if coupled or "shear_displacement" in unknowns:
            pressure = self.pressure("pressure")
            normal = replace(normal, pressure=pressure, covered=(pressure > 0.0).astype(float), whole_elements=self.pressure())
        bound = unknowns.get("friction", derived.problem.friction.coefficient) * normal.pressure
        creepages = self.creepage * derived.saturation_creepage
        guess = Traction.guess(self.fields["share"] * bound, (float(creepages[0]), float(creepages[1])))
        return Contact(normal, guess, **unknowns)


@dataclass(frozen=True)
class Neighbours:
    """One grid of the last two problems, `last` and the one `before` (None: there was none), with the next coarser grid of this
    problem and of both; `t` as `step_length`."""

    last: RefinementLevel
    before: RefinementLevel | None = None
    coarse: RefinementLevel | None = None
    coarse_last: RefinementLevel | None = None
    coarse_before: RefinementLevel | None = None
    t: float = 0.0

    def predicted(self, derived: DerivedQuantities, grid: Grid, *, coupled: bool) -> Prediction | None:
        """The state predicted on `grid`, with thermal deformation (`coupled`) or without; None if nothing predicts it."""
        last = _state(self.last, coupled=coupled)
        if last is None or (self.coarse is not None and _state(self.coarse, coupled=coupled) is None):
            return None
        fields, creepage = _scaled(self.last.discretisation, last.contact)
        before, t = _state(self.before, coupled=coupled), self.t
        if before is not None and t:
            old, old_creepage = _scaled(self.before.discretisation, before.contact)  # type: ignore[union-attr]
        if before is None or not t or old.keys() != fields.keys():
            old, old_creepage, t = fields, creepage, 0.0
        fields = {name: field + t * (field - old[name]) for name, field in fields.items()}
        creepage = creepage + t * (creepage - old_creepage)
        change = self._coarse_change(grid, t, coupled=coupled)
        if change is not None and change[0].keys() == fields.keys():
            fields = {name: field + change[0][name] for name, field in fields.items()}
            creepage = creepage + change[1]
        return Prediction(derived, fields, creepage, last.contact.normal.contact)

    def _coarse_change(self, grid: Grid, t: float, *, coupled: bool) -> tuple[Fields, Array] | None:
        """P(Δ_coarse − t Δ_coarse,old)."""
        levels = (self.coarse, self.coarse_last, self.coarse_before if t else self.coarse_last)
        states = [_state(level, coupled=coupled) for level in levels]
        if None in states:
            return None
        (new, new_c), (old, old_c), (older, older_c) = (
            _scaled(level.discretisation, state.contact)  # type: ignore[union-attr]
            for level, state in zip(levels, states, strict=True))
        if not new.keys() == old.keys() == older.keys():
            return None
        change = {name: new[name] - old[name] - t * (old[name] - older[name]) for name in new}
        assert self.coarse is not None
        prolong = Prolongation(self.coarse.discretisation.grid, grid)
        # Shares of the bound count with the pressure that they belong to: outside the contact there are none.
        pressure = np.maximum(new["pressure"], 0.0)
        weight = prolong(pressure)
        share = prolong(change.pop("share") * pressure) / np.where(weight > 0.0, weight, 1.0)
        finer = {name: prolong(field) for name, field in change.items()} | {"share": share}
        return finer, new_c - old_c - t * (old_c - older_c)


def _state(level: RefinementLevel | None, *, coupled: bool) -> SteadyState | None:
    """The state of a grid, if it may serve for a prediction: found, and on the usual domain."""
    if level is None:
        return None
    state = level.coupled if coupled else level.isothermal
    usual = not coupled or level.own_discretisation is level.discretisation
    return state if state is not None and state.converged and usual else None


def _scaled(here: Discretisation, contact: Contact) -> tuple[Fields, Array]:
    """The fields of a state and its creepages in Hertz's units."""
    derived, normal = here.derived, contact.normal
    bound = (derived.problem.friction.coefficient if contact.friction is None else contact.friction) * normal.pressure
    fields = {
        "pressure": normal.pressure / derived.scales.peak_pressure,
        "start": normal.start / derived.scales.peak_pressure,
        "share": contact.tangential.traction / np.where(bound > 0.0, bound, 1.0),
    } | {name: field / UNKNOWNS[name](derived) for name, field in unknowns_of(contact).items()}
    return fields, np.array(contact.tangential.creepage) / (derived.saturation_creepage or 1.0)
