"""What is allowed and yet hardly meant: constants no solid has, pressures and temperatures none stands, keys without effect."""

from __future__ import annotations

import math
from collections.abc import Iterator

from thermoroll_cli.problem.problem import Material, Problem
from thermoroll_cli.steady_state.derived import DerivedQuantities

PRESSURE_OVER_MODULUS = 0.01
"""Part of Young's modulus up to which bodies answer linearly; metals yield below it."""
LARGEST_PRESSURE = 10e9
"""Pa. Diamond and ceramics fail at about this much; steel yields at a third of it."""
LARGEST_RISE = 2000.0
"""K. Steel melts at 1500 °C, and no constant stays one that far."""

SOLIDS = {
    "youngs_modulus": ("Young's modulus", 1e9, "GPa", 1e-4, 1.3e3),
    "conductivity": ("thermal conductivity", 1.0, "W/(m K)", 0.01, 3e3),
    "expansion": ("thermal expansion", 1e-6, "1e-6/K", 0.01, 1e3),
    "diffusivity": ("thermal diffusivity", 1e-6, "mm²/s", 0.01, 3e3),
}
"""Name, unit in SI, and range in that unit of each constant: from soft rubber, aerogel, invar and polymers to diamond, with
room. A value outside is a mistaken unit rather than a material."""
HEAT_CAPACITIES = 1e5, 1e7
"""J/(m³ K). Conductivity over diffusivity: of dense solids between 0.9e6 and 4.5e6."""

PEAK_OVER_MEAN = 1.5
"""The hottest point over what the mean heat flux makes of it: 1.4 to 1.6 where the contact rolls with creepage."""


def plausibility_warnings(derived: DerivedQuantities) -> list[str]:
    """Doubts about a problem that need no solution."""
    return [*_constants(derived.problem), *_pressure(derived), *_without_effect(derived.problem)]


def expected_temperature_warning(derived: DerivedQuantities) -> list[str]:
    """A doubt about the temperature to be expected, from the estimate `expected_rise`."""
    rise = expected_rise(derived)
    if not rise > LARGEST_RISE:
        return []
    return [f"the surfaces are expected to get about {_round(rise)} K hotter: {_no_solid()}"]


def temperature_warning(rise: float) -> list[str]:
    """A doubt about the largest temperature `rise` (K) that a solution has."""
    return [f"temperature rises by up to {rise:.4g} K: {_no_solid()}"] if rise > LARGEST_RISE else []


def expected_rise(derived: DerivedQuantities) -> float:
    """Largest temperature rise in K, within a factor of about two where creepage rules, too small where spin does.

    Johnson's creep curve F = μW [1 − (1 − ξ/ξ_s)³] of a circular contact gives the frictional heat ξFV, spread over the Hertz
    ellipse; its temperature is the smaller of that of a resting source, q c/k, and that of material that passes in the time
    2a0/V, 2 (q/k) sqrt(2 a0 κ/(π V)) (Carslaw and Jaeger, 2.9), joined harmonically.
    """
    problem, hertz = derived.problem, derived.scales
    if not (problem.heating.heat and derived.has_traction):
        return 0.0
    saturation, limit, motion = derived.saturation_creepage, problem.traction_limit, problem.motion
    creepage = math.hypot(motion.creepage_x or 0.0, motion.creepage_y or 0.0, 0.5 * motion.spin * hertz.mean_radius)
    if problem.prescribed_force:
        found = saturation * (1.0 - (1.0 - min(problem.prescribed_force / limit, 1.0)) ** (1.0 / 3.0))
        creepage = math.hypot(creepage, found)
    force = limit * (1.0 - (1.0 - min(creepage / saturation, 1.0)) ** 3)
    flux = creepage * force * motion.speed / hertz.area
    lower, upper = (_rise_by(flux, body, derived) for body in (problem.lower, problem.upper))
    if problem.heating.partition == "matched":
        return PEAK_OVER_MEAN / (1.0 / lower + 1.0 / upper) if lower and upper else 0.0
    return PEAK_OVER_MEAN * max(problem.heating.partition * lower, (1.0 - problem.heating.partition) * upper)


