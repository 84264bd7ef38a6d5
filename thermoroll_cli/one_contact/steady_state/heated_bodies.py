"""The two bodies under heat: speeds of their material through the contact, recirculating heat, thermal crown.

`HeatResponses` keeps their thermal responses on one grid until speeds or cooling change.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.physics.halfspace.layered_thermal import LayeredHeat, thermal_constants
from thermoroll_cli.physics.heat.frictional_heat import Before
from thermoroll_cli.physics.heat.heat_response import HeatedBody, HeatResponse, KeptTables, ThermalResponse
from thermoroll_cli.physics.heat.recirculation import RecirculatingResponse, Track, TurningBody
from thermoroll_cli.physics.heat.sliding_heat import SlidingHeatResponse, SlidingKernels
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.problem.problem import BODIES, Material, Problem
from thermoroll_cli.tools.arrays import Array

LEAST_SPEED = 1e-2
"""Least speed of the surface of a body with recirculating heat, over the rolling speed."""


def heated_bodies(problem: Problem, creepage_x: float, creepage_y: float) -> tuple[HeatedBody, HeatedBody]:
    """Lower and upper body with the speeds of their material through the contact, V ± C/2."""
    if problem.heating.peclet != "rolling":
        return _heated(problem.lower, 0.0, 0.0), _heated(problem.upper, 0.0, 0.0)
    if problem.motion.force_x is not None:
        creepage_x = _rounded(creepage_x)
    if problem.motion.force_y is not None:
        creepage_y = _rounded(creepage_y)
    speed = problem.motion.speed
    cx, cy = creepage_x * speed / 2.0, creepage_y * speed / 2.0
    return _heated(problem.lower, speed + cx, cy), _heated(problem.upper, speed - cx, -cy)


def peclet_numbers(derived: DerivedQuantities) -> tuple[float, float]:
    """v a0/κ of the lower and of the upper body, nan without a diffusivity.

    v is the speed of the heat source over the body: its own along rolling, V ± C/2 (V where the creepage is an unknown), and 0
    for sources at rest."""
    problem = derived.problem
    creepage = problem.motion.creepage_x or 0.0
    factors = {"rolling": (abs(1.0 + creepage / 2.0), abs(1.0 - creepage / 2.0)), "stationary": (0.0, 0.0)}
    lower, upper = factors.get(problem.heating.peclet, (1.0, 1.0))
    return lower * derived.peclet(problem.lower), upper * derived.peclet(problem.upper)


def _heated(body: Material, speed_x: float, speed_y: float) -> HeatedBody:
    """The half-space of the top material, with the layers."""
    top = body.layers[0] if body.layers else body
    conductivity, diffusivity, expansion = thermal_constants(top)
    return HeatedBody(conductivity, (1.0 + top.poisson_ratio) * expansion, diffusivity, speed_x, speed_y,
                      LayeredHeat(body) if body.layers else None)


def _rounded(creepage: float) -> float:
    """An unknown creepage rounded to 1e-6: smaller changes do not need new thermal tables."""
    return round(creepage * 2.0**20) / 2.0**20


def turning_bodies(problem: Problem, creepage_x: float) -> tuple[TurningBody | None, TurningBody | None]:
    """Lower and upper body as they turn and cool, None for one without recirculating heat.

    A body that iterates stop or turn backwards still turns at `LEAST_SPEED` of the rolling speed; no solution may."""
    slowest, both = LEAST_SPEED * problem.motion.speed, []
    for body, heated in zip(BODIES, heated_bodies(problem, creepage_x, 0.0), strict=True):
        track, radius = getattr(problem.heating, f"{body}_track"), getattr(problem.geometry, f"{body}_radius_x")
        both.append(None if track is None else TurningBody(
            abs(radius), track.width, track.passes, max(heated.speed_x, slowest), heated.conductivity, heated.diffusivity,
            heated.free_expansion, getattr(problem, body).poisson_ratio, track.convection, track.resistance, radius < 0.0))
    return both[0], both[1]


def crown_matters(derived: DerivedQuantities) -> bool:
    """True if the gap includes the tracks' thermal crown: pressures change by less than its curvature over that of the gap."""
    return derived.problem.heating.recirculates and crown_bound(derived) >= derived.problem.numerics.negligible


def crown_bound(derived: DerivedQuantities) -> float:
    """Upper bound of Λ = Σ (1+ν)α q̄(0) R'_y/k, the curvature of the tracks' thermal crowns over that of the gap.

    For the heat of full sliding under Hertz's pressure, with the share of a given partition or all of it for either body; with
    prescribed forces at three times the saturation creepage."""
    p, motion, scales = derived.problem, derived.problem.motion, derived.scales
    share = p.heating.partition
    saturation = 3.0 * derived.saturation_creepage
    along, across = (saturation if c is None else abs(c) for c in (motion.creepage_x, motion.creepage_y))
    slip = math.hypot(along, across) + abs(motion.spin) * max(scales.semi_axis_x, scales.semi_axis_y)
    line = 0.5 * math.pi * scales.semi_axis_x * scales.peak_pressure * p.friction.highest * slip * motion.speed
    shares = (1.0, 1.0) if share == "matched" else (share, 1.0 - share)
    return sum(
        part * line * turning.crown_per_heat / derived.lateral_curvature
        for part, turning in zip(shares, turning_bodies(p, motion.creepage_x or 0.0), strict=True) if turning is not None
    )


class HeatResponses:
    """Thermal responses on one grid; kernels are kept, and built again only when speeds change. In a step over time there
    is heat `before`."""

    before: Before | None = None

    def __init__(self, grid: Grid, tables: KeptTables | None = None) -> None:
        self.grid = grid
        self.tables = tables or KeptTables()
        self._last: HeatResponse | None = None
        self._tracks: dict[TurningBody, Track] = {}

    @cached_property
    def sliding(self) -> SlidingKernels:
        return SlidingKernels(self.grid)

    def response(self, derived: DerivedQuantities, creepage: tuple[float, float], slip: Array) -> ThermalResponse:
        """Thermal response of both bodies at the given creepages; `slip` s/V (2, nx, ny) is used only if it determines the
        Péclet number."""
        problem = derived.problem
        lower, upper = heated_bodies(problem, *creepage)
        if problem.heating.peclet == "sliding":
            return SlidingHeatResponse(self.sliding, lower, upper, problem.motion.speed * np.hypot(slip[0], slip[1]))
        if self._last is None or self._last.bodies != (lower, upper):
            self._last = HeatResponse(self.grid, lower, upper, self.tables)
        if not problem.heating.recirculates:
            return self._last
        both = turning_bodies(problem, creepage[0])
        self._tracks = {r: self._tracks.get(r) or Track(r, self.grid) for r in both if r is not None}
        below, above = (None if r is None else self._tracks[r] for r in both)
        return RecirculatingResponse(self._last, (below, above), bulging=crown_matters(derived))
