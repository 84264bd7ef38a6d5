"""Both states on each grid of a sequence, with their reported form; and the result of the whole sequence: error estimates,
self-checks, account of the work."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from thermoroll_cli.heat.frictional_heat import account
from thermoroll_cli.numerics.convolution import counted
from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.problem.problem import BODIES, Problem
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.refinement.checks import failures
from thermoroll_cli.refinement.error_estimates import EXTRAPOLATED, Levels, estimates, missed_accuracy, reported
from thermoroll_cli.refinement.plan import Plan, first_of_both
from thermoroll_cli.refinement.scalars import input_scalars, patches_of, state_of
from thermoroll_cli.refinement.sharp_places import sharp_places
from thermoroll_cli.refinement.warnings import feedback_warning, inner_heat_warning, unresolved_coatings, warnings_after
from thermoroll_cli.steady_state.discretisation import Discretisation
from thermoroll_cli.steady_state.fixed_point import SteadyState
from thermoroll_cli.steady_state.iteration import expansion_in


@dataclass(frozen=True)
class FollowedState:
    """A coupled state with the `discretisation` it lives on."""

    discretisation: Discretisation
    state: SteadyState


@dataclass(frozen=True)
class RefinementLevel:
    """The state without thermal deformation and, where there is any, the one with it; each with its reported form.

    The coupled state lives on `own_discretisation`, which is `discretisation` unless its contact has become much smaller;
    `transforms` are those done for both."""

    discretisation: Discretisation
    isothermal: SteadyState
    coupled: SteadyState | None
    isothermal_state: State
    coupled_state: State
    own_discretisation: Discretisation
    transforms: int

    @property
    def touches_rim(self) -> bool:
        """Whether a contact was found to reach the edge of a domain that a larger one may replace."""
        reached = self.coupled is not None and self.coupled.touches_rim and self.own_discretisation.followed is None
        return self.isothermal.touches_rim or reached

    @property
    def elements_across(self) -> float:
        """Elements over 1.1 diameters of the contact, which is the side of the usual domain; of a grid that is not square those
        of its coarser direction."""
        grid = self.discretisation.grid
        inside = float(self.contact.normal.covered.sum())
        return max(1.0, 2.2 * math.sqrt(inside / math.pi * min(grid.shape) / max(grid.shape)))

    @property
    def contact(self) -> Contact:
        return (self.coupled or self.isothermal).contact


def refinement_level(
    discretisation: Discretisation, isothermal: SteadyState, followed: FollowedState | None, plan: Plan, before: int
) -> RefinementLevel:
    """Report both states of a grid, for which `counted.transforms` has counted from `before`. The isothermal one includes the
    expansion that its heat would cause."""
    heating, contact = discretisation.derived.problem.heating, isothermal.contact
    heat = plan.runs("heat")
    expansion = expansion_in(discretisation, discretisation.heat(contact), contact) if heat and heating.deformation else None
    # Without heat everything stays cold: known without asking a kernel.
    cold = not heat and heating.heat
    if cold:
        expansion = np.zeros(discretisation.grid.shape)
    reported = state_of(discretisation, contact, temperatures=heat or cold, expansion=expansion)
    own_discretisation, coupled, heated = discretisation, None, reported
    if followed is not None:
        own_discretisation, coupled = followed.discretisation, followed.state
        heated = state_of(own_discretisation, coupled.contact, temperatures=True, expansion=coupled.contact.expansion)
    return RefinementLevel(discretisation, isothermal, coupled, reported, heated, own_discretisation,
                           counted.transforms - before)


def result_of(
    problem: Problem, plan: Plan, levels: list[RefinementLevel], seconds: dict[str, float], *, extrapolated: bool = True
) -> Result:
    """The result of the last of `levels`; its integrals `extrapolated` from the last three, if so."""
    last = levels[-1]
    coupled, isothermal = scalars_by_level(levels)
    # At a given approach the load was found.
    problem = replace(problem, normal_force=coupled[-1]["normal_N"])
    derived = replace(last.discretisation.derived, problem=problem)
    final = reported if extrapolated else (lambda levels, derived: dict(levels[-1]))
    sharp = sharp_places(last.own_discretisation, last.contact)
    errors = estimates(coupled, derived, last.elements_across, plan, {*sharp.unbounded, *sharp.unresolved})
    reasons = failures(derived, last.discretisation, last.isothermal, last.own_discretisation, last.coupled)
    warnings = [*plan.warnings, *unresolved_coatings(derived, last.own_discretisation.grid), *sharp.warnings]
    heat = last.own_discretisation.heat(last.contact) if plan.runs("heat") else None
    if heat is not None:
        fields = last.coupled_state.fields
        rises = fields["temperature_rise_lower"], fields["temperature_rise_upper"]
        highest = max(last.coupled_state.scalars[f"temperature_rise_max_{body}_K"] for body in BODIES)
        warnings += warnings_after(derived, heat, last.contact.tangential.slip, rises, highest)
        if problem.relaxes:
            warnings += inner_heat_warning(coupled[-1]["hysteresis_W"], coupled[-1]["Q_F_W"])
        if last.contact.friction is not None:
            warnings += feedback_warning(derived, rises, last.contact.friction)
    wanted = problem.numerics.accuracy
    if wanted is not None:
        missed = missed_accuracy(errors, coupled[-1], wanted)
        if missed:
            worst = max(missed, key=lambda k: errors[k])
            elements = last.discretisation.grid.nx
            reasons.append(f"accuracy {wanted:g} not reached on the finest grid tried, {elements} elements per side: "
                           f"{worst} is good to {errors[worst]:.1e}; ask for less or set numerics.grid")
    history: dict[str, Any] = {}
    if last.coupled is not None:
        history["coupling_residual"] = np.array(last.coupled.history)
    if last.isothermal.acts_back:
        history[f"{_coupling_name(last)}_residual"] = np.array(last.isothermal.history)
    isothermal_state = replace(last.isothermal_state, scalars=final(isothermal, derived))
    if last.own_discretisation is not last.discretisation:
        warnings.append(f"the domain has followed the heated contact: {_place(last)}; the state without thermal "
                        "deformation has a grid of its own")
    same = last.coupled_state is last.isothermal_state
    return Result(
        problem=problem,
        coupled=isothermal_state if same else replace(last.coupled_state, scalars=final(coupled, derived)),
        isothermal=isothermal_state,
        hertz=input_scalars(derived),
        converged=not reasons,
        reason="; ".join(reasons),
        error=errors,
        work=_work(plan, levels, seconds, extrapolated=extrapolated) | ({} if heat is None else account(heat)),
        history=history,
        warnings=tuple(warnings),
        patches=tuple(patches_of(last.discretisation, last.contact)) if not problem.geometry.elliptic else (),
        unbounded=tuple(sorted(sharp.unbounded)),
    )


def _place(level: RefinementLevel) -> str:
    """Where the coupled state lives, in mm."""
    low_x, high_x, low_y, high_y = _limits(level)
    return f"x from {low_x:.4g} to {high_x:.4g} mm, y from {low_y:.4g} to {high_y:.4g} mm"


def _limits(level: RefinementLevel) -> list[float]:
    """Lowest and highest x, lowest and highest y of the domain of the coupled state, in mm."""
    grid = level.own_discretisation.grid
    sides = (grid.centre_x, grid.nx * grid.dx), (grid.centre, grid.ny * grid.dy)
    return [float(1e3 * (centre + half)) for centre, side in sides for half in (-0.5 * side, 0.5 * side)]


def scalars_by_level(levels: list[RefinementLevel]) -> tuple[Levels, Levels]:
    """Scalars of the coupled and of the isothermal state, coarse to fine, on the last grids that refine both sides."""
    levels = refining_both(levels)
    return [r.coupled_state.scalars for r in levels], [r.isothermal_state.scalars for r in levels]


def refining_both(levels: list[RefinementLevel]) -> list[RefinementLevel]:
    """The last of `levels` that show how errors fall: each refines both sides of the one before."""
    return levels[first_of_both([level.discretisation.grid.shape for level in levels]) :]


def _coupling_name(level: RefinementLevel) -> str:
    """Name of the coupling that the state without thermal deformation iterates on."""
    return "warm_friction" if level.discretisation.derived.problem.friction_varies else "elastic_coupling"


def _work(
    plan: Plan, levels: list[RefinementLevel], seconds: dict[str, float], *, extrapolated: bool
) -> dict[str, Any]:
    entries = []
    for r in levels:
        entry: dict[str, Any] = {
            "grid": list(r.discretisation.grid.shape),
            "newton_steps": r.isothermal.newton_steps,
            "applications": r.isothermal.applications,
            "transforms": r.transforms,
        }
        if r.isothermal.acts_back:
            entry |= {
                f"{_coupling_name(r)}_iterations": r.isothermal.iterations,
                "normal_iterations": r.isothermal.normal_iterations,
            }
        if r.coupled is not None:
            entry |= {
                "coupling_iterations": r.coupled.iterations,
                "coupled_normal_iterations": r.coupled.normal_iterations,
                "coupled_newton_steps": r.coupled.newton_steps,
                "coupled_applications": r.coupled.applications,
            }
        entries.append(entry)
    last = levels[-1].discretisation.grid
    return {
        "grid": list(last.shape),
        "extent": plan.extent,
        "extent_coupled": levels[-1].own_discretisation.extent,
        "domain_coupled_mm": _limits(levels[-1]),
        "iterations": {k: entries[-1][k] for k in entries[-1] if k.endswith(("iterations", "steps"))},
        "applications": entries[-1]["applications"] + entries[-1].get("coupled_applications", 0),
        "levels": entries,
        "seconds": {k: round(v, 6) for k, v in seconds.items()},
        "extrapolated": list(EXTRAPOLATED) if extrapolated and len(refining_both(levels)) > 2 else [],
        "skipped": dict(plan.skipped),
    }
