"""The size of thermal effects before anything is solved: a contact that slides everywhere, on a coarse grid.

Its pressure is an ellipsoid of the contact's semi-axes and peak pressure: Hertz's where there is one, else about as large as
that of a coarse solution, or larger."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from thermoroll_cli.one_contact.refinement.warnings import LARGEST_RISE, NO_SOLID
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.heated_bodies import HeatResponses
from thermoroll_cli.physics.heat.frictional_heat import divide
from thermoroll_cli.physics.heat.heat_response import ThermalResponse
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.tools.arrays import Array, Mask

SIDE, EXTENT = 16, 2.1
"""Elements per side of that grid, and semi-axes that it covers."""
BULGE_EFFECT = 1.6
"""Reported scalars change by up to 1.46 times the estimated bulge's share of the approach (γ_p of the article's case at little
heat: a contact that slides in part is heated on one side), so that without it the estimate is short of that."""


def deformation_effect(derived: DerivedQuantities) -> float:
    """Bound of the relative change of any scalar by thermal deformation."""
    return BULGE_EFFECT * bulge_bound(derived) / derived.scales.approach


@lru_cache(maxsize=4)
def bulge_bound(derived: DerivedQuantities) -> float:
    """Estimate of the thermal expansion's variation over the contact in m: that of the heat of `_sliding`."""
    heating = derived.problem.heating
    _, response, flux, inside = _sliding(derived)
    bulge = divide(replace(heating, bulk_lower=0.0, bulk_upper=0.0), response, flux, inside).expansion()
    if not heating.conducts:
        return float(np.ptp(bulge[inside]))
    # Friction that turns out smaller must not have hidden what conduction does.
    conducted = divide(heating, response, np.zeros(flux.shape), inside).expansion()
    return float(np.ptp(bulge[inside]) + np.ptp(conducted[inside]))


def expected_temperature_warning(derived: DerivedQuantities) -> list[str]:
    """A doubt about the temperature to be expected, within a factor of about two where creepage rules, too small where spin
    does.

    The heat of `_sliding` is reduced to ξFV with the force F = μW [1 − (1 − ξ/ξ_s)³] of Johnson's creep curve for a circle."""
    if not derived.problem.heating.heat or not derived.kinematics.has_traction:
        return []
    problem, saturation, limit = derived.problem, derived.saturation_creepage, derived.problem.traction_limit
    motion = problem.motion
    creepage = math.hypot(motion.creepage_x or 0.0, motion.creepage_y or 0.0, 0.5 * motion.spin * derived.scales.mean_radius)
    if problem.prescribed_force:
        found = saturation * (1.0 - (1.0 - min(problem.prescribed_force / limit, 1.0)) ** (1.0 / 3.0))
        creepage = math.hypot(creepage, found)
    force = limit * (1.0 - (1.0 - min(creepage / saturation, 1.0)) ** 3)
    grid, response, flux, inside = _sliding(derived)
    if not flux.any():
        return []
    flux *= creepage * force * motion.speed / (float(flux.sum()) * grid.element_area)
    heat = divide(replace(problem.heating, bulk_lower=0.0, bulk_upper=0.0), response, flux, inside)
    rise = float(max(rises.max() for rises in heat.temperatures()))
    if rise <= LARGEST_RISE:
        return []
    return [f"the surfaces are expected to get about {float(f'{rise:.1g}'):g} K hotter: {NO_SOLID}"]


def even_share(derived: DerivedQuantities) -> float | None:
    """Share of the lower body with which both surfaces get equally warm everywhere; None if that takes a solution."""
    motion, heating = derived.problem.motion, derived.problem.heating
    if heating.conducts or (heating.peclet == "rolling" and (motion.force_x, motion.force_y) != (None, None)):
        return None
    grid = derived.grid((SIDE, SIDE), EXTENT)
    return _response(derived, grid, np.zeros((2, *grid.shape))).matched_share


def _sliding(derived: DerivedQuantities) -> tuple[Grid, ThermalResponse, Array, Mask]:
    """A coarse grid, and the thermal response, the heat flux (W/m²) and the elements of a contact that slides everywhere.

    It slides at its slip without traction, which the elastic slip exceeds only locally. Prescribed forces leave the creepage
    open: full sliding needs a few times the saturation creepage at most. The pressure p on unlike bodies adds 2|β|p/E* at most,
    its value in plane strain."""
    problem, motion, scales = derived.problem, derived.problem.motion, derived.scales
    grid = derived.grid((SIDE, SIDE), EXTENT)
    x, y = (grid.x[:, None] - scales.centre_x) / scales.semi_axis_x, (grid.y - scales.centre) / scales.semi_axis_y
    pressure = scales.peak_pressure * np.sqrt(np.maximum(1.0 - x**2 - y**2, 0.0))
    rigid = derived.kinematics.rigid_slip(grid)
    for i, force in enumerate((motion.force_x, motion.force_y)):
        if force is not None:
            rigid[i] += 3.0 * derived.saturation_creepage
    slip = np.hypot(*rigid) + 2.0 * abs(derived.dundurs_beta) * pressure / problem.contact_modulus
    return grid, _response(derived, grid, rigid), problem.friction.highest * pressure * slip * motion.speed, pressure > 0.0


def _response(derived: DerivedQuantities, grid: Grid, slip: Array) -> ThermalResponse:
    motion = derived.problem.motion
    return HeatResponses(grid).response(derived, (motion.creepage_x or 0.0, motion.creepage_y or 0.0), slip)
