"""Warnings: cases that are allowed and yet doubtful, before they are solved (`warnings_before`) and after (`warnings_after`).

They concern constants outside the range of solids, pressures and temperatures that no solid survives, keys without effect,
contacts beyond half-space theory, ends of profiles, cooling that no body has, and thermal expansion along the surfaces.

**Expansion along the surfaces.** Heat makes a free surface rise by u_z and stretch along itself: the surface displacement of a
thermoelastic half-space (quasi-static, Goodier's potential plus Boussinesq's correction, m and n the wavenumbers along x and y,
w = sqrt(m² + n²)) is

    û_z = 2(1+ν)α T^/(w + w')      û_x = −(i m/w) û_z      û_y = −(i n/w) û_z       w'² = w² + i m s/κ,

which for material moving with speed s along x, since 1/(w + w') = κ (w' − w)/(i m s), is in real space

    ∂u_x/∂x = 2(1+ν)α κ/s · ∂(T − T_0)/∂x,      ∂u_y/∂x = 2(1+ν)α κ/s · ∂(T − T_0)/∂y

with T_0 the temperature that the same heat would make in material at rest (where the strains add up to (1+ν)αT). Bodies
alike in all this expand alike, and their slip does not feel it; the difference of two other bodies belongs into the slip
equation, ṡ/V = ξ − ∂u/∂x, but is left out: in realistic cases it is below one per cent of the creepage at which the contact
slides (docs/physics.md). There is a warning if it is more.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.halfspace.coatings import THICK
from thermoroll_cli.heat.frictional_heat import Heat
from thermoroll_cli.heat.recirculation import Roller
from thermoroll_cli.heat.sliding_heat import SlidingHeatResponse
from thermoroll_cli.numerics.grid import Grid
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import FEWEST_ROUGH, Geometry, Unsolvable, rough_warning
from thermoroll_cli.problem.problem import BODIES, Layer, Material, Problem
from thermoroll_cli.steady_state.derived import SLIP_SAMPLES, DerivedQuantities
from thermoroll_cli.steady_state.heated_bodies import crown_bound, rollers

HALF_SPACE_LIMIT = 0.3
"""Half-width over radius from which the half-space is a doubtful model (Johnson, Contact Mechanics, 4.1)."""
STEEPEST = 0.1
"""Slope across the contact from which the plane of the frame is a doubtful model: cosines differ from one by 0.5 %."""
WIDEST_CURVED = 1.0
"""Turn of a curved contact in rad from which the half-space is a doubtful model: a conformal force is 0.3 % off there."""
CONFORMAL = "; conformal = true in [geometry] follows the surface"
PRESSURE_OVER_MODULUS = 0.01
"""Part of Young's modulus up to which bodies answer linearly; metals yield below it."""
LARGEST_RISE = 2000.0
"""K. Steel melts at 1500 °C, and no constant stays one that far."""

NO_SOLID = f"no solid stands {LARGEST_RISE:g} K with these constants"

SOLIDS = {
    "youngs_modulus": ("Young's modulus", 1e9, "GPa", 1e-4, 1.3e3),
    "conductivity": ("thermal conductivity", 1.0, "W/(m K)", 0.01, 3e3),
    "expansion": ("thermal expansion", 1e-6, "1e-6/K", 0.01, 1e3),
    "diffusivity": ("thermal diffusivity", 1e-6, "mm²/s", 0.01, 3e3),
    "heat_capacity": ("heat capacity, conductivity over diffusivity,", 1.0, "J/(m³ K)", 1e5, 1e7),
}
"""Name, unit in SI, and range in that unit of each constant: from soft rubber, aerogel, invar and polymers to diamond, with
room (heat capacities of dense solids are 0.9e6 to 4.5e6). A value outside is a mistaken unit rather than a material."""


def warnings_before(derived: DerivedQuantities) -> list[str]:
    """Doubts about a solvable problem before it is solved."""
    problem, moves = derived.problem, derived.kinematics.moves
    return [*_constants(problem), *_pressure(derived), *_without_effect(problem, moves), *_memory(derived),
            *_half_space_warnings(derived), *_large_strain(derived), *coating_warnings(problem), *_rough_profiles(derived),
            *(track_warnings(derived) if problem.heating.recirculates and derived.kinematics.has_traction else ())]


