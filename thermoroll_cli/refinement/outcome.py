"""The result of a solve from its levels: error estimates, self-checks, account of the work."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from thermoroll_cli.heat.frictional_heat import account
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.checks import failures
from thermoroll_cli.refinement.error_estimates import EXTRAPOLATED, Levels, estimates, missed_accuracy, reported, unbounded
from thermoroll_cli.refinement.plan import Plan
from thermoroll_cli.refinement.refinement_level import RefinementLevel
from thermoroll_cli.refinement.scalars import input_scalars, patches_of
from thermoroll_cli.refinement.warnings import unresolved_layers, warnings_after


def result_of(
    problem: Problem, plan: Plan, levels: list[RefinementLevel], seconds: dict[str, float], of_heat: Sequence[str], *,
    extrapolated: bool = True,
) -> Result:
    """The result of the last of `levels`; its integrals `extrapolated` from the last three, if so. `of_heat` are the
    reasons for which its heat makes it no result (`heat_failures`)."""
    last = levels[-1]
    derived = last.discretisation.derived
    coupled, isothermal = scalars_by_level(levels)
    final = reported if extrapolated else (lambda levels, derived: dict(levels[-1]))
    errors = estimates(coupled, derived, last.elements_across, plan)
    reasons = failures(derived, last.discretisation, last.isothermal, last.home, last.coupled, of_heat)
    warnings = [*plan.warnings, *unresolved_layers(derived, last.home.grid)]
    heat = last.home.heat(last.contact) if plan.runs("heat") else None
    if heat is not None:
        fields = last.coupled_state.fields
        rises = fields["temperature_rise_lower"], fields["temperature_rise_upper"]
        highest = max(last.coupled_state.scalars[f"temperature_rise_max_{body}_K"] for body in ("lower", "upper"))
        warnings += warnings_after(derived, heat, last.contact.tangential.slip, rises, highest)
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
    if last.home is not last.discretisation:
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
        patches=tuple(patches_of(last.discretisation, last.contact)) if problem.geometry.has_profile else (),
        unbounded=tuple(sorted(unbounded(derived))),
    )


def _place(level: RefinementLevel) -> str:
    """Where the coupled state lives, in mm."""
    low_x, high_x, low_y, high_y = _limits(level)
    return f"x from {low_x:.4g} to {high_x:.4g} mm, y from {low_y:.4g} to {high_y:.4g} mm"


def _limits(level: RefinementLevel) -> list[float]:
    """Lowest and highest x, lowest and highest y of the domain of the coupled state, in mm."""
    grid = level.home.grid
    sides = (grid.centre_x, grid.nx * grid.dx), (grid.centre, grid.ny * grid.dy)
    return [float(1e3 * (centre + half)) for centre, side in sides for half in (-0.5 * side, 0.5 * side)]


def scalars_by_level(levels: list[RefinementLevel]) -> tuple[Levels, Levels]:
    """Scalars of the coupled and of the isothermal state on each grid, coarse to fine."""
    return [r.coupled_state.scalars for r in levels], [r.isothermal_state.scalars for r in levels]


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
        "extent_coupled": levels[-1].home.extent,
        "domain_coupled_mm": _limits(levels[-1]),
        "iterations": {k: entries[-1][k] for k in entries[-1] if k.endswith(("iterations", "steps"))},
        "applications": entries[-1]["applications"] + entries[-1].get("coupled_applications", 0),
        "levels": entries,
        "seconds": {k: round(v, 6) for k, v in seconds.items()},
        "extrapolated": list(EXTRAPOLATED) if extrapolated and len(entries) > 2 else [],
        "skipped": dict(plan.skipped),
    }
