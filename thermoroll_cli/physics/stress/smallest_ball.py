"""Smallest enclosing balls of many small point sets at once.

Shakedown, alternating plasticity and Dang Van's criterion all need the centre whose largest distance from a set of stress
states is smallest (Melan's residual stress). The primal problem

    R² = min over c of max over i of |P_i − c|² + g_i

has the dual: maximise Σ λ_i (|P_i|² + g_i) − |Σ λ_i P_i|² over λ ≥ 0, Σ λ_i = 1, with c = Σ λ_i P_i. At most d + 1 of the λ_i
are positive. The algorithm is Wolfe's (Finding the nearest point in a polytope, Math. Programming 11, 1976): the farthest
point joins the basis, and the basis is solved exactly, dropping points whose λ would become negative.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.tools.arrays import Array

TOLERANCE = 1e-11
"""Relative excess of the farthest point's squared distance over R² at which a ball is accepted; the error of centres is about
the square root of this number."""
MOST_ROUNDS = 500
"""Points that may join a basis before the search is given up; 5 to 20 are usual."""
REGULARISATION = 1e-13
"""Added to the diagonal, relative to its largest entry: d + 2 points are affinely dependent, and the solution then points along
the direction in which the dual grows without bound, until the first λ vanishes."""


class Balls(NamedTuple):
    """Centres (B, d), squared radii (B,) and the basis of each ball: indices (B, d + 2) with their multipliers λ."""

    centres: Array
    squared_radii: Array
    basis: NDArray[np.intp]
    multipliers: Array


def smallest_balls(points: Array, heights: Array | None = None, start: Balls | None = None) -> Balls:
    """Smallest balls around `points` (B, n, d) with squared distances |P − c|² + `heights` (B, n; default 0).

    `start` are balls of neighbouring sets; the search begins with points of the same indices. Raises ArithmeticError if a ball
    is not found, which does not happen for finite points."""
    count, _, dimension = points.shape
    squares = np.einsum("bnd,bnd->bn", points, points)
    lifted = squares if heights is None else squares + heights
    slots = dimension + 2
    if start is None:
        basis = np.zeros((count, slots), dtype=np.intp)
        basis[:, 0] = np.argmax(lifted, axis=1)
        multipliers = np.zeros((count, slots))
        multipliers[:, 0] = 1.0
    else:
        basis, multipliers = start.basis.copy(), start.multipliers.copy()
    every = np.arange(count)
    _solve_bases(points, lifted, basis, multipliers, every)
    squared_radii = np.zeros(count)
    centres = np.zeros((count, dimension))
    active = every
    for _ in range(MOST_ROUNDS):
        chosen = points[active[:, None], basis[active]]
        centre = np.einsum("bs,bsd->bd", multipliers[active], chosen)
        centres[active] = centre
        distances = lifted[active] - 2.0 * np.einsum("bnd,bd->bn", points[active], centre)
        farthest = np.argmax(distances, axis=1)
        offset = np.einsum("bd,bd->b", centre, centre)
        reach = distances[np.arange(active.size), farthest] + offset
        within = np.einsum("bs,bs->b", multipliers[active], lifted[active[:, None], basis[active]]) - offset
        squared_radii[active] = np.maximum(reach, 0.0)
        outside = reach - within > TOLERANCE * np.maximum(reach, np.finfo(float).tiny)
        # A farthest point that is in the basis already lies on the ball to rounding.
        outside &= ~((basis[active] == farthest[:, None]) & (multipliers[active] > 0.0)).any(axis=1)
        active, farthest = active[outside], farthest[outside]
        if active.size == 0:
            return Balls(centres, squared_radii, basis, multipliers)
        free = np.argmin(multipliers[active], axis=1)
        basis[active, free] = farthest
        multipliers[active, free] = 0.0
        _solve_bases(points, lifted, basis, multipliers, active, joined=free)
    raise ArithmeticError(f"no smallest ball after {MOST_ROUNDS} points")


def _solve_bases(
    points: Array, lifted: Array, basis: NDArray[np.intp], multipliers: Array, active: NDArray[np.intp],
    joined: NDArray[np.intp] | None = None,
) -> None:
    """Optimal multipliers of the bases of the `active` sets, in place; the slot that has `joined` starts from λ = 0."""
    slots = basis.shape[1]
    used = multipliers[active] > 0.0
    if joined is not None:
        used[np.arange(active.size), joined] = True
    current = multipliers[active]
    todo = np.arange(active.size)
    for _ in range(2 * slots):
        rows, mask = active[todo], used[todo]
        chosen = points[rows[:, None], basis[rows]]
        # Differences from one of the points keep the digits of small balls far from the origin.
        origin = chosen[np.arange(todo.size), np.argmax(mask, axis=1)]
        relative = (chosen - origin[:, None]) * mask[:, :, None]
        gram = 2.0 * relative @ relative.transpose(0, 2, 1)
        heights = lifted[rows[:, None], basis[rows]]
        heights = heights - 2.0 * np.einsum("bsd,bd->bs", chosen, origin) + np.einsum("bd,bd->b", origin, origin)[:, None]
        size = np.trace(gram, axis1=1, axis2=2)
        size[size == 0.0] = 1.0
        system = np.zeros((todo.size, slots + 1, slots + 1))
        system[:, :slots, :slots] = gram / size[:, None, None]
        diagonal = np.arange(slots)
        system[:, diagonal, diagonal] += np.where(mask, REGULARISATION, 1.0)
        system[:, slots, :slots] = system[:, :slots, slots] = mask
        right = np.zeros((todo.size, slots + 1, 1))
        right[:, :slots, 0] = np.where(mask, heights / size[:, None], 0.0)
        right[:, slots, 0] = 1.0
        wanted = np.linalg.solve(system, right)[:, :slots, 0] * mask
        here = current[todo]
        negative = (wanted < 0.0) & mask
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = np.where(negative, here / (here - wanted), np.inf)
        step = np.minimum(ratios.min(axis=1), 1.0)
        moved = np.maximum(here + step[:, None] * (wanted - here), 0.0) * mask
        dropped = np.argmin(ratios, axis=1)
        some = negative.any(axis=1)
        moved[some, dropped[some]] = 0.0
        current[todo] = moved / moved.sum(axis=1, keepdims=True)
        used[todo] = mask & (current[todo] > 0.0)
        todo = todo[some]
        if todo.size == 0:
            break
    multipliers[active] = current * used
