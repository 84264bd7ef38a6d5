"""Borders that run inside elements: leading edge, partly covered elements, end of stick, neutral lines.

**Leading edge** (`known_gradient`): the error of the difference formula at the place where tractions begin like a square root.
Every traction there is, to leading order, the pressure times a constant vector, whether it sticks or slips. For tractions
shaped like the pressure the true gradient is known, so D A of their element averages gives its error element by
element:

    E τ = [(∂u/∂x of p) − D A p] τ/p       on the elements cut by the leading edge and on the two next to it.

Added to D A, E makes the beginning of a stick area correct for any position of the border inside its elements. E > 0 on covered
parts alone (`EdgeCompliance`) would shift the border by a fraction of an element that depends on its direction, which is a
first-order error in the tractions of the whole stick area. At the trailing border tractions are at Coulomb's bound and E has
no effect.

**Partly covered elements** (`edge_compliance`): a gradient that the uniform element of the influence coefficients lacks.
If the contact border cuts an element, the traction acts on the covered part φ only and is that much denser. Near a straight
border with inward normal n the half-space is in plane strain along n and in anti-plane strain along the border, so the missing
gradient of the displacement along the rolling direction is

    K τ = |n_x| [ Σ(1−ν)/G · n nᵀ + Σ 1/G · (I − n nᵀ) ] (1 − φ)/φ · τ

With n fixed along x lateral forces would have a first-order error.

**End of stick** (`stick_ends`): the place of the border between stick and slip inside the elements on which slip begins.
At the downstream border of a stick area, at a distance d from it, the half-space is in plane strain along the border's normal n
and in anti-plane strain along the border, and the reserve of friction and the slip have one common factor A:

    μp − |τ| = A sqrt(d)  inside,      |s| = |n_x| c A sqrt(d)  outside,      c = Σ(1−ν)/G (n·τ)²/τ² + Σ1/G (1 − (n·τ)²/τ²)

(for n along x this is Carter's contact, with its shear modulus along and across). Measured along x, both are A sqrt(|n_x| d_x).

**Neutral lines** (`neutral_compliance`): lines where differential slip changes its direction inside an element.
Across a neutral line the traction of a sliding contact jumps from one side of the Coulomb bound to the other. If the slip of an
element varies by ±v across its width about its mean s, the mean of its traction is μp s/v for |s| < v, else the bound. An
element that the line crosses therefore obeys s = κ τ with κ = v/μp, an additional compliance, where μ is that of the slip v
(`FrictionLaw.about_neutral`). Without it the neutral line would lie on the centre of a column of elements, and the creepage
under a given force would have a corresponding error.

If an element sticks as a whole, κ does not apply. It is multiplied by r⁴/(1 + r⁴), with r the smallest κ of a column over
the element's own compliance. r falls like the element's width, so this does not change the order of the solution.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.physics.halfspace.elastic import ShearCompliance
from thermoroll_cli.physics.numerics.grid import framed, neighbour_max, sobel
from thermoroll_cli.physics.rolling.rolling_gradient import MARGIN, RollingGradient, RollingOptions, difference
from thermoroll_cli.tools.arrays import AnyArray, Array, Mask

SMALLEST_PRESSURE = 1e-7
"""Pressure over the peak below which elements have no resolved shape."""
SLOPE_ALONG_ROLLING = 1e-6
"""The pressure's slope along x over the steepest one below which the border runs along the rolling direction."""


LEADING_RING = 2
"""Width in elements of the zone where the border causes errors; further in, sticking tractions do not have the shape of the
pressure."""


def leading_ring(pressure: Array, covered: Array) -> Mask:
    """Elements (n, m) up to `LEADING_RING` from the border where the pressure rises along the rolling direction."""
    near = ~framed(covered >= 1.0)
    for _ in range(LEADING_RING):
        near = neighbour_max(near)
    near = near[1:-1, 1:-1]
    along, _ = _slopes(pressure, 1.0, 1.0)
    return near & (covered > 0.0) & (pressure > SMALLEST_PRESSURE * pressure.max()) & (
        along > SLOPE_ALONG_ROLLING * float(np.abs(along).max()))


