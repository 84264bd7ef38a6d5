"""Decided before the grids are solved: which stages run or are skipped and why, on which grids, at what cost.

The size of thermal effects comes from a preview: a contact that slides everywhere, on a grid of 16 by 16 elements.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.heat.frictional_heat import divide
from thermoroll_cli.heat.heat_response import ThermalResponse
from thermoroll_cli.problem.problem import Problem, SubsurfaceRequest
from thermoroll_cli.refinement.subsurface_plan import subsurface_plan
from thermoroll_cli.refinement.warnings import LARGEST_RISE, NO_SOLID, relaxation_facts, track_facts, warnings_before
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.discretisation import Discretisation
from thermoroll_cli.steady_state.heated_bodies import crown_bound, crown_matters, peclet_numbers
from thermoroll_cli.steady_state.solvable import check
from thermoroll_cli.steady_state.traction import check_yield

COARSEST = 8
"""Elements per side of the coarsest grid, twice as many where three grids are left without it: the Hertz contact is 7 wide,
enough for a first guess. With 16, estimates on 32² elements come from two grids and are twice as wide (28 random cases)."""
FINEST_FOR_ACCURACY = 512
"""Largest grid where an accuracy is asked for: the next one takes more than 2 GB."""
SMALLEST_EXTENT = 2.1
"""The Hertz contact spans 2 semi-axes; a domain must leave a little room around it. Without: 24 of 40
random cases with an extent of 1.2 to 2.05 lose a part of their load."""

BULGE_EFFECT = 1.5
"""Reported scalars change by up to 1.3 times the bulge's share of the approach (γ_p of the article's case), so
that without it the estimate is short of that."""


def stages(derived: DerivedQuantities) -> dict[str, str | None]:
    """For each stage why it is skipped: "" where it runs, None where it does not concern the problem."""
    problem, kinematics, cold = derived.problem, derived.kinematics, _cold(derived)
    heating, hertzian = problem.heating, problem.has_hertz_solution and not kinematics.feeds_back
    mirrored = kinematics.has_traction and kinematics.mirror_on(grid_sequence(problem)[-1][1], heated=False) is not None
    sideways = "" if kinematics.heat_mirrors else ", without heat: with heat the bodies' sideways motion is felt"
    tracks = heating.lower_track is not None or heating.upper_track is not None
    return {
        "elastic coupling": "" if kinematics.feeds_back else _uncoupled(derived),
        "normal (isothermal)": "smooth bodies without thermal bulge: Hertz's closed form is exact" if hertzian
        else None if problem.has_hertz_solution else "",
        "tangential": "no creepage, spin, force or differential slip: everything sticks without traction"
        if not kinematics.moves else "" if problem.friction.coefficient else "no friction: the surfaces slide freely",
        "tangential, y < 0": "the mirror image of y > 0" + sideways if mirrored else None,
        "differential slip": "" if kinematics.differential_slip.active else kinematics.differential_slip.why_not,
        "heat": cold,
        "partition": None if cold or heating.partition != "matched" else _even_partition(derived),
        "warm friction": None if not problem.friction.slope
        else "" if problem.friction_varies and kinematics.has_traction else "no friction and heat that could change it",
        "deformation": _deformation(derived),
        "recirculation": None if not tracks else "no heat" if cold else "",
        "thermal crown": None if not tracks or cold else "" if crown_matters(derived)
        else f"its curvature is {crown_bound(derived):.1e} of the gap's at most: pressures change by less than that",
        "wear": None if problem.wear is None else "" if kinematics.moves else "nothing slips",
    }


def _uncoupled(derived: DerivedQuantities) -> str:
    lower, upper = derived.problem.lower, derived.problem.upper
    if derived.dissimilar:
        return "no friction: there is no shear to act on the pressure"
    if (lower.youngs_modulus, lower.poisson_ratio) == (upper.youngs_modulus, upper.poisson_ratio):
        return "both bodies have the same elastic constants"
    return "the elastic constants differ, but Dundurs' second constant is zero: pressure and shear do not act on each other"


def _cold(derived: DerivedQuantities) -> str:
    """Why there is no heat; empty where there is."""
    if not derived.problem.heating.heat:
        return "switched off or no thermal constants: purely mechanical"
    return "" if derived.kinematics.has_traction or derived.problem.heating.conducts else "nothing rubs: no frictional heat"


def _even_partition(derived: DerivedQuantities) -> str:
    share = _even_share(derived)
    return "" if share is None else f"both surfaces respond alike: equally warm with a share of {share:g} everywhere"


def _deformation(derived: DerivedQuantities) -> str:
    """Why thermal deformation is left out; empty where it is not."""
    if _cold(derived):
        return "no heat"
    if not derived.problem.heating.deformation:
        return "switched off"
    if derived.problem.heating.deformation == "always":
        return ""
    bodies = derived.problem.lower, derived.problem.upper
    if not any(body.expansion or any(layer.expansion for layer in body.layers) for body in bodies):
        return "the bodies do not expand"
    negligible, effect = derived.problem.numerics.negligible, deformation_effect(derived)
    return "" if effect >= negligible else (
        f"thermal expansion changes scalars by less than {effect:.1e}, which is below {negligible:g}: left out")


def leaves_out_deformation(problem: Problem) -> bool | None:
    """Whether thermal deformation is left out because its effect is small; None where nothing is to be decided."""
    derived = DerivedQuantities(problem)
    if problem.heating.deformation is not True or _cold(derived):
        return None
    return bool(_deformation(derived))


def grid_sequence(problem: Problem, *, alone: bool = False) -> tuple[tuple[int, int], ...]:
    """Grids from coarse to fine, each side doubled (rounded): from about `COARSEST` elements, from twice as
    many if three grids are left without it. If the shorter side cannot be halved again, the longer one is halved alone: such
    grids give starts, and only those from `first_of_both` on give error estimates."""
    wish = problem.numerics.grid or (FINEST_FOR_ACCURACY, FINEST_FOR_ACCURACY)
    coarsest = COARSEST if min(wish) < 8 * COARSEST else 2 * COARSEST
    grids = [wish]
    while not alone and max(grids[0]) >= 2 * coarsest:
        nx, ny = (n if n < 2 * coarsest else (n + 1) // 2 for n in grids[0])
        grids.insert(0, (nx, ny))
    return tuple(grids)


def first_of_both(grids: Sequence[tuple[int, int]]) -> int:
    """Index of the first of `grids` (coarse to fine) from which on every grid refines both sides of the one before."""
    first = len(grids) - 1
    while first > 0 and all(coarse < fine for coarse, fine in zip(grids[first - 1], grids[first], strict=True)):
        first -= 1
    return first


def deformation_effect(derived: DerivedQuantities) -> float:
    """Bound of the relative change of any scalar by thermal deformation."""
    return BULGE_EFFECT * bulge_bound(derived) / derived.scales.approach


@lru_cache(maxsize=4)
def bulge_bound(derived: DerivedQuantities) -> float:
    """Estimate from above of the thermal expansion's variation over the contact in m: that of the heat of `_sliding`."""
    heating = derived.problem.heating
    discretisation, response, flux = _sliding(derived)
    inside = discretisation.isothermal_pressure.contact
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
    if _cold(derived) or not derived.kinematics.has_traction:
        return []
    problem, saturation, limit = derived.problem, derived.saturation_creepage, derived.problem.traction_limit
    motion = problem.motion
    creepage = math.hypot(motion.creepage_x or 0.0, motion.creepage_y or 0.0, 0.5 * motion.spin * derived.scales.mean_radius)
    if problem.prescribed_force:
        found = saturation * (1.0 - (1.0 - min(problem.prescribed_force / limit, 1.0)) ** (1.0 / 3.0))
        creepage = math.hypot(creepage, found)
    force = limit * (1.0 - (1.0 - min(creepage / saturation, 1.0)) ** 3)
    discretisation, response, flux = _sliding(derived)
    if not flux.any():
        return []
    flux *= creepage * force * motion.speed / (float(flux.sum()) * discretisation.grid.element_area)
    heating = replace(problem.heating, bulk_lower=0.0, bulk_upper=0.0)
    heat = divide(heating, response, flux, discretisation.isothermal_pressure.contact)
    rise = float(max(rises.max() for rises in heat.temperatures()))
    if rise <= LARGEST_RISE:
        return []
    return [f"the surfaces are expected to get about {float(f'{rise:.1g}'):g} K hotter: {NO_SOLID}"]