def _rough_profiles(derived: DerivedQuantities) -> Iterator[str]:
    """Doubts about measured profiles whose noise the contact feels."""
    scales = derived.scales
    for body, profile in derived.problem.geometry.profiles:
        points = np.array(profile.points).reshape(-1, 2)
        away = np.abs(points[:, 0] + profile.offset - scales.centre)
        # A contact on a single asperity has hardly a point of its own.
        reach = max(scales.semi_axis_y, *np.sort(away)[: 2 * FEWEST_ROUGH], 0.0)
        yield from rough_warning(f"{body} body", points[away <= reach])


THICK_COATING = 0.1
"""Thickness of a coating over the smallest radius of its body from which plane layers are a doubtful model."""
STIFF_ON_SOFT = 30.0
"""Modulus of a layer over that below it from which coatings bend as plates, and break."""


def coating_warnings(problem: Problem) -> Iterator[str]:
    """Doubts about coatings."""
    geometry = problem.geometry
    radii = zip((geometry.lower_radius_x, geometry.upper_radius_x), geometry.across_radii, strict=True)
    for body, material, both in zip(BODIES, (problem.lower, problem.upper), radii, strict=True):
        thickness, radius = sum(layer.thickness for layer in material.layers), min(map(abs, both))
        if thickness > THICK_COATING * radius:
            yield (f"the coating of the {body} body is {thickness / radius:.2g} of its smallest radius thick: plane layers are "
                   f"a doubtful model above {THICK_COATING:g}")
        below = (*(layer.youngs_modulus for layer in material.layers[1:]), material.youngs_modulus)
        for number, (layer, modulus) in enumerate(zip(material.layers, below, strict=False), 1):
            if layer.youngs_modulus > STIFF_ON_SOFT * modulus:
                yield (f"layer {number} of the coating of the {body} body is {layer.youngs_modulus / modulus:.3g} times "
                       f"stiffer than the material below it: above {STIFF_ON_SOFT:g} layers bend like plates, and real ones "
                       "crack")


RESOLVED_BORDER = 0.5
"""Part to which half-spaces describe a border within an element (`coatings.NearBorder.trust`), at least."""


def unresolved_coatings(derived: DerivedQuantities, grid: Grid) -> Iterator[str]:
    """Doubt about coatings as thin as an element, which matter at the border and for the stresses in them."""
    coatings, request, element = derived.coatings, derived.problem.subsurface, min(grid.dx, grid.dy)
    for body in () if request is None else request.bodies:
        for layer in getattr(derived.problem, body).layers[:1]:
            if layer.thickness < THICK * element:
                yield (f"the top layer of the {body} body's coating is {layer.thickness / element:.2g} elements thick: near "
                       "borders of contact and stick its stresses vary within elements; "
                       f"{_resolving(grid, layer.thickness)} would resolve them")
    if coatings is None or coatings.near_border(grid.dx, grid.dy).trust >= RESOLVED_BORDER:
        return
    bodies = (coatings.lower, coatings.upper)
    thickness = min(body.layers[0].thickness for body in bodies if body.layers)
    yield (f"the grid does not resolve the top layer of a coating, {thickness / element:.2g} elements thick: the contact ends "
           f"at the border of an element, which shows in areas; {_resolving(grid, thickness)} would resolve it")


def _resolving(grid: Grid, thickness: float) -> str:
    """The grid of which `THICK` elements are as thick as a layer of a coating."""
    finer = THICK * min(grid.dx, grid.dy) / thickness
    nx, ny = (math.ceil(finer * side) for side in grid.shape)
    return f"numerics.grid = {nx}" if nx == ny else f"numerics.grid = [{nx}, {ny}]"


SHARP_EDGE, ELEMENTS_TO_EDGE = 0.05, 4.0
"""Error of the largest pressure by an edge that is not resolved from which it is worth a warning; elements that resolve it."""


def edge_warning(derived: DerivedQuantities, grid: Grid, error: float) -> Iterator[str]:
    """Whether material that has not relaxed yet makes a maximum at the leading edge that the grid does not resolve; `error` is
    that of the largest pressure."""
    if derived.relaxing is None or error < SHARP_EDGE:
        return
    place, _ = derived.relaxing.leading_edge(derived.scales.semi_axis_x)
    wanted = math.ceil(ELEMENTS_TO_EDGE * grid.dx / place * grid.nx)
    yield (f"the pressure has a maximum about {place * 1e6:.2g} µm behind the leading edge, {place / grid.dx:.2g} elements, "
           f"where the bodies have not relaxed yet: the largest pressure and traction may be {100.0 * error:.0f} % off; "
           f"numerics.grid = [{wanted}, {grid.ny}] would resolve it")


