"""Decided before the grids are solved: which stages run or are skipped and why, on which grids, at what cost."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

from thermoroll_cli.one_contact.refinement.expected_heat import deformation_effect, even_share
from thermoroll_cli.one_contact.refinement.subsurface_plan import subsurface_plan
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities, derived_of
from thermoroll_cli.one_contact.steady_state.doubts import relaxation_facts, track_facts, warnings_before
from thermoroll_cli.one_contact.steady_state.heated_bodies import crown_bound, crown_matters, peclet_numbers
from thermoroll_cli.one_contact.steady_state.solvable import check
from thermoroll_cli.one_contact.steady_state.traction import check_yield
from thermoroll_cli.problem.kinds import InWords
from thermoroll_cli.problem.names import per_length
from thermoroll_cli.problem.problem import Numerics, Problem

COARSEST = 6
"""Elements per side of the coarsest grid, twice as many where three grids are left without it: the Hertz contact is 5 wide,
enough for a first guess. With 8, estimates on 24² elements come from two grids and are twice as wide (30 random contacts: 12
times the true errors in the middle, in place of 6)."""
FINEST_FOR_ACCURACY = 512
"""Largest grid where an accuracy is asked for: the next one takes more than 2 GB."""
FINEST_LINE = 4096
"""The same of a line contact, in elements along rolling."""
SMALLEST_EXTENT = 2.1
"""The Hertz contact spans 2 semi-axes; a domain must leave a little room around it. Without: 24 of 40
random cases with an extent of 1.2 to 2.05 lose a part of their load."""


def stages(derived: DerivedQuantities) -> dict[str, str | None]:
    """For each stage why it is skipped: "" where it runs, None where it does not concern the problem."""
    return {stage: reason(derived) for stage, reason in STAGES.items()}


def _elastic_coupling(derived: DerivedQuantities) -> str:
    lower, upper = derived.problem.lower, derived.problem.upper
    if derived.kinematics.feeds_back:
        return ""
    if derived.dissimilar:
        return "no friction: there is no shear to act on the pressure"
    if (lower.youngs_modulus, lower.poisson_ratio) == (upper.youngs_modulus, upper.poisson_ratio):
        return "both bodies have the same elastic constants"
    return "the elastic constants differ, but Dundurs' second constant is zero: pressure and shear do not act on each other"


def _isothermal_pressure(derived: DerivedQuantities) -> str | None:
    if derived.hertz is None:
        return ""
    return None if derived.kinematics.feeds_back else "smooth bodies without thermal bulge: Hertz's closed form is exact"


def _tangential(derived: DerivedQuantities) -> str:
    if not derived.kinematics.moves:
        return "no creepage, spin, force or differential slip: everything sticks without traction"
    return "" if derived.problem.friction.coefficient else "no friction: the surfaces slide freely"


def _other_side(derived: DerivedQuantities) -> str | None:
    kinematics = derived.kinematics
    if not kinematics.has_traction or kinematics.mirror_on(grid_sequence(derived.problem)[-1][1], heated=False) is None:
        return None
    sideways = "" if kinematics.heat_mirrors else ", without heat: with heat the bodies' sideways motion is felt"
    return "the mirror image of y > 0" + sideways


def _differential_slip(derived: DerivedQuantities) -> str | None:
    slip = derived.kinematics.differential_slip
    return "" if slip.active else slip.why_not


def _heat(derived: DerivedQuantities) -> str:
    if not derived.problem.heating.heat:
        return "switched off or no thermal constants: purely mechanical"
    return "" if derived.kinematics.has_traction or derived.problem.heating.conducts else "nothing rubs: no frictional heat"


def _partition(derived: DerivedQuantities) -> str | None:
    if _heat(derived) or derived.problem.heating.partition != "matched":
        return None
    share = even_share(derived)
    return "" if share is None else f"both surfaces respond alike: equally warm with a share of {share:g} everywhere"


def _warm_friction(derived: DerivedQuantities) -> str | None:
    if not derived.problem.friction.slope:
        return None
    varies = derived.problem.friction_varies and derived.kinematics.has_traction
    return "" if varies else "no friction and heat that could change it"


def _deformation(derived: DerivedQuantities) -> str:
    problem = derived.problem
    if _heat(derived):
        return "no heat"
    if not problem.heating.deformation:
        return "switched off"
    if problem.heating.deformation == "always":
        return ""
    bodies = problem.lower, problem.upper
    if not any(body.expansion or any(layer.expansion for layer in body.layers) for body in bodies):
        return "the bodies do not expand"
    negligible, effect = problem.numerics.negligible, deformation_effect(derived)
    return "" if effect >= negligible else (
        f"thermal expansion changes scalars by less than {effect:.1e}, which is below {negligible:g}: left out")


def _recirculation(derived: DerivedQuantities) -> str | None:
    heating = derived.problem.heating
    if heating.lower_track is None and heating.upper_track is None:
        return None
    return "no heat" if _heat(derived) else ""


def _thermal_crown(derived: DerivedQuantities) -> str | None:
    if _recirculation(derived) != "":
        return None
    return "" if crown_matters(derived) else (
        f"its curvature is {crown_bound(derived):.1e} of the gap's at most: pressures change by less than that")


def _wear(derived: DerivedQuantities) -> str | None:
    if derived.problem.wear is None:
        return None
    return "" if derived.kinematics.moves else "nothing slips"


STAGES: dict[str, Callable[[DerivedQuantities], str | None]] = {
    "elastic coupling": _elastic_coupling,
    "normal (isothermal)": _isothermal_pressure,
    "tangential": _tangential,
    "tangential, y < 0": _other_side,
    "differential slip": _differential_slip,
    "heat": _heat,
    "partition": _partition,
    "warm friction": _warm_friction,
    "deformation": _deformation,
    "recirculation": _recirculation,
    "thermal crown": _thermal_crown,
    "wear": _wear,
}
"""Stages above the surface, each with the reason why it is skipped (see `stages`)."""


def leaves_out_deformation(problem: Problem) -> bool | None:
    """Whether thermal deformation is left out because its effect is small; None where nothing is to be decided."""
    derived = derived_of(problem)
    if problem.heating.deformation is not True or _heat(derived):
        return None
    return bool(_deformation(derived))


def grid_sequence(problem: Problem, *, alone: bool = False) -> tuple[tuple[int, int], ...]:
    """Grids from coarse to fine, each side doubled (rounded): from about `COARSEST` elements, from twice as
    many if three grids are left without it; of a line contact whose grid is given the last three. If the shorter side cannot be
    halved again, the longer one is halved alone: such grids give starts, and only those from `first_of_both` on give error
    estimates."""
    wish = problem.numerics.grid or (FINEST_FOR_ACCURACY, FINEST_FOR_ACCURACY)
    if problem.line:
        wish = (problem.numerics.grid or (FINEST_LINE, 1))[0], 1
    coarsest = COARSEST if min(n for n in wish if n > 1) < 8 * COARSEST else 2 * COARSEST
    grids = [wish]
    # The time of a line contact is that of its calls, the same on every grid: those of the estimates are enough.
    most = 3 if problem.line and problem.numerics.grid else math.inf
    while not alone and max(grids[0]) >= 2 * coarsest and len(grids) < most:
        nx, ny = (n if n < 2 * coarsest else (n + 1) // 2 for n in grids[0])
        grids.insert(0, (nx, ny))
    return tuple(grids)


def first_of_both(grids: Sequence[tuple[int, int]]) -> int:
    """Index of the first of `grids` (coarse to fine) from which on every grid refines both sides of the one before."""
    first = len(grids) - 1
    while first > 0 and all(coarse < fine or fine == 1 for coarse, fine in zip(grids[first - 1], grids[first], strict=True)):
        first -= 1
    return first

LARGEST_EXTENT, GROWTH = 12.0, 1.25
"""Domain in semi-axes beyond which it grows no more, and the factor by which it does when the contact reaches its rim."""
REACHED_RIM = "the contact reached the rim of the domain: extent grown to "


def extent_of(numerics: Numerics) -> tuple[float, list[str]]:
    """The domain in semi-axes to begin with, and a warning if it is not the one that is asked for."""
    if numerics.extent >= SMALLEST_EXTENT:
        return numerics.extent, []
    return SMALLEST_EXTENT, [f"numerics.extent = {numerics.extent:g} is smaller than the contact: grown to {SMALLEST_EXTENT:g}"]


def may_grow(extent: float) -> bool:
    """Whether a domain whose rim the contact reaches grows."""
    return extent <= LARGEST_EXTENT


def grown(extent: float, warnings: Iterable[str]) -> tuple[float, list[str]]:
    """The next larger domain, and the `warnings` with one that says so."""
    extent *= GROWTH
    return extent, [*(warning for warning in warnings if not warning.startswith(REACHED_RIM)), f"{REACHED_RIM}{extent:g}"]


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
    def sides(self) -> tuple[int, ...]:
        """`grid`, of a line contact its elements along rolling."""
        return self.grid[:1] if self.derived.problem.line else self.grid

    @property
    def steps(self) -> list[tuple[str, tuple[int, ...]]]:
        """Stages on grids in the order in which `solve` reports them (fewer where an accuracy is reached earlier)."""
        stages = ("tangential", "coupling") if self.runs("deformation") else ("tangential",)
        return [(stage, grid[: len(self.sides)]) for grid in self.grids for stage in stages]

    @property
    def in_words(self) -> InWords:
        stages = [(name, "runs", "") for name in self.run] + [(name, "skipped:", why) for name, why in self.skipped.items()]
        return InWords(stages, [f"grid {'×'.join(map(str, self.sides))}"], (),
                       {"run": self.run, "skipped": self.skipped, "grid": self.sides}, 2 if self.runs("heat") else 0)

    @property
    def widest(self) -> bool:
        return not may_grow(self.extent)

    def wider(self) -> Plan:
        """The same on a larger domain, with a warning."""
        extent, warnings = grown(self.extent, self.warnings)
        return replace(self, extent=extent, warnings=warnings)

    def runs(self, stage: str) -> bool:
        return stage in self.run

    @property
    def hertzian(self) -> bool:
        """Whether the pressure is Hertz's in every state."""
        return "normal (isothermal)" in self.skipped and not self.runs("deformation")


