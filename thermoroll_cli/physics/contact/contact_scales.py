"""Estimated size, peak pressure and approach of a contact before it is solved: by Hertz, or from a coarse solution."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
import scipy

from thermoroll_cli.exact.hertz import HertzContact, hertz_contact
from thermoroll_cli.physics.contact.active_set import Approach, Given
from thermoroll_cli.physics.contact.normal_contact import NormalSolver
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.numerics.grid import Domain, Grid, Prolongation, peak_value
from thermoroll_cli.problem.geometry import ContactGeometry, Unsolvable
from thermoroll_cli.tools.arrays import Array

COARSE_GRID = (32, 64)
"""Elements along and across rolling on which a profile's contact is looked for: two patches need more across than along."""
COARSE_LINE = 128
"""Elements on which a line contact is looked for."""
DOMAIN_OVER_CONTACT = 1.1
"""Sides of the domain over those of the contact in it, as on the grids of the solution proper."""
DOMAIN_FITS = 3
"""Domains on which a contact of coated bodies is solved in turn."""
ATTEMPTS = 8
"""Domains tried; each one that proves too small makes the overlap half as deep again."""
COARSE_TOLERANCE = 1e-6
OVERLAP_SAMPLES = 4001
"""Places across the rolling direction at which the overlap of the rigid bodies is summed."""
OVERLAP_SHARE = 0.5
"""Square of the half-width along rolling over that of the rigid overlap: ½ below a sphere (Hertz), less below a cylinder."""


@dataclass(frozen=True)
class ContactScales:
    """Half-lengths of the contact along x and y (Hertz's semi-axes; else half of what all patches span), the `centre` of that
    span along y and `centre_x` of that along x, `area` (m²), `mean_radius` of the circle of that area, `peak_pressure` (Pa),
    `approach` (m) and `normal_force` (N). `ends` says whether the contact reaches the lower and the upper end of a profile,
    where its pressure has no upper bound; `limits` are these ends (m); `converged` says whether the coarse pressure has
    converged, and `pressure_centre` is the y (m) of its centre; `loads` has pairs of y (m) and load per width, in any unit, of
    lines of rolling, without them it falls like a parabola.

    A line contact has no length across: that along x stands for it, area and normal force are per m of length, and the approach
    is that of a sphere of the same half-width."""

    semi_axis_x: float
    semi_axis_y: float
    peak_pressure: float
    approach: float
    normal_force: float
    area: float
    mean_radius: float
    centre: float = 0.0
    ends: tuple[bool, bool] = (False, False)
    limits: tuple[float, float] = (-math.inf, math.inf)
    converged: bool = True
    centre_x: float = 0.0
    pressure_centre: float = 0.0
    loads: tuple[tuple[float, float], ...] = ()

    @classmethod
    def of_hertz(cls, hertz: HertzContact) -> ContactScales:
        if math.isinf(hertz.semi_axis_y):
            return cls.of_line(hertz.semi_axis_x, hertz.curvature_x, hertz.peak_pressure, hertz.normal_force)
        return cls(hertz.semi_axis_x, hertz.semi_axis_y, hertz.peak_pressure, hertz.approach, hertz.normal_force, hertz.area,
                   hertz.mean_radius)

    @classmethod
    def of_line(cls, half: float, curvature: float, peak: float, load: float) -> ContactScales:
        """Those of a line contact of this `half`-width between cylinders of a relative `curvature` (1/m)."""
        return cls(half, half, peak, half * half * curvature, load, 2.0 * half, half)

    @property
    def reaches_an_end(self) -> bool:
        return any(self.ends)

    def domain(self, extent: float) -> Domain:
        """A domain of `extent` half-lengths about the contact. It ends where a profile ends."""
        side_x, half = extent * self.semi_axis_x, 0.5 * extent * self.semi_axis_y
        low, high = max(self.centre - half, self.limits[0]), min(self.centre + half, self.limits[1])
        if math.isinf(self.limits[0]):
            return Domain(side_x, 2.0 * half, self.centre, self.centre_x)
        return Domain(side_x, high - low, 0.5 * (low + high), self.centre_x)


def approach_weight(geometry: ContactGeometry, y: Array) -> Array:
    """cos α, (m,): by how much an approach closes the gap along the normals of the common surface, and which part of the
    pressure there carries the load."""
    return np.cos(geometry.inclination(y))


def hertz_at(geometry: ContactGeometry, contact_modulus: float, given: Given) -> HertzContact:
    """Hertz's contact under a normal force (N) or at an approach, to which W ∝ δ^{3/2} leads."""
    of_load = partial(hertz_contact, geometry.curvature_x, geometry.curvature_y, contact_modulus)
    return of_load((given.depth / of_load(1.0).approach) ** 1.5 if isinstance(given, Approach) else given)