def _half_space_warnings(derived: DerivedQuantities) -> Iterator[str]:
    scales, geometry = derived.scales, derived.problem.geometry
    widths = {"x": (scales.semi_axis_x, geometry.lower_radius_x, geometry.upper_radius_x)}
    if geometry.elliptic:
        widths["y"] = (scales.semi_axis_y, *geometry.across_radii)
    else:
        yield from profile_warnings(derived)
    low, high = derived.contact_angles
    if high - low > WIDEST_CURVED:
        yield (f"the contact turns by {high - low:.2f} rad across rolling: influence coefficients are those of half-spaces, a "
               f"doubtful model above {WIDEST_CURVED:g} rad")
    for axis, (half, *radii) in widths.items():
        if (share := half / min(map(abs, radii))) > HALF_SPACE_LIMIT:
            yield (f"contact half-width along {axis} is {share:.2f} of the smallest radius: the half-space assumption is "
                   f"doubtful above {HALF_SPACE_LIMIT:g}{CONFORMAL if axis == 'y' else ''}")


LARGEST_STRAIN = 0.1
"""Half-width over relative radius, the mean strain, up to which polymers and rubber are about linear."""
INNER_HEAT = 0.05
"""Share of all heat from which the heat that is made inside bodies is worth a warning."""


def _large_strain(derived: DerivedQuantities) -> Iterator[str]:
    strain = derived.scales.semi_axis_x * abs(derived.problem.geometry.curvature_x)
    if derived.problem.relaxes and strain > LARGEST_STRAIN:
        yield (f"the mean strain, about half-width over radius, is {strain:.2g}: bodies that relax are hardly linear above "
               f"{LARGEST_STRAIN:g}")


def relaxation_facts(derived: DerivedQuantities) -> dict[str, float]:
    """E* that the contact feels, at the frequency V/a, and the lengths that are rolled in the retardation times, over a."""
    relaxing, half = derived.relaxing, derived.scales.semi_axis_x
    assert relaxing is not None
    lengths = {f"retardation_length_{number}_{body}_over_a": derived.problem.motion.speed * time / half
               for body in BODIES
               for number, (_, time) in enumerate(getattr(derived.problem, body).surface.retardation, 1)}
    return {"felt_modulus_GPa": 1e-9 * relaxing.surface_modulus / relaxing.softening(half), **lengths}


def inner_heat_warning(hysteresis: float, friction: float) -> Iterator[str]:
    """Whether bodies that relax are heated inside, from the power that they lose and the heat of `friction`, both in W."""
    share = hysteresis / (hysteresis + friction)
    if share > INNER_HEAT:
        yield (f"{100.0 * share:.0f} % of all heat, {hysteresis:.3g} W, is made inside bodies that relax: temperatures and "
               "thermal expansion do not contain it")


def warnings_after(
    derived: DerivedQuantities, heat: Heat, slip: Array, rises: tuple[Array, Array], highest: float
) -> list[str]:
    """Doubts about a solved state with `heat`, from its `slip` s/V (2, nx, ny) and the temperature `rises` of both bodies in
    K, of which the `highest` is reported."""
    warnings = [*sideways_warning(heat, slip)]
    if derived.kinematics.has_traction:
        warnings += tangential_expansion_warning(derived, *rises)
    if highest > LARGEST_RISE:
        warnings.append(f"temperature rises by up to {highest:.4g} K: {NO_SOLID}")
    return warnings


def feedback_warning(derived: DerivedQuantities, rises: tuple[Array, Array], friction: Array) -> Iterator[str]:
    """If friction rises with temperature, a change of friction μ changes the temperature, and that the friction again. Several
    steady states are possible if the gain of this loop exceeds one. The temperature rise is in proportion to μ, so the gain is
    |dμ/dT| ΔT/μ, with the mean rise ΔT of both surfaces."""
    law, heating = derived.problem.friction, derived.problem.heating
    rise = 0.5 * (rises[0] + rises[1])
    without = rise * law.coefficient / np.where(friction > 0.0, friction, law.coefficient)  # with μ₀
    gain = -law.slope * float(without.max())
    hottest = 0.5 * (heating.bulk_lower + heating.bulk_upper) + law.maximum * float(without.max())
    if gain > 1.0 and hottest > law.start:
        yield (f"friction rises steeply with temperature: through its heat a change of friction causes one up to {gain:.2g} "
               "times as large, so there may be several steady states, and the start may decide which one is found; sweep "
               "rolling.speed_m_s up and down")


