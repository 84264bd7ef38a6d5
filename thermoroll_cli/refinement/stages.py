"""Why each stage runs or is skipped: decided before solving, from the problem and a preview on a coarse grid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from thermoroll_cli.heat.frictional_heat import divide
from thermoroll_cli.numerics.solver_options import RefinementOptions
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.discretisation import Discretisation

BULGE_EFFECT = 1.5
"""Reported scalars change by up to 1.3 times the bulge's share of the approach (γ_p of the article's case)."""


def _elastic_coupling(derived: DerivedQuantities, options: RefinementOptions) -> str | None:
    lower, upper = derived.problem.lower, derived.problem.upper
    if derived.feeds_back:
        return ""
    if derived.dissimilar:
        return "no friction: there is no shear to act on the pressure"
    if (lower.youngs_modulus, lower.poisson_ratio) == (upper.youngs_modulus, upper.poisson_ratio):
        return "both bodies have the same elastic constants"
    return "the elastic constants differ, but Dundurs' second constant is zero: pressure and shear do not act on each other"


def _isothermal_normal(derived: DerivedQuantities, options: RefinementOptions) -> str | None:
    if derived.problem.geometry.has_profile:
        return ""
    return None if derived.feeds_back else "smooth bodies without thermal bulge: Hertz's closed form is exact"


def _tangential(derived: DerivedQuantities, options: RefinementOptions) -> str | None:
    if not derived.moves:
        return "no creepage, spin, force or differential slip: everything sticks without traction"
    return "" if derived.problem.friction else "no friction: the surfaces slide freely"


def _other_half(derived: DerivedQuantities, options: RefinementOptions) -> str | None:
    columns = grid_sequence(derived.problem, options)[-1][1]
    if not derived.has_traction or derived.mirror_on(columns, heated=False) is None:
        return None
    sideways = "" if derived.heat_mirrors else ", without heat: with heat the bodies' sideways motion is felt"
    return "the mirror image of y > 0" + sideways


def _differential_slip(derived: DerivedQuantities, options: RefinementOptions) -> str | None:
    return "" if derived.differential_slip.active else derived.differential_slip.why_not


def _heat(derived: DerivedQuantities, options: RefinementOptions) -> str | None:
    if not derived.problem.heating.heat:
        return "switched off or no thermal constants: purely mechanical"
    return "" if derived.has_traction or derived.problem.heating.conducts else "nothing rubs: no frictional heat"


def _partition(derived: DerivedQuantities, options: RefinementOptions) -> str | None:
    if _heat(derived, options) or derived.problem.heating.partition != "matched":
        return None
    share = _even_share(derived, options)
    return "" if share is None else f"both surfaces respond alike: equally warm with a share of {share:g} everywhere"


def _warm_friction(derived: DerivedQuantities, options: RefinementOptions) -> str | None:
    if not derived.problem.friction_slope:
        return None
    return "" if derived.problem.friction_varies and derived.has_traction else "no friction and heat that could change it"


def _deformation(derived: DerivedQuantities, options: RefinementOptions) -> str | None:
    if _heat(derived, options):
        return "no heat"
    if not derived.problem.heating.deformation:
        return "switched off"
    wanted = derived.problem.numerics.wanted_accuracy
    bulge = bulge_bound(derived, options) / derived.scales.approach
    if BULGE_EFFECT * bulge >= wanted:
        return ""
    return f"thermal expansion is about {bulge:.1e} of the approach at most: it changes nothing by more than {wanted:g}"


def _recirculation(derived: DerivedQuantities, options: RefinementOptions) -> str | None:
    heating = derived.problem.heating
    if heating.lower_track is None and heating.upper_track is None:
        return None
    return "no heat" if _heat(derived, options) else ""


def _thermal_crown(derived: DerivedQuantities, options: RefinementOptions) -> str | None:
    if _recirculation(derived, options) != "":
        return None
    if derived.crown_matters:
        return ""
    return f"its curvature is {derived.crown_bound:.1e} of the gap's at most: pressures change by less than that"


STAGES: dict[str, Callable[[DerivedQuantities, RefinementOptions], str | None]] = {
    "elastic coupling": _elastic_coupling,
    "normal (isothermal)": _isothermal_normal,
    "tangential": _tangential,
    "tangential, y < 0": _other_half,
    "differential slip": _differential_slip,
    "heat": _heat,
    "partition": _partition,
    "warm friction": _warm_friction,
    "deformation": _deformation,
    "recirculation": _recirculation,
    "thermal crown": _thermal_crown,
}
"""For each stage why it is skipped: "" where it runs, None where it does not concern the problem."""


def grid_sequence(problem: Problem, options: RefinementOptions | None = None) -> tuple[tuple[int, int], ...]:
    """Grids from coarse to fine, each side doubled (rounded): from about `RefinementOptions.coarsest` elements, from twice as
    many where three grids are left without it."""
    options = options or RefinementOptions()
    wish = problem.numerics.grid or (options.finest_for_accuracy, options.finest_for_accuracy)
    coarsest = options.coarsest if max(wish) < 8 * options.coarsest else 2 * options.coarsest
    grids = [wish]
    while options.sequence and max(grids[0]) >= 2 * coarsest:
        nx, ny = (n if n < 2 * coarsest else (n + 1) // 2 for n in grids[0])
        grids.insert(0, (nx, ny))
    return tuple(grids)


def bulge_bound(derived: DerivedQuantities, options: RefinementOptions | None = None) -> float:
    """Estimate from above of the thermal expansion's variation over the contact in m.

    The whole contact is let slide at its slip without traction, which the elastic slip exceeds only locally, and the
    expansion of that heat is computed on a coarse grid. Prescribed forces leave the creepage open: full sliding needs a few
    times the saturation creepage at most."""
    problem, motion = derived.problem, derived.problem.motion
    discretisation = _preview(derived, options or RefinementOptions())
    rigid = discretisation.driving_slip(discretisation.isothermal_pressure)
    for i, force in enumerate((motion.force_x, motion.force_y)):
        if force is not None:
            rigid[i] += 3.0 * derived.saturation_creepage
    slip = np.hypot(rigid[0], rigid[1])
    flux = problem.highest_friction * discretisation.isothermal_pressure.pressure * slip * motion.speed
    response = discretisation.heat_response((motion.creepage_x or 0.0, motion.creepage_y or 0.0), rigid)
    inside = discretisation.isothermal_pressure.contact
    bulge = divide(replace(problem.heating, bulk_lower=0.0, bulk_upper=0.0), response, flux, inside).expansion()
    if not problem.heating.conducts:
        return float(np.ptp(bulge[inside]))
    # Friction that turns out smaller must not have hidden what conduction does.
    conducted = divide(problem.heating, response, np.zeros(discretisation.grid.shape), inside).expansion()
    return float(np.ptp(bulge[inside]) + np.ptp(conducted[inside]))


def _preview(derived: DerivedQuantities, options: RefinementOptions) -> Discretisation:
    """A grid coarse enough for estimates."""
    return Discretisation(derived, (2 * options.coarsest, 2 * options.coarsest), options.smallest_extent)


def _even_share(derived: DerivedQuantities, options: RefinementOptions) -> float | None:
    """Share of the lower body with which both surfaces get equally warm everywhere; None if that takes a solution."""
    motion = derived.problem.motion
    if derived.problem.heating.conducts:
        return None
    if derived.problem.heating.peclet == "rolling" and (motion.force_x, motion.force_y) != (None, None):
        return None
    discretisation = _preview(derived, options)
    creepage = (motion.creepage_x or 0.0, motion.creepage_y or 0.0)
    return discretisation.heat_response(creepage, np.zeros((2, *discretisation.grid.shape))).matched_share
