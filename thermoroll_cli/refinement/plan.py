"""Decided before solving: which stages run, which are skipped and why, on which grids, at what cost."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from thermoroll_cli.numerics.solver_options import RefinementOptions
from thermoroll_cli.problem.problem import Problem, SubsurfaceRequest
from thermoroll_cli.refinement.plausibility import plausibility_warnings
from thermoroll_cli.refinement.profile_warnings import profile_warnings
from thermoroll_cli.refinement.stages import STAGES, grid_sequence
from thermoroll_cli.refinement.subsurface_plan import subsurface_plan
from thermoroll_cli.refinement.track_outlook import track_facts, track_warnings
from thermoroll_cli.steady_state.derived import DerivedQuantities

HALF_SPACE_LIMIT = 0.3
"""Half-width over radius from which the half-space is a doubtful model (Johnson, Contact Mechanics, 4.1)."""


@dataclass(frozen=True)
class Plan:
    """`grids` from coarse to fine; `run` and `skipped` name stages, the latter with reasons; `facts` are numbers known
    before solving; `memory_bytes` and `seconds` are estimates for the finest grid."""

    grids: tuple[tuple[int, int], ...]
    extent: float
    run: list[str]
    skipped: dict[str, str]
    warnings: list[str]
    facts: dict[str, float] = field(default_factory=dict)
    memory_bytes: int = 0
    seconds: float = 0.0

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


def make_plan(problem: Problem, options: RefinementOptions | None = None) -> Plan:
    """Plan of a problem. Raises ValueError where no steady state can exist (|F| > μW)."""
    if problem.prescribed_force and problem.prescribed_force >= problem.traction_limit:
        raise ValueError(f"the prescribed force of {problem.prescribed_force:g} N reaches or exceeds the friction limit μW = "
                         f"{problem.traction_limit:g} N")
    options = options or RefinementOptions()
    derived = DerivedQuantities(problem)
    grids = grid_sequence(problem, options)
    run, skipped, warnings = [], {}, []
    for stage, why_skipped in STAGES.items():
        reason = why_skipped(derived, options)
        if reason:
            skipped[stage] = reason
        elif reason is not None:
            run.append(stage)
    extent = problem.numerics.extent
    if extent < options.smallest_extent:
        warnings.append(f"numerics.extent = {extent:g} is smaller than the contact: grown to {options.smallest_extent:g}")
        extent = options.smallest_extent
    warnings += doubts(derived)
    plan = Plan(grids, extent, run, skipped, warnings, _facts(derived), *_cost(grids[-1], run, derived))
    return plan if problem.subsurface is None else _with_subsurface(plan, problem.subsurface, derived)


def _with_subsurface(plan: Plan, request: SubsurfaceRequest, derived: DerivedQuantities) -> Plan:
    """`plan` with the stage below the surface, whose code is imported for it."""

    below = subsurface_plan(request, derived, plan.grid, heated=plan.runs("heat"))
    return replace(plan, run=plan.run + below.run, skipped=plan.skipped | below.skipped, facts=plan.facts | below.facts,
                   memory_bytes=plan.memory_bytes + below.memory_bytes, seconds=plan.seconds + below.seconds)


def doubts(derived: DerivedQuantities) -> list[str]:
    """What is doubtful about a problem before it is solved."""
    tracks = track_warnings(derived) if derived.problem.heating.recirculates and derived.has_traction else []
    return [*plausibility_warnings(derived), *_half_space_warnings(derived), *tracks]


def _half_space_warnings(derived: DerivedQuantities) -> list[str]:
    scales, geometry = derived.scales, derived.problem.geometry
    out = profile_warnings(derived) if geometry.has_profile else []
    for axis, half, radii in (
        ("x", scales.semi_axis_x, (geometry.lower_radius_x, geometry.upper_radius_x)),
        ("y", scales.semi_axis_y, (geometry.lower_radius_y, geometry.upper_radius_y)),
    ):
        if axis == "y" and geometry.has_profile:
            continue
        smallest = min(abs(r) for r in radii)
        if half / smallest > HALF_SPACE_LIMIT:
            out.append(f"contact half-width along {axis} is {half / smallest:.2f} of the smallest radius: "
                       f"the half-space assumption is doubtful above {HALF_SPACE_LIMIT:g}")
    return out


def _facts(derived: DerivedQuantities) -> dict[str, float]:
    scales, problem = derived.scales, derived.problem
    if problem.geometry.has_profile:
        # Of the coarse solution from which the domain follows.
        size = {"contact_length_mm": 2e3 * scales.semi_axis_x, "contact_width_mm": 2e3 * scales.semi_axis_y,
                "contact_centre_mm": 1e3 * scales.centre, "contact_pressure_MPa": scales.peak_pressure * 1e-6}
    else:
        size = {"hertz_a_mm": scales.semi_axis_x * 1e3, "hertz_b_mm": scales.semi_axis_y * 1e3,
                "hertz_p0_MPa": scales.peak_pressure * 1e-6}
    return size | {
        "approach_um": scales.approach * 1e6,
        "peclet_lower": derived.peclet(problem.lower),
        "peclet_upper": derived.peclet(problem.upper),
        "friction_limit_N": problem.traction_limit,
        "saturation_creepage": derived.saturation_creepage,
        "dundurs_beta": derived.dundurs_beta,
    } | (track_facts(derived) if problem.heating.recirculates else {})


def _cost(shape: tuple[int, int], run: list[str], derived: DerivedQuantities) -> tuple[int, float]:
    """Rough memory (bytes) and time (s, one core): counts of padded fields and transforms times their size.

    Counts are those of the article's cases; 0.4 ns per element and log₂ is what a transform was measured to take on one core.
    """
    padded = 4 * shape[0] * shape[1]
    # Kernels, spectra and work fields of each solver; half of the tangential ones are in single precision.
    fields = 12 + (45 if "tangential" in run else 0) + (12 if "heat" in run else 0) + (8 if "elastic coupling" in run else 0)
    # A coupled state costs about three isothermal ones, whose tractions take some 70 applications of 4 transforms each.
    solves = (4 if "deformation" in run else 1) + ("elastic coupling" in run)
    rolling = 140 if derived.mirror_on(shape[1], heated=False) is not None else 280
    transforms = 10 + (rolling if "tangential" in run else 0) * solves
    return 8 * padded * fields, 0.1 + transforms * padded * math.log2(padded) * 4e-10