def _constants(problem: Problem) -> Iterator[str]:
    for material, whose in _materials(problem):
        constants = vars(material) | {"heat_capacity": (material.conductivity or 0.0) / (material.diffusivity or 1.0)}
        for attribute, (name, unit, unit_name, smallest, largest) in SOLIDS.items():
            value = constants[attribute]
            if value and not smallest <= value / unit <= largest:  # no expansion at all is an assumption
                yield (f"{name} of {whose} is {value / unit:.4g} {unit_name}: that of solids lies between {smallest:g} and "
                       f"{largest:g}; a mistaken unit?")


def _materials(problem: Problem) -> Iterator[tuple[Material | Layer, str]]:
    """Bodies and the layers of their coatings."""
    both = ((problem.lower, "both bodies"),) if problem.lower == problem.upper else (
        (problem.lower, "the lower body"), (problem.upper, "the upper body"))
    for body, whose in both:
        yield body, whose
        yield from ((layer, f"layer {number} of the coating of {whose}") for number, layer in enumerate(body.layers, 1))


def _pressure(derived: DerivedQuantities) -> Iterator[str]:
    pressure = derived.scales.peak_pressure
    modulus = min(body.surface.youngs_modulus for body in (derived.problem.lower, derived.problem.upper))
    limit = LARGEST_STRAIN if derived.problem.relaxes else PRESSURE_OVER_MODULUS
    if pressure > limit * modulus:
        yield (f"the pressure of {pressure * 1e-6:.4g} MPa is {100 * pressure / modulus:.2g} % of Young's modulus: beyond "
               f"{100 * limit:g} % the bodies are hardly linear and elastic")
    if pressure > limit * modulus or derived.scales.reaches_an_end:
        yield from _other_frames(derived.problem, limit * modulus, pressure)


WIDEST_PROFILE = 0.5
"""Width of a profile in m."""
MUCH_LESS = 0.05
"""Over the pressure, what it becomes without a mistake that must be asked about, even if it stays large."""
MISTAKES = {"point into the body: turn the sign of the heights": (1.0, -1.0), "be in metres: give them in mm": (1e3, 1e3)}
"""Usual mistakes in points of a profile with advice, and factors of y and height that undo them."""


def _other_frames(problem: Problem, limit: float, pressure: float) -> Iterator[str]:
    """A mistake in the points of a profile without which the `pressure` stays below the `limit` (Pa), and off the ends, or
    becomes much less."""
    geometry = problem.geometry
    for body in BODIES if isinstance(geometry, Geometry) else ():
        profile = getattr(geometry, f"{body}_profile")
        for mistake, factors in MISTAKES.items() if profile is not None and profile.points else ():
            points = tuple((factors[0] * y, factors[1] * height) for y, height in profile.points)
            other = replace(geometry, **{f"{body}_profile": replace(profile, points=points)})
            if points[-1][0] - points[0][0] > WIDEST_PROFILE:
                continue
            with contextlib.suppress(Unsolvable):
                scales = DerivedQuantities(replace(problem, geometry=other)).scales
                sound = scales.peak_pressure < limit and not scales.reaches_an_end
                if sound or scales.peak_pressure < MUCH_LESS * pressure:
                    yield (f"the points of geometry.{body}_profile may {mistake}, and the pressure becomes "
                           f"{scales.peak_pressure * 1e-6:.4g} MPa{'' if scales.reaches_an_end else ', off the ends'}")


def _without_effect(problem: Problem, moves: bool) -> Iterator[str]:
    """Keys without effect; those of friction where they differ from the defaults of the dataclass."""
    heating, friction, cold = problem.heating, problem.friction, not problem.heating.heat
    for applies, sentence in (
        (cold and friction.slope, "friction that changes with temperature has no effect: heat is off"),
        (cold and (heating.bulk_lower or heating.bulk_upper), "bulk temperatures have no effect: heat is off"),
        (cold and (heating.lower_track or heating.upper_track), "bodies that bring heat back have no effect: heat is off"),
        (friction.start != Friction.start and not friction.slope,
         "the temperature from which friction changes has no effect: friction.temperature_slope_1_K is 0"),
        (friction.minimum != Friction.minimum and not friction.slope > 0.0,
         "friction.temperature_minimum_factor has no effect: friction does not fall with temperature"),
        (friction.maximum != Friction.maximum and not friction.slope < 0.0,
         "friction.temperature_maximum_factor has no effect: friction does not rise with temperature"),
        (problem.wear is not None and not moves, "nothing slips, so nothing wears"),
    ):
        if applies:
            yield sentence