def known_gradient(pressure: Array, computed: Array, exact: Array, covered: Array) -> Array:
    """E as (3, n, m), its components xx, yy, xy in 1/Pa, zero away from the leading edge.

    `computed` and `exact` (3, n, m) are ∂u_x/∂x and ∂u_y/∂x under tractions (p, 0), (0, p) of their own direction, and the one
    under the other: by the operator (`RollingGradient.of_shape`) and the true ones, dimensionless."""
    ring = leading_ring(pressure, covered)
    return np.asarray(np.where(ring, (exact - computed) / np.where(ring, pressure, 1.0), 0.0))


def continued_gradient(
    pressure: Array, computed: Array, isotropic: Array, dx: float, dy: float, compliance: ShearCompliance
) -> Array:
    """True gradients (3, n, m) for `known_gradient` if only that of the potential ∬p/r is known, `isotropic` (Pa, (n, m)). It
    follows from the normal problem, because u_z closes the gap inside the contact.

    The missing part of the potential's gradient belongs to the border and so varies along its normal n alone. Only the
    directional kernel across n changes, by dir·(I − n nᵀ) times the same."""
    c = compliance
    missing = isotropic - (computed[0] + computed[1]) / (2.0 * c.isotropic + c.directional)
    along, across = _slopes(pressure, dx, dy)
    size = np.hypot(along, across)
    size[size == 0.0] = 1.0
    nx, ny = along / size, across / size
    return computed + missing * np.stack([
        c.isotropic + c.directional * ny * ny, c.isotropic + c.directional * nx * nx, -c.directional * nx * ny])


def _slopes(pressure: Array, dx: float, dy: float) -> tuple[Array, Array]:
    """Sobel differences of p², which is smooth across the border, along x and y."""
    return sobel(framed(pressure**2), dx, dy)


@dataclass(frozen=True)
class EdgeCompliance:
    """K on a bounding box (n, m), components xx, yy, xy in `k` (3, n, m), and that of the trailing border only. Almost all
    of K is zero, but picking the other elements takes longer than multiplying all.

    `partial` marks partly covered elements, `crossed` those in which a neutral line outweighs the compliance of the element;
    `neutral` (n, m) is the compliance of that line, a part of K; None without one."""

    k: AnyArray
    of_trailing: AnyArray
    partial: Mask
    crossed: Mask
    neutral: AnyArray | None

    @property
    def diagonal(self) -> AnyArray:
        """Diagonal of K, (2, n, m)."""
        return self.k[:2]

    def trailing(self, traction: AnyArray) -> AnyArray:
        """K `traction` of the trailing border only, (2, n, m).

        If it slips, its traction is at the bound for any gradient, and K would only reduce the power of the slip."""
        return block_product(self.of_trailing, traction)


def edge_compliance(
    covered: AnyArray, bound: AnyArray, gradient: RollingGradient, leading: AnyArray | None = None,
    variation: AnyArray | None = None, options: RollingOptions | None = None, at_slip: AnyArray | None = None,
) -> EdgeCompliance:
    """K of a contact that covers the shares `covered` of the elements, with Coulomb's `bound` (Pa, 0 outside), for the operator
    `gradient`, all on the bounding box (n, m).

    `leading` (3, n, m), if it is given, replaces K on its elements, because it is more accurate. On elements that are long
    along x the operator is soft for tractions that alternate across rolling; to subtract more than its compliance would let
    rows slip against each other. `variation` (n, m) is half the change of slip across an element (`neutral_compliance`), and
    `at_slip` the bound there if friction depends on slip."""
    options, contact, compliance = options or RollingOptions(), bound > 0.0, gradient.near_border
    dx, dy = gradient.dx, gradient.dy
    share = np.clip(np.where(contact, covered, 1.0), options.smallest_cover, 1.0)
    partial: Mask = share < 1.0
    i, j = np.nonzero(partial)
    around = framed(np.where(contact, covered, 0.0))
    if gradient.mirror is not None:
        around[:, 0] = around[:, 1]
    nx, ny = _border_normal(around, i, j, dx, dy)
    # Without rolling the slip is no gradient, and nothing of one is missing.
    scale = gradient.rolls * np.abs(nx) * (1.0 - share[i, j]) / share[i, j]
    along, across = compliance.along, compliance.across
    k = np.zeros((3, *covered.shape))
    k[:, i, j] = scale * np.stack([along * nx * nx + across * ny * ny, along * ny * ny + across * nx * nx,
                                   (along - across) * nx * ny])
    trailing = np.zeros(covered.shape, dtype=bool)
    trailing[i, j] = nx < 0.0
    if leading is not None:
        known = leading.any(axis=0) & contact
        softest = gradient.alternating_gradient
        trust = min(compliance.trust, softest[0] / (options.deepest * along), softest[1] / (options.deepest * across))
        k[:, known] = (1.0 - trust) * k[:, known] + trust * _limited(leading[:, known], along, across, options)
        # Over an interlayer tractions rise linearly; only the share of the half-spaces rises like a square root.
        k[:, known] /= 1.0 + compliance.interlayer / (along * dx)
        trailing &= ~known
    if gradient.bodies.shear.interlayer and gradient.rolls:
        k[:2] += interlayer_ends(covered, contact, gradient.bodies.shear.interlayer, dx, gradient.weights,
                                 options.smallest_cover)
    neutral, crossed = None, np.zeros_like(contact)
    of_trailing = k * trailing
    if variation is not None:
        own = float(np.mean(gradient.self_gradient))
        neutral, crossed = neutral_compliance(variation, bound if at_slip is None else at_slip, own)
        k[:2] += neutral
    return EdgeCompliance(k, of_trailing, partial, crossed, neutral)


