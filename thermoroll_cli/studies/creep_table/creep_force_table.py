"""Creep forces from a table, for simulations that ask for them millions of times.

Cubic splines between its points know the symmetries, the slopes at zero and the bound. The extensions beyond the quadrant
X, Y ≥ 0 follow from two symmetries, reversal of all creepages and reflection in y = 0:

    f(u, −v, w) = S f(u, v, −w),  S = (1, −1, −1)
    f(u, 2 − v, w) = (−1, 1, 1) f(u, v, w)
    f(u, v, w + 2) = −f(u, v, w)

for (F_x, F_y, M_z), and γ_st is even in all of them: no end of a spline along v or w is free. Along ln(a/b) the spline is free
at both ends.
"""

from __future__ import annotations

import math
import os
import pathlib
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline, NdBSpline, make_interp_spline

from thermoroll_cli.exact.kalker import creepage_coefficients
from thermoroll_cli.problem.friction import FrictionLaw
from thermoroll_cli.studies.creep_table.scaling import STEEPNESS_AT_ZERO, coordinates, directions, scales
from thermoroll_cli.studies.creep_table.table_file import LARGEST_MAGNITUDE, TableValues, read_table
from thermoroll_cli.tools.arrays import Array

Outside = Literal["error", "saturation"]
DEFAULT_TABLE = pathlib.Path(__file__).with_name("default_table.h5")


class OutsideTable(ValueError):
    """A contact ellipse that the table does not reach."""


@dataclass(frozen=True)
class TableForces:
    """`force_x`, `force_y` (N) and `spin_moment` (N m) on body 1 against its slip, the wear number `t_gamma` = Q_F/V (N), the
    `stick_fraction` of the contact area, the `error` of the forces and `t_gamma_error` (N), and `spin_moment_error` (N m):
    arrays of the shape of the creepages. Errors are the largest measured at random points, and 0 without creepage."""

    force_x: Array
    force_y: Array
    spin_moment: Array
    t_gamma: Array
    stick_fraction: Array
    error: Array
    spin_moment_error: Array
    t_gamma_error: Array


