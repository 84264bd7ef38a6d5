"""Frictionless normal contact: primal–dual active set with preconditioned conjugate gradients (Eqs. 1–6).

**Border** (`border_elements`): its place inside elements, and the load that these carry.
Near the border of any smooth contact, at a distance d from it, the half-space is in plane strain and

    p = A sqrt(d)  inside,      h = 4A/(3E*) d^{3/2}  outside,

with one and the same A (a cylinder; Johnson, Contact Mechanics, 4.2). So p² is smooth, and −A² (3E* h/4A)^{2/3} continues it
to the elements outside. A paraboloid is fitted to both sides, so the border is interpolated. From the inside alone p² would
have to be extrapolated over two elements, and a thermal bulge curves it too much for that.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.physics.contact.active_set import (
    Approach,
    Close,
    Closed,
    Given,
    NormalSolution,
    approach_of,
    carrying,
    settle,
)
from thermoroll_cli.physics.contact.stiff_layers import Blocks, has_stiff_layers
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.numerics.convolution import (
    Convolution,
    around,
    in_pairs,
    multiply,
)
from thermoroll_cli.physics.numerics.grid import Grid, framed, neighbour_max, neighbour_sum
from thermoroll_cli.physics.numerics.krylov import Vector, gmres
from thermoroll_cli.tools.arrays import AnyArray, Array, Mask

FIRST_REDUCTION = 0.1
"""Factor by which the gap on an active set is reduced before the set is updated: the first sets are far off."""
ANEW = 1e8
"""Growth of the squared residual from step to step that no contact has: the step before ended in rounding."""
PRESSURE_SHARE = 0.005
"""Weight of the relative pressure error in the residual below stiff coatings, where short waves hardly move the surface."""
BORDER_PASSES = 3
"""Passes that drop elements under tension after the border was resolved; if tension remains, whole elements are kept."""
BORDER_ITERATIONS = 60
"""Conjugate gradients per such pass, which start from the solution with whole elements."""
MOST_ITERATIONS = 120
"""GMRES steps per active set: four to eight are usual."""


class NormalSolver:
    """Keeps the kernel of the `bodies` and the plans for one grid. `applications` counts convolutions.

    If the common surface is inclined, `cosine` (ny,) is the cosine w of its inclination: pressures are then w p, which carry
    the load, and gaps and displacements are those along the normals over w, which an approach closes evenly."""

    def __init__(self, grid: Grid, bodies: Bodies, cosine: Array | None = None) -> None:
        self.grid, self.bodies = grid, bodies
        self._cosine = None if cosine is None or (cosine == 1.0).all() else cosine
        self.applications = 0
        self._convolution = Convolution(*grid.shape)
        self._table = bodies.normal_table(*grid.shape, grid.dx, grid.dy)
        self._kernel = in_pairs(self._table.symbol((self._convolution.px, self._convolution.py)))
        self._blocks = Blocks(grid, bodies.at_once) if has_stiff_layers(grid, bodies) else None
        self._hat = self._convolution.empty_spectrum()

    @cached_property
    def _inverse(self) -> tuple[Convolution, AnyArray]:
        """A plane that the kernel is wrapped around, which costs a preconditioner nothing, and the inverse of its symbol."""
        grid, period = self.grid, around(self.grid.shape)
        symbol = self.bodies.normal_symbol(self._table, period, grid.dx, grid.dy)
        # Rounding could leave a wavenumber without stiffness; the kernel itself is positive.
        stiff = symbol if self.bodies.relaxes else np.maximum(symbol, 1e-12 * symbol.max())
        return Convolution(*grid.shape, padded=period), in_pairs(1.0 / stiff)

    def displacement(self, pressure: Array) -> Array:
        """u_z^e = A p in m, by free-space convolution (Eq. 6)."""
        self.applications += 1
        hat = self._convolution.forward(pressure if self._cosine is None else pressure / self._cosine, out=self._hat)
        displacement = self._convolution.inverse(multiply(hat, self._kernel, out=hat))
        return displacement if self._cosine is None else displacement / self._cosine

    def _respond(self, pressure: Array, _: Mask) -> Array:
        return self.displacement(pressure)

    def hysteresis(self, pressure: Array) -> float:
        """∬ p ∂u_z/∂x in N (of a line contact N/m): what `pressure` (Pa, (nx, ny)) loses in bodies that relax, per distance
        rolled."""
        if not self.bodies.relaxes:
            return 0.0
        hat = self._convolution.forward(pressure)
        return -self._convolution.drift(np.abs(hat) ** 2 * self._kernel.imag) * self.grid.element_area / self.grid.dx

    @property
    def below_stiff_layers(self) -> bool:
        return self._blocks is not None

    def preconditioner(self, contact: Mask, *, at_load: bool = True) -> Callable[[Array], Array]:
        """Displacement on the `contact`, zero outside, to about the pressure that causes it; `at_load` to one without load."""
        plane, symbol = self._inverse

        def periodic(residual: Array) -> Array:
            hat = plane.forward(residual, out=plane.plane)
            return np.asarray(plane.inverse(multiply(hat, symbol, out=hat)) * contact)

        inverse = periodic if self._blocks is None else self._blocks.preconditioner(contact, periodic)

        def without_load(residual: Array) -> Array:
            z = inverse(residual)
            z -= contact * (z.sum() / np.count_nonzero(contact))
            return z

        return without_load if at_load else inverse

    def closed_by_gmres(
        self, respond: Callable[[Array, Mask], Array], gap: Array, given: Given, scale: float | None, contact: Mask,
        pressure: Array, closing: Array, tolerance: float, reduction: float, most: int,
    ) -> Closed:
        """The gap on the `contact` closed by GMRES, for bodies that `respond` to pressures by no symmetric operator (m);
        `closing` is their response to `pressure`. Without change of load if that is given; errors are over `scale` (m; None:
        the mean response)."""
        at_load = not isinstance(given, Approach)
        unit = max(float(np.abs(closing[contact]).mean()), 1e-300) if scale is None else scale

        def residual(closing: Array) -> tuple[Vector, float, float]:
            remaining = (closing + gap)[contact]
            approach = approach_of(given, float(remaining.mean()))
            remaining = approach - remaining
            return remaining, approach, float(np.sqrt(np.mean(remaining**2))) / unit

        def on_grid(values: Vector) -> Array:
            field = np.zeros(contact.shape)
            field[contact] = values
            return field

        def inside(_: Vector, image: Vector) -> Vector:
            values = image.reshape(contact.shape)[contact]
            return np.asarray(values - values.mean() if at_load else values)

        inverse = self.preconditioner(contact, at_load=at_load)
        remaining, approach, error = residual(closing)
        if error <= tolerance:
            return Closed(pressure, closing, approach, error, unit, 0)
        solution = gmres(lambda values: respond(on_grid(values), contact).ravel(), inside,
                         lambda values: inverse(on_grid(values))[contact], remaining, max(tolerance / error, reduction),
                         min(MOST_ITERATIONS, most))
        # One or two elements, whose pressures the load and the symmetry decide: nothing can be corrected.
        if solution.iterations:
            pressure, closing = pressure + on_grid(solution.step), closing + solution.image.reshape(contact.shape)
            _, approach, error = residual(closing)
        return Closed(pressure, closing, approach, error, unit, solution.iterations)

    def _close(self, gap: Array, given: Given) -> Close:
        """How the gap is closed on one active set."""
        if not self.bodies.relaxes:
            return partial(self._conjugate_gradients, gap, given)
        return partial(self.closed_by_gmres, self._respond, gap, given, None)

    def _conjugate_gradients(
        self, gap: Array, given: Given, free: Mask, pressure: Array, displacement: Array, tolerance: float, reduction: float,
        max_iterations: int,
    ) -> Closed:
        """Close the gap on the `free` elements at constant load or at the approach `given`, down to `tolerance` or by the
        factor `reduction`."""
        precondition = self.preconditioner(free, at_load=not isinstance(given, Approach))
        count = np.count_nonzero(free)
        weight = free / count
        scale = max(float(np.abs(displacement[free]).mean()), 1e-300)

        def residual_of(pressure: Array, displacement: Array) -> tuple[Array, float, float, Array | None]:
            residual = displacement + gap
            approach = approach_of(given, float(np.vdot(residual, weight)))
            np.subtract(approach, residual, out=residual)
            residual *= free
            error, z = float(np.linalg.norm(residual)) / np.sqrt(count) / scale, None
            if self._blocks is not None:
                z = precondition(residual)
                error = max(error, PRESSURE_SHARE * float(np.abs(z).max() / np.abs(pressure).max()))
            return residual, approach, error, z

        residual, approach, error, z = residual_of(pressure, displacement)
        goal = max(reduction * error, tolerance)
        direction = residual
        rz_old = 0.0
        iterations = 0
        while error > goal and iterations < max_iterations:
            if z is None:
                z = precondition(residual)
            rz = float(np.vdot(residual, z))
            if rz <= 0.0:  # the circulant inverse is only nearly positive: plain CG for this step
                z, rz_old = residual, 0.0
                rz = float(np.vdot(residual, z))
            # From a residual that is mere rounding, as from none, it begins anew.
            direction = z + direction * (rz / rz_old) if rz < ANEW * rz_old else z
            if rz <= 0.0:
                break  # a contact of one element: its pressure follows from the load
            rz_old = rz
            image = self.displacement(direction)
            step = rz / float(np.vdot(direction, image))
            pressure = pressure + step * direction
            image *= step
            displacement = displacement + image
            residual, approach, error, z = residual_of(pressure, displacement)
            iterations += 1
        return Closed(pressure, displacement, approach, error, scale, iterations)

    def solve(
        self, gap: Array, given: Given, pressure: Array, tolerance: float = 1e-9, max_iterations: int = 400
    ) -> NormalSolution:
        """Contact pressure of surfaces `gap` apart (m, (nx, ny)) under a normal force (N; any constant in the gap), or at an
        `Approach`.

        `pressure` is the first guess; where it is positive is the first guess of the contact. On the active set A p = δ − h
        is solved, under ∬p = W in the subspace of constant load; then p < 0 is dropped, h < 0 added, and so on.
        """
        if not isinstance(given, Approach):
            given = given / self.grid.element_area
        settled = settle(self._respond, self._close(gap, given), gap, given, pressure, tolerance,
                         reduction=FIRST_REDUCTION, most_sets=max_iterations, most_iterations=max_iterations,
                         hand_over=_handed_over if self.bodies.dispersive else None)
        displacement = self.displacement(settled.pressure)  # without the rounding of all steps
        left = np.where(settled.contact, 0.0, displacement + gap - settled.approach)
        return replace(settled, displacement=displacement, gap=left)

    def load(self, pressure: Array) -> float:
        """Normal force in N."""
        return float(pressure.sum()) * self.grid.element_area

    def border(self, solution: NormalSolution, *, mirrored: bool = False) -> tuple[Mask, Array, Array]:
        """`border_elements` of a solution with whole elements."""
        near = self.bodies.near_border(self.grid.dx, self.grid.dy)
        return border_elements(solution.pressure, solution.contact, solution.gap, self.grid, near.contact_modulus,
                               near.shear.trust, mirrored=mirrored)

    def refine(
        self, solution: NormalSolution, gap: Array, normal_force: float, tolerance: float = 1e-9, *, mirrored: bool = False
    ) -> NormalSolution:
        """Resolve the border inside its elements (see `border_elements`): they keep the load that the continued pressure
        gives them, the others are solved for once more. Pressures are then averages over elements.

        Errors of the element averages of a Hertz pressure are 4–5 times smaller than by collocation on whole elements; those of
        the contact area, also of contacts far from Hertz's, are about 1e-3 at N = 32 and 1e-4 at N = 128. A second pass would
        be worse: the errors of whole elements on both sides of the border cancel, those beside elements of known load do not.
        """
        border, load, covered = self.border(solution, mirrored=mirrored)
        free = solution.contact & ~border
        fixed = np.where(border, load, 0.0)
        given = normal_force / self.grid.element_area
        wanted = given - float(fixed.sum())
        unrefined = replace(solution, covered=covered)
        if wanted <= 0.0 or not free.any():
            return unrefined
        pressure = np.where(free, solution.pressure, 0.0)
        for _ in range(BORDER_PASSES):
            if not pressure.any():  # a few elements, which all turn out to be border
                return unrefined
            pressure = carrying(wanted, pressure) + fixed
            state = self._close(gap, given)(free, pressure, self.displacement(pressure), tolerance, 0.0, BORDER_ITERATIONS)
            negative = state.pressure < 0.0
            if not negative.any():
                break
            free = free & ~negative
            pressure = np.where(free, state.pressure, 0.0)
            covered = np.where(negative, 0.0, covered)
        else:
            return unrefined
        opening = np.maximum(state.displacement + gap - state.approach, 0.0)
        return replace(solution, pressure=state.pressure, covered=covered, displacement=state.displacement,
                       gap=np.where(covered > 0.0, 0.0, opening), approach=state.approach)


def _handed_over(pressure: Array, drop: Mask, contact: Mask) -> Array:
    """`pressure` with the tension of the elements that `drop` shared by the elements of the `contact` around each: stiff layers
    feel a border's load and moment from afar, and the next contact begins that much closer."""
    sharing = neighbour_sum(contact.astype(float))
    return pressure + neighbour_sum(np.where(drop & (sharing > 0.0), pressure / np.maximum(sharing, 1.0), 0.0))


