"""From raw fields to a reported state: temperatures, masks, the article's scalars, wear of one passage, tracks and patches."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from thermoroll_cli.exact.kalker import combined_constants, creepage_coefficients
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation
from thermoroll_cli.one_contact.steady_state.heated_bodies import peclet_numbers
from thermoroll_cli.one_contact.steady_state.iteration import expansion_in
from thermoroll_cli.physics.halfspace.bodies import bodies_of
from thermoroll_cli.physics.heat.frictional_heat import Heat, divide
from thermoroll_cli.physics.numerics.grid import Grid, between_sides, patches_across, peak_inside, peak_value, value_at
from thermoroll_cli.physics.rolling.element_borders import stick_share
from thermoroll_cli.physics.rolling.rolling_gradient import RollingGradient
from thermoroll_cli.problem.contact import Contact, Traction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.names import PROBLEM_SCALARS, SCALARS
from thermoroll_cli.problem.problem import BODIES, Heating, Problem, WornBody
from thermoroll_cli.problem.result import State
from thermoroll_cli.tools.arrays import AnyArray, Array, Mask

OUT, STICK, SLIP = 0, 1, 2
ROUNDING = 1e-12
"""Share below which a value is rounding noise: a rise ahead of a contact that only cools (of the largest change of
temperature), the crown of a track that is expanded evenly (of its expansion)."""


def problem_scalars(derived: DerivedQuantities) -> dict[str, float]:
    """The scalars of `PROBLEM_SCALARS`: known before anything is solved; nan where there is no ellipse."""
    problem = derived.problem
    scalars = dict.fromkeys(PROBLEM_SCALARS, math.nan) | {
        "friction_limit_N": problem.traction_limit,
        **dict(zip(("peclet_lower", "peclet_upper"), peclet_numbers(derived), strict=True)),
    }
    if derived.hertz is None:
        return scalars
    hertz, lower, upper = derived.hertz, problem.lower, problem.upper
    shear_modulus, poisson_ratio = combined_constants(
        lower.shear_modulus, lower.poisson_ratio, upper.shear_modulus, upper.poisson_ratio)
    scalars |= {
        "hertz_a_mm": hertz.semi_axis_x * 1e3,
        "hertz_b_mm": hertz.semi_axis_y * 1e3,
        "hertz_p0_MPa": hertz.peak_pressure * 1e-6,
        "shear_modulus_GPa": shear_modulus * 1e-9,
    }
    if problem.line:
        return scalars
    kalker = creepage_coefficients(hertz.semi_axis_x / hertz.semi_axis_y, poisson_ratio)
    return scalars | {"kalker_C11": kalker.c11, "kalker_C22": kalker.c22, "kalker_C23": kalker.c23}


def _reference(discretisation: Discretisation) -> tuple[float, float]:
    """Area (m²) and peak pressure (Pa) to which γ_c and γ_p relate: Hertz's, or those of the cold bodies on this grid."""
    hertz = discretisation.derived.hertz
    if hertz is not None:
        return hertz.area, hertz.peak_pressure
    cold = discretisation.pressure.isothermal
    return float(cold.covered.sum()) * discretisation.grid.element_area, cold.peak


def stick_share_of(discretisation: Discretisation, contact: Contact) -> Array:
    """Share of each element that sticks, (nx, ny)."""
    derived, grid, tangential = discretisation.derived, discretisation.grid, contact.tangential
    if not derived.kinematics.has_traction:
        return contact.normal.covered * tangential.stick
    bound = contact.traction_bound(derived.problem.friction.coefficient)
    return stick_share(tangential.traction, tangential.slip, bound, tangential.stick, contact.normal.covered,
                       grid.dx, grid.dy, derived.bodies.near_border(grid.dx, grid.dy).shear)