class CreepForceTable:
    """A table of creep forces of elliptic contacts between bodies of the same elasticity, for one Poisson's ratio.

    Forces follow from a/b and the scaled creepages alone (`scaling`), are never above μW, and have Kalker's coefficients as
    slopes at zero. Get a table with `default`, `read` or `thermoroll table build`.

    Parameters:

    - `values`: points, Poisson's ratio and, in `quality`, the errors measured at random points."""

    def __init__(self, values: TableValues) -> None:
        self.values = values
        self._interpolant = Interpolant(values)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> CreepForceTable:
        """The table in a file.

        Parameters:

        - `path`: the HDF5 file that `thermoroll table build` wrote.

        Raises OSError, with a plain message, for a file that is missing, cut short, damaged or of another version."""
        return cls(read_table(path))

    @classmethod
    def default(cls) -> CreepForceTable:
        """The table that comes with this package: a/b from 0.05 to 20, Poisson's ratio 0.28."""
        return cls.read(DEFAULT_TABLE)

    def forces(
        self, longitudinal: ArrayLike, lateral: ArrayLike, spin: ArrayLike, *, semi_axes: tuple[ArrayLike, ArrayLike],
        shear_modulus: ArrayLike, friction: ArrayLike, load: ArrayLike, outside: Outside = "error",
        law: FrictionLaw | None = None, speed: ArrayLike = math.nan,
    ) -> TableForces:
        """Creep forces, spin moment, wear number and stick fraction, with the signs of docs/frames.md.

        Parameters, arrays that broadcast with each other:

        - `longitudinal`, `lateral`: creepages ξ_x, ξ_y;
        - `spin`: ξ_φ in rad/m;
        - `semi_axes`: a (along rolling) and b in m;
        - `shear_modulus`: G in Pa, of both bodies together (`exact.kalker.combined_constants`);
        - `friction`: μ;
        - `load`: W in N; 0, as of a wheel in the air, has no forces and nothing that sticks;
        - `outside`: "error" for a/b that is not within the table, or "saturation" for the forces of full sliding of the nearest
          ellipse; nothing is extrapolated;
        - `law`: of friction that changes with slip; `friction` is then μ₀;
        - `speed`: V in m/s, needed with a law.

        Returns `TableForces`, arrays of the shape of the creepages: N, N m for moments. A creepage that is nan has forces that
        are nan. With a `law` the table is asked with μ at the slip speed V sqrt(ξ_x² + ξ_y² + ξ_φ²(a² + b²)/5): an
        approximation, which `error` includes.

        Raises ValueError for quantities that must be positive and finite and are not, for infinite creepages, and for a law
        with memory; OutsideTable, a ValueError, for a/b that the table does not reach.
        """
        if outside not in get_args(Outside):
            raise ValueError(f"outside is one of {', '.join(get_args(Outside))}, not {outside!r}")
        if law is not None and law.memory:
            raise ValueError("no table knows friction with memory, nor an interlayer: solve such cases by "
                             "thermoroll run or sweep")
        xi, eta, phi, a, b, modulus, mu, weight = np.broadcast_arrays(*(
            np.asarray(v, dtype=float) for v in (longitudinal, lateral, spin, *semi_axes, shear_modulus, friction, load)))
        shape = xi.shape
        xi, eta, phi = (v.ravel() for v in (xi, eta, phi))
        loaded = weight.ravel() != 0.0
        weight = np.where(weight == 0.0, 1.0, weight)
        given = {"semi-axis a": a, "semi-axis b": b, "shear_modulus": modulus, "friction": mu, "load": weight}
        for name, values in given.items():
            if not (np.all(values > 0.0) and np.all(np.isfinite(values))):
                raise ValueError(f"{name} must be positive and finite")
        if np.isinf(xi).any() or np.isinf(eta).any() or np.isinf(phi).any():
            raise ValueError("creepages must be finite")
        unknown = np.isnan(xi) | np.isnan(eta) | np.isnan(phi)
        xi, eta, phi = (np.where(unknown, 0.0, v) for v in (xi, eta, phi))
        # One ellipse for all is the usual case, and cheaper.
        same = all(np.asarray(v).size == 1 for v in semi_axes)
        a, b = (v.ravel()[:1] if same else v.ravel() for v in (a, b))
        without_slip, area = (mu * weight).ravel(), a * b
        limit = without_slip
        if law is not None:
            rolling = np.broadcast_to(np.asarray(speed, dtype=float), shape).ravel()
            if not (np.all(rolling > 0.0) and np.isfinite(rolling).all()):
                raise ValueError("speed must be positive and finite")
            limit = without_slip * law.factor(rolling * np.sqrt(xi**2 + eta**2 + phi**2 * (a**2 + b**2) / 5.0))[0]
        mean = np.sqrt(area)
        unit = modulus.ravel() * area / limit
        ratio = a / b
        lowest, highest = self.values.axes.aspect_ratios[0], self.values.axes.aspect_ratios[-1]
        # The node itself may be met to rounding.
        inside = (ratio >= lowest * (1.0 - 1e-9)) & (ratio <= highest * (1.0 + 1e-9))
        if outside == "error" and not inside.all():
            reach = f"{lowest:g} alone" if lowest == highest else f"{lowest:g} … {highest:g}"
            raise OutsideTable(f"a/b = {ratio[~inside][0]:g} is outside the table, which has a/b = {reach}")
        values = self._values(np.clip(ratio, lowest, highest), np.stack([xi * unit, eta * unit, phi * unit * mean]), inside)
        force_x, force_y, moment = values[0] * limit, values[1] * limit, values[2] * limit * mean
        # The lowest points of a table carry 0.1 μW (forces and moment together): below, errors are proportional to that.
        carried = np.minimum(np.sqrt((values[:3] ** 2).sum(axis=0)) / 0.1, 1.0)
        error = self.values.quality.largest * without_slip * carried
        if law is not None:
            # The largest at 200 random contacts, without and with spin, whose criterion of falling friction was up to 0.6:
            # 95 % had errors below 0.14 and 0.25 of (μ₀ − μ)W.
            error = error + np.where(phi == 0.0, 0.2, 0.6) * np.abs(without_slip - limit)
        moment_error = np.where(moment == 0.0, 0.0, error * mean)
        work_error = np.hypot(xi, eta) * error + np.abs(phi) * moment_error
        columns = (force_x, force_y, moment, xi * force_x + eta * force_y + phi * moment, values[3], error, moment_error,
                 work_error)
        return TableForces(*(np.where(unknown, math.nan, np.where(loaded, v, 0.0)).reshape(shape) for v in columns))

    def _values(self, ratio: Array, creepages: Array, inside: NDArray[np.bool_]) -> Array:
        """`QUANTITIES` (4, n) at ξ', η', φ' (3, n)."""
        # X/ξ', Y/η', Z/φ' (3, n), or of one ratio for all: between many different ones by interpolation.
        nu, few = self.values.poisson_ratio, len(ratio) <= 8
        x, y, z = creepages * (np.array([scales(creepage_coefficients(float(each), nu)) for each in ratio]).T if few
                               else self._interpolant.scales_of(ratio))
        # The quadrant X, Y ≥ 0 determines the others.
        turn_x, turn_y = np.where(x < 0.0, -1.0, 1.0), np.where(y < 0.0, -1.0, 1.0)
        scaled = np.stack([np.abs(x), np.abs(y), z * turn_y])
        if not inside.all():
            size = np.sqrt((scaled**2).sum(axis=0))
            sliding = np.where(size > 0.0, LARGEST_MAGNITUDE / np.where(size > 0.0, size, 1.0), 1.0)
            scaled = np.where(inside, scaled, scaled * sliding)
        values = self._interpolant(ratio, scaled)
        values[0] *= turn_x
        values[1] *= turn_y
        values[2] *= turn_y
        # A component that a symmetry makes zero has rounding noise only.
        noise = np.abs(values[:3]) <= 1e-9 * np.abs(values[:3]).max(axis=0) + 1e-15
        values[:3] = np.where(noise, 0.0, values[:3])
        return values


