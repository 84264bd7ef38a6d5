"""Whether a problem has a steady state that is computed: every reason against it that is known before solving."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.heated_bodies import peclet_numbers
from thermoroll_cli.physics.contact.contact_scales import COARSE_GRID, DOMAIN_OVER_CONTACT, contact_scales
from thermoroll_cli.problem.geometry import Geometry, Unsolvable
from thermoroll_cli.problem.problem import BODIES, BodyName, Problem, ReturningTrack

FASTEST = 1e8
"""Largest Péclet number with heat: integrals over time take √P nodes, seconds of CPU here on a coarse grid and minutes at 1e12.
Steel on a contact of 10 mm reaches it at about 1e5 m/s, above its speeds of sound."""

THINNEST = 1e-6
"""Thickness of a coating in smaller semi-axes of the contact: rounding in the stresses of a layer grows like 1e-16 over the
square of its thickness in elements, to 2 % at a tenth of this."""

THINNEST_RELAXING = 0.04
"""Thickness of layers in a coating that relaxes over the larger semi-axis, about an element of a grid of 64. With layers of a
tenth of an element resistances are up to 20 % wrong."""


def reasons_against(derived: DerivedQuantities) -> Iterator[Unsolvable]:
    """Every reason why the problem is not solved, each with the key of the case file that it concerns. A yielding interlayer
    may turn out to be too weak later, when the pressure is known (`traction.check_yield`)."""
    problem = derived.problem
    heating = problem.heating
    if problem.approach is not None and heating.heat and heating.deformation and heating.peclet == "stationary":
        yield Unsolvable("stationary heat expands half-spaces by any constant, so an approach means no load",
                         "load.approach_um",
                         'load.normal_N, peclet = "rolling" or "sliding", or deformation = false', "thermal.peclet")
    if problem.motion.speed < 0.0:
        yield Unsolvable(f"the rolling speed of {problem.motion.speed:g} m/s is negative", "rolling.speed_m_s",
                         "a speed above 0: backwards, creepages and forces change their signs")
    if heating.heat and heating.peclet != "stationary":
        yield from _fast_heat(derived)
    if problem.line and heating.heat and abs(problem.motion.creepage_x or 0.0) == 2.0:
        yield Unsolvable("one body stands still at this creepage: heat without ends has no steady temperature on it",
                         "creepage.longitudinal", "a creepage at which both bodies move, or thermal.heat = false")
    yield from _force(derived)
    yield from _conformal(derived)
    yield from _interlayer(problem)
    yield from _coatings(problem)
    yield from _relaxing_layers(derived)
    yield from _thin_coatings(derived)
    for body in BODIES if problem.heating.recirculates else ():
        track = getattr(problem.heating, f"{body}_track")
        if track is not None:
            yield from _track(derived, body, track)


def _fast_heat(derived: DerivedQuantities) -> Iterator[Unsolvable]:
    """The nodes of the thermal integrals are as close as the material drifts while heat spreads: their number grows with √P."""
    peclet = float(np.fmax(*peclet_numbers(derived)))  # one without constants of heat is nan
    if peclet > FASTEST:
        yield Unsolvable(f"with heat at a Péclet number of {peclet:.1e}: temperatures are computed up to {FASTEST:.0e}",
                         "rolling.speed_m_s",
                         f"at most {derived.problem.motion.speed * FASTEST / peclet:.3g} here, or heat = false in [thermal]")


@lru_cache(maxsize=2)
def passes(derived: DerivedQuantities) -> bool:
    """Whether there is no reason against the problem; kept for whoever asks next, as `derived_of` keeps what it is asked of."""
    return next(reasons_against(derived), None) is None


def check(derived: DerivedQuantities) -> None:
    """Raises Unsolvable, for the first of the reasons."""
    if not passes(derived):
        raise next(reasons_against(derived))


def _force(derived: DerivedQuantities) -> Iterator[Unsolvable]:
    """Friction must carry the force while it is cold, and a law that falls and rises again has several answers. In a conformal
    contact the pressure adds up to more than the load, by 1/cos of its steepest place at most."""
    problem = derived.problem
    force, load, law = problem.prescribed_force, problem.normal_force, problem.friction.law
    if not force:
        return
    coefficient = problem.friction.coefficient * problem.friction.largest_share * (1.0 if law is None else law.highest)
    unit = "N_mm" if problem.line else "N"
    key = f"force.{'longitudinal' if problem.motion.force_x is not None else 'lateral'}_{unit}"
    inclined = 1.0 if isinstance(problem.geometry, Geometry) else math.cos(max(map(abs, derived.contact_angles)))
    if force * inclined >= coefficient * load:
        rises = "; friction that rises with temperature begins cold" if problem.friction.slope < 0.0 else ""
        yield Unsolvable(f"the tangential force of {problem.force_text(force)} reaches or exceeds what friction can carry, "
                         f"{coefficient:g} · {problem.force_text(load)} = {problem.force_text(coefficient * load)}{rises}", key,
                         f"a force below the coefficient of friction · load.normal_{unit}, or a creepage")
    if law is not None and law.rises_again:
        yield Unsolvable("friction that falls with slip and then rises again carries one force at several creepages", key,
                         "a creepage", "friction.law")


def _conformal(derived: DerivedQuantities) -> Iterator[Unsolvable]:
    """The lateral creepage of an inclined surface has another direction at every place; the model holds up to some slope."""
    problem, geometry = derived.problem, derived.problem.geometry
    limits = np.array(geometry.limits)  # raises Unsolvable if profiles never face each other
    if isinstance(geometry, Geometry):
        return
    if problem.motion.force_y is not None:
        yield Unsolvable("a lateral force is not computed for a conformal contact", "force.lateral_N", "creepage.lateral",
                         "geometry.conformal")
    if any(geometry.cut) and any(end and cut for end, cut in zip(derived.scales.ends, geometry.cut, strict=True)):
        low, high = geometry.lateral_place(limits) * 1e3
        yield Unsolvable(f"the contact reaches y = {low:.4g} or {high:.4g} mm, where the model of a half-space ends: the "
                         "surfaces are too steep, a body too near its axis, or the approach is a quarter of the radius",
                         "load.normal_N", "a load with a narrower contact", "geometry.conformal")


def _interlayer(problem: Problem) -> Iterator[Unsolvable]:
    law, interlayer = problem.friction.law, problem.interlayer
    if law is not None and interlayer.yield_stress is not None:
        yield Unsolvable("where the interlayer yields the surfaces do not slip: friction that depends on slip is not computed "
                         "with it", "layer.yield_MPa", "no law of friction, or no yield stress", "friction.law")
    if law is not None and law.fall() and interlayer.compliance and not law.memory:
        yield Unsolvable("with friction that falls with slip the problem has no continuous solution unless friction has memory",
                         "layer.compliance_um_GPa", "friction.memory_um > 0", "friction.law")


def _coatings(problem: Problem) -> Iterator[Unsolvable]:
    """Stages that do not know coatings."""
    coated = [body for body in BODIES if getattr(problem, body).layers]
    if not coated:
        return
    other, heating, request, wear = f"material.{coated[0]}.layers", problem.heating, problem.subsurface, problem.wear
    if heating.heat and heating.peclet == "sliding":
        yield Unsolvable("sources with the slip velocity are not computed for coated bodies", "thermal.peclet",
                         '"rolling" or "stationary", or no coatings', other)
    for body in BODIES:
        if heating.heat and getattr(heating, f"{body}_track") is not None:
            yield Unsolvable("recirculating heat is not computed for coated bodies", f"thermal.{body}.recirculate",
                             f"false, with thermal.bulk_temperature_{body}_K for a warm body, or no coatings", other)
    if request is not None and heating.heat and request.thermal and any(body in request.bodies for body in coated):
        yield Unsolvable("thermal stresses are not computed for coated bodies", "subsurface.thermal",
                         "false, for the elastic stresses alone, or bodies without coatings in subsurface.bodies", other)
    if wear is not None and (math.isfinite(wear.distance) or math.isfinite(wear.depth)):
        yield Unsolvable("the evolution of wear does not thin coatings",
                         "wear.distance_km" if math.isfinite(wear.distance) else "wear.depth_um",
                         "[wear] without distance_km and depth_um: the wear of one passage, or no coatings", other)


def _relaxing_layers(derived: DerivedQuantities) -> Iterator[Unsolvable]:
    """Stages that do not know layers that relax, and layers too thin for the grids."""
    heating, request = derived.problem.heating, derived.problem.subsurface
    for body in BODIES:
        layers = getattr(derived.problem, body).layers
        if not any(layer.relaxation for layer in layers):
            continue
        other = f"material.{body}.layers"
        if heating.heat and heating.deformation:
            yield Unsolvable("thermal expansion is not computed for layers that relax", "thermal.deformation", "false", other)
        if request is not None and body in request.bodies:
            yield Unsolvable("stresses are not computed for layers that relax", "subsurface.bodies",
                             "bodies without such layers", other)
        # Before it relaxes, the contact is smaller, and quickly found.
        problem, thinnest = derived.problem, min(layer.thickness for layer in layers)
        scales = contact_scales(problem.geometry, derived.bodies.at_once, problem.normal_force)
        width = max(scales.semi_axis_x, scales.semi_axis_y)
        if thinnest < THINNEST_RELAXING * width:
            yield Unsolvable(f"a layer of {thinnest * 1e6:.3g} µm in a coating that relaxes is too thin for a contact of "
                             f"{2e3 * width:.3g} mm", other, f"a thickness_um of {THINNEST_RELAXING * width * 1e6:.3g} or more")


def _thin_coatings(derived: DerivedQuantities) -> Iterator[Unsolvable]:
    """Stresses in coatings so thin that rounding rules them."""
    request = derived.problem.subsurface
    if request is None or not any(getattr(derived.problem, body).layers for body in request.bodies):
        return
    width = min(derived.scales.semi_axis_x, derived.scales.semi_axis_y)
    for body in request.bodies:
        for layer in getattr(derived.problem, body).layers:
            if layer.thickness < THINNEST * width:
                yield Unsolvable(
                    f"stresses are not computed in a coating of {layer.thickness * 1e6:.3g} µm, a millionth of the contact's "
                    "smaller semi-axis or less", f"material.{body}.layers",
                    f"a thickness_um of {THINNEST * width * 1e6:.2g} or more, or no coating: the same contact", "subsurface")


def _track(derived: DerivedQuantities, body: BodyName, track: ReturningTrack) -> Iterator[Unsolvable]:
    """The body must turn, the contact must fit on it, and its cooled surface must be known."""
    problem, table, radius_key = derived.problem, f"thermal.{body}", f"geometry.{body}_radius_x_mm"
    radius, creepage = getattr(problem.geometry, f"{body}_radius_x"), problem.motion.creepage_x or 0.0
    if math.isinf(radius):
        yield Unsolvable("the heat of a body straight along rolling never recirculates", f"{table}.recirculate",
                         f"false, or a finite {radius_key}", radius_key)
        return
    if radius < 0.0 and track.convection is not None:
        yield Unsolvable("a concave body is a ring, of which only the bore is known: not where it is cooled",
                         f"{table}.convection_W_m2K", "thermal_resistance_K_W instead", radius_key)
    if problem.heating.peclet == "rolling" and 1.0 + (0.5 if body == "lower" else -0.5) * creepage <= 0.0:
        yield Unsolvable(f"the {body} body stands still or turns backwards at this creepage", "creepage.longitudinal",
                         "between -2 and 2 where heat recirculates", f"{table}.recirculate")
    try:
        contact = 2e3 * derived.scales.semi_axis_y
    except Unsolvable as cause:
        yield cause
        return
    # A contact is known to an element: that of a profile comes from a coarse solution.
    elements = min((problem.numerics.grid or COARSE_GRID)[1], COARSE_GRID[1])
    if 1e3 * track.width < contact * (1.0 - DOMAIN_OVER_CONTACT / elements):
        yield Unsolvable(f"a width of {1e3 * track.width:g} mm is below that of the contact, {contact:.4g} mm",
                         f"{table}.width_mm", f"at least {contact:.4g} mm")