def _sliding(derived: DerivedQuantities) -> tuple[Discretisation, ThermalResponse, Array]:
    """A coarse grid, and the thermal response and the heat flux (W/m²) of a contact that slides everywhere.

    It slides at its slip without traction, which the elastic slip exceeds only locally. Prescribed forces leave the creepage
    open: full sliding needs a few times the saturation creepage at most."""
    problem, motion = derived.problem, derived.problem.motion
    discretisation = _preview(derived)
    normal = discretisation.isothermal_pressure
    rigid = discretisation.driving_slip(normal)
    for i, force in enumerate((motion.force_x, motion.force_y)):
        if force is not None:
            rigid[i] += 3.0 * derived.saturation_creepage
    flux = problem.friction.highest * normal.pressure * np.hypot(rigid[0], rigid[1]) * motion.speed
    creepage = motion.creepage_x or 0.0, motion.creepage_y or 0.0
    return discretisation, discretisation.heat_response(creepage, rigid), flux


def _preview(derived: DerivedQuantities) -> Discretisation:
    """A grid coarse enough for estimates."""
    return Discretisation(derived, (2 * COARSEST, 2 * COARSEST), SMALLEST_EXTENT)


def _even_share(derived: DerivedQuantities) -> float | None:
    """Share of the lower body with which both surfaces get equally warm everywhere; None if that takes a solution."""
    motion = derived.problem.motion
    if derived.problem.heating.conducts:
        return None
    if derived.problem.heating.peclet == "rolling" and (motion.force_x, motion.force_y) != (None, None):
        return None
    discretisation = _preview(derived)
    creepage = (motion.creepage_x or 0.0, motion.creepage_y or 0.0)
    return discretisation.heat_response(creepage, np.zeros((2, *discretisation.grid.shape))).matched_share