REFLECTED = np.array([1.0, -1.0, -1.0, 1.0, 1.0])
"""Signs of the columns F_x, F_y, M_z, γ_st, and |F| on its own."""
REVERSED_X = np.array([-1.0, 1.0, 1.0, 1.0, 1.0])
REVERSED = np.array([-1.0, -1.0, -1.0, 1.0, 1.0])
SWING = 0.05
"""Share that sticks below which splines swing about the kink where full sliding begins."""
GHOSTS = 8
"""Values continued beyond an end of v or w: 3e-5 of the error at the end of the continuation is left at the last real value."""


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
    """B-spline coefficients (2 T, A + 2, B + 2, 5) of the values (4, T, A, B) of one ellipse."""
    values = fill_holes(values)
    values = np.concatenate([values, np.hypot(values[0], values[1])[None]])
    _, t, a, b = values.shape
    # Slopes per interval along u: at zero those of Kalker's coefficients.
    c = creepage_coefficients(aspect_ratio, poisson_ratio)
    per_x, per_y, per_z = scales(c)
    x, y, z = directions(np.linspace(0.0, 1.0, a)[:, None], np.linspace(-1.0, 1.0, b)[None])
    linear = np.stack([c.c11 / per_x * x, c.c22 / per_y * y - c.c23 / per_z * z, c.c23 / per_y * y + c.c33 / per_z * z])
    linear /= (t - 1) * STEEPNESS_AT_ZERO
    nodes, index = np.arange(t), [0, 1, 2, 4]
    clamped, steep = np.concatenate([linear, np.hypot(linear[0], linear[1])[None]]), np.empty_like(values)
    steep[index] = CubicSpline(nodes, values[index], axis=1, bc_type=((1, clamped), "not-a-knot"))(nodes, 1)
    steep[3] = CubicSpline(nodes, values[3])(nodes, 1)
    steep[3:, 1:] = _monotone(values[3:], steep[3:])[:, 1:]
    steep[3, 0] = _monotone(values[3:4], steep[3:4])[0, 0]
    steep /= 3.0
    # Values and slopes of a cubic at a node are two coefficients over knots that occur twice.
    along = np.moveaxis(np.stack([values - steep, values + steep], axis=2).reshape(5, 2 * t, a, b), 0, -1)

    def reflected(k: int) -> Array:
        """The values at index `k` of v, also beyond its ends."""
        if k < 0:
            return np.asarray(reflected(-k)[:, ::-1] * REFLECTED)
        return np.asarray(along[:, k] if k < a else reflected(2 * (a - 1) - k) * REVERSED_X)

    along = _inner(np.stack([reflected(k) for k in range(-GHOSTS, a + GHOSTS)]))  # (A + 2, 2 T, B, 5)
    along = np.moveaxis(along, 2, 0)
    # More ghosts than values: the period is 2 in w, and the sign changes with each.
    turned = np.concatenate([along[:-1], along[:-1] * REVERSED])
    around = _inner(np.stack([turned[k % (2 * (b - 1))] for k in range(-GHOSTS, b + GHOSTS)]))  # (B + 2, A + 2, 2 T, 5)
    return np.ascontiguousarray(around.transpose(2, 1, 0, 3))


def _inner(continued: Array) -> Array:
    """Spline coefficients along the first axis from half a step before the real values to half a step after them."""
    spline = make_interp_spline(np.arange(len(continued)), continued)
    return np.asarray(spline.c[GHOSTS - 1 : 1 - GHOSTS])


def _monotone(values: Array, steep: Array) -> Array:
    """Slopes `steep` at `values` along the second axis, no steeper than lets the interpolant be monotone where the values are
    (Fritsch & Carlson 1980): no overshoot where full sliding begins."""
    rises = np.diff(values, axis=1)
    before, after = np.concatenate([rises[:, :1], rises], axis=1), np.concatenate([rises, rises[:, -1:]], axis=1)
    sign = np.sign(before)
    limited = sign * np.clip(sign * steep, 0.0, 3.0 * np.minimum(np.abs(before), np.abs(after)))
    return np.where(before * after > 0.0, limited, steep)


