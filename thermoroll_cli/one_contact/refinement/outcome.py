"""The result of the levels of both states: error estimates, self-checks, account of the work."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from thermoroll_cli.one_contact.refinement.checks import failures
from thermoroll_cli.one_contact.refinement.error_estimates import (
    EXTRAPOLATED,
    Levels,
    Resolution,
    estimates,
    missed_accuracy,
    reported,
)
from thermoroll_cli.one_contact.refinement.level import Level
from thermoroll_cli.one_contact.refinement.plan import Plan, first_of_both
from thermoroll_cli.one_contact.refinement.sharp_places import sharp_places
from thermoroll_cli.one_contact.refinement.warnings import surface_of_substrates, unresolved_coatings, warnings_after
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.scalars import patches_of, problem_scalars
from thermoroll_cli.physics.heat.frictional_heat import account
from thermoroll_cli.problem.names import ALL_SCALARS, per_length
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.problem.rounding import by_rounding
from thermoroll_cli.problem.scalar_errors import error_scale, not_reached


def result_of(plan: Plan, cold: list[Level], hot: list[Level], *, extrapolated: bool = True) -> Result:
    """The result of the last of the levels without (`cold`) and with thermal deformation (`hot`, the same where there is none);
    its integrals `extrapolated` from the last three, if so."""
    last, isothermal, by_level = hot[-1], cold[-1], scalars_by_level(hot)
    # At a given approach the load was found.
    problem = replace(plan.derived.problem, normal_force=by_level[-1]["normal_N"])
    derived = replace(plan.derived, problem=problem)
    final = reported if extrapolated else (lambda levels, derived: dict(levels[-1]))
    unbounded, unresolved, sharp = sharp_places(last.here, last.contact)
    resolution = Resolution.of(last, by_level, derived, plan)
    errors = estimates(resolution, {*unbounded, *unresolved})
    reasons = failures(isothermal, None if hot is cold else last)
    warnings = [*plan.warnings, *unresolved_coatings(derived, last.here.grid), *surface_of_substrates(derived), *sharp]
    heat = last.here.heat(last.contact) if plan.runs("heat") else None
    warnings += warnings_after(derived, last, heat, resolution.edge)
    if missed := missed_accuracy(errors, by_level[-1], problem):
        reasons.append(not_reached(
            problem.numerics.accuracy, missed, f"on the finest grid tried, {last.here.grid.nx} elements per side",
            "ask for less, name what has to be accurate in numerics.accuracy_of, or set numerics.grid"))
    # No grid betters these errors: they do not count for the accuracy.
    errors = {name: error + rounded(name, derived, by_level[-1]) for name, error in errors.items()}
    residuals: dict[str, Any] = {}
    if hot is not cold:
        residuals["coupling_residual"] = np.array(last.state.history)
    if isothermal.state.acts_back:
        residuals[f"{_coupling_name(plan)}_residual"] = np.array(isothermal.state.history)
    if last.here.followed is not None:
        limits = _limits(last)
        place = ", ".join(f"{axis} from {low:.4g} to {high:.4g} mm"
                          for axis, low, high in zip("xy", limits[::2], limits[1::2], strict=False))
        warnings.append(f"the domain has followed the heated contact: {place}; the state without thermal deformation has a "
                        "grid of its own")
    coupled, given = replace(last.reported, scalars=final(by_level, derived)), problem_scalars(derived)
    numbers = {**coupled.scalars, **given}
    return Result(
        problem=problem,
        coupled=coupled,
        isothermal=coupled if hot is cold else replace(isothermal.reported, scalars=final(scalars_by_level(cold), derived)),
        of_problem=given,
        converged=not reasons,
        reason="; ".join(reasons),
        uncertainty={name: error * error_scale(name, numbers) for name, error in errors.items()},
        work=_work(plan, cold, hot, extrapolated=extrapolated) | ({} if heat is None else account(heat)),
        residuals=residuals,
        warnings=tuple(warnings),
        patches=tuple(patches_of(last.here, last.contact)),
        unbounded=tuple(sorted(unbounded)),
    )


def rounded(name: str, derived: DerivedQuantities, scalars: Mapping[str, float]) -> float:
    """By how much the rounding of profiles may change the scalar of this name, over its `error_scale`: the largest pressure and
    traction, and stresses below the surface at the depths that `scalars` have; 0 of all others."""
    scalar, scales = ALL_SCALARS.get(name), derived.scales
    below = scalar is not None and scalar.scale == "stress below"
    if scalar is None or not (below or scalar.kind in ("peak pressure", "peak")):
        return 0.0
    depth = 1e-3 * scalars.get(name.replace("_max_", "_depth_").replace("_MPa", "_mm"), 0.0) if below else 0.0
    roundings = derived.problem.geometry.roundings(scales.centre, scales.semi_axis_y)
    return by_rounding(roundings, derived.problem.contact_modulus, scales.semi_axis_y, depth) / scales.peak_pressure


def state_of_line(state: State) -> State:
    """The `state` of a line contact as it is reported. Its displacements, which are known up to a constant, are 0 where they
    are least."""
    fields = {name: values[:, 0] for name, values in state.fields.items()}
    if (displacement := fields.get("displacement_elastic")) is not None:  # states over time may be kept without fields
        fields["displacement_elastic"] = displacement - displacement.min()
    return State(fields, per_length(state.scalars), state.x, np.zeros(0))


def of_line(result: Result) -> Result:
    """The `result` of a line contact as it is reported: its scalars per mm of length, its fields over x alone."""
    coupled = state_of_line(result.coupled)
    isothermal = coupled if result.isothermal is result.coupled else state_of_line(result.isothermal)
    below = result.subsurface
    if below is not None:
        # The only plane has all there is.
        bodies = {body: replace(stresses, fields={}, strength={
            name: values.reshape(len(stresses.depths)) for name, values in stresses.strength.items()})
            for body, stresses in below.bodies.items()}
        below = replace(below, bodies=bodies, scalars=per_length(below.scalars))
    return replace(result, coupled=coupled, isothermal=isothermal, of_problem=per_length(result.of_problem), subsurface=below,
                   uncertainty=per_length(result.uncertainty))


def _limits(level: Level) -> list[float]:
    """Lowest and highest x, lowest and highest y of the domain of a level, in mm; of a line contact those of x."""
    grid = level.here.grid
    sides = ((grid.centre_x, grid.nx * grid.dx), (grid.centre, grid.ny * grid.dy))[: len(grid.sides)]
    return [float(1e3 * (centre + half)) for centre, side in sides for half in (-0.5 * side, 0.5 * side)]


def scalars_by_level(levels: list[Level]) -> Levels:
    """Scalars of a state, coarse to fine, on the last grids that refine both sides."""
    return [level.reported.scalars for level in refining_both(levels)]


def refining_both(levels: list[Level]) -> list[Level]:
    """The last of `levels` that show how errors fall: each refines both sides of the one before."""
    return levels[first_of_both([level.here.grid.shape for level in levels]) :]


def _coupling_name(plan: Plan) -> str:
    """Name of the coupling that the state without thermal deformation iterates on."""
    return "warm_friction" if plan.derived.problem.friction_varies else "elastic_coupling"


def _work(plan: Plan, cold: list[Level], hot: list[Level], *, extrapolated: bool) -> dict[str, Any]:
    entries, both = [], hot is not cold
    for isothermal, coupled in zip(cold, hot, strict=True):
        state = isothermal.state
        entry: dict[str, Any] = {
            "grid": list(isothermal.here.grid.sides),
            "newton_steps": state.newton_steps,
            "applications": state.applications,
            "transforms": isothermal.transforms + (coupled.transforms if both else 0),
        }
        if state.acts_back:
            entry |= {f"{_coupling_name(plan)}_iterations": state.iterations, "normal_iterations": state.normal_iterations}
        if both:
            entry |= {
                "coupling_iterations": coupled.state.iterations,
                "coupled_normal_iterations": coupled.state.normal_iterations,
                "coupled_newton_steps": coupled.state.newton_steps,
                "coupled_applications": coupled.state.applications,
            }
        entries.append(entry)
    seconds = {"isothermal": sum(level.seconds for level in cold)}
    if both:
        seconds["coupling"] = sum(level.seconds for level in hot)
    return {
        "grid": entries[-1]["grid"],
        "extent": plan.extent,
        "extent_coupled": hot[-1].here.extent,
        "domain_coupled_mm": _limits(hot[-1]),
        "iterations": {k: entries[-1][k] for k in entries[-1] if k.endswith(("iterations", "steps"))},
        "applications": entries[-1]["applications"] + entries[-1].get("coupled_applications", 0),
        "levels": entries,
        "seconds": {k: round(v, 6) for k, v in seconds.items()},
        "extrapolated": list(EXTRAPOLATED) if extrapolated and len(refining_both(hot)) > 2 else [],
        "skipped": dict(plan.skipped),
        **({"accuracy_of": list(asked)} if (asked := plan.derived.problem.numerics.accuracy_of) else {}),
    }
