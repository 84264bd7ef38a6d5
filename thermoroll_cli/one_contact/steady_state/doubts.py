"""Cases that are allowed and yet doubtful, before they are solved: constants outside the range of solids, pressures that no
solid survives, keys without effect, contacts beyond half-space theory, ends of profiles, cooling that no body has."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from thermoroll_cli.one_contact.steady_state.derived import SLIP_SAMPLES, DerivedQuantities
from thermoroll_cli.one_contact.steady_state.heated_bodies import crown_bound, turning_bodies
from thermoroll_cli.physics.contact.contact_scales import approach_weight
from thermoroll_cli.physics.heat.recirculation import TurningBody
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import FEWEST_ROUGH, Geometry, Unsolvable, rough_warning
from thermoroll_cli.problem.problem import BODIES, Layer, Material, Problem
from thermoroll_cli.problem.rounding import rounding_warning

HALF_SPACE_LIMIT = 0.3
"""Half-width over radius from which the half-space is a doubtful model (Johnson, Contact Mechanics, 4.1)."""
STEEPEST = 0.1
"""Slope across the contact from which the plane of the frame is a doubtful model: cosines differ from one by 0.5 %."""
WIDEST_CURVED = 1.0
"""Turn of a curved contact in rad from which the half-space is a doubtful model: a conformal force is 0.3 % off there."""
LARGEST_STRAIN = 0.1
"""Half-width over relative radius, the mean strain, up to which polymers and rubber are about linear."""
CONFORMAL = "; conformal = true in [geometry] follows the surface"
WIDEST_PROFILE = 0.5
"""Width of a profile in m."""
MUCH_LESS = 0.05
"""Over the pressure, what it becomes without a mistake that must be asked about, even if it stays large."""
MISTAKES = {"point into the body: turn the sign of the heights": (1.0, -1.0), "be in metres: give them in mm": (1e3, 1e3),
            'have heights in µm: give them in mm, or height_unit = "um" beside their file': (1.0, 1e-3)}
"""Usual mistakes in points of a profile with advice, and factors of y and height that undo them."""
MUCH_ROUNDED = 0.02
"""Share of the largest pressure by which rounding may change it without a word."""
NO_SOLID = 0.05
"""Part of E* that no solid carries: beyond it units are mistaken."""
PRESSURE_OVER_MODULUS = 0.01
"""Part of Young's modulus up to which bodies answer linearly; metals yield below it."""
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
            *_half_space_warnings(derived), *coating_warnings(problem), *_rough_profiles(derived), *_rounded_profiles(derived),
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


def _rounded_profiles(derived: DerivedQuantities) -> Iterator[str]:
    """Doubts about profiles whose numbers have too few decimals."""
    scales, modulus, geometry = derived.scales, derived.problem.contact_modulus, derived.problem.geometry
    # Those of a patch have been told with its wheel and its rail.
    for body, profile in geometry.profiles:
        rounding = profile.rounding_at(scales.centre, scales.semi_axis_y)
        yield from rounding_warning(f"{body} body", rounding, modulus, scales.semi_axis_y, MUCH_ROUNDED * scales.peak_pressure)


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
    strain = scales.semi_axis_x * abs(geometry.curvature_x)
    if derived.problem.relaxes and strain > LARGEST_STRAIN:
        yield (f"the mean strain, about half-width over radius, is {strain:.2g}: bodies that relax are hardly linear above "
               f"{LARGEST_STRAIN:g}")


def relaxation_facts(derived: DerivedQuantities) -> dict[str, float]:
    """E* that the contact feels, at the frequency V/a, and the lengths that are rolled in the retardation times, over a."""
    bodies, half = derived.bodies, derived.scales.semi_axis_x
    lengths = {f"retardation_length_{number}_{body}_over_a": derived.problem.motion.speed * time / half
               for body in BODIES
               for number, (_, time) in enumerate(getattr(derived.problem, body).surface.retardation, 1)}
    return {"felt_modulus_GPa": 1e-9 * bodies.contact_modulus / bodies.softening(half), **lengths}


def _constants(problem: Problem) -> Iterator[str]:
    both = ((problem.lower, "both bodies"),) if problem.lower == problem.upper else (
        (problem.lower, "the lower body"), (problem.upper, "the upper body"))
    parts: list[tuple[Material | Layer, str]] = []
    for body, whose in both:
        parts += (body, whose), *((layer, f"layer {k} of the coating of {whose}") for k, layer in enumerate(body.layers, 1))
    for material, whose in parts:
        constants = vars(material) | {"heat_capacity": (material.conductivity or 0.0) / (material.diffusivity or 1.0)}
        for attribute, (name, unit, unit_name, smallest, largest) in SOLIDS.items():
            value = constants[attribute]
            if value and not smallest <= value / unit <= largest:  # no expansion at all is an assumption
                yield (f"{name} of {whose} is {value / unit:.4g} {unit_name}: that of solids lies between {smallest:g} and "
                       f"{largest:g}; a mistaken unit?")