def scalars_of(discretisation: Discretisation, contact: Contact, stick_share: Array) -> dict[str, float]:
    """Scalars of `SCALARS` that need no temperature (those are added by `reported_state`)."""
    derived, grid = discretisation.derived, discretisation.grid
    problem, (cold_area, cold_peak) = derived.problem, _reference(discretisation)
    normal, tangential = contact.normal, contact.tangential
    area = float(normal.covered.sum()) * grid.element_area
    stick_area = min(float(stick_share.sum()) * grid.element_area, area)
    force = tangential.traction.sum(axis=(1, 2)) * grid.element_area
    inclination = problem.geometry.inclination(grid.y)
    x, y, cosine = grid.x[:, None], problem.geometry.lateral_place(grid.y), np.cos(inclination)
    force[1] = float((tangential.traction[1] * cosine).sum()) * grid.element_area
    moment = float((x * tangential.traction[1] * cosine - y * tangential.traction[0]).sum()) * grid.element_area
    shear = np.hypot(tangential.traction[0], tangential.traction[1])
    scalars = _off_centre(discretisation, contact, float(force[0]), moment) | {
        "normal_N": problem.normal_force if problem.approach is None else discretisation.pressure.load(normal),
        "Q_F_W": tangential.work * problem.motion.speed,
        "gamma_c": area / cold_area,
        "gamma_st": stick_area / area,
        "gamma_p": normal.peak / cold_peak,
        "force_x_N": float(force[0]),
        "force_y_N": float(force[1]),
        "spin_moment_Nmm": moment * 1e3,
        "T_gamma_N": tangential.work,
        "T_gamma_without_spin_N": float(np.abs(force * tangential.creepage).sum()),
        "creepage_longitudinal": tangential.creepage[0],
        "creepage_lateral": tangential.creepage[1],
        "creepage_spin_rad_mm": problem.motion.spin * 1e-3,
        "pressure_max_MPa": normal.peak * 1e-6,
        "shear_max_MPa": peak_value(shear) * 1e-6,
        "approach_um": float(normal.approach) * 1e6,
        "contact_area_mm2": area * 1e6,
        "stick_area_mm2": stick_area * 1e6,
        "power_balance_error": power_balance_error(tangential, grid.element_area),
    }
    if problem.relaxes or derived.kinematics.feeds_back or contact.expansion is not None:
        scalars["rolling_resistance_moment_Nmm"] = _pressure_moment(discretisation, contact) * 1e3
    if problem.relaxes:
        scalars |= _resistance(discretisation, contact)
    # What vanishes by symmetry is zero, and not what the solver's tolerance leaves.
    vanishing = derived.kinematics.vanishing
    return scalars | {name: 0.0 for name in scalars if vanishing and SCALARS[name].vanishes == vanishing}


def _opening(discretisation: Discretisation) -> Array:
    """∂g/∂x, how the gap of the undeformed surfaces opens along rolling, (nx, ny); 0 where a body has no material."""
    grid = discretisation.grid
    gap = discretisation.derived.problem.geometry.gap(grid.rows_with(1), grid.y)
    gap = np.where(np.isfinite(gap), gap, 0.0)
    return np.asarray((gap[2:] - gap[:-2]) / (2.0 * grid.dx))


def _pressure_moment(discretisation: Discretisation, contact: Contact) -> float:
    """Moment (N m) about the middle of the undeformed contact with which the pressure brakes the rolling, −R'_x ∬ p ∂g/∂x, of
    an elliptic gap −∬ x p; the power that it takes is the moment times V/R'_x. The gap is symmetric along rolling on each line,
    so the pressure of elastic bodies alike without heat has none."""
    problem = discretisation.derived.problem
    pressure = contact.normal.start if problem.relaxes else contact.normal.pressure  # see `_resistance`
    return -float((pressure * _opening(discretisation)).sum()) * discretisation.grid.element_area / problem.geometry.curvature_x


