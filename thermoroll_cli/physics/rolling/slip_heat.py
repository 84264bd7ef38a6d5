"""Distribution of the heat of slip along rows: the heat of each element, and its change along x within the element.

The power is τ·s plus the part that the discretisation dissipates, `lost` of each element (`TangentialSolution`): with it the
power of each row is correct, and the sum is exactly the work of the forces. The heat of single elements at the beginning of a
slip zone is wrong, though: slip starts like a square root at a place inside an element (`stick_ends`), and behind a stick area
of the length L it is close to Carter's (1926)

    s ∝ sqrt(d (L + d)) ≈ sqrt(L d) (1 + d/2L)     at the distance d from the border,

The total heat of the first elements of a zone is therefore distributed like sqrt(d) (1 + B d), continuous with the next
element. On the last elements, where slip is smooth, it follows the pressure, which ends like a square root. Temperatures of
zones of few elements depend on that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.physics.halfspace.elastic import ShearCompliance
from thermoroll_cli.physics.halfspace.thermal import slopes
from thermoroll_cli.physics.rolling.element_borders import stick_ends
from thermoroll_cli.physics.rolling.newton import TangentialProblem
from thermoroll_cli.physics.rolling.rolling_solver import TangentialSolution
from thermoroll_cli.tools.arrays import Array, Mask

ONSET_ELEMENTS = 4
"""Elements, beginning with the last one that sticks, whose heat follows the root: errors of slip on them are 6, 4, 1.5 and 0.7
% of its maximum. With more elements the root would reach the end of short zones."""
LEAST_BEND, MOST_BEND = -0.15, 0.3
"""Bounds of B per element, which makes the root continuous with the slip behind it. The lower bound belongs to contacts so
slender that slip stops growing, the upper one to Carter's slip behind a short stick area."""
LEAST_ZONE_ELEMENTS = 5
"""Least elements of a zone whose last three follow the pressure: the slip continued to them must not be that of its
beginning."""
WHOLE_COVER = 0.8
"""Covered fraction above which the last element but one counts as covered."""


class _Onset(NamedTuple):
    """Beginnings of slip zones: `rows`, `columns` of their first elements, (zones, ONSET_ELEMENTS + 1), and the mask `inside`
    of those that belong to the zone. On them root-like slip times μp has the means `weight`, centred at the distance `centre`
    from the border in elements, and changes through an element by `slope` times its mean. `bend` is B of Carter's slip per
    element."""

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    inside: Mask
    weight: Array
    centre: Array
    slope: Array
    bend: Array


def heat_of_slip(
    solution: TangentialSolution, problem: TangentialProblem, rigid: Array, compliance: ShearCompliance, dx: float, dy: float
) -> tuple[Array, Array]:
    """Heat flux over V in Pa, element averages ≥ 0, (n, m), whose sum is the work of the tractions on the `rigid` slip
    (2, n, m), less what is lost inside the bodies; and its change along x through each element, limited so that heat is nowhere
    negative at the front of an element, which would make surfaces colder than their surroundings."""
    slips = (problem.covered > 0.0) & ~solution.stick
    zones = _zones(slips)
    onset = _onset(solution, problem, zones, slips, compliance, dx, dy)
    heat = _balanced(solution, zones, slips, onset)
    heat = _following_the_pressure(heat, solution, problem.covered, slips)
    heat = np.maximum(_following_the_root(heat, onset), 0.0)
    total, work = float(heat.sum()), float((solution.traction * rigid).sum()) - solution.hysteresis
    heat *= max(work, 0.0) / total if total > 0.0 else 0.0
    return heat, np.minimum(_slopes(heat, onset, problem.covered, slips), 2.0 * heat)


def _zones(slips: Mask) -> NDArray[np.intp]:
    """Number of the zone of each element, (n, m): consecutive elements that slip, with the sticking ones in front of them."""
    rows = slips.T
    first = np.ones_like(rows)
    first[:, 1:] = rows[:, :-1] & ~rows[:, 1:]
    return np.asarray((np.cumsum(first.ravel()) - 1).reshape(rows.shape).T)