def make_plan(problem: Problem, *, alone: bool = False) -> Plan:
    """Plan of a problem. Raises Unsolvable for the reasons of `solvable`, and where a prescribed force is above what a yielding
    interlayer carries."""
    derived = derived_of(problem)
    check(derived)
    grids = grid_sequence(problem, alone=alone)
    reasons = stages(derived)
    run = [stage for stage, reason in reasons.items() if reason == ""]
    skipped = {stage: reason for stage, reason in reasons.items() if reason}
    extent, warnings = extent_of(problem.numerics)
    warnings += warnings_before(derived)
    # Bounds of the effects of stages that could change a scalar and are left out.
    bounds, deformation = {"differential slip": derived.kinematics.differential_slip.left_out}, problem.heating.deformation
    if deformation and _deformation(derived) and not _heat(derived):
        bounds["deformation"] = deformation_effect(derived)
    elif deformation and skipped.get("thermal crown"):
        bounds["thermal crown"] = crown_bound(derived)
    plan = Plan(derived, grids, extent, run, skipped, warnings, _facts(derived), *_cost(grids[-1], run, derived),
                {stage: bound for stage, bound in bounds.items() if bound > 0.0})
    if plan.hertzian and problem.interlayer.most is not None:
        # Other pressures are known only when they are solved (`checks`).
        share = min(1.0, problem.interlayer.most / (problem.friction.coefficient * derived.scales.peak_pressure))
        check_yield(problem, share_below(share, line=problem.line) * problem.traction_limit)
    if problem.subsurface is None:
        return plan
    run, left_out, facts, memory, seconds = subsurface_plan(problem.subsurface, derived, plan.grid, heated=plan.runs("heat"))
    return replace(plan, run=plan.run + run, skipped=plan.skipped | left_out, facts=plan.facts | facts,
                   memory_bytes=plan.memory_bytes + memory, seconds=plan.seconds + seconds)