@lru_cache(maxsize=64)
def contact_scales(geometry: ContactGeometry, bodies: Bodies, given: Given) -> ContactScales:
    """Scales of the contact of two bodies for which Hertz has no closed form, from a coarse normal solution under a normal
    force (N) or at an approach.

    The first domain is the overlap of the rigid bodies, the second one the contact found in it. Raises Unsolvable where the
    bodies never face each other.
    """
    if geometry.elliptic:
        return _of_smooth(geometry, bodies, given)
    low, high = geometry.limits
    mirror = geometry.symmetric
    first, last = low, high
    for _ in range(ATTEMPTS):
        y = np.linspace(first, last, OVERLAP_SAMPLES)
        gap = geometry.across(y)
        depth = given.depth if isinstance(given, Approach) else _overlap(y, gap, bodies.softest, given)
        if np.count_nonzero(gap < depth) > 1:
            break
        # The contact lies between two samples.
        closest, step = y[np.argmin(gap)], y[1] - y[0]
        first, last = max(low, closest - step), min(high, closest + step)
    for _ in range(ATTEMPTS):
        inside = y[gap < depth]
        rear, front = geometry.along(depth, inside)
        box = _Box(0.5 * (front - rear), float(inside[0]), float(inside[-1]), 0.5 * (front + rear))
        grown = box.grown(DOMAIN_OVER_CONTACT, low, high, mirror=mirror)
        solution = _solve(geometry, bodies, given, grown, (low, high), depth, mirror=mirror)
        if solution is not None:
            break
        depth *= 1.5
    else:
        raise Unsolvable("no contact of these profiles was found: their gap is too steep", "geometry")
    # Once more with all elements on the contact: its border is known to an element.
    grown = _Box.around(solution.scales).grown(DOMAIN_OVER_CONTACT, low, high, mirror=mirror)
    finer = _solve(geometry, bodies, given, grown, (low, high), solution, mirror=mirror)
    return (finer or solution).scales


def _of_smooth(geometry: ContactGeometry, bodies: Bodies, given: Given) -> ContactScales:
    """Scales of coated or relaxing bodies: the first domain is Hertz's contact of the surfaces' materials, relaxed, each
    further one the contact found."""
    hertz = hertz_at(geometry, bodies.softest, given)
    box, limits = _Box(hertz.semi_axis_x, -hertz.semi_axis_y, hertz.semi_axis_y), (-math.inf, math.inf)
    solution, fits = None, 0
    for _ in range(4 * ATTEMPTS):
        grown = box.grown(DOMAIN_OVER_CONTACT, *limits, mirror=True)
        start = solution or hertz.approach
        attempt = _solve(geometry, bodies, given, grown, limits, start, mirror=True)
        if attempt is None:
            box = _Box(1.5 * box.half_x, 1.5 * box.low, 1.5 * box.high)
            continue
        solution, fits = attempt, fits + 1
        found = _Box.around(solution.scales)
        box = replace(found, low=box.low, high=box.high) if math.isinf(box.high) else found
        if fits == DOMAIN_FITS:
            return solution.scales
    raise Unsolvable("no contact of these bodies was found", "material")


@dataclass(frozen=True)
class _Box:
    half_x: float
    low: float
    high: float
    centre_x: float = 0.0

    @classmethod
    def around(cls, scales: ContactScales) -> _Box:
        return cls(scales.semi_axis_x, scales.centre - scales.semi_axis_y, scales.centre + scales.semi_axis_y, scales.centre_x)

    def grown(self, factor: float, lowest: float, highest: float, *, mirror: bool) -> _Box:
        """`factor` times as large, but not beyond the ends of the profiles; even about y = 0 for `mirror`."""
        room = 0.5 * (factor - 1.0) * (self.high - self.low)
        low, high = max(self.low - room, lowest), min(self.high + room, highest)
        if mirror:
            high = max(high, -low)
            low = -high
        return _Box(factor * self.half_x, low, high, self.centre_x)


class _Found(NamedTuple):
    """The coarse solution behind some `scales`."""

    scales: ContactScales
    grid: Grid
    pressure: Array