def block_product(block: Iterable[AnyArray], v: AnyArray) -> AnyArray:
    """Symmetric 2×2 matrices, components xx, yy, xy (n, m) in `block`, times the vectors `v` (2, n, m)."""
    xx, yy, xy = block
    x, y = v
    out = np.empty_like(v)
    out_x, out_y = out
    term = np.multiply(xy, y)
    np.multiply(xx, x, out=out_x)
    out_x += term
    np.multiply(yy, y, out=out_y)
    out_y += np.multiply(xy, x, out=term)
    return out


def _limited(k: AnyArray, along: float, across: float, options: RollingOptions) -> AnyArray:
    """Components xx, yy, xy (3, …) limited to the largest values under Hertz pressures, so that slivers do not lose digits."""
    x, y = k[0] / along, k[1] / across
    excess = np.maximum(np.maximum(x, y) * options.smallest_cover, -np.minimum(x, y) / options.deepest)
    return np.asarray(k / np.maximum(1.0, excess))


def _border_normal(c: AnyArray, i: NDArray[np.intp], j: NDArray[np.intp], dx: float, dy: float) -> tuple[AnyArray, AnyArray]:
    """Unit vector along the steepest change of the covered fraction (Sobel differences) at elements (i, j); `c` holds the
    fractions with one more row and column on all sides."""
    along_x, along_y = (d[i, j] for d in sobel(c, dx, dy))
    size = np.hypot(along_x, along_y)
    known = size > 0.0
    safe = np.where(known, size, 1.0)
    # An isolated element has no direction: it is treated as cut across the rolling direction.
    return np.where(known, along_x / safe, 1.0), np.where(known, along_y / safe, 0.0)


LEAST_NORMAL_COMPLIANCE = 1e-3
"""Least |n_x| c, over Σ(1−ν)/G: if the border runs along the rolling direction, slip does not determine its distance."""


def stick_share(
    traction: Array, slip: Array, bound: Array, stick: Mask, covered: Array, dx: float, dy: float, compliance: ShearCompliance
) -> Array:
    """Share of each element that sticks, (n, m): the `covered` share of those marked `stick`, moved to where the downstream
    border of the stick area runs inside elements.

    Arguments are those of `stick_ends`. If stick begins behind slip, its border has no such law and stays between elements."""
    share = covered * stick
    i, j, place = stick_ends(traction, slip, bound, stick, covered, dx, dy, compliance)
    # The border lies between the two centres, and not beyond the contact.
    beyond = np.clip(place - 0.5, -covered[i, j], covered[i + 1, j])
    share[i, j] += np.minimum(beyond, 0.0)
    share[i + 1, j] += np.maximum(beyond, 0.0)
    return share