def _resistance(discretisation: Discretisation, contact: Contact) -> dict[str, float]:
    """What is lost inside bodies that relax. The power of the pressure follows twice: from the memory of the bodies and, as
    u_z closes the gap, from the gap. The difference is part of the power that is not accounted for.

    The pressure is that of whole elements, which closes the gap in each of them: loads that are fitted to the border move the
    small moment of a memory shorter than an element by up to 10 %."""
    grid, solvers, problem = discretisation.grid, discretisation.pressure, discretisation.derived.problem
    pressure, tangential = contact.normal.start, contact.tangential
    inside = solvers.solver.hysteresis(pressure)
    slope = -_opening(discretisation)
    if contact.normal.offset is not None:
        slope += np.gradient(contact.normal.offset, grid.dx, axis=0)
    unbalanced = float((pressure * slope).sum()) * grid.element_area - inside
    if discretisation.derived.dissimilar:
        inside += discretisation.traction.coupling.hysteresis(pressure, tangential.traction)
    inside += tangential.hysteresis
    slipped = float((tangential.traction * tangential.slip).sum()) * grid.element_area
    return {
        "hysteresis_W": inside * problem.motion.speed,
        "rolling_resistance_N": inside,
        "power_balance_error": abs(tangential.work - slipped + unbalanced) / (tangential.work + inside),
    }


def _off_centre(discretisation: Discretisation, contact: Contact, force_x: float, moment: float) -> dict[str, float]:
    """Where the contact of profiles lies across rolling, the spin moment about that place, and the resultants of pressure and
    traction on the upper body if their directions vary: ∬ (τ_y cos α − p sin α) and ∬ (p cos α + τ_y sin α)."""
    grid, geometry, pressure = discretisation.grid, discretisation.derived.problem.geometry, contact.normal.pressure
    if geometry.elliptic:
        return {}
    place = float((pressure * geometry.lateral_place(grid.y)).sum() / pressure.sum())
    scalars = {"contact_y_mm": place * 1e3, "spin_moment_at_contact_Nmm": (moment + place * force_x) * 1e3}
    inclination, across = geometry.inclination(grid.y), contact.tangential.traction[1]
    if not inclination.any():
        return scalars
    sine, cosine = np.sin(inclination), np.cos(inclination)
    return scalars | {"contact_force_y_N": float((across * cosine - pressure * sine).sum()) * grid.element_area,
                    "contact_force_z_N": float((pressure * cosine + across * sine).sum()) * grid.element_area}


def power_balance_error(tangential: Traction, element_area: float) -> float:
    """Part of the creep forces' work that the slip of whole elements does not account for (0 without work).

    It measures resolution: the missing part belongs to slip zones narrower than an element (`Discretisation.roll` returns it
    to the heat flux, whose integral therefore is the work)."""
    if tangential.work == 0.0:
        return 0.0
    slipped = float((tangential.traction * tangential.slip).sum()) * element_area
    return abs(slipped - tangential.work) / abs(tangential.work)