def _pressure(derived: DerivedQuantities) -> Iterator[str]:
    pressure = derived.scales.peak_pressure
    modulus = min(body.surface.youngs_modulus for body in (derived.problem.lower, derived.problem.upper))
    limit = LARGEST_STRAIN if derived.problem.relaxes else PRESSURE_OVER_MODULUS
    if pressure > limit * modulus:
        impossible = pressure > NO_SOLID * derived.problem.contact_modulus
        units = ("; are all lengths and heights in the units of their keys? A body softer than its pressure, or a tyre that "
                 "air carries, is another model") if impossible else ""
        yield (f"the pressure of {pressure * 1e-6:.4g} MPa is {100 * pressure / modulus:.2g} % of Young's modulus: beyond "
               f"{100 * limit:g} % the bodies are hardly linear and elastic{units}")
    geometry = derived.problem.geometry
    if not (isinstance(geometry, Geometry) and (pressure > limit * modulus or derived.scales.reaches_an_end)):
        return
    # A mistake in the points of a profile without which the pressure is allowed, and off the ends, or becomes much less.
    for body in BODIES:
        profile = getattr(geometry, f"{body}_profile")
        for mistake, factors in MISTAKES.items() if profile is not None and profile.points else ():
            points = tuple((factors[0] * y, factors[1] * height) for y, height in profile.points)
            other = replace(geometry, **{f"{body}_profile": replace(profile, points=points)})
            if points[-1][0] - points[0][0] > WIDEST_PROFILE:
                continue
            with contextlib.suppress(Unsolvable):
                scales = DerivedQuantities(replace(derived.problem, geometry=other)).scales
                sound = scales.peak_pressure < limit * modulus and not scales.reaches_an_end
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
    y, step = np.linspace(scales.centre - scales.semi_axis_y, scales.centre + scales.semi_axis_y, SLIP_SAMPLES, retstep=True)
    y = y[1:-1][geometry.across(y[1:-1]) < scales.approach * approach_weight(geometry, y[1:-1])]
    patches = np.split(y, np.flatnonzero(np.diff(y) > 1.5 * step) + 1)
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
LUMPED_BIOT = 10.0
"""hR/k from which the surface of a solid body is cold beside its core of the track: cooling like this takes jets or baths."""
WIDE = 2.0
"""The half-space model needs a body this many times as wide as its contact."""


def turning_bodies_of(derived: DerivedQuantities) -> dict[str, TurningBody]:
    """The bodies that bring heat back, by name, at the creepage that is given (0 where it is to be found)."""
    pairs = zip(BODIES, turning_bodies(derived.problem, derived.problem.motion.creepage_x or 0.0), strict=True)
    return {body: turning for body, turning in pairs if turning is not None}


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
    for body, turning in turning_bodies_of(derived).items():
        part, around = parts[body]
        facts[f"expected_bulk_temperature_{body}_K"] = around + turning.mean_resistance * turning.passes * part * heat
        if turning.convection is not None:
            facts[f"biot_{body}"] = turning.biot
        facts[f"warm_up_time_{body}_s"] = turning.warm_up_time
    return facts


def track_warnings(derived: DerivedQuantities) -> Iterator[str]:
    """Doubts about a fixed partition, a track wider than its body, cooling stronger than a solid body can use."""
    if derived.problem.heating.partition != "matched":
        yield ("recirculated heat changes the partition: with a fixed thermal.partition temperatures can be far off; use "
               '"matched"')
    heating, geometry = derived.problem.heating, derived.problem.geometry
    for cold, warm in (BODIES, BODIES[::-1]):
        alone = getattr(heating, f"{cold}_track") is None and getattr(heating, f"{warm}_track") is not None
        if alone and math.isfinite(getattr(geometry, f"{cold}_radius_x")):
            yield (f"heat returns to the contact on the {warm} body alone: the {cold} body, which turns, too, stays at its "
                   f"bulk temperature and takes most of the heat; set thermal.{cold}.recirculate if it gets warm")
    contact = 2.0 * derived.scales.semi_axis_y
    for body, turning in turning_bodies_of(derived).items():
        track = contact + 4.0 * turning.spreading
        if track > turning.width:
            yield (f"the heated track of the {body} body, {1e3 * track:.3g} mm with what spreads between passes, is wider "
                   f"than the body ({1e3 * turning.width:.3g} mm)")
        elif contact * WIDE > turning.width:
            yield (f"the contact takes {100.0 * contact / turning.width:.0f} % of the width of the {body} body: the half-space "
                   "is a doubtful model of it")
        if turning.biot > LUMPED_BIOT:
            yield (f"the Biot number hR/k of the {body} body is {turning.biot:.3g}: its surface is cooled faster than heat "
                   "flows through it, and the answer depends on where exactly it is cooled")