Index = NDArray[np.intp]

FIT_REACH = 4
"""Elements up to this far away, along each axis, are fitted."""
FIT_WEIGHT_LENGTH = 2.0
"""Distance in elements at which a fitted element has lost 40 % of its weight (a Gaussian): p² is curved within a few elements
where a thermal bulge squeezes the border."""
SAMPLES_PER_SIDE = 8
"""Sample points per side of a border element."""
LOADED_FROM, OPEN_FROM = 0.25, 1.0
"""An element counts as loaded from this share of the highest p² beside it, and as open from this distance (in elements) outside
the border. Below these its weight and that of its neighbours fall smoothly to zero: border elements that flip in and out during
the coupled iteration must not switch any weights."""
TOLERABLE_BEND = 0.05
"""An outer element with a second-order term of the gap this large, relative, has half the weight."""
TOLERABLE_MISFIT = 0.25
"""A paraboloid that misses the fitted elements by this distance of the border, in elements, has half the trust."""
ROUNDING_PRESSURE = 1e-12
"""Pressures below this fraction of the peak are rounding noise."""
TOLERABLE_CHANGE = 0.2
"""Largest difference between the loads of an element by the fit and by whole elements, over the highest pressure beside it
(0.17 at the border of ellipses from N = 16 to 128). If the difference is larger, the pressure falls within an element, as
at the end of a roller, and no paraboloid describes it."""
FEWEST_FITTED = 8
"""A paraboloid has six coefficients; fewer fitted elements than this are not trusted to give them."""
SINGULAR_DETERMINANT = 1e-9
"""Determinant of the scaled normal equations below which a direction is not determined beyond rounding."""