def reported_state(discretisation: Discretisation, contact: Contact, *, heated: bool) -> State:
    """Fields and scalars of a state, with heat (`heated`) or without; without thermal deformation with the expansion that its
    heat would cause. Scalars that do not apply are nan.

    The expansion is that of the state's own heat. The one that closes the gap, an unknown of the fixed point, differs from it
    by the tolerance, a share of the approach: of weak heat by a twentieth of all of it."""
    problem, grid = discretisation.derived.problem, discretisation.grid
    heating, expansion = problem.heating, None
    if heating.heat and not heated:
        # Everything stays cold: known without asking a kernel.
        expansion = np.zeros(grid.shape)
    elif heated and heating.deformation:
        expansion = expansion_in(discretisation, discretisation.heat(contact), contact)
    normal, tangential, speed = contact.normal, contact.tangential, problem.motion.speed
    inside = normal.contact
    flux = speed * tangential.heat
    fields: dict[str, AnyArray] = {
        "pressure": normal.pressure,
        "shear_x": tangential.traction[0],
        "shear_y": tangential.traction[1],
        "slip_x": tangential.slip[0] * speed,
        "slip_y": tangential.slip[1] * speed,
        "state": np.where(inside, np.where(tangential.stick, STICK, SLIP), OUT).astype(np.int8),
        "covered": normal.covered,
        "stick_share": stick_share_of(discretisation, contact),
        "heat_flux": flux,
        "displacement_elastic": normal.displacement if contact.shear_displacement is None
        else normal.displacement - contact.shear_displacement,
        "gap": np.where(normal.gap < 0.5 * discretisation.pressure.far, normal.gap, np.nan),
    }
    if contact.local_friction is not None:
        fields["friction_coefficient"] = contact.local_friction * inside
    if tangential.hardening is not None and problem.interlayer.yield_stress is not None:
        fields["yield_stress"] = (problem.interlayer.yield_stress + tangential.hardening) * inside
    scalars = dict.fromkeys(SCALARS, math.nan)
    scalars |= scalars_of(discretisation, contact, fields["stick_share"]) | _friction_scalars(discretisation, contact)
    scalars |= wear_scalars(problem, fields, grid.dx, grid.dy)
    scalars |= revolution_scalars(problem, scalars)
    centre = at_centre(grid, normal.covered)
    scalars["pressure_centre_MPa"] = centre(normal.pressure) * 1e-6
    # At the end of a crown the pressure falls within an element, and single elements carry what belongs to their neighbours.
    smooth = flux if discretisation.derived.problem.geometry.elliptic else between_sides(
        flux, contact.normal.pressure, discretisation.pressure.at_ends)
    scalars["heat_flux_max_W_mm2"] = float(smooth.max()) * 1e-6
    if heating.heat:
        heat = discretisation.heat(contact)
        rises = heat.temperatures()
        scalars["partition_mean"] = heat.mean_share
        scalars |= heat_flows(heating, heat, contact.normal.covered, grid.element_area)
        if heat.into.exchanged is not None:
            fields["heat_flux_lower"] = heat.into.lower
        for body, rise, inner, bulk in zip(
            BODIES, rises, heat.interface_temperatures(), (heating.bulk_lower, heating.bulk_upper), strict=True
        ):
            fields[f"temperature_rise_{body}"] = rise
            scalars[f"temperature_rise_max_{body}_K"] = _hottest(rise)
            scalars[f"temperature_rise_mean_{body}_K"] = float((rise * normal.covered).sum() / normal.covered.sum())
            scalars[f"temperature_rise_centre_{body}_K"] = centre(rise)
            scalars[f"surface_temperature_max_{body}_K"] = bulk + _hottest(rise)
            if inner is not None:
                scalars[f"temperature_interface_max_{body}_K"] = bulk + _hottest(inner)
        if any(heat.tracks):
            scalars |= track_scalars(discretisation.derived, heat, rises, inside)
            fields |= {f"entry_temperature_{body}": np.repeat(entry[None], grid.nx, axis=0)
                       for body, entry, track in zip(BODIES, heat.entry_temperatures(), heat.tracks, strict=True) if track}
    if expansion is not None:
        fields["displacement_thermal"] = expansion
        scalars["thermal_displacement_max_um"] = float(np.ptp(expansion[inside])) * 1e6
        if contact.expansion is not None:
            work = float((normal.pressure * np.gradient(expansion, grid.dx, axis=0)).sum()) * grid.element_area
            scalars["expansion_power_W"] = work * speed
    return State(fields, scalars, grid.x, grid.y)


def at_centre(grid: Grid, covered: Array) -> Callable[[Array], float]:
    """The values of fields (nx, ny) at the centroid of the contact; nan where that lies outside, as between patches."""
    shares = covered / covered.sum()
    x, y = float(shares.sum(axis=1) @ grid.x), float(shares.sum(axis=0) @ grid.y)
    inside = value_at(grid, covered, x, y) > 0.5
    return lambda field: value_at(grid, field, x, y) if inside else math.nan


def _friction_scalars(discretisation: Discretisation, contact: Contact) -> dict[str, float]:
    """Mean coefficient of friction over slip, and the criterion of falling friction, p₀ |dμ/ds| V B₀ with the compliance B₀ of
    an element to its own traction. Beyond about 0.7, without memory, convergence with the grid is of first order only. That of
    an interlayer does not count: it grows with every refinement, and an interlayer needs memory."""
    derived, grid = discretisation.derived, discretisation.grid
    problem, law, scalars = derived.problem, derived.problem.friction.law, {}
    pressure = contact.normal.pressure * (contact.normal.contact & ~contact.tangential.stick)
    if contact.local_friction is not None and pressure.any():
        scalars["friction_mean"] = float((contact.local_friction * pressure).sum() / pressure.sum())
    if law is not None:
        bodies = bodies_of(problem.lower, problem.upper, problem.motion.speed, length=problem.length)
        own = RollingGradient((1, 1), grid.dx, grid.dy, bodies).self_gradient[0]
        steepness = problem.friction.coefficient * law.steepest * problem.motion.speed * own
        scalars["falling_friction_criterion"] = contact.normal.peak * steepness
    return scalars