def _onset(
    solution: TangentialSolution, problem: TangentialProblem, zones: NDArray[np.intp], slips: Mask, compliance: ShearCompliance,
    dx: float, dy: float,
) -> _Onset:
    """The first elements of all zones that begin behind stick."""
    i, j, place = stick_ends(
        solution.traction, solution.slip, problem.traction_bound, solution.stick, problem.covered, dx, dy, compliance)
    step = np.arange(ONSET_ELEMENTS + 1)
    rows, columns = np.minimum(i[:, None] + step, len(slips) - 1), np.broadcast_to(j[:, None], (len(i), ONSET_ELEMENTS + 1))
    inside = (i[:, None] + step < len(slips)) & (zones[rows, columns] == zones[i, j][:, None])
    covered = problem.covered[rows, columns]
    near = step - 0.5 - place[:, None]
    covered = np.where(covered > 0.0, covered, 1.0)
    root, centre = _root(np.maximum(near, 0.0), np.maximum(near + covered, 0.0))
    weight = root / covered * problem.traction_bound[rows, columns] * inside
    known = (weight[:, :ONSET_ELEMENTS].sum(axis=1) > 0.0)[:, None] & inside
    bend = 0.5 / (_run_lengths(solution.stick)[i, j] - 0.5 + place)
    return _Onset(rows, columns, known, weight, centre, 12.0 * (centre - near - 0.5) * (weight > 0.0), bend)


def _root(near: Array, far: Array) -> tuple[Array, Array]:
    """Integral of sqrt(d) over `near` ≤ d ≤ `far`, and the centre of that."""
    area = (far**1.5 - near**1.5) / 1.5
    return area, (far**2.5 - near**2.5) / 2.5 / np.where(area > 0.0, area, 1.0)


def _run_lengths(mask: Mask) -> Array:
    """Length of the run of True along x that ends at each element."""
    row = np.arange(1.0, len(mask) + 1.0)[:, None]
    return np.asarray(row - np.maximum.accumulate(np.where(mask, 0.0, row), axis=0))


def _balanced(solution: TangentialSolution, zones: NDArray[np.intp], slips: Mask, onset: _Onset) -> Array:
    """Heat of the elements that conserves the power of each zone: τ·s and the lost power, of either sign. Heat of elements that
    stick goes to the last of them. Zones without a root distribute the difference in proportion to the lost power."""
    count = int(zones.max()) + 1

    def of_zones(field: Array) -> Array:
        return np.bincount(zones.ravel(), field.ravel(), count).astype(np.float64)

    resolved = np.maximum((solution.traction * solution.slip).sum(axis=0), 0.0)
    taken = np.maximum(solution.lost, 0.0)
    missing, losses, made = of_zones(solution.lost), of_zones(taken), of_zones(resolved)
    back = np.maximum(missing, 0.0) / np.where(losses > 0.0, losses, 1.0)
    less = np.maximum(1.0 + np.minimum(missing, 0.0) / np.where(made > 0.0, made, 1.0), 0.0)
    heat = resolved * less[zones] + taken * back[zones]
    whole = np.where(slips, resolved + solution.lost, 0.0)
    known = onset.inside[:, 0]
    last = onset.rows[known, 0], onset.columns[known, 0]
    whole[last] = of_zones(np.where(slips, 0.0, resolved + solution.lost))[zones[last]]
    has_root = np.zeros(count, dtype=bool)
    has_root[zones[last]] = True
    return np.where(has_root[zones], whole, heat)


