"""Forces between the points of a table: cubic splines that know the symmetries, the slopes at zero and the bound.

The extensions beyond the quadrant X, Y ≥ 0 follow from two symmetries, reversal of all creepages and reflection in y = 0:

    f(u, −v, w) = S f(u, v, −w),  S = (1, −1, −1)
    f(u, 2 − v, w) = (−1, 1, 1) f(u, v, w)
    f(u, v, w + 2) = −f(u, v, w)

for (F_x, F_y, M_z), and γ_st is even in all of them: no end of a spline along v or w is free.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from thermoroll_cli.arrays import Array
from thermoroll_cli.creep_table import spline
from thermoroll_cli.creep_table.scaling import STEEPNESS_AT_ZERO, coordinates, directions, scales, slopes
from thermoroll_cli.creep_table.values import TableValues

COLUMNS = 5
"""F_x, F_y, M_z, γ_st, and |F| on its own."""
REFLECTED = np.array([1.0, -1.0, -1.0, 1.0, 1.0])
REVERSED_X = np.array([-1.0, 1.0, 1.0, 1.0, 1.0])
REVERSED = np.array([-1.0, -1.0, -1.0, 1.0, 1.0])
BY_COMPONENTS, BY_SIZE = 0.8, 0.95
"""Below the first |F|/μW components are interpolated (|F| has cusps where they vanish); above the second, |F| on its own, which
then does not overshoot where full sliding begins."""
FINE = 401
"""Ratios a/b between which the scales are interpolated where many different ones are asked for."""
CHUNK = 4096
"""Queries looked up at once: their intermediate arrays stay in the cache."""


def fill_holes(values: Array) -> Array:
    """`values` (4, T, A, B) with each nan replaced by the mean of its neighbours in direction, of the same magnitude."""
    filled = values.copy()
    while np.isnan(filled).any():
        padded = np.pad(filled, ((0, 0), (0, 0), (1, 1), (1, 1)), constant_values=np.nan)
        around = np.stack([padded[:, :, :-2, 1:-1], padded[:, :, 2:, 1:-1], padded[:, :, 1:-1, :-2], padded[:, :, 1:-1, 2:]])
        known = ~np.isnan(around)
        if not (known.any(axis=0) & np.isnan(filled)).any():
            raise ValueError("whole layers of the table are holes: build it again")
        mean = np.where(known, around, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        filled = np.where(np.isnan(filled) & known.any(axis=0), mean, filled)
    return filled


def coefficients(values: Array, aspect_ratio: float, poisson_ratio: float) -> Array:
    """Coefficients (2 T, A + 2, B + 2, 5) of the values (4, T, A, B) of one ellipse: along u values and slopes in turn, of
    which B-splines are made in both directions."""
    values = fill_holes(values)
    values = np.concatenate([values, np.hypot(values[0], values[1])[None]])
    _, t, a, b = values.shape
    c = slopes(aspect_ratio, poisson_ratio)
    per_x, per_y, per_z = scales(c)
    x, y, z = directions(np.linspace(0.0, 1.0, a)[:, None], np.linspace(-1.0, 1.0, b)[None])
    linear = np.stack([c.c11 / per_x * x, c.c22 / per_y * y - c.c23 / per_z * z, c.c23 / per_y * y + c.c33 / per_z * z])
    linear = np.concatenate([linear, np.zeros_like(linear[:1]), np.hypot(linear[0], linear[1])[None]])
    linear /= (t - 1) * STEEPNESS_AT_ZERO
    steep = np.empty_like(values)
    for q, (own, slope) in enumerate(zip(values, linear, strict=True)):
        if q == 3:
            steep[q] = spline.monotone_slopes(own, spline.coefficients_free(own))
            continue
        of_spline = spline.coefficients_clamped(own, slope)
        steep[q] = spline.monotone_slopes(own, of_spline) if q > 3 else 0.5 * (of_spline[2:] - of_spline[:-2])
        steep[q, 0] = slope
    along = np.stack([np.moveaxis(part, 0, -1) for part in (values, steep)], axis=1).reshape(2 * t, a, b, COLUMNS)

    def reflected(k: int) -> Array:
        """The values at index `k` of v, also beyond its ends."""
        if k < 0:
            return np.asarray(reflected(-k)[:, ::-1] * REFLECTED)
        return np.asarray(along[:, k] if k < a else reflected(2 * (a - 1) - k) * REVERSED_X)

    g = spline.GHOSTS
    before, after = (np.stack([reflected(k) for k in r]) for r in (range(-g, 0), range(a, a + g)))
    along = spline.coefficients_continued(before, np.moveaxis(along, 1, 0), after)  # (A + 2, 2 T, B, 5)
    along = np.moveaxis(along, 2, 0)  # (B, A + 2, 2 T, 5)
    # More ghosts than values: the period is 2 in w, and the sign changes with each.
    turned = np.concatenate([along[:-1], along[:-1] * REVERSED, along[:1]])
    period = 2 * (b - 1)
    before = np.stack([turned[k % period] for k in range(-g, 0)])
    after = np.stack([turned[k % period] for k in range(b, b + g)])
    return np.ascontiguousarray(spline.coefficients_continued(before, along, after).transpose(2, 1, 0, 3))


class Interpolant:
    """The splines of a whole table."""

    def __init__(self, table: TableValues) -> None:
        self._ratios = np.log(np.array(table.axes.aspect_ratios))
        self._shape = np.array(table.axes.shape)
        self._poisson = table.poisson_ratio
        self._coefficients = np.stack([
            coefficients(values, ratio, table.poisson_ratio)
            for values, ratio in zip(table.values, table.axes.aspect_ratios, strict=True)
        ])
        self._single: tuple[float, Array] | None = None
        self._fine: tuple[Array, Array] | None = None

    def __call__(self, aspect_ratio: Array, scaled: Array) -> Array:
        """`QUANTITIES` (4, n) at X ≥ 0, Y ≥ 0, Z of `scaled` (3, n), for ratios a/b (n,) or one for all (1,)."""
        out = np.empty((COLUMNS, scaled.shape[1]))
        # In the order of a/b neighbours in a chunk read the same part of the table: a third of the time was waiting for memory.
        order = np.argsort(aspect_ratio) if len(aspect_ratio) > CHUNK else None
        for i in range(0, scaled.shape[1], CHUNK):
            part = slice(i, i + CHUNK) if order is None else order[i : i + CHUNK]
            out[:, part] = self._look_up(aspect_ratio if len(aspect_ratio) == 1 else aspect_ratio[part], scaled[:, part])
        size = np.hypot(out[0], out[1])
        share = np.clip((size - BY_COMPONENTS) / (BY_SIZE - BY_COMPONENTS), 0.0, 1.0)
        share *= share * (3.0 - 2.0 * share)
        wanted = np.minimum(size + share * (out[4] - size), 1.0)
        out[:2] *= wanted / np.where(size > 0.0, size, 1.0)
        np.clip(out[3], 0.0, 1.0, out=out[3])
        return out[:4]

    def scales_of(self, aspect_ratio: Array) -> Array:
        """X/ξ', Y/η', Z/φ' as (3, n) for many ratios a/b within the table, to 1e-4 between fine nodes."""
        if self._fine is None:
            nodes = np.linspace(self._ratios[0], self._ratios[-1], FINE)
            known = np.array([scales(slopes(float(np.exp(node)), self._poisson)) for node in nodes])
            self._fine = nodes, np.log(known)
        nodes, logs = self._fine
        where = np.log(aspect_ratio)
        return np.exp(np.stack([np.interp(where, nodes, column) for column in logs.T]))

    def _look_up(self, aspect_ratio: Array, scaled: Array) -> Array:
        found = coordinates(*scaled)
        t, a, b = self._shape
        first_u, by_u = spline.hermite_weights(found.u * (t - 1), t)
        first_v, by_v = spline.weights(found.v * (a - 1), a)
        first_w, by_w = spline.weights((found.w + 1.0) * (0.5 * (b - 1)), b)
        if len(aspect_ratio) == 1:
            tables, layers, by_ratio = self._of_ratio(float(aspect_ratio[0]))[None], np.zeros((1, 1), int), np.ones((1, 1))
        else:
            tables = self._coefficients
            layers, by_ratio = self._ratio_weights(np.log(aspect_ratio))
        # Four neighbours along w lie side by side: they are fetched as one row of twenty numbers.
        rows = tables.reshape(-1)
        view = as_strided(rows, (rows.size // COLUMNS - 3, 4 * COLUMNS), (rows.strides[0] * COLUMNS, rows.strides[0]))
        total = np.zeros((scaled.shape[1], 4 * COLUMNS))
        for layer, share in zip(layers, by_ratio, strict=True):
            for i in range(4):
                for j in range(4):
                    place = ((layer * (2 * t) + first_u + i) * (a + 2) + first_v + j) * (b + 2) + first_w
                    total += (share * by_u[i] * by_v[j])[:, None] * view[place]
        return np.einsum("nkq,kn->qn", total.reshape(-1, 4, COLUMNS), by_w)

    def _of_ratio(self, aspect_ratio: float) -> Array:
        """Coefficients for one ratio a/b; those asked for last are kept."""
        if self._single is None or self._single[0] != aspect_ratio:
            layers, share = self._ratio_weights(np.log(np.array([aspect_ratio])))
            self._single = aspect_ratio, np.einsum("k,ktabq->tabq", share[:, 0], self._coefficients[layers[:, 0]])
        return self._single[1]

    def _ratio_weights(self, where: Array) -> tuple[NDArray[np.intp], Array]:
        """Ellipses and their weights, (4, n) each, for ln(a/b): cubic Hermite interpolation with slopes of parabolas."""
        nodes = self._ratios
        count = len(nodes)
        if count == 1:
            return np.zeros((1, len(where)), int), np.ones((1, len(where)))
        left = np.clip(np.searchsorted(nodes, where) - 1, 0, count - 2)
        width = nodes[left + 1] - nodes[left]
        x = (where - nodes[left]) / width
        value = (1.0 + 2.0 * x) * (1.0 - x) ** 2, x * x * (3.0 - 2.0 * x)
        slope = x * (1.0 - x) ** 2 * width, x * x * (x - 1.0) * width
        layers = np.clip(left + np.arange(-1, 3)[:, None], 0, count - 1)
        weights = np.zeros((4, len(where)))
        weights[1], weights[2] = value
        for end in (0, 1):
            at = left + end
            # The parabola through a node and its neighbours; at the ends of the axis the straight line.
            before, after = np.maximum(at - 1, 0), np.minimum(at + 1, count - 1)
            lower, upper = nodes[at] - nodes[before], nodes[after] - nodes[at]
            both = lower + upper
            fall = np.where(lower > 0.0, upper / (np.where(lower > 0.0, lower, 1.0) * both), 0.0)
            rise = np.where(upper > 0.0, lower / (np.where(upper > 0.0, upper, 1.0) * both), 0.0)
            fall = np.where((upper == 0.0), 1.0 / both, np.where(lower == 0.0, 0.0, fall))
            rise = np.where((lower == 0.0), 1.0 / both, np.where(upper == 0.0, 0.0, rise))
            weights[end] -= slope[end] * fall
            weights[end + 1] += slope[end] * (fall - rise)
            weights[end + 2] += slope[end] * rise
        return layers, weights