@dataclass(frozen=True)
class Plan:
    """`derived` quantities of the problem; `grids` from coarse to fine; `run` and `skipped` name stages, the latter with
    reasons; `facts` are numbers known before solving; `left_out` are stages that are skipped because their effect is small,
    each with the bound of the relative change of any scalar by it; `memory_bytes` and `seconds` are estimates for the finest
    grid."""

    derived: DerivedQuantities
    grids: tuple[tuple[int, int], ...]
    extent: float
    run: list[str]
    skipped: dict[str, str]
    warnings: list[str]
    facts: dict[str, float] = field(default_factory=dict)
    memory_bytes: int = 0
    seconds: float = 0.0
    left_out: dict[str, float] = field(default_factory=dict)

    @property
    def grid(self) -> tuple[int, int]:
        """The finest grid (the largest allowed one where an accuracy is asked for)."""
        return self.grids[-1]

    @property
    def steps(self) -> list[tuple[str, tuple[int, int]]]:
        """Stages on grids in the order in which `solve` reports them (fewer where an accuracy is reached earlier)."""
        stages = ("tangential", "coupling") if self.runs("deformation") else ("tangential",)
        return [(stage, grid) for grid in self.grids for stage in stages]

    def runs(self, stage: str) -> bool:
        return stage in self.run

    @property
    def hertzian(self) -> bool:
        """Whether the pressure is Hertz's in every state."""
        return "normal (isothermal)" in self.skipped and not self.runs("deformation")


def make_plan(problem: Problem, *, alone: bool = False) -> Plan:
    """Plan of a problem. Raises Unsolvable for the reasons of `solvable`, and where a prescribed force is above what a yielding
    interlayer carries."""
    derived = DerivedQuantities(problem)
    check(derived)
    grids = grid_sequence(problem, alone=alone)
    reasons = stages(derived)
    run = [stage for stage, reason in reasons.items() if reason == ""]
    skipped = {stage: reason for stage, reason in reasons.items() if reason}
    warnings = []
    extent = problem.numerics.extent
    if extent < SMALLEST_EXTENT:
        warnings.append(f"numerics.extent = {extent:g} is smaller than the contact: grown to {SMALLEST_EXTENT:g}")
        extent = SMALLEST_EXTENT
    warnings += warnings_before(derived)
    plan = Plan(derived, grids, extent, run, skipped, warnings, _facts(derived), *_cost(grids[-1], run, derived),
                _left_out(derived, skipped))
    if plan.hertzian and problem.interlayer.yield_stress is not None:
        # ∬ min(μp, τ_c) below Hertz's pressure; other pressures are known only when they are solved (`checks`).
        share = min(1.0, problem.interlayer.yield_stress / (problem.friction.coefficient * derived.scales.peak_pressure))
        check_yield(problem, 0.5 * (3.0 * share - share**3) * problem.traction_limit)
    return plan if problem.subsurface is None else _with_subsurface(plan, problem.subsurface, derived)


