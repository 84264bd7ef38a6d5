"""Each run checks itself: what fails makes the result not converged, with a reason a person can act on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from thermoroll_cli.one_contact.refinement.level import Level
from thermoroll_cli.one_contact.steady_state.heated_bodies import LEAST_SPEED, heated_bodies
from thermoroll_cli.one_contact.steady_state.iteration import friction_of, reserve
from thermoroll_cli.one_contact.steady_state.scalars import power_balance_error
from thermoroll_cli.problem.problem import BODIES

BALANCE_ERROR = 1e-5
"""Largest relative error of the load, of prescribed forces (over μW), and of the heat beside the work of the creep forces: as
much as the residual of the tractions may leave."""
LOCAL_ERROR = 1e-4
"""Largest relative excess of the traction over its bound (2-norm), and largest difference of the surface temperatures over
their peak with a matched partition: ten times the residual of the tractions."""
DIRECTION_ERROR = 1e-3
"""Largest share of the power that is lost because slip does not point along the traction: small slip has few digits."""
UNRESOLVED_HEAT = 0.5
"""Share of the heat from slip zones narrower than an element, times its expansion over the approach if that is below one. Above
it the state is an artefact of the grid; below it unresolved slip costs accuracy alone, which the estimates include."""
FEWEST_ELEMENTS = 12
"""Elements of a heated contact below which its grid no longer shows it. Without: one of 100 hot contacts on coarse grids passes
with 2 elements of 83."""
SLOWEST, SPEEDS = 50.0, 14
"""Range and number of the speeds in the sweep that a message proposes: each state starts from those below it."""


def failures(cold: Level, hot: Level | None) -> list[str]:
    """Reasons why the states without thermal deformation and with it (None: there is none) cannot be trusted; empty when they
    can."""
    isothermal, derived = cold.state, cold.here.derived
    reasons = [f"isothermal state: {reason}" for reason in _state_failures(cold)]
    if not derived.scales.converged:
        what = "stiffness and thickness of the layers" if derived.problem.geometry.elliptic else "profiles"
        reasons.append(f"the coarse pressure from which the domain follows has not converged: check the {what}")
    if isothermal.acts_back and not isothermal.converged and not isothermal.touches_rim and not _too_little(cold):
        coupling, advice = "coupling of pressure and shear", "try a finer or coarser numerics.grid"
        if derived.problem.friction_varies:
            coupling, friction = "coupling of friction and temperature", derived.problem.friction
            span = (friction.limits[1] - friction.limits[0]) / (friction.coefficient * abs(friction.slope))
            rise = max(cold.reported.scalars[f"temperature_rise_max_{body}_K"] for body in BODIES)
            # A contact that warms by more than friction needs to go all of its way has friction that jumps between neighbouring
            # elements, and what one grid finds another does not.
            if rise > span:
                advice = (f"within {span:.2g} K friction reaches its limit, and the contact warms by {rise:.2g} K, so that it "
                          "jumps between elements; set a flatter friction.temperature_slope_1_K, or lower the speed or the "
                          "creepage")
        reasons.append(f"{coupling} stopped after {isothermal.iterations} iterations at a residual of "
                       f"{isothermal.residual:.1e} of the approach: {advice}")
    if cold.touches_rim or (hot is not None and hot.touches_rim):
        reasons.append("the contact still touches the rim of the domain: set a larger numerics.extent")
    if hot is None:
        return reasons
    of_heat = [] if hot.touches_rim else list(_heat_failures(cold, hot))
    if of_heat:
        top = derived.problem.motion.speed
        reasons += [*of_heat, "for the largest speed that has a steady state: thermoroll sweep CASE --over "
                              f"rolling.speed_m_s={top / SLOWEST:.4g}:{top:.4g}:{SPEEDS}:log"]
    # Other faults of an iteration that has not converged only follow from that.
    if hot.state.converged or not of_heat:
        reasons += [f"coupled state: {reason}" for reason in _state_failures(hot)]
    return reasons


def _heat_failures(cold: Level, hot: Level) -> Iterator[str]:
    """In which ways the coupled iteration failed for its heat, and not for its domain."""
    coupled = hot.state
    if coupled.touches_rim:
        tried = hot.here.options.most_moves
        yield (f"the heated contact has left each of {tried} domains that followed it: no steady state was found, which does "
               "not show that there is none; lower the speed or the creepage")
        return
    if not coupled.converged and coupled.heat_reached < 1.0:
        share = 100.0 * coupled.heat_reached
        yield (f"at the slip that was reached no pressure was found in balance with more than {share:.3g} % of its own "
               "heat: raising it further failed, which does not show that there is no steady state; lower "
               "the speed or the creepage, or try a finer numerics.grid")
        return
    if not coupled.converged:
        yield (f"thermal coupling with all of the heat stopped after {coupled.iterations} iterations at a residual of "
               f"{coupled.residual:.1e} of the approach: no steady state was found, which does not show that there is none; "
               "try a finer or coarser numerics.grid, or lower the speed or the creepage")
        return
    unresolved = power_balance_error(hot.contact.tangential, hot.here.grid.element_area)
    # How much the thermal expansion varies over the contact, over the approach.
    expansion, inside = hot.contact.expansion, hot.contact.normal.contact
    bulge = 0.0 if expansion is None else float(np.ptp(expansion[inside])) / hot.here.derived.scales.approach
    if unresolved * min(bulge, 1.0) > UNRESOLVED_HEAT:
        yield (f"{100.0 * unresolved:.0f} % of the heat that shapes the contact is made in slip zones narrower "
               "than an element: set a finer numerics.grid, or lower the speed or the creepage")
    # Areas, because few elements are counted too coarsely; a coarse grid may have had but a handful from the beginning.
    left, before = (float(level.contact.normal.covered.sum()) for level in (hot, cold))
    if left < min(FEWEST_ELEMENTS, 0.5 * before):
        yield (f"the heated contact has shrunk to {int(np.count_nonzero(hot.contact.normal.contact))} elements, too few to "
               "trust: set a finer numerics.grid")


MOST_RELAXED = 100.0
"""Relaxed over instantaneous compliance up to which pressures have been found at any speed."""


def _too_little(level: Level) -> str:
    """The reason where friction carries less than the prescribed force, from which follows what else fails. Empty elsewhere."""
    discretisation, contact = level.here, level.contact
    problem = discretisation.derived.problem
    force, wanted = problem.prescribed_force, problem.force_text(problem.prescribed_force)
    limit = float(contact.traction_bound(problem.friction.coefficient).sum()) * discretisation.grid.element_area
    if problem.interlayer.most is not None and force > limit:
        return f"the interlayer yields: it carries {problem.force_text(limit)} at most, less than the prescribed {wanted}"
    if problem.friction_varies:
        contact = replace(contact, friction=friction_of(discretisation, discretisation.heat(contact)))
    if not (missing := reserve(discretisation, contact)) < 0.0:
        return ""
    carried = problem.force_text(force + missing)
    if problem.friction_varies:
        return (f"friction falls with the temperature: at those of the last iteration it carries {carried}, "
                f"less than the prescribed {wanted}. That is not the largest force that has a steady state: sweep the "
                "creepage to find it")
    return f"friction across the contact carries {carried} at most, less than the prescribed {wanted}"


def _state_failures(level: Level) -> list[str]:
    discretisation, contact = level.here, level.contact
    derived, grid = discretisation.derived, discretisation.grid
    problem, normal, tangential = derived.problem, contact.normal, contact.tangential
    reasons: list[str] = []
    everything = (normal.pressure, normal.displacement, tangential.traction, tangential.slip, tangential.heat)
    if not all(np.isfinite(f).all() for f in everything):
        return ["a field is not finite"]
    if too_little := _too_little(level):
        return [too_little]
    load = discretisation.pressure.load(normal) / problem.normal_force
    if problem.approach is None and abs(load - 1.0) > BALANCE_ERROR:
        reasons.append(f"pressure carries {load:.6f} of the load")
    if normal.pressure.min() < 0.0:
        reasons.append("negative pressure")
    if not normal.converged:
        advice = ""
        if (ratio := derived.bodies.contact_modulus / derived.bodies.softest) > MOST_RELAXED:
            advice = (f", another rolling.speed_m_s, or a relaxation that leaves more of the modulus: these surfaces relax to "
                      f"{ratio:.3g} times their instantaneous compliance, and above {MOST_RELAXED:g} pressures are not found "
                      "at all speeds")
        reasons.append(f"the pressure has not converged after {normal.iterations} iterations: try a finer or coarser "
                       f"numerics.grid{advice}")
    if not tangential.converged:
        reasons.append(f"tractions stopped at a residual of {tangential.residual:.1e}: try a finer or coarser numerics.grid")
    bound = contact.traction_bound(problem.friction.coefficient)
    shear = np.hypot(*tangential.traction)
    if np.linalg.norm(np.maximum(shear - bound, 0.0)) > LOCAL_ERROR * max(float(np.linalg.norm(bound)), 1e-300):
        reasons.append("traction exceeds the Coulomb bound")
    if problem.friction.coefficient > 0.0:
        speed = np.hypot(*tangential.slip)
        along = (tangential.traction * tangential.slip).sum(axis=0)
        # If almost everything sticks, the little slip is of the size of the tolerance: the work sets the scale.
        total = max(float((shear * speed).sum()), abs(tangential.work) / grid.element_area)
        if float((shear * speed - along).sum()) > DIRECTION_ERROR * total:
            reasons.append("slip does not point along the traction")
    heat = float(tangential.heat.sum()) * grid.element_area
    if abs(heat - tangential.work) > BALANCE_ERROR * max(abs(tangential.work), abs(heat)):
        share = heat / tangential.work if tangential.work else np.inf
        reasons.append(f"dissipated heat is {share:.6f} of the work of the creep forces")
    if problem.heating.heat and problem.heating.partition == "matched":
        mismatch = discretisation.heat(contact).mismatch
        if mismatch > LOCAL_ERROR:
            reasons.append(f"temperatures of both surfaces differ by {mismatch:.1e} of their peak")
    bodies = heated_bodies(problem, *tangential.creepage) if problem.heating.recirculates else ()
    for body, heated in zip(BODIES, bodies, strict=False):
        if getattr(problem.heating, f"{body}_track") is not None and heated.speed_x < LEAST_SPEED * problem.motion.speed:
            reasons.append(f"the {body} body hardly turns, or turns backwards, at a longitudinal creepage of "
                           f"{tangential.creepage[0]:.3g}: no heat recirculates; lower the force or the creepage")
    motion = problem.motion
    force = tangential.traction.sum(axis=(1, 2)) * grid.element_area
    for got, wanted, axis in zip(force, (motion.force_x, motion.force_y), "xy", strict=True):
        if wanted is not None and abs(got - wanted) > BALANCE_ERROR * problem.traction_limit:
            reasons.append(f"force along {axis} is {problem.force_text(got)} instead of {problem.force_text(wanted)}")
    return reasons