def _rise_by(flux: float, body: Material, derived: DerivedQuantities) -> float:
    """Temperature of a body that takes all of a mean `flux` (W/m²), in K."""
    assert body.conductivity is not None and body.diffusivity is not None
    resting = flux * derived.scales.mean_radius / body.conductivity
    if derived.problem.heating.peclet != "rolling":
        return resting
    time = 2.0 * derived.scales.semi_axis_x / derived.problem.motion.speed
    passing = 2.0 * flux / body.conductivity * math.sqrt(body.diffusivity * time / math.pi)
    return resting * passing / (resting + passing) if flux else 0.0


def _constants(problem: Problem) -> Iterator[str]:
    for material, whose in _bodies(problem):
        for attribute, (name, unit, unit_name, smallest, largest) in SOLIDS.items():
            value = getattr(material, attribute)
            if value is not None and not smallest <= value / unit <= largest:
                yield (f"{name} of {whose} is {value / unit:.4g} {unit_name}: that of solids lies between {smallest:g} and "
                       f"{largest:g}; a mistaken unit?")
        if material.conductivity is not None and material.diffusivity is not None:
            capacity = material.conductivity / material.diffusivity
            if not HEAT_CAPACITIES[0] <= capacity <= HEAT_CAPACITIES[1]:
                yield (f"conductivity over diffusivity of {whose} is {capacity:.2g} J/(m³ K): the heat capacity of solids lies "
                       f"between {HEAT_CAPACITIES[0]:.0e} and {HEAT_CAPACITIES[1]:.0e}; a mistaken unit?")


def _bodies(problem: Problem) -> Iterator[tuple[Material, str]]:
    if problem.lower == problem.upper:
        yield problem.lower, "both bodies"
    else:
        yield problem.lower, "the lower body"
        yield problem.upper, "the upper body"


def _pressure(derived: DerivedQuantities) -> Iterator[str]:
    pressure = derived.scales.peak_pressure
    modulus = min(derived.problem.lower.youngs_modulus, derived.problem.upper.youngs_modulus)
    if pressure > LARGEST_PRESSURE:
        yield f"the pressure is {pressure * 1e-9:.3g} GPa: beyond {LARGEST_PRESSURE * 1e-9:g} GPa no solid stays elastic"
    elif pressure > PRESSURE_OVER_MODULUS * modulus:
        yield (f"the pressure of {pressure * 1e-6:.4g} MPa is {100 * pressure / modulus:.2g} % of Young's modulus: beyond "
               f"{100 * PRESSURE_OVER_MODULUS:g} % the bodies are hardly linear and elastic")


def _without_effect(problem: Problem) -> Iterator[str]:
    heating, slope = problem.heating, problem.friction_slope
    if not heating.heat:
        if slope:
            yield "friction that changes with temperature has no effect: heat is off"
        if heating.bulk_lower or heating.bulk_upper:
            yield "bulk temperatures have no effect: heat is off"
        if heating.lower_track is not None or heating.upper_track is not None:
            yield "bodies that bring heat back have no effect: heat is off"
    # Defaults of the dataclass: what differs from them was meant to matter.
    if problem.friction_start != Problem.friction_start and not slope:
        yield "the temperature from which friction changes has no effect: friction_temperature_slope_1_K is 0"
    if problem.friction_minimum != Problem.friction_minimum and not slope > 0.0:
        yield "friction_minimum_factor has no effect: friction does not fall with temperature"
    if problem.friction_maximum != Problem.friction_maximum and not slope < 0.0:
        yield "friction_maximum_factor has no effect: friction does not rise with temperature"


def _no_solid() -> str:
    return f"no solid stands {LARGEST_RISE:g} K with these constants"


def _round(value: float) -> str:
    return f"{value:.1g}" if value >= 1e5 else f"{float(f'{value:.1g}'):.0f}"