def sliding(problem: Problem, fields: Mapping[str, AnyArray]) -> tuple[Array, Array]:
    """Local p|s|/V and T_γ/A = μp|s|/V in Pa, (nx, ny): load and work per area, times the distance slid over that rolled.

    Where surfaces slide p |s| = q/μ with the heat flux q, which has the slip of zones narrower than an element."""
    work, at_rest = fields["heat_flux"] / problem.motion.speed, problem.friction.coefficient
    if at_rest == 0.0:
        return fields["pressure"] * np.hypot(fields["slip_x"], fields["slip_y"]) / problem.motion.speed, work
    friction = fields.get("friction_coefficient", np.full_like(work, at_rest))
    return work / np.where(friction > 0.0, friction, at_rest), work


def worn_per_passage(problem: Problem, worn: WornBody, fields: Mapping[str, AnyArray], dx: float) -> Array:
    """∫ κ p |s|/V dx of every line of rolling in m, (ny,): the depth worn off one body per passage (Archard)."""
    slid, work = sliding(problem, fields)
    return np.asarray((worn.rate_at(work)[0] * slid).sum(axis=0) * dx)


def wear_steepness(problem: Problem, worn: WornBody, fields: Mapping[str, AnyArray]) -> float:
    """The largest d ln(wear)/d ln(pressure) of any line of rolling; at least 1."""
    slid, work = sliding(problem, fields)
    rate, steepness = worn.rate_at(work)
    depth = (rate * slid).sum(axis=0)
    return max(1.0, float(((rate * slid * steepness).sum(axis=0) / np.where(depth > 0.0, depth, 1.0)).max()))


def wear_scalars(problem: Problem, fields: Mapping[str, AnyArray], dx: float, dy: float) -> dict[str, float]:
    """Area (µm²) and largest depth (nm) that each body loses per passage, and volume per distance rolled (mm³/m)."""
    if problem.wear is None:
        return {}
    scalars: dict[str, float] = {}
    for body in BODIES:
        depth = worn_per_passage(problem, getattr(problem.wear, body), fields, dx)
        area = float(depth.sum()) * (1.0 if math.isinf(dy) else dy)
        scalars |= {f"wear_area_{body}_um2": area * 1e12, f"wear_depth_max_{body}_nm": peak_value(depth[None]) * 1e9,
                  f"wear_rate_{body}_mm3_m": area * 1e9}
    return scalars


def revolution_scalars(problem: Problem, scalars: Mapping[str, float]) -> dict[str, float]:
    """Worn volume (mm³) and frictional heat (J) of one revolution of each disc that wears or meets one that does: both per
    distance rolled, times 2π|R|/(1 ± ξ_x/2), which is rolled while a surface of this speed over V goes round."""
    if problem.wear is None or not isinstance(problem.geometry, Geometry):
        return {}
    found: dict[str, float] = {}
    for body, sign in zip(BODIES, (1.0, -1.0), strict=True):
        radius = abs(getattr(problem.geometry, f"{body}_radius_x"))
        own_speed = abs(1.0 + 0.5 * sign * scalars["creepage_longitudinal"])
        if math.isfinite(radius) and own_speed > 0.0:
            rolled = 2.0 * math.pi * radius / own_speed
            found |= {f"wear_per_revolution_{body}_mm3": scalars[f"wear_rate_{body}_mm3_m"] * rolled,
                      f"heat_per_revolution_{body}_J": scalars["T_gamma_N"] * rolled}
    return found


def _hottest(rise: Array) -> float:
    """Largest rise of a surface in K. It is zero far from the contact, and so it is zero for a body that only cools."""
    return peak_value(rise, averages=False) if rise.max() > ROUNDING * np.abs(rise).max() else 0.0