def stick_ends(
    traction: Array, slip: Array, bound: Array, stick: Mask, covered: Array, dx: float, dy: float, compliance: ShearCompliance
) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Elements (i, j) that stick while (i + 1, j) slips, and how far the border is beyond their centres, from 0 to 1 elements.

    `traction` (Pa) and relative `slip` s/V are (2, n, m), `bound` μp (Pa) and the `covered` fractions (n, m). The reserve of
    friction on the last element that sticks, and the slip on the first one behind it, both root-like, give the border between
    their centres by linear interpolation: on Carter's contact to 0.005 elements for any position (whole elements: 0.3). Over an
    interlayer slip begins at once behind the border, and the reserve is linear."""
    inside = covered > 0.0
    i, j = np.nonzero(stick[:-1] & ~stick[1:] & inside[1:])
    if not i.size:
        return i, j, np.zeros(0)
    size = np.hypot(traction[0], traction[1])
    reserve = np.maximum(bound - size, 0.0) * stick
    speed = np.hypot(slip[0], slip[1]) * (inside & ~stick)
    around = framed(reserve - speed / compliance.along)
    # Repeat the outermost values: np.pad takes several times as long.
    around[0], around[-1] = around[1], around[-2]
    around[:, 0], around[:, -1] = around[:, 1], around[:, -2]
    normal = sobel(around, dx, dy)
    nx, ny = normal[0][i, j] + normal[0][i + 1, j], normal[1][i, j] + normal[1][i + 1, j]
    length = np.hypot(nx, ny)
    length[length == 0.0] = 1.0
    nx, ny = nx / length, ny / length
    tx, ty, force = traction[0, i + 1, j], traction[1, i + 1, j], size[i + 1, j]
    along = ((nx * tx + ny * ty) / np.where(force > 0.0, force, 1.0)) ** 2
    c = compliance.along * along + compliance.across * (1.0 - along)
    outside = speed[i + 1, j] / np.maximum(c * np.abs(nx), LEAST_NORMAL_COMPLIANCE * compliance.along)
    total = reserve[i, j] + outside
    place = np.where(total > 0.0, reserve[i, j] / np.where(total > 0.0, total, 1.0), 0.5)
    if compliance.interlayer:
        # Over an interlayer the traction rises by the slip that follows, over its compliance: the reserve is linear.
        slip_behind = speed[i + 1, j]
        linear = compliance.interlayer / dx * reserve[i, j] / np.where(slip_behind > 0.0, slip_behind, np.inf)
        share = compliance.interlayer / (compliance.interlayer + c * dx)
        place = (1.0 - share) * place + share * np.minimum(linear, 1.0)
    return i, j, place


def neutral_compliance(variation: AnyArray, bound: AnyArray, own: float) -> tuple[AnyArray, Mask]:
    """κ of the module's docstring in 1/Pa, and the mask of the elements whose own compliance it outweighs, both (n, m).

    From the `variation` v of the slip, the Coulomb `bound` μp in Pa, both (n, m), and the compliance `own` of an element in
    1/Pa."""
    inside = bound > 0.0
    compliance = np.where(inside, variation / np.where(inside, bound, 1.0), 0.0)
    # The ratio is that of a column, so that the low pressure at the edge of the contact does not decide whether elements stick.
    highest = bound.max(axis=0)
    ratio = np.where(highest > 0.0, variation.max(axis=0) / np.where(highest > 0.0, highest, 1.0) / own, 0.0)
    # Limited so that the fourth power does not overflow.
    power = np.minimum(ratio, 1e3) ** 4
    return compliance * (power / (1.0 + power)), inside & (ratio > 1.0)


END_CHANGE = 1e-9
"""Relative error of the difference formula below which a row has no end nearby."""


def interlayer_ends(
    covered: AnyArray, contact: Mask, interlayer: float, dx: float, weights: tuple[float, ...], least: float
) -> Array:
    """Error of the difference formula in the gradient of an interlayer's displacement at both ends of rows, in 1/Pa, (n, m).

    Over an interlayer of compliance L (m/Pa) tractions rise from zero linearly, as f = φ (D + φ/2) in element averages with the
    covered share φ and the covered length D upstream, in elements. The exact gradient is L τ/(f dx), the formula gives
    (L/dx) τ/f times the difference of f; `weights` are those of the formula, and φ counts no less than `least`."""
    share = np.where(contact, np.clip(covered, least, 1.0), 0.0)
    upstream = np.cumsum(share, axis=0) - share
    begins = contact & ~np.pad(contact, ((1, 0), (0, 0)))[:-1]
    first = np.maximum.accumulate(np.where(begins, np.arange(len(share))[:, None], 0), axis=0)
    upstream -= np.take_along_axis(upstream, first, axis=0)
    profile = share * (upstream + 0.5 * share)
    computed = difference(np.pad(profile, ((MARGIN, MARGIN), (0, 0))), weights, 1.0)
    missed = (1.0 - computed) / np.where(contact, profile, 1.0)
    ends = contact & (np.abs(1.0 - computed) > END_CHANGE)
    return np.asarray(np.where(ends, interlayer / dx * missed, 0.0))
