"""Where the contact border runs inside an element, and what load its elements carry.

Near the border of any smooth contact, at a distance d from it, the half-space is in plane strain and

    p = A sqrt(d)  inside,      h = 4A/(3E*) d^{3/2}  outside,

with one and the same A (a cylinder; Johnson, Contact Mechanics, 4.2). So p² is smooth, and −A² (3E* h/4A)^{2/3} continues it
to the elements outside. A paraboloid is fitted to both sides: the border is interpolated, where p² from the inside alone would
have to be extrapolated over two elements, and a thermal bulge bends it too much for that.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.arrays import Array, Mask
from thermoroll_cli.numerics.grid import Grid
from thermoroll_cli.numerics.stencils import highest

Index = NDArray[np.intp]

REACH = 4
"""Elements up to this far away, along each axis, are fitted."""
NEAR = 2.0
"""Distance in elements at which a fitted element has lost 40 % of its weight (a Gaussian): p² bends within a few elements
where a thermal bulge squeezes the border."""
FINE = 8
"""Sample points per side of a border element."""
JOINING, LEAVING = 0.25, 1.0
"""An element counts as loaded from this share of the highest p² beside it on, and as open from this distance (in elements)
outside the border on. Below, its weight and that of its neighbours falls to zero: an element of the border that comes and goes
in the coupled iteration must not switch any weights."""
TOLERABLE_BEND = 0.05
"""An outer element where the second-order term of the gap is this large, relative, counts by half."""
TOLERABLE_MISFIT = 0.25
"""A paraboloid that misses the fitted elements by this distance of the border, in elements, is trusted by half."""
FAINT = 1e-12
"""Of the peak: a pressure below it is rounding, beside which nothing can be told of a change."""
TOLERABLE_CHANGE = 0.2
"""Whole elements carry another load than the fit gives them, by up to this part of the highest pressure beside them (0.17 at
the border of ellipses from N = 16 to 128). Where the fit wants more, the pressure falls within an element, as at the end of a
roller, and no paraboloid describes it."""
FEWEST = 8
"""A paraboloid has six coefficients; fewer fitted elements than this are not trusted to give them."""
UNDETERMINED = 1e-9
"""Determinant of the scaled normal equations below which rounding decides about a direction."""


def border_elements(
    pressure: Array, contact: Mask, gap: Array, grid: Grid, contact_modulus: float
) -> tuple[Mask, Array, Array]:
    """Border of the contact from the `pressure` (Pa) inside it and the `gap` (m) around it, all (nx, ny).

    `pressure` and `gap` are those of whole elements, `contact` is where they touch; `contact_modulus` is E* in Pa. Returns the
    mask of elements at the border (partly covered, or next to such), and on these the element averages of the pressure and
    the covered fractions that the continued p² implies; elsewhere the pressure as given and 1 or 0.
    """
    scale = max(float(pressure.max()), 1e-300)
    # Whole elements next to the border carry up to 3 % too much pressure, the first ones outside are as much too far apart:
    # both put it off by 0.02 elements, one inwards and one outwards, and those right at the border by up to 0.05.
    square = np.where(contact, pressure / scale, 0.0) ** 2
    loaded = np.minimum(square / np.maximum(JOINING * highest(square), 1e-300), 1.0)
    weight = 1.0 - highest(1.0 - loaded)
    beside = highest(loaded)
    i, j = np.nonzero((beside > 0.0) & ~contact & (gap > 0.0))
    coefficients, trust = _paraboloids(square, weight, i, j)
    square[i, j], bend = _continued(coefficients, gap[i, j] * contact_modulus / scale, grid)
    away = -square[i, j] / np.maximum(np.hypot(coefficients[:, 1], coefficients[:, 2]), 1e-300)
    weight[i, j] = trust * beside[i, j] * np.minimum(away / LEAVING, 1.0) / (1.0 + (bend / TOLERABLE_BEND) ** 2)
    i, j = np.nonzero(highest(contact) & highest(~contact))
    coefficients, trust = _paraboloids(square, weight, i, j)
    fitted = trust > 0.0
    i, j, coefficients, trust = i[fitted], j[fitted], coefficients[fitted], trust[fitted]
    part, root = _sampled(coefficients)
    # Beside a contact of almost no pressure any change is too large.
    beside = np.maximum(highest(pressure)[i, j], FAINT * scale)
    change = np.abs(scale * root - np.where(contact, pressure, 0.0)[i, j]) / beside
    trust = trust * np.minimum(1.0, TOLERABLE_CHANGE / np.maximum(change, 1e-300)) ** 4
    covered = contact.astype(np.float64)
    load = np.where(contact, pressure, 0.0)
    covered[i, j] += trust * (part - covered[i, j])
    load[i, j] += trust * (scale * root - load[i, j])
    border = np.zeros_like(contact)
    border[i, j] = True
    covered[load <= 0.0] = 0.0
    load[covered <= 0.0] = 0.0
    return border, load, covered


def _continued(coefficients: Array, gap: Array, grid: Grid) -> tuple[Array, Array]:
    """p² continued to elements outside, from their gap: `gap` is E*h in m, and p² is measured in the square of that unit.

    `coefficients` are those of paraboloids of p² around these elements, fitted to the inside. They give A² = |∇p²| at the
    border, and the terms that come next. With p² = A²(d + c d²), the cylinder has h ~ d^{3/2} (1 − 3/10 c d) (p and h' are
    the real parts of one analytic function on both sides), a border of curvature κ another −κd/5 (from Hertz's sphere). Also
    returned: that correction of the distance, relative."""
    _, u, v, uu, uv, vv = coefficients.T
    u, v, uu, uv, vv = u / grid.dx, v / grid.dy, 2.0 * uu / grid.dx**2, uv / (grid.dx * grid.dy), 2.0 * vv / grid.dy**2
    slope = np.maximum(np.hypot(u, v), 1e-300)
    u, v = u / slope, v / slope
    along, across = uu * u * u + 2.0 * uv * u * v + vv * v * v, uu * v * v - 2.0 * uv * u * v + vv * u * u
    # From the centre of the element back to the border; a wild fit must not turn the slope round.
    inwards = np.clip(-coefficients[:, 0] / slope, 0.0, 3.0 * max(grid.dx, grid.dy))
    steepness = np.maximum(slope + along * inwards, 0.2 * slope)
    distance = (0.75 * gap / np.sqrt(steepness)) ** (2.0 / 3.0)
    bend = -(0.4 * along + 2.0 / 15.0 * across) / steepness * distance
    return -steepness * distance * (1.0 + np.clip(bend, -0.5, 0.5)), bend


def _sampled(coefficients: Array) -> tuple[Array, Array]:
    """Part of the element where each paraboloid is positive, and the element average of its root there."""
    t = (np.arange(FINE) + 0.5) / FINE - 0.5
    u, v = (o.ravel() for o in np.meshgrid(t, t, indexing="ij"))
    value = coefficients @ np.stack([np.ones_like(u), u, v, u * u, u * v, v * v])
    slope = np.maximum(np.hypot(coefficients[:, 1], coefficients[:, 2]), 1e-300)
    # A sample cell cut by the border counts in part; this keeps the fraction continuous.
    part = np.clip(0.5 + value * (FINE / slope)[:, None], 0.0, 1.0)
    return part.mean(axis=1), np.sqrt(np.maximum(value, 0.0)).mean(axis=1)


def _paraboloids(square: Array, weight: Array, i: Index, j: Index) -> tuple[Array, Array]:
    """Least-squares paraboloid of `square` around each element (i, j), fitted with `weight` to the elements within reach.

    Returns (m, 6) coefficients of 1, u, v, u², uv, v² in elements from the centre of (i, j), and how far each fit can be
    trusted, from 1 (exact) to 0 (not determined): a trust that falls smoothly keeps the coupled iteration from jumping."""
    offsets = np.arange(-REACH, REACH + 1)
    u, v = (o.ravel() for o in np.meshgrid(offsets, offsets, indexing="ij"))
    basis = np.stack([np.ones(u.size), u, v, u * u, u * v, v * v], axis=1).astype(float)
    products = (basis[:, :, None] * basis[:, None, :]).reshape(-1, 36)
    width = square.shape[1] + 2 * REACH
    places = ((i + REACH) * width + j + REACH)[:, None] + (u * width + v)
    w = np.pad(weight, REACH).ravel()[places] * np.exp(-0.5 * (u * u + v * v) / NEAR**2)
    values = np.pad(square, REACH).ravel()[places]
    normal = (w @ products).reshape(-1, 6, 6)
    weighted = w * values
    right = weighted @ basis
    total = w.sum(axis=1)
    # All fitted elements in one row or column leave directions undetermined: the determinant of the scaled matrix tells.
    diagonal = np.sqrt(np.maximum(np.einsum("maa->ma", normal), 1e-300))
    scaled = normal / diagonal[:, :, None] / diagonal[:, None, :]
    usable = (np.count_nonzero(w, axis=1) >= FEWEST) & (np.linalg.det(scaled) > UNDETERMINED)
    out = np.zeros((len(i), 6))
    if usable.any():
        solution = np.linalg.solve(scaled[usable], (right / diagonal)[usable][:, :, None])[:, :, 0]
        out[usable] = solution / diagonal[usable]
    missed = np.einsum("mk,mk->m", weighted, values) - np.einsum("ma,ma->m", out, right)
    misfit = np.sqrt(np.maximum(missed, 0.0) / np.maximum(total, 1e-300))
    shift = misfit / np.maximum(np.hypot(out[:, 1], out[:, 2]), 1e-300) / TOLERABLE_MISFIT
    return out, np.where(usable, 1.0 / (1.0 + np.minimum(shift, 1e9) ** 4), 0.0)