def _memory(derived: DerivedQuantities) -> Iterator[str]:
    """Memory that changes nothing, and memory too short for an interlayer: its shear L τ must not fall with slip faster than
    friction follows, d_c > L p₀ Δμ, with the largest fall Δμ up to the slip that the given creepages make (up to any where a
    force is given)."""
    problem, law, motion = derived.problem, derived.problem.friction.law, derived.problem.motion
    if law is None or not law.memory:
        return
    if law.highest == 1.0 and not law.fall():
        yield "friction.memory_um has no effect: friction does not depend on slip"
    slip = math.hypot(motion.creepage_x or 0.0, motion.creepage_y or 0.0) + abs(motion.spin) * derived.scales.mean_radius
    needed = derived.interlayer_shear * law.fall(math.inf if problem.prescribed_force else slip * motion.speed)
    if law.memory < needed:
        yield (f"friction.memory_um = {law.memory * 1e6:.3g} is shorter than the shear of the interlayer while friction falls, "
               f"{needed * 1e6:.3g} µm: where slip begins the state may depend on the grid; a longer memory avoids that")


def profile_warnings(derived: DerivedQuantities) -> Iterator[str]:
    """Where half-space theory is doubtful, and where the pressure has no upper bound."""
    scales, geometry = derived.scales, derived.problem.geometry
    y = scales.centre + scales.semi_axis_y * np.linspace(-1.0, 1.0, SLIP_SAMPLES)[1:-1]
    y = y[geometry.across(y) < scales.approach]
    patches = np.split(y, np.flatnonzero(np.diff(y) > 1.5 * (y[1] - y[0])) + 1)
    for body, slope_of in zip(BODIES, geometry.slopes, strict=False):
        if (slope := float(np.abs(slope_of(y)).max())) > STEEPEST:
            yield (f"the surface of the {body} body is inclined by up to {slope:.2f} in the contact: the plane of the frame is "
                   f"a doubtful model above {STEEPEST:g}{CONFORMAL}")
        # Along each patch by itself. Where the radius varies, the angle counts by which the surface turns across the patch.
        if (share := max(0.5 * float(np.ptp(slope_of(part))) for part in patches)) > HALF_SPACE_LIMIT:
            yield (f"contact half-width along y is {share:.2f} of the radius of curvature of the {body} body in it: the "
                   f"half-space assumption is doubtful above {HALF_SPACE_LIMIT:g}{CONFORMAL}")
    if all(scales.ends):
        low, high = (1e3 * y for y in scales.limits)
        yield f"the contact reaches both ends of a profile, y = {low:g} and {high:g} mm. {RELIEVE}"
    if scales.reaches_an_end:
        yield FREE_END


FREE_END = ("the contact reaches the end of a profile: the pressure there has no upper bound, so pressure_max_MPa, gamma_p and "
            "shear_max_MPa grow with every refinement and have no error estimate")
"""The warning wherever a free end is loaded."""
RELIEVE = ('Give more of a measured profile, and relieve the ends of a roller, by a crown (kind = "logarithmic") or by points '
           "that fall off")


WORTH_TELLING = 0.02
"""Part of the saturation creepage from which the warning is given; the true gradient may be 2–3 times as large locally."""


def tangential_expansion(derived: DerivedQuantities, rise_lower: Array, rise_upper: Array) -> float:
    """Estimate of the largest |∂u/∂x| between the surfaces by their thermal expansion, from their temperature rises in K.

    Of each body (1+ν)α T · 2w/|w + w'| with w = 1/a0, that is 2/(1 + (1 + P²)^¼): within a factor of two of the closed
    form above for smooth heat and Péclet numbers P = V a0/κ up to 5000."""
    lower, upper = derived.problem.lower, derived.problem.upper
    difference = _strain_per_kelvin(derived, lower) * rise_lower - _strain_per_kelvin(derived, upper) * rise_upper
    return float(np.abs(difference).max())


def _strain_per_kelvin(derived: DerivedQuantities, body: Material) -> float:
    # Only in rolling mode does every point of the material pass at the same known speed.
    peclet = derived.peclet(body) if derived.problem.heating.peclet == "rolling" else 0.0
    parts: tuple[Material | Layer, ...] = (body, *body.layers)
    free = max((1.0 + part.poisson_ratio) * part.expansion for part in parts if part.expansion is not None)
    return free * 2.0 / (1.0 + (1.0 + peclet**2) ** 0.25)