def share_below(limit: float, *, line: bool) -> float:
    """∬ min(p, p₀ `limit`) over ∬ p of Hertz's pressure, of an ellipse or of a `line` contact; `limit` from 0 to 1."""
    if line:
        return 2.0 / math.pi * (limit * math.sqrt(1.0 - limit**2) + math.asin(limit))
    return 0.5 * (3.0 * limit - limit**3)


def _facts(derived: DerivedQuantities) -> dict[str, float]:
    scales, problem = derived.scales, derived.problem
    if derived.hertz is None:
        # From the coarse solution that the domain follows from.
        size = {"contact_length_mm": 2e3 * scales.semi_axis_x, "contact_width_mm": 2e3 * scales.semi_axis_y,
                "contact_centre_mm": 1e3 * scales.centre, "contact_pressure_MPa": scales.peak_pressure * 1e-6}
    else:
        size = {"hertz_a_mm": scales.semi_axis_x * 1e3, "hertz_b_mm": scales.semi_axis_y * 1e3,
                "hertz_p0_MPa": scales.peak_pressure * 1e-6}
    low, high = derived.contact_angles
    facts = size | ({} if problem.hertz_pressure is None else {"normal_N": problem.normal_force}) | {
        "approach_um": scales.approach * 1e6,
        **({"contact_angle_low_mrad": 1e3 * low, "contact_angle_high_mrad": 1e3 * high} if high > low else {}),
        **dict(zip(("peclet_lower", "peclet_upper"), peclet_numbers(derived), strict=True)),
        "friction_limit_N": problem.traction_limit,
        "saturation_creepage": derived.saturation_creepage,
        "dundurs_beta": derived.dundurs_beta,
    }
    facts |= track_facts(derived) if problem.heating.recirculates else {}
    facts |= relaxation_facts(derived) if problem.relaxes else {}
    return per_length(facts) if problem.line else facts


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
    fields += 150 if derived.bodies.relaxes and derived.bodies.dispersive else 0
    return 8 * padded * fields, 0.1 + transforms * padded * math.log2(padded) * 4e-10