def _left_out(derived: DerivedQuantities, skipped: Mapping[str, str]) -> dict[str, float]:
    """Bound of the effect of each stage that could change a scalar but is left out."""
    heating, bounds = derived.problem.heating, {"differential slip": derived.kinematics.differential_slip.left_out}
    if heating.deformation and _deformation(derived) and not _cold(derived):
        bounds["deformation"] = deformation_effect(derived)
    elif heating.deformation and skipped.get("thermal crown"):
        bounds["thermal crown"] = crown_bound(derived)
    return {stage: bound for stage, bound in bounds.items() if bound > 0.0}


def _with_subsurface(plan: Plan, request: SubsurfaceRequest, derived: DerivedQuantities) -> Plan:
    """`plan` with the stage below the surface."""
    below = subsurface_plan(request, derived, plan.grid, heated=plan.runs("heat"))
    return replace(plan, run=plan.run + below.run, skipped=plan.skipped | below.skipped, facts=plan.facts | below.facts,
                   memory_bytes=plan.memory_bytes + below.memory_bytes, seconds=plan.seconds + below.seconds)


def _facts(derived: DerivedQuantities) -> dict[str, float]:
    scales, problem = derived.scales, derived.problem
    if not problem.has_hertz_solution:
        # From the coarse solution that the domain follows from.
        size = {"contact_length_mm": 2e3 * scales.semi_axis_x, "contact_width_mm": 2e3 * scales.semi_axis_y,
                "contact_centre_mm": 1e3 * scales.centre, "contact_pressure_MPa": scales.peak_pressure * 1e-6}
    else:
        size = {"hertz_a_mm": scales.semi_axis_x * 1e3, "hertz_b_mm": scales.semi_axis_y * 1e3,
                "hertz_p0_MPa": scales.peak_pressure * 1e-6}
    low, high = derived.contact_angles
    return size | {
        "approach_um": scales.approach * 1e6,
        **({"contact_angle_low_mrad": 1e3 * low, "contact_angle_high_mrad": 1e3 * high} if high > low else {}),
        **dict(zip(("peclet_lower", "peclet_upper"), peclet_numbers(derived), strict=True)),
        "friction_limit_N": problem.traction_limit,
        "saturation_creepage": derived.saturation_creepage,
        "dundurs_beta": derived.dundurs_beta,
    } | (track_facts(derived) if problem.heating.recirculates else {}) | (relaxation_facts(derived) if problem.relaxes else {})


def _cost(shape: tuple[int, int], run: list[str], derived: DerivedQuantities) -> tuple[int, float]:
    """Rough memory (bytes) and time (s, one core): counts of padded fields and transforms times their size.

    Counts are those of the article's cases; 0.4 ns per element and log₂ is what a transform was measured to take on one core.
    """
    padded = 4 * shape[0] * shape[1]
    # Kernels, spectra and work fields of each solver.
    fields = 12 + (45 if "tangential" in run else 0) + (12 if "heat" in run else 0) + (8 if "elastic coupling" in run else 0)
    # A coupled state costs about three isothermal ones, whose tractions take some 70 applications of 4 transforms each.
    solves = (4 if "deformation" in run else 1) + ("elastic coupling" in run)
    rolling = 140 if derived.kinematics.mirror_on(shape[1], heated=False) is not None else 280
    transforms = 10 + (rolling if "tangential" in run else 0) * solves
    # The planes of layers that relax are a few times as large.
    fields += 150 if derived.relaxing is not None and derived.coatings is not None else 0
    return 8 * padded * fields, 0.1 + transforms * padded * math.log2(padded) * 4e-10
