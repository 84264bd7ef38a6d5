"""Where the contact border runs inside an element, and what load its elements carry.

The pressure falls to zero like a square root, so p² is smooth across the border: it is fitted by a paraboloid to the
elements well inside and continued outwards.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

REACH = 5
"""Elements up to this far away, along each axis, are fitted."""
FINE = 8
"""Sample points per side of a border element."""
TOLERABLE_MISFIT = 0.005
"""A paraboloid that misses the fitted p² by this share is trusted by half."""
FEWEST = 8
"""A paraboloid has six coefficients; fewer fitted elements than this are not trusted to give them."""


def _neighbours(mask: Mask) -> Array:
    """How many of the 3 × 3 elements around each one are in `mask`."""
    padded = np.pad(mask, 1).astype(np.int8)
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return np.asarray(rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:])


def border_elements(pressure: Array, contact: Mask) -> tuple[Mask, Array, Array]:
    """Border of the contact from the pressures (nx, ny) inside it.

    Returns the mask of elements at the border (partly covered, or next to such), and on these the element averages of the
    pressure and the covered fractions that the continued p² implies; elsewhere the pressure as given and 1 or 0.
    """
    inner = contact & (_neighbours(contact) == 9)
    # The elements next to the border carry some of its error: 1–3 % too much pressure. The next ring is good to 0.5 %.
    core = inner & (_neighbours(inner) == 9)
    ring = (_neighbours(contact) > 0) & ~inner
    i, j = np.nonzero(ring)
    square = np.where(core, pressure, 0.0) ** 2
    coefficients, trust = _paraboloids(square, core, i, j)
    fitted = trust > 0.0
    i, j, coefficients, trust = i[fitted], j[fitted], coefficients[fitted], trust[fitted]
    t = (np.arange(FINE) + 0.5) / FINE - 0.5
    u, v = np.meshgrid(t, t, indexing="ij")
    basis = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v]).reshape(6, -1)
    value = coefficients @ basis
    zero, one = np.zeros_like(u), np.ones_like(u)
    along_u = np.stack([zero, one, zero, 2 * u, v, zero]).reshape(6, -1)
    along_v = np.stack([zero, zero, one, zero, u, 2 * v]).reshape(6, -1)
    slope = np.hypot(coefficients @ along_u, coefficients @ along_v)
    # A sample cell cut by the border counts in part; this keeps the fraction continuous.
    part = np.clip(0.5 + FINE * value / np.maximum(slope, 1e-300), 0.0, 1.0)
    covered = contact.astype(np.float64)
    load = np.where(contact, pressure, 0.0)
    covered[i, j] += trust * (part.mean(axis=1) - covered[i, j])
    load[i, j] += trust * (np.sqrt(np.maximum(value, 0.0)).mean(axis=1) - load[i, j])
    border = np.zeros_like(contact)
    border[i, j] = True
    covered[load <= 0.0] = 0.0
    load[covered <= 0.0] = 0.0
    return border, load, covered


def _paraboloids(square: Array, core: Mask, i: NDArray[np.intp], j: NDArray[np.intp]) -> tuple[Array, Mask]:
    """Least-squares paraboloid of `square` around each element (i, j) from the `core` elements within reach.

    Returns (m, 6) coefficients of 1, u, v, u², uv, v² in elements from the centre of (i, j), and how far each fit can be
    trusted, from 1 (exact) to 0 (not determined): a trust that falls smoothly keeps the coupled iteration from jumping."""
    width = 2 * REACH + 1
    offsets = np.arange(-REACH, REACH + 1)
    u, v = (o.ravel() for o in np.meshgrid(offsets, offsets, indexing="ij"))
    basis = np.stack([np.ones(width**2), u, v, u * u, u * v, v * v], axis=1).astype(float)
    padded = np.pad(square, REACH)
    weights = np.pad(core, REACH).astype(float)
    rows, columns = i[:, None] + REACH + u, j[:, None] + REACH + v
    w = weights[rows, columns]
    values = padded[rows, columns]
    scale = max(float(square.max()), 1e-300)
    normal = np.einsum("mk,ka,kb->mab", w, basis, basis, optimize=True)
    right = (w * values / scale) @ basis
    usable = w.sum(axis=1) >= FEWEST
    # All fitted elements in one row or column leave directions undetermined: the determinant of the scaled matrix tells.
    diagonal = np.sqrt(np.maximum(np.einsum("maa->ma", normal), 1e-300))
    scaled = normal / diagonal[:, :, None] / diagonal[:, None, :]
    usable &= np.linalg.det(scaled) > 1e-9
    out = np.zeros((len(i), 6))
    if usable.any():
        solution = np.linalg.solve(scaled[usable], (right / diagonal)[usable][:, :, None])[:, :, 0]
        out[usable] = solution / diagonal[usable] * scale
    misfit = np.sqrt((w * (values - out @ basis.T) ** 2).sum(axis=1))
    size = np.sqrt((w * values**2).sum(axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        trust = 1.0 / (1.0 + (misfit / size / TOLERABLE_MISFIT) ** 2)
    return out, np.where(usable & (size > 0.0), trust, 0.0)
