"""Problems that tests and scripts have in common: spheres and ellipsoids of steel, the article's hot case."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from scipy.special import elliprd

from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Material, Motion, Numerics, Problem

STEEL = Material(210e9, 0.28, 50.2, 11.7e-6, 10e-6)
MECHANICAL = Heating(heat=False, deformation=False)


def elastic(poisson_ratio: float, youngs_modulus: float = 210e9) -> Material:
    """A body without thermal constants."""
    return Material(youngs_modulus, poisson_ratio)


def spheres(radius: float) -> Geometry:
    return Geometry(radius, radius, radius, radius)


def ellipse(aspect_ratio: float, radius: float = 0.05) -> Geometry:
    """Bodies whose Hertz contact has a0/b0 = `aspect_ratio`; `radius` is the geometric mean of the relative radii."""
    g = aspect_ratio
    ratio = float(elliprd(0.0, 1.0 / g, g) / elliprd(0.0, g, 1.0 / g))  # κ_x/κ_y (Hertz)
    rx, ry = radius / math.sqrt(ratio), radius * math.sqrt(ratio)
    return Geometry(rx, ry, math.inf, math.inf)


def on_grid(problem: Problem, grid: int | tuple[int, int], extent: float = 2.2) -> Problem:
    shape = (grid, grid) if isinstance(grid, int) else grid
    return replace(problem, numerics=Numerics(grid=shape, extent=extent))


def rolling(
    *, grid: int | tuple[int, int] = 64, geometry: Geometry | None = None, body: Material = STEEL, load: float = 65.0,
    friction: float = 0.3, creepage: tuple[float | None, float | None] = (0.0, 0.0), spin: float = 0.0,
    force: tuple[float | None, float | None] = (None, None), speed: float = 1.0, heating: Heating = MECHANICAL,
    extent: float = 2.2, differential_slip: bool = False,
) -> Problem:
    """Two equal bodies (spheres of 30 mm unless told otherwise), mechanical unless `heating` is given; without differential
    slip, as in all references but those that say so."""
    motion = Motion(speed, creepage[0], creepage[1], spin, force[0], force[1], differential_slip)
    problem = Problem(body, body, geometry or spheres(0.03), load, Friction(friction), motion, heating)
    return on_grid(problem, grid, extent)


def article_4_1(grid: int | tuple[int, int], speed: float = 200.0, heating: Heating | None = None) -> Problem:
    """The article's hot case (Table 1) at the heat scale of its figures."""
    return rolling(grid=grid, creepage=(0.003, 0.0), speed=speed, heating=heating or Heating(peclet="stationary"))


@dataclass(frozen=True)
class Saturation:
    """Creepages (and spin in rad/m) of the size at which a contact begins to slide as a whole."""

    creepage: float
    spin: float


def saturation(problem: Problem) -> Saturation:
    derived = DerivedQuantities(problem)
    creepage = derived.saturation_creepage
    return Saturation(creepage, creepage / derived.hertz.mean_radius)


def spin_ellipse(aspect_ratio: float, grid: int | tuple[int, int]) -> Problem:
    """An ellipse in which spin makes most of the slip, with a little creepage along both axes so that nothing cancels."""
    base = rolling(grid=grid, geometry=ellipse(aspect_ratio), body=elastic(0.28), load=100.0, friction=0.6)
    scale = saturation(base)
    return replace(base, motion=replace(base.motion, creepage_x=0.1 * scale.creepage, creepage_y=0.05 * scale.creepage,
                                        spin=0.9 * scale.spin))
