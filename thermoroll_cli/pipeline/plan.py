"""Decided before solving: which stages run, which are skipped and why, on which grids, at what cost."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from thermoroll_cli.pipeline.problem import Problem
from thermoroll_cli.pipeline.scene import Scene

COARSEST = 16
FINEST_FOR_ACCURACY = 512
SMALLEST_EXTENT = 2.1
"""The Hertz contact spans 2 semi-axes; a domain must leave a little room around it."""

NEGLIGIBLE_BULGE = 1e-6
"""Thermal expansion below this share of the approach cannot show in any reported digit."""

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

    def runs(self, stage: str) -> bool:
        return stage in self.run


def make_plan(problem: Problem) -> Plan:
    """Plan of a problem. Raises ValueError where no steady state can exist (|F| > μW)."""
    if problem.prescribed_force > problem.traction_limit:
        raise ValueError(f"the prescribed force of {problem.prescribed_force:g} N exceeds the friction limit μW = "
                         f"{problem.traction_limit:g} N")
    scene = Scene(problem)
    run, skipped, warnings = [], {}, []
    heating = problem.heating
    skipped["normal (isothermal)"] = "smooth bodies without thermal bulge: Hertz's closed form is exact"
    if not scene.moves:
        skipped["tangential"] = "no creepage, spin or force: everything sticks without traction"
    elif problem.friction == 0.0:
        skipped["tangential"] = "no friction: the surfaces slide freely"
    else:
        run.append("tangential")
    if not heating.heat:
        skipped["heat"] = "switched off or no thermal constants: purely mechanical"
    elif not scene.has_traction:
        skipped["heat"] = "nothing rubs: no frictional heat"
    else:
        run.append("heat")
    if "heat" not in run:
        skipped["deformation"] = "no heat"
    elif not heating.deformation:
        skipped["deformation"] = "switched off"
    else:
        bulge = bulge_bound(scene) / scene.hertz.approach
        if bulge < NEGLIGIBLE_BULGE:
            skipped["deformation"] = f"thermal expansion is at most {bulge:.1e} of the approach"
        else:
            run.append("deformation")
    extent = problem.numerics.extent
    if extent < SMALLEST_EXTENT:
        warnings.append(f"numerics.extent = {extent:g} is smaller than the contact: grown to {SMALLEST_EXTENT:g}")
        extent = SMALLEST_EXTENT
    warnings += _half_space_warnings(scene)
    grids = grid_ladder(problem)
    return Plan(grids, extent, run, skipped, warnings, _facts(scene), *_cost(grids[-1], run))


def grid_ladder(problem: Problem) -> tuple[tuple[int, int], ...]:
    """Grids from coarse to fine, each side doubled (rounded), down to about `COARSEST` elements on the shorter side."""
    wish = problem.numerics.grid
    if wish is None:
        shapes = []
        n = COARSEST
        while n <= FINEST_FOR_ACCURACY:
            shapes.append((n, n))
            n *= 2
        return tuple(shapes)
    ladder = [wish]
    while min(ladder[0]) >= 2 * COARSEST:
        nx, ny = ladder[0]
        ladder.insert(0, ((nx + 1) // 2, (ny + 1) // 2))
    return tuple(ladder)


def bulge_bound(scene: Scene) -> float:
    """Upper bound of the thermal expansion's variation over the contact in m.

    No heat source can exceed μp times the rigid slip plus the elastic slip that tractions at the Coulomb bound can cause;
    a half-space heated at total rate Q expands by at most about (1+ν)αQ/(k·π) · 2 across the contact, more slowly the
    faster the material moves: the stationary value bounds all speeds.
    """
    problem, hertz = scene.problem, scene.hertz
    motion = problem.motion
    radius = math.hypot(hertz.semi_axis_x, hertz.semi_axis_y)
    rigid = math.hypot(motion.creepage_x or 0.0, motion.creepage_y or 0.0) + abs(motion.spin) * radius
    if motion.force_x is not None or motion.force_y is not None:
        rigid += 10.0 * scene.saturation_creepage
    heat = problem.traction_limit * rigid * motion.speed
    spread = math.log(2.0 + max(hertz.aspect_ratio, 1.0 / hertz.aspect_ratio))
    factor = 0.0
    for body, share in ((problem.lower, problem.heating.partition), (problem.upper, 1.0 - problem.heating.partition)):
        assert body.conductivity is not None and body.expansion is not None
        factor += share * (1.0 + body.poisson_ratio) * body.expansion / body.conductivity
    return 2.0 / math.pi * factor * heat * spread


def _half_space_warnings(scene: Scene) -> list[str]:
    hertz, geometry = scene.hertz, scene.problem.geometry
    out = []
    for axis, half, radii in (
        ("x", hertz.semi_axis_x, (geometry.lower_radius_x, geometry.upper_radius_x)),
        ("y", hertz.semi_axis_y, (geometry.lower_radius_y, geometry.upper_radius_y)),
    ):
        smallest = min(abs(r) for r in radii)
        if half / smallest > HALF_SPACE_LIMIT:
            out.append(f"contact half-width along {axis} is {half / smallest:.2f} of the smallest radius: "
                       f"the half-space assumption is doubtful above {HALF_SPACE_LIMIT:g}")
    return out


def _facts(scene: Scene) -> dict[str, float]:
    hertz, problem = scene.hertz, scene.problem
    return {
        "hertz_a_mm": hertz.semi_axis_x * 1e3,
        "hertz_b_mm": hertz.semi_axis_y * 1e3,
        "hertz_p0_MPa": hertz.peak_pressure * 1e-6,
        "approach_um": hertz.approach * 1e6,
        "peclet_lower": scene.peclet(problem.lower),
        "peclet_upper": scene.peclet(problem.upper),
        "friction_limit_N": problem.traction_limit,
        "saturation_creepage": scene.saturation_creepage,
    }


def _cost(shape: tuple[int, int], run: list[str]) -> tuple[int, float]:
    """Rough memory (bytes) and time (s, one core): counts of padded fields and transforms times their size."""
    padded = 4 * shape[0] * shape[1]
    fields = 12 + (90 if "tangential" in run else 0) // 2 + (12 if "heat" in run else 0)
    transforms = 10 + (280 if "tangential" in run else 0) * (4 if "deformation" in run else 1)
    return 8 * padded * fields, 0.1 + transforms * padded * math.log2(padded) * 1.2e-10 * 5.0