class Interpolant:
    """The splines of a whole table."""

    def __init__(self, table: TableValues) -> None:
        axes = table.axes
        self._poisson = table.poisson_ratio
        self._ratios = np.log(np.array(axes.aspect_ratios))
        # Steps of v and w are 1 here; knots reach three steps beyond the ends.
        t, a, b = axes.shape
        self._knots = (np.repeat(np.arange(-1.0, t + 1.0), 2), np.arange(-3.0, a + 3.0), np.arange(-3.0, b + 3.0))
        self._steps = np.array([t - 1, a - 1, 0.5 * (b - 1)])
        layers = np.stack([coefficients(values, ratio, table.poisson_ratio)
                           for values, ratio in zip(table.values, axes.aspect_ratios, strict=True)])  # fmt: skip
        count = len(layers)
        self._along_ratio = make_interp_spline(self._ratios, layers, k=min(3, count - 1)) if count > 1 else None
        self._single = None if count > 1 else (math.nan, NdBSpline(self._knots, layers[0], 3))
        self._fine: tuple[Array, Array] | None = None
        low = high = np.stack([fill_holes(values)[3] for values in table.values])
        for axis, length in enumerate(low.shape):
            # Of cells between points: least and largest of all of their corners.
            if length > 1:
                first, second = range(length - 1), range(1, length)
                low = np.minimum(low.take(first, axis), low.take(second, axis))
                high = np.maximum(high.take(first, axis), high.take(second, axis))
        self._around = low, high

    def __call__(self, aspect_ratio: Array, scaled: Array) -> Array:
        """`QUANTITIES` (4, n) at X ≥ 0, Y ≥ 0, Z of `scaled` (3, n), for ratios a/b (n,) or one for all (1,)."""
        place = (coordinates(*scaled).T + np.array([0.0, 0.0, 1.0])) * self._steps
        if self._along_ratio is None or len(aspect_ratio) == 1:
            # The spline of one ratio a/b; the one asked for last is kept.
            if self._along_ratio is not None and (self._single is None or self._single[0] != aspect_ratio[0]):
                self._single = float(aspect_ratio[0]), NdBSpline(self._knots, self._along_ratio(np.log(aspect_ratio[0])), 3)
            assert self._single is not None
            out = self._single[1](place).T
        else:
            spline = self._along_ratio
            whole = NdBSpline((spline.t, *self._knots), spline.c, (spline.k, 3, 3, 3))
            out = whole(np.concatenate([np.log(aspect_ratio)[:, None], place], axis=1)).T
        size = np.hypot(out[0], out[1])
        # Below 0.8 components are interpolated (|F| has cusps where they vanish); above 0.95 |F| on its own, which then does
        # not overshoot where full sliding begins.
        share = np.clip((size - 0.8) / 0.15, 0.0, 1.0)
        share *= share * (3.0 - 2.0 * share)
        wanted = np.minimum(size + share * (out[4] - size), 1.0)
        out[:2] *= wanted / np.where(size > 0.0, size, 1.0)
        self._bound_small(out[3], aspect_ratio, place)
        return np.asarray(out[:4])

    def _bound_small(self, stick: Array, aspect_ratio: Array, place: Array) -> None:
        """Keep the share that sticks (n,), at `place` (n, 3) on the axes, from 0 to 1, and a small one among those at the
        points of the table around: splines across directions and spins swing there about the kink where full sliding begins."""
        np.clip(stick, 0.0, 1.0, out=stick)
        near = np.flatnonzero(stick < SWING)
        low, high = self._around
        cell = np.minimum(place[near].astype(int), np.array(low.shape[1:]) - 1)
        ratio = np.clip(np.searchsorted(self._ratios, np.log(aspect_ratio), side="right") - 1, 0, len(low) - 1)
        at = (np.broadcast_to(ratio, stick.shape)[near], *cell.T)
        stick[near] = np.clip(stick[near], np.minimum(low[at], SWING), high[at])

    def scales_of(self, aspect_ratio: Array) -> Array:
        """X/ξ', Y/η', Z/φ' as (3, n) for many ratios a/b within the table, to 1e-4 between fine nodes."""
        if self._fine is None:
            nodes = np.linspace(self._ratios[0], self._ratios[-1], 401)
            known = np.array([scales(creepage_coefficients(float(np.exp(node)), self._poisson)) for node in nodes])
            self._fine = nodes, np.log(known)
        nodes, logs = self._fine
        where = np.log(aspect_ratio)
        return np.exp(np.stack([np.interp(where, nodes, column) for column in logs.T]))