def tangential_expansion_warning(derived: DerivedQuantities, rise_lower: Array, rise_upper: Array) -> Iterator[str]:
    """Whether the surfaces of different bodies stretch so differently that the slip would feel it."""
    share = tangential_expansion(derived, rise_lower, rise_upper) / derived.saturation_creepage
    if share > WORTH_TELLING:
        yield (f"the heated surfaces stretch along each other by about {100 * share:.0f} % of the saturation creepage: the "
               "slip equation does not contain this part of the thermal expansion")


LUMPED_BIOT = 10.0
"""hR/k from which the surface of a solid body is cold beside its core of the track: cooling like this takes jets or baths."""
WIDE = 2.0
"""The half-space model needs a body this many times as wide as its contact."""


def rollers_of(derived: DerivedQuantities) -> dict[str, Roller]:
    """The bodies that bring heat back, by name, at the creepage that is given (0 where it is to be found)."""
    pairs = zip(BODIES, rollers(derived.problem, derived.problem.motion.creepage_x or 0.0), strict=True)
    return {body: roller for body, roller in pairs if roller is not None}


def track_facts(derived: DerivedQuantities) -> dict[str, float]:
    """Numbers known before solving: thermal crown Λ at most, and per body the bulk temperature expected, Biot number and time
    constant.

    The heat is that of full sliding, shared evenly if the partition is not given: what a slide rule would give."""
    motion, heating = derived.problem.motion, derived.problem.heating
    creepages = [3.0 * derived.saturation_creepage if c is None else abs(c) for c in (motion.creepage_x, motion.creepage_y)]
    heat = derived.problem.traction_limit * math.hypot(*creepages) * motion.speed
    facts = {"thermal_crown_bound": crown_bound(derived)}
    share = 0.5 if heating.partition == "matched" else heating.partition
    parts = {"lower": (share, heating.bulk_lower), "upper": (1.0 - share, heating.bulk_upper)}
    for body, roller in rollers_of(derived).items():
        part, around = parts[body]
        facts[f"expected_bulk_temperature_{body}_K"] = around + roller.mean_resistance * roller.passes * part * heat
        if roller.convection is not None:
            facts[f"biot_{body}"] = roller.biot
        facts[f"warm_up_time_{body}_s"] = roller.warm_up_time
    return facts


def track_warnings(derived: DerivedQuantities) -> Iterator[str]:
    """Doubts about a fixed partition, a track wider than its body, cooling stronger than a solid body can use."""
    if derived.problem.heating.partition != "matched":
        yield ("recirculated heat changes the partition: with a fixed thermal.partition temperatures can be far off; use "
               '"matched"')
    contact = 2.0 * derived.scales.semi_axis_y
    for body, roller in rollers_of(derived).items():
        track = contact + 4.0 * roller.spreading
        if track > roller.width:
            yield (f"the heated track of the {body} body, {1e3 * track:.3g} mm with what spreads between passes, is wider "
                   f"than the body ({1e3 * roller.width:.3g} mm)")
        elif contact * WIDE > roller.width:
            yield (f"the contact takes {100.0 * contact / roller.width:.0f} % of the width of the {body} body: the half-space "
                   "is a doubtful model of it")
        if roller.biot > LUMPED_BIOT:
            yield (f"the Biot number hR/k of the {body} body is {roller.biot:.3g}: its surface is cooled faster than heat "
                   "flows through it, and the answer depends on where exactly it is cooled")


SIDEWAYS_SHARE = 0.1
"""Share of heat from sideways slip, times a Péclet number below one, from which its direction is worth a warning."""


def sideways_warning(heat: Heat, slip: Array) -> Iterator[str]:
    """Whether sliding Péclet numbers carry heat of sideways slip along x (`heat.sliding_heat`); `slip` is (2, nx, ny)."""
    total = float(heat.flux.sum())
    if not isinstance(heat.response, SlidingHeatResponse) or total == 0.0:
        return
    share = float(heat.flux[np.abs(slip[1]) > np.abs(slip[0])].sum()) / total
    peclet = heat.response.mean_peclet(heat.flux)
    if share * min(peclet, 1.0) > SIDEWAYS_SHARE:
        yield (f"{100 * share:.0f} % of the heat is made by sideways slip, at a mean Péclet number of {peclet:.2g}: "
               'thermal.peclet = "sliding" carries all heat along x, whatever the direction of slip')