def border_elements(
    pressure: Array, contact: Mask, gap: Array, grid: Grid, contact_modulus: float, certainty: float = 1.0, *,
    mirrored: bool = False,
) -> tuple[Mask, Array, Array]:
    """Border of the contact from the `pressure` (Pa) inside it and the `gap` (m) around it, all (nx, ny).

    `pressure` and `gap` belong to whole elements, `contact` is the mask of those that touch; `contact_modulus` is E* in Pa, and
    `certainty`, 0 to 1, says how well half-spaces of that modulus describe the surfaces within an element of the border. With
    `mirrored` all is even in y, and only the elements y > 0 of an even number are fitted.
    Returns the mask of elements at the border (partly covered, or next to such), and on these the element averages of the
    pressure and the covered fractions that the continued p² implies; elsewhere the pressure as given and 1 or 0.
    """
    if math.isinf(grid.dy):
        # A fit reaches over so many lines, which are all alike.
        lines, middle = 2 * FIT_REACH + 1, slice(FIT_REACH, FIT_REACH + 1)
        border, load, covered = border_elements(
            np.repeat(pressure, lines, axis=1), np.repeat(contact, lines, axis=1), np.repeat(gap, lines, axis=1),
            replace(grid, ny=lines, dy=grid.dx), contact_modulus, certainty)
        return border[:, middle], load[:, middle], covered[:, middle]
    scale, half = max(float(pressure.max()), 1e-300), mirrored * (grid.ny // 2)

    def places(mask: Mask) -> tuple[Index, Index]:
        i, j = np.nonzero(mask[:, half:])
        return i, j + half

    def complete(*fields: AnyArray) -> None:
        for field in fields:
            field[:, :half] = field[:, : -half - 1 : -1]

    # Whole elements next to the border carry up to 3 % too much pressure, and the gap of the first ones outside is as much too
    # large: each shifts the border by 0.02 elements, one inwards and one outwards, elements right at the border by up to 0.05.
    square = np.where(contact, pressure / scale, 0.0) ** 2
    loaded = np.minimum(square / np.maximum(LOADED_FROM * neighbour_max(square), 1e-300), 1.0)
    weight = 1.0 - neighbour_max(1.0 - loaded)
    highest_neighbour = neighbour_max(loaded)
    i, j = places((highest_neighbour > 0.0) & ~contact & (gap > 0.0))
    coefficients, trust = _paraboloids(square, weight, i, j)
    square[i, j], bend = _continued(coefficients, gap[i, j] * contact_modulus / scale, grid)
    away = -square[i, j] / np.maximum(np.hypot(coefficients[:, 1], coefficients[:, 2]), 1e-300)
    weight[i, j] = trust * highest_neighbour[i, j] * np.minimum(away / OPEN_FROM, 1.0) / (1.0 + (bend / TOLERABLE_BEND) ** 2)
    complete(square, weight)
    i, j = places(neighbour_max(contact) & neighbour_max(~contact))
    coefficients, trust = _paraboloids(square, weight, i, j)
    fitted = trust > 0.0
    i, j, coefficients, trust = i[fitted], j[fitted], coefficients[fitted], trust[fitted]
    part, root = _sampled(coefficients)
    # Beside a contact of almost no pressure any change is too large.
    beside = np.maximum(neighbour_max(pressure)[i, j], ROUNDING_PRESSURE * scale)
    change = np.abs(scale * root - np.where(contact, pressure, 0.0)[i, j]) / beside
    trust = certainty * trust * np.minimum(1.0, TOLERABLE_CHANGE / np.maximum(change, 1e-300)) ** 4
    covered = contact.astype(np.float64)
    load = np.where(contact, pressure, 0.0)
    covered[i, j] += trust * (part - covered[i, j])
    load[i, j] += trust * (scale * root - load[i, j])
    border = np.zeros_like(contact)
    border[i, j] = True
    complete(covered, load, border)
    covered[load <= 0.0] = 0.0
    load[covered <= 0.0] = 0.0
    return border, load, covered


def _continued(coefficients: Array, gap: Array, grid: Grid) -> tuple[Array, Array]:
    """p² continued to elements outside, from their gap: `gap` is E*h in m, and p² is measured in the square of that unit.

    `coefficients` are those of paraboloids of p² around these elements, fitted to the inside. They give A² = |∇p²| at the
    border, and the next terms. With p² = A²(d + c d²), the cylinder has h ~ d^{3/2} (1 − 3/10 c d) (p and h' are the real
    parts of one analytic function on both sides); a border of curvature κ adds −κd/5 (from Hertz's sphere). Also returns that
    relative correction of the distance."""
    _, u, v, uu, uv, vv = coefficients.T
    u, v, uu, uv, vv = u / grid.dx, v / grid.dy, 2.0 * uu / grid.dx**2, uv / (grid.dx * grid.dy), 2.0 * vv / grid.dy**2
    slope = np.maximum(np.hypot(u, v), 1e-300)
    u, v = u / slope, v / slope
    along, across = uu * u * u + 2.0 * uv * u * v + vv * v * v, uu * v * v - 2.0 * uv * u * v + vv * u * u
    # From the centre of the element back to the border; a wild fit must not reverse the slope.
    inwards = np.clip(-coefficients[:, 0] / slope, 0.0, 3.0 * max(grid.dx, grid.dy))
    steepness = np.maximum(slope + along * inwards, 0.2 * slope)
    distance = (0.75 * gap / np.sqrt(steepness)) ** (2.0 / 3.0)
    bend = -(0.4 * along + 2.0 / 15.0 * across) / steepness * distance
    return -steepness * distance * (1.0 + np.clip(bend, -0.5, 0.5)), bend


def _sampled(coefficients: Array) -> tuple[Array, Array]:
    """Share of the element where each paraboloid is positive, and the element average of its square root there."""
    t = (np.arange(SAMPLES_PER_SIDE) + 0.5) / SAMPLES_PER_SIDE - 0.5
    u, v = (o.ravel() for o in np.meshgrid(t, t, indexing="ij"))
    value = coefficients @ np.stack([np.ones_like(u), u, v, u * u, u * v, v * v])
    slope = np.maximum(np.hypot(coefficients[:, 1], coefficients[:, 2]), 1e-300)
    # A sample cell cut by the border counts in part; this keeps the fraction continuous.
    part = np.clip(0.5 + value * (SAMPLES_PER_SIDE / slope)[:, None], 0.0, 1.0)
    return part.mean(axis=1), np.sqrt(np.maximum(value, 0.0)).mean(axis=1)


_U, _V = (offset.ravel() for offset in np.mgrid[-FIT_REACH : FIT_REACH + 1, -FIT_REACH : FIT_REACH + 1])
"""Elements within reach, along x and y."""
_GAUSSIAN = np.exp(-0.5 * (_U**2 + _V**2) / FIT_WEIGHT_LENGTH**2)
_POWERS = [(degree - k, k) for degree in range(5) for k in range(degree + 1)]
_MONOMIALS = np.stack([_U**a * _V**b for a, b in _POWERS], axis=1).astype(float)
"""1, u, v, u², uv, v², and those of degrees three and four: (81, 15)."""
_PRODUCTS = np.array([[_POWERS.index((a + c, b + d)) for c, d in _POWERS[:6]] for a, b in _POWERS[:6]])
"""Which monomial the product of any two of the first six is."""


def _paraboloids(square: Array, weight: Array, i: Index, j: Index) -> tuple[Array, Array]:
    """Least-squares paraboloid of `square` around each element (i, j), fitted with `weight` to the elements within reach.

    Returns (m, 6) coefficients of 1, u, v, u², uv, v² in elements from the centre of (i, j), and how far each fit can be
    trusted, from 1 (exact) to 0 (not determined): a trust that falls smoothly keeps the coupled iteration from jumping."""
    width = square.shape[1] + 2 * FIT_REACH
    places = ((i + FIT_REACH) * width + j + FIT_REACH)[:, None] + (_U * width + _V)
    w = framed(weight, FIT_REACH).ravel()[places]
    values = framed(square, FIT_REACH).ravel()[places]
    weighted = w * values
    moments = w @ (_GAUSSIAN[:, None] * _MONOMIALS)
    normal, total = moments[:, _PRODUCTS], moments[:, 0]
    right = weighted @ (_GAUSSIAN[:, None] * _MONOMIALS[:, :6])
    # Fitted elements in a single row or column do not determine all coefficients: the determinant of the scaled matrix shows
    # it.
    diagonal = np.sqrt(np.maximum(np.einsum("maa->ma", normal), 1e-300))
    scaled = normal / diagonal[:, :, None] / diagonal[:, None, :]
    usable = (np.count_nonzero(w, axis=1) >= FEWEST_FITTED) & (np.linalg.det(scaled) > SINGULAR_DETERMINANT)
    out = np.zeros((len(i), 6))
    if usable.any():
        solution = np.linalg.solve(scaled[usable], (right / diagonal)[usable][:, :, None])[:, :, 0]
        out[usable] = solution / diagonal[usable]
    missed = (weighted * values) @ _GAUSSIAN - np.einsum("ma,ma->m", out, right)
    misfit = np.sqrt(np.maximum(missed, 0.0) / np.maximum(total, 1e-300))
    shift = misfit / np.maximum(np.hypot(out[:, 1], out[:, 2]), 1e-300) / TOLERABLE_MISFIT
    return out, np.where(usable, 1.0 / (1.0 + np.minimum(shift, 1e9) ** 4), 0.0)