def heat_flows(heating: Heating, heat: Heat, covered: Array, element_area: float) -> dict[str, float]:
    """Heat in W that enters each body, and that flows from the hotter to the colder one by conduction alone.

    The division of heat is linear in friction and in the difference of bulk temperatures, so the last one is the heat that
    would flow through this contact without friction. Over time it is not known: it depends on what has flowed before."""
    conducted = math.nan if heat.before is not None else 0.0
    if heating.conducts and heat.before is None:
        alone = heat if not heat.flux.any() else divide(heating, heat.response, np.zeros(heat.flux.shape), covered)
        conducted = abs(float(alone.into.lower.sum())) * element_area
    lower, upper = (float(flux.sum()) * element_area for flux in (heat.into.lower, heat.into.upper))
    return {"heat_into_lower_W": lower, "heat_into_upper_W": upper, "heat_conducted_W": conducted}


def track_scalars(
    derived: DerivedQuantities, heat: Heat, rises: tuple[Array, Array], contact: Mask
) -> dict[str, float]:
    """Bulk (mean surface), entry and flash temperatures in K; of bodies that turn also bulge,
    thermal crown Λ and time constants.

    `rises` are the temperatures of both surfaces above what surrounds them in K, (nx, ny). Bulk and entry temperatures include
    what the case says of the surroundings; the flash is the rise of this pass alone. A body that does not return is everywhere,
    and when it enters, as warm as far away.
    """
    heating = derived.problem.heating
    scalars: dict[str, float] = {}
    tracks, entries = heat.tracks, heat.entry_temperatures()
    into = heat.into.lower, heat.into.upper
    columns = contact.any(axis=0)
    for i, (body, around) in enumerate((("lower", heating.bulk_lower), ("upper", heating.bulk_upper))):
        track = tracks[i]
        scalars[f"bulk_temperature_{body}_K"] = around + (0.0 if track is None else track.bulk_temperature(into[i]))
        scalars[f"entry_temperature_max_{body}_K"] = around + (0.0 if track is None else float(entries[i][columns].max()))
        flash = rises[i] - entries[i]
        scalars[f"flash_temperature_max_{body}_K"] = peak_value(flash, averages=False) if flash.max() > 0.0 else 0.0
        scalars[f"warm_up_time_{body}_s"] = math.nan if track is None else track.body.warm_up_time
    bulge = sum(track.entry_bulge(flux) for track, flux in zip(tracks, into, strict=True) if track is not None)
    crown = np.asarray(bulge)[columns]
    # A track that is expanded evenly has rounding for a crown.
    height = float(np.ptp(crown))
    scalars["recirculation_bulge_um"] = 1e6 * height if height > ROUNDING * np.abs(crown).max() else 0.0
    scalars["thermal_crown_ratio"] = sum(
        track.crown(flux, derived.lateral_curvature)
        for track, flux in zip(tracks, into, strict=True) if track is not None
    )
    return scalars


def patches_of(discretisation: Discretisation, contact: Contact) -> list[dict[str, float]]:
    """Scalars of each patch, from −y to +y: centre of its pressure, forces, area and largest pressure, in the units of the
    names; none of an elliptic gap, which has one patch, nor of rough surfaces, which have spots.

    The gap is a function of x plus one of y, so no patch lies beside another along x."""
    grid, normal = discretisation.grid, contact.normal
    lateral = discretisation.derived.problem.geometry.lateral_place(grid.y)
    out: list[dict[str, float]] = []
    several = not discretisation.derived.problem.geometry.elliptic and discretisation.heights is None
    for columns in patches_across(normal.covered) if several else ():
        here = np.zeros(grid.ny, dtype=bool)
        here[columns] = True
        pressure, covered = normal.pressure * here, normal.covered * here
        force = (contact.tangential.traction * here).sum(axis=(1, 2)) * grid.element_area
        out.append({
            "y_mm": float((pressure.sum(axis=0) * lateral).sum() / pressure.sum()) * 1e3,
            "normal_N": float((pressure * discretisation.pressure.cosine).sum()) * grid.element_area,
            "force_x_N": float(force[0]),
            "force_y_N": float(force[1]),
            "area_mm2": float(covered.sum()) * grid.element_area * 1e6,
            "pressure_max_MPa": peak_inside(pressure, covered) * 1e-6,
        })
    return out
