"""The largest value of a field between its layers and elements."""

from __future__ import annotations

from typing import Any

import numpy as np

from thermoroll_cli.arrays import AnyArray
from thermoroll_cli.problem.result import Peak

LAYER_POINTS, ELEMENT_POINTS = 5, 3
"""Points of the interpolating polynomials: along the depth, where layers are far apart, and along the surface."""
MOST_MOVES = 16
ZOOMS, POINTS_PER_ZOOM = 7, 9
"""Each zoom samples so many points per axis and shrinks to a quarter."""


def peak_of(values: AnyArray, depths: AnyArray, x: AnyArray, y: AnyArray, mirrored: bool = False) -> Peak:
    """The largest of `values` (nz, nx, ny) on `depths` × `x` × `y`, between them by polynomials through the neighbours.

    If the largest value is at the surface, the surface alone is searched as well. A `mirrored` field, even in y, is given for
    y > 0 only. Positions are in the units of the arrays."""
    candidates = [_followed(values, depths, x, y, mirrored)]
    if depths[0] == 0.0:
        candidates.append(_followed(values[:1], depths[:1], x, y, mirrored))
    return max(candidates, key=lambda peak: peak.value)


def _followed(values: AnyArray, depths: AnyArray, x: AnyArray, y: AnyArray, mirrored: bool) -> Peak:
    """The maximum near the largest of `values`, searched again around each place found: on an inclined ridge it may lie between
    two layers, several elements away from the largest value on a layer."""
    place = np.unravel_index(int(np.argmax(values)), values.shape)
    best = _refined(values, place, depths, x, y, mirrored)
    for _ in range(MOST_MOVES):
        moved = tuple(int(np.argmin(np.abs(axis - at))) for axis, at in ((depths, best.z), (x, best.x), (y, best.y)))
        found = _refined(values, moved, depths, x, y, mirrored)
        if not found.value > best.value:
            break
        best = found
    return best


def row_ranges(values: AnyArray) -> AnyArray:
    """Largest minus smallest of `values` (nx, ny) along x, between elements by parabolas; (ny,)."""
    return _row_maxima(values) + _row_maxima(-values)


def _row_maxima(values: AnyArray) -> AnyArray:
    top = np.clip(np.argmax(values, axis=0), 1, len(values) - 2)
    columns = np.arange(values.shape[1])
    before, here, after = (values[top + i, columns] for i in (-1, 0, 1))
    slope, bend = 0.5 * (after - before), before - 2.0 * here + after
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = np.where(bend < 0.0, np.clip(-slope / bend, -1.0, 1.0), 0.0)
    return np.asarray(np.maximum(here + shift * (slope + 0.5 * bend * shift), values.max(axis=0)))


def _refined(values: AnyArray, place: tuple[Any, ...], depths: AnyArray, x: AnyArray, y: AnyArray, mirrored: bool) -> Peak:
    """The maximum of the polynomial through the points around `place`, no farther away than the next points."""
    (zi, zs), (xi, xs) = (_around(axis, int(i), n, False)
                          for axis, i, n in ((depths, place[0], LAYER_POINTS), (x, place[1], ELEMENT_POINTS)))
    yi, ys = _around(y, int(place[2]), ELEMENT_POINTS, mirrored)
    cube = values[np.ix_(zi, xi, yi)].astype(np.float64)
    nodes = zs, xs, ys
    centre = [float(axis[int(i)]) for axis, i in zip((depths, x, y), place, strict=True)]
    limits = [_limits(axis, at) for axis, at in zip(nodes, centre, strict=True)]
    low, high = [limit[0] for limit in limits], [limit[1] for limit in limits]
    best = Peak(float(values[place]), centre[1], centre[2], centre[0])
    for _ in range(ZOOMS):
        samples = [np.linspace(a, b, POINTS_PER_ZOOM if b > a else 1) for a, b in zip(low, high, strict=True)]
        bases = [_lagrange(axis, sample) for axis, sample in zip(nodes, samples, strict=True)]
        found = bases[1] @ np.tensordot(bases[0], cube, axes=1) @ bases[2].T
        top = np.unravel_index(int(np.argmax(found)), found.shape)
        centre = [float(sample[i]) for sample, i in zip(samples, top, strict=True)]
        if found[top] > best.value:
            best = Peak(float(found[top]), centre[1], centre[2], centre[0])
        for axis, at in enumerate(centre):
            reach = 0.125 * (high[axis] - low[axis])
            low[axis], high[axis] = max(limits[axis][0], at - reach), min(limits[axis][1], at + reach)
    return best


def _around(axis: AnyArray, index: int, count: int, mirrored: bool) -> tuple[AnyArray, AnyArray]:
    """Indices and positions of `count` neighbouring points around `index`; points beyond a mirror lie before the first
    point."""
    count = min(count, len(axis))
    first = min(index - count // 2, len(axis) - count)
    indices = np.arange(first, first + count) if mirrored else np.arange(max(first, 0), max(first, 0) + count)
    beyond = indices < 0
    folded = np.where(beyond, -1 - indices, indices)
    return folded, np.where(beyond, -axis[folded], axis[folded])


def _limits(nodes: AnyArray, at: float) -> tuple[float, float]:
    """The points next to `at`."""
    index = int(np.argmin(np.abs(nodes - at)))
    return float(nodes[max(index - 1, 0)]), float(nodes[min(index + 1, len(nodes) - 1)])


def _lagrange(nodes: AnyArray, at: AnyArray) -> AnyArray:
    """Values of the Lagrange polynomials of `nodes` (n,) at the points `at` (m,): (m, n)."""
    itself = np.eye(len(nodes), dtype=bool)
    factors = (at[:, None, None] - nodes) / (nodes[:, None] - nodes + itself)
    return np.asarray(np.where(itself, 1.0, factors).prod(axis=2))