def _following_the_root(heat: Array, onset: _Onset) -> Array:
    """`heat` with the total of the first elements of each zone distributed like root-like slip."""
    now = heat[onset.rows, onset.columns] * onset.inside
    together, behind = now[:, :ONSET_ELEMENTS].sum(axis=1), now[:, ONSET_ELEMENTS]
    weight, centre = onset.weight[:, :ONSET_ELEMENTS], onset.centre[:, :ONSET_ELEMENTS]
    plain, bent = weight.sum(axis=1), (weight * centre).sum(axis=1)
    # weight (1 + bend d) has the sum `together` and is continuous with the next element.
    share = together * onset.weight[:, ONSET_ELEMENTS]
    lever = bent * behind - share * onset.centre[:, ONSET_ELEMENTS]
    known = onset.inside[:, ONSET_ELEMENTS] & (share > 0.0) & (lever < 0.0)
    bend = np.where(known, (share - plain * behind) / np.where(known, lever, 1.0), onset.bend)
    shape = weight * (1.0 + np.clip(bend, LEAST_BEND, MOST_BEND)[:, None] * centre)
    total = shape.sum(axis=1)
    shape *= (together / np.where(total > 0.0, total, 1.0))[:, None]
    inside = onset.inside[:, :ONSET_ELEMENTS]
    heat = heat.copy()
    heat[onset.rows[:, :ONSET_ELEMENTS][inside], onset.columns[:, :ONSET_ELEMENTS][inside]] = shape[inside]
    return heat


def _ends(slips: Mask) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Elements that slip while the next one along x does not."""
    behind = np.zeros_like(slips)
    behind[:-1] = slips[1:]
    i, j = np.nonzero(slips & ~behind)
    return i, j


def _following_the_pressure(heat: Array, solution: TangentialSolution, covered: Array, slips: Mask) -> Array:
    """`heat` with the total of the last three elements of each zone that ends with the contact distributed like their tractions
    times continued slip: slip is smooth there, but its difference formula reaches across the border."""
    i, j = _ends(slips)
    far = i >= LEAST_ZONE_ELEMENTS - 1
    for k in range(1, LEAST_ZONE_ELEMENTS):
        far &= slips[np.maximum(i - k, 0), j]
    far[i + 1 < len(covered)] &= covered[i[i + 1 < len(covered)] + 1, j[i + 1 < len(covered)]] == 0.0
    i, j = i[far], j[far]
    speed = np.hypot(solution.slip[0], solution.slip[1])
    size = np.hypot(solution.traction[0], solution.traction[1])
    start = speed[i - 2, j]
    steps = np.stack([np.zeros(len(i)), np.ones(len(i)), 1.5 + 0.4 * covered[i, j]])
    weight = np.maximum(start + (start - speed[i - 3, j]) * steps, 0.0)
    weight *= np.stack([size[i - k, j] for k in (2, 1, 0)])
    together = heat[i, j] + heat[i - 1, j] + heat[i - 2, j]
    total = weight.sum(axis=0)
    known = (total > 0.0) & (together > 0.0)
    heat = heat.copy()
    for k, part in zip((2, 1, 0), weight, strict=True):
        heat[i[known] - k, j[known]] = (part * together / np.where(known, total, 1.0))[known]
    return heat


def _slopes(heat: Array, onset: _Onset, covered: Array, slips: Mask) -> Array:
    """Change of the heat through each element: at the beginning of zones that of root-like slip, on the last two elements of
    each zone that ends with the contact that of a square root that ends at the border, times a slowly varying factor."""
    slope = slopes(heat)
    first = onset.inside & (np.arange(ONSET_ELEMENTS + 1) < ONSET_ELEMENTS)
    at = onset.rows[first], onset.columns[first]
    slope[at] = heat[at] * onset.slope[first]
    i, j = _ends(slips)
    behind = np.concatenate((covered, np.zeros_like(covered[:1])))[i + 1, j]
    i, j = i[behind == 0.0], j[behind == 0.0]
    part = covered[i, j]
    # A linear distribution cannot have all heat at one end; heat on less than a third of an element determines its temperature.
    slope[i, j] = heat[i, j] * np.maximum(4.8 * part - 6.0, -6.0 * part)
    one, other = np.maximum(i - 1, 0), np.maximum(i - 2, 0)
    two = (i >= 2) & slips[one, j] & slips[other, j] & (covered[one, j] > WHOLE_COVER)
    i, j = i[two] - 1, j[two]
    part = np.maximum(part[two] + covered[i, j] - 1.0, 0.0)
    mean, centre = _root(part, part + 1.0)
    before, _ = _root(part + 1.0, part + 2.0)
    slope[i, j] = 12.0 * heat[i, j] * (part + 0.5 - centre) + heat[i, j] - heat[i - 1, j] * mean / before
    return slope