def _overlap(y: Array, gap: Array, contact_modulus: float, normal_force: float) -> float:
    """Estimate of the approach δ in m from the `gap` h (m) over `y`: each strip across as a cylinder of half-width
    a² = ½·2R'_x(δ − h), which carries πE*a²/(4R'_x) per length (Kik & Piotrowski's assumption)."""
    finite = np.where(np.isfinite(gap), gap, 1e300)
    stiffness = 0.25 * math.pi * contact_modulus * OVERLAP_SHARE * 2.0 * (y[1] - y[0])

    def load(depth: float) -> float:
        return stiffness * float(np.maximum(depth - finite, 0.0).sum())

    upper = 1e-12
    while load(upper) >= normal_force:
        upper *= 0.5
    while load(upper) < normal_force:
        upper *= 2.0
    return 1.2 * float(scipy.optimize.brentq(lambda depth: load(depth) - normal_force, 0.5 * upper, upper, xtol=1e-12 * upper))


def _solve(
    geometry: ContactGeometry, bodies: Bodies, given: Given, box: _Box, limits: tuple[float, float],
    before: _Found | float, *, mirror: bool,
) -> _Found | None:
    """Scales of the contact on a coarse grid over `box`; None if it reaches a side of the box where no profile ends. `before`
    is the start: the solution on another box, or how deep (m) rigid bodies overlap."""
    line = math.isinf(box.high)
    nx, ny = shape = (COARSE_LINE, 1) if line else COARSE_GRID
    grid = Grid.over(shape, 2.0 * box.half_x, box.high - box.low, 0.0 if line else 0.5 * (box.low + box.high), box.centre_x)
    cosine = approach_weight(geometry, grid.y)
    gap = geometry.gap(grid.x, grid.y) / cosine
    start = (Prolongation(before.grid, grid).from_inside(before.pressure) if isinstance(before, _Found)
             else np.sqrt(np.maximum(OVERLAP_SHARE * before - gap, 0.0)))
    solver = NormalSolver(grid, bodies, cosine)
    solution = solver.solve(gap, given, start, COARSE_TOLERANCE)
    share = solver.border(solution, mirrored=mirror)[2]
    columns, rows = (np.flatnonzero(solution.contact.any(axis=axis)) for axis in (0, 1))
    slack = 0.0 if line else 1e-9 * (limits[1] - limits[0])
    at_end = box.low <= limits[0] + slack, box.high >= limits[1] - slack
    first, last = columns[0] == 0, columns[-1] == ny - 1
    if rows[0] == 0 or rows[-1] == nx - 1 or (first and not at_end[0]) or (last and not at_end[1]):
        return None
    along, centre_x = share.sum(axis=0).max() * grid.dx, 0.0
    if geometry.leans:
        # A patch that leans spans more than its longest line of rolling.
        along, centre_x = (rows[-1] - rows[0] + 1) * grid.dx, 0.5 * (grid.x[rows[0]] + grid.x[rows[-1]])
    elif bodies.relaxes:
        # The contact leads.
        part = np.pad(share.max(axis=1), 1)
        rear = grid.x[rows[0]] - part[rows[0] : rows[0] + 2].sum() * grid.dx
        front = grid.x[rows[-1]] + part[rows[-1] + 1 : rows[-1] + 3].sum() * grid.dx
        along, centre_x = front - rear, 0.5 * (front + rear)
    if line:
        found = ContactScales.of_line(0.5 * float(along), geometry.curvature_x, peak_value(solution.pressure),
                                      solver.load(solution.pressure))
        return _Found(replace(found, converged=solution.converged, centre_x=float(centre_x)), grid, solution.pressure)
    # Covered parts and half an element of room: with whole elements the domains of neighbouring problems would jump.
    covered = np.pad(share.max(axis=0), 1)
    low = grid.y[columns[0]] - covered[columns[0] : columns[0] + 2].sum() * grid.dy
    high = grid.y[columns[-1]] + covered[columns[-1] + 1 : columns[-1] + 3].sum() * grid.dy
    area = float(share.sum()) * grid.element_area
    # Rounding in the centre would end the symmetry of profiles that wear on such a grid.
    centre = 0.0 if mirror else float(0.5 * (low + high))
    edge = geometry.free_ends
    ends = bool(first and at_end[0] and edge[0]), bool(last and at_end[1] and edge[1])
    peak = peak_value(solution.pressure / cosine)
    per_length = solution.pressure.sum(axis=0)
    scales = ContactScales(0.5 * float(along), 0.5 * float(high - low), peak, solution.approach, solver.load(solution.pressure),
                           area, math.sqrt(area / math.pi), centre, ends, limits, solution.converged, float(centre_x),
                           0.0 if mirror else float(grid.y @ per_length / per_length.sum()),
                           tuple(zip(grid.y, per_length, strict=True)))
    return _Found(scales, grid, solution.pressure)
