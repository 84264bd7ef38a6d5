"""What the difference formula misses at the leading edge, where tractions begin at zero like a square root.

There every traction is, to leading order, the pressure times a constant vector, whether it sticks or slips. For tractions
shaped like the pressure the true gradient is known, so what D A makes of their element averages tells its error element by
element:

    E τ = [(∂u/∂x of p) − D A p] τ/p       on the elements cut by the leading edge and on the two next to it.

Added to D A, E makes a stick area begin right wherever the border lies in its elements. The part E > 0 on covered parts alone
(`edge_compliance`) moves the border by a part of an element that depends on its direction: an error of first order in the
tractions of the whole stick area. At the trailing border tractions are at Coulomb's bound and nothing depends on E.
"""

from __future__ import annotations

import numpy as np

from thermoroll_cli.arrays import Array, Mask
from thermoroll_cli.halfspace.elastic import ShearCompliance
from thermoroll_cli.numerics.solver_options import RollingOptions
from thermoroll_cli.numerics.stencils import highest, sobel

SMALLEST_PRESSURE = 1e-7
"""Over the peak: elements with less have no shape to speak of."""
CROSSWISE = 1e-6
"""The pressure's slope along x over the steepest one below which the border runs along the rolling direction."""


def leading_ring(pressure: Array, covered: Array, width: int) -> Mask:
    """Elements (n, m) up to `width` from the border where the pressure rises along the rolling direction."""
    near = np.pad(covered < 1.0, 1, constant_values=True)
    for _ in range(width):
        near = highest(near)
    near = near[1:-1, 1:-1]
    along, _ = _slopes(pressure, 1.0, 1.0)
    return near & (covered > 0.0) & (pressure > SMALLEST_PRESSURE * pressure.max()) & (
        along > CROSSWISE * float(np.abs(along).max()))


def known_gradient(
    pressure: Array, found: Array, exact: Array, covered: Array, width: int = RollingOptions.leading_ring
) -> Array:
    """E as (3, n, m), its components xx, yy, xy in 1/Pa, zero away from the leading edge.

    `found` and `exact` (3, n, m) are ∂u_x/∂x and ∂u_y/∂x under tractions (p, 0), (0, p) of their own direction, and the one
    under the other: by the operator (`RollingGradient.of_shape`) and the true ones, dimensionless."""
    ring = leading_ring(pressure, covered, width)
    return np.asarray(np.where(ring, (exact - found) / np.where(ring, pressure, 1.0), 0.0))


def continued_gradient(
    pressure: Array, found: Array, isotropic: Array, dx: float, dy: float, compliance: ShearCompliance
) -> Array:
    """True gradients (3, n, m) for `known_gradient` where only that of the potential ∬p/r is known, `isotropic` (Pa, (n, m)):
    from the normal problem, as u_z inside the contact is what closes the gap.

    What the potential's gradient lacks belongs to the border and so varies along its normal n alone: of the directional
    kernels only the one across n feels it, dir·(I − n nᵀ) times the same."""
    c = compliance
    missing = isotropic - (found[0] + found[1]) / (2.0 * c.isotropic + c.directional)
    along, across = _slopes(pressure, dx, dy)
    size = np.hypot(along, across)
    size[size == 0.0] = 1.0
    nx, ny = along / size, across / size
    return found + missing * np.stack([
        c.isotropic + c.directional * ny * ny, c.isotropic + c.directional * nx * nx, -c.directional * nx * ny])


def _slopes(pressure: Array, dx: float, dy: float) -> tuple[Array, Array]:
    """Sobel differences of p², which is smooth across the border, along x and y."""
    return sobel(np.pad(pressure**2, 1), dx, dy)
