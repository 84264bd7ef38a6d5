"""The largest value of a smooth field that is known on a grid."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.kernels.arrays import Array

SHARPEST = 3.0
"""How much more a peak may bend than what is beside it. Peaks of temperature behind narrow slip zones do (with 1, their errors
are 20 % larger); at the edge of a plateau the ratio has no end."""

STEEP = 0.5
"""Share of an element's pressure that the next one carries at a smooth border, or more (0.55 where elements are whole)."""


def peak_value(field: Array, *, averages: bool = True) -> float:
    """Maximum of a smooth field of shape (nx, ny), given by its element averages (pressure) or, without `averages`, by its
    values at the elements' centres (temperature): what is reported and written over pictures.

    The top of the parabolas along x and y through the largest element, or that element's value at the edge of the field's
    support. Fields may have a corner there (a plateau that ends, a border of stick): the parabola bends at most `SHARPEST`
    times as much as the field does beside the largest element, so nothing is made of a drop on one side alone.
    """
    i, j = np.unravel_index(int(np.argmax(field)), field.shape)
    return float(field[i, j]) + _rise(field[:, j], int(i), averages) + _rise(field[i, :], int(j), averages)


def _rise(line: Array, k: int, averages: bool) -> float:
    """How far the parabola along one line of averages rises above element k, the largest."""
    if not 0 < k < len(line) - 1 or min(line[k - 1], line[k + 1]) <= 0.0:
        return 0.0
    beside = float(np.diff(line[max(k - 2, 0) : k + 3], 2).max())
    if beside >= 0.0:
        return 0.0
    bend = max(float(line[k - 1] - 2.0 * line[k] + line[k + 1]), SHARPEST * beside)
    # The slope in the middle, from the side that falls less: the other may lie behind a corner.
    slope = max(-0.5 * bend - float(line[k] - max(line[k - 1], line[k + 1])), 0.0)
    # Top of the parabola, and back from averages to values: f = mean − h² f''/24.
    return -0.5 * slope**2 / bend - (bend / 24.0 if averages else 0.0)


def peak_inside(field: Array, covered: Array, ends: tuple[bool, bool]) -> float:
    """`peak_value` of the elements away from the border of the contact, where there are any: near a border that is steeper than
    an element, single elements carry what belongs to their neighbours.

    `covered` are the covered fractions, (nx, ny); `ends` tells that the first and the last column lie at the end of a profile,
    which is no border of this kind."""
    whole = np.pad(covered > 0.0, 1)
    whole[:, 0], whole[:, -1] = whole[:, 1] & ends[0], whole[:, -2] & ends[1]
    rows = whole[:-2] & whole[1:-1] & whole[2:]
    inside = rows[:, :-2] & rows[:, 1:-1] & rows[:, 2:]
    if not inside.any():
        return peak_value(field)
    i, j = np.unravel_index(int(np.argmax(np.where(inside, field, -np.inf))), field.shape)
    return float(field[i, j]) + _rise(field[:, j], int(i), averages=True) + _rise(field[i, :], int(j), averages=True)


def between_sides(field: Array, pressure: Array, ends: tuple[bool, bool]) -> Array:
    """`field` (nx, ny) without the elements at a steep lateral border of the contact: those with a neighbour to one side that
    carries less than `STEEP` of their `pressure`, and one to the other side that does not (a patch of few elements has a top
    without that). At the leading and the trailing edge they stay: a slip zone may be no wider. `ends` as in `peak_inside`. All
    of `field` where nothing else is left."""
    beside = np.pad(pressure, ((0, 0), (1, 1)), mode="edge")
    beside[:, 0] *= ends[0]
    beside[:, -1] *= ends[1]
    low, high = (beside[:, side : side + pressure.shape[1]] < STEEP * pressure for side in (0, 2))
    kept = np.where(low ^ high, 0.0, field)
    return kept if kept.any() else field
