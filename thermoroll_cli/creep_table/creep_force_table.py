"""Creep forces from a table, for simulations that ask for them millions of times."""

from __future__ import annotations

import math
import os
import pathlib
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thermoroll_cli.arrays import Array
from thermoroll_cli.creep_table.interpolation import Interpolant
from thermoroll_cli.creep_table.scaling import scales
from thermoroll_cli.creep_table.table_file import LARGEST_MAGNITUDE, TableValues, read_table
from thermoroll_cli.exact.kalker import creepage_coefficients
from thermoroll_cli.problem.problem import FrictionLaw

Outside = Literal["error", "saturation"]
DEFAULT_TABLE = pathlib.Path(__file__).with_name("default_table.h5")
NOISE = 1e-9
"""Error of the largest of F_x/μW, F_y/μW and M_z/(μW sqrt(ab))."""
TINY = 1e-15
LAW_ERROR, LAW_ERROR_WITH_SPIN = 0.2, 0.6
"""Errors of forces with an equivalent coefficient of friction, over (μ₀ − μ)W: the largest at 200 random contacts, without and
with spin, whose criterion of falling friction was up to 0.6. 95 % had errors below 0.14 and 0.25."""


class OutsideTable(ValueError):
    """A contact ellipse that the table does not reach."""


@dataclass(frozen=True)
class TableForces:
    """`force_x`, `force_y` (N) and `spin_moment` (N m) on body 1 against its slip, the wear number `t_gamma` = Q_F/V (N), the
    `stick_fraction` of the contact area, and the largest `error` of the forces (N), as measured at random points: arrays of the
    shape of the creepages."""

    force_x: Array
    force_y: Array
    spin_moment: Array
    t_gamma: Array
    stick_fraction: Array
    error: Array


class CreepForceTable:
    """A table of creep forces of elliptic contacts between bodies of the same elasticity, for one Poisson's ratio.

    Forces follow from a/b and the scaled creepages alone (`scaling`), are never above μW, and have Kalker's coefficients as
    slopes at zero. How good they are is in `values.quality`."""

    def __init__(self, values: TableValues) -> None:
        self.values = values
        self._interpolant = Interpolant(values)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> CreepForceTable:
        """The table in the file at `path`. Raises OSError: no such file, cut short, damaged, of another version."""
        return cls(read_table(path))

    @classmethod
    def default(cls) -> CreepForceTable:
        """The table that comes with this package: a/b from 0.05 to 20, Poisson's ratio 0.28. Its errors are in
        `values.quality`."""
        return cls.read(DEFAULT_TABLE)

    def forces(
        self, longitudinal: ArrayLike, lateral: ArrayLike, spin: ArrayLike, *, semi_axes: tuple[ArrayLike, ArrayLike],
        shear_modulus: ArrayLike, friction: ArrayLike, load: ArrayLike, outside: Outside = "error",
        law: FrictionLaw | None = None, speed: ArrayLike = math.nan,
    ) -> TableForces:
        """Forces at creepages ξ_x, ξ_y (1) and spin ξ_φ (rad/m), arrays that broadcast with each other and with all else.

        `semi_axes` are a (along rolling) and b in m, `shear_modulus` G in Pa (of both bodies together, `combined_constants`),
        `friction` μ and `load` W in N. Where a/b is not within the table: an error, or with `outside="saturation"` the
        forces of full sliding of the nearest ellipse; nothing is extrapolated.

        With a `law` of friction that falls with slip `friction` is μ₀, and the table is asked with the coefficient μ at the
        slip speed V sqrt(ξ_x² + ξ_y² + ξ_φ²(a² + b²)/5), V = `speed` in m/s: an approximation, which `error` includes.

        Raises ValueError for quantities that must be positive and finite and are not, and for a law with memory; OutsideTable.
        """
        if law is not None and law.memory:
            raise ValueError("no table knows friction with memory, nor a layer between the bodies: solve such cases by "
                             "thermoroll run or sweep")
        xi, eta, phi, a, b, modulus, mu, weight = np.broadcast_arrays(*(
            np.asarray(v, dtype=float) for v in (longitudinal, lateral, spin, *semi_axes, shear_modulus, friction, load)))
        shape = xi.shape
        xi, eta, phi = (v.ravel() for v in (xi, eta, phi))
        given = {"semi-axis a": a, "semi-axis b": b, "shear_modulus": modulus, "friction": mu, "load": weight}
        for name, values in given.items():
            if not (np.all(values > 0.0) and np.all(np.isfinite(values))):
                raise ValueError(f"{name} must be positive and finite")
        if not (np.isfinite(xi).all() and np.isfinite(eta).all() and np.isfinite(phi).all()):
            raise ValueError("creepages must be finite")
        # One ellipse for all is the usual case, and cheaper.
        same = all(np.asarray(v).size == 1 for v in semi_axes)
        a, b = (v.ravel()[:1] if same else v.ravel() for v in (a, b))
        without_slip, area = (mu * weight).ravel(), a * b
        limit, error = without_slip, self.values.quality.largest * without_slip
        if law is not None:
            rolling = np.broadcast_to(np.asarray(speed, dtype=float), shape).ravel()
            if not (np.all(rolling > 0.0) and np.isfinite(rolling).all()):
                raise ValueError("speed must be positive and finite")
            limit = without_slip * law.factor(rolling * np.sqrt(xi**2 + eta**2 + phi**2 * (a**2 + b**2) / 5.0))[0]
            error = error + np.where(phi == 0.0, LAW_ERROR, LAW_ERROR_WITH_SPIN) * np.abs(without_slip - limit)
        mean = np.sqrt(area)
        unit = modulus.ravel() * area / limit
        ratio = a / b
        inside = self._inside(ratio, outside)
        values = self._values(np.clip(ratio, *self._range), np.stack([xi * unit, eta * unit, phi * unit * mean]), inside)
        force_x, force_y, moment = values[0] * limit, values[1] * limit, values[2] * limit * mean
        found = force_x, force_y, moment, xi * force_x + eta * force_y + phi * moment, values[3], error
        return TableForces(*(v.reshape(shape) for v in found))

    @property
    def _range(self) -> tuple[float, float]:
        ratios = self.values.axes.aspect_ratios
        return ratios[0], ratios[-1]

    def _inside(self, ratio: Array, outside: Outside) -> NDArray[np.bool_]:
        lowest, highest = self._range
        # The node itself may be met to rounding.
        inside = (ratio >= lowest * (1.0 - 1e-9)) & (ratio <= highest * (1.0 + 1e-9))
        if outside == "error" and not inside.all():
            wrong = float(ratio[~inside][0])
            reach = f"{lowest:g} alone" if lowest == highest else f"{lowest:g} … {highest:g}"
            raise OutsideTable(f"a/b = {wrong:g} is outside the table, which has a/b = {reach}")
        return np.asarray(inside)

    def _values(self, ratio: Array, creepages: Array, inside: NDArray[np.bool_]) -> Array:
        """`QUANTITIES` (4, n) at ξ', η', φ' (3, n)."""
        per = self._scales(ratio)
        x, y, z = creepages * per
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
        noise = np.abs(values[:3]) <= NOISE * np.abs(values[:3]).max(axis=0) + TINY
        values[:3] = np.where(noise, 0.0, values[:3])
        return values

    def _scales(self, ratio: Array) -> Array:
        """X/ξ', Y/η', Z/φ' as (3, n) for ratios (n,) or one for all: between many different ones by interpolation."""
        nu = self.values.poisson_ratio
        if len(ratio) <= 8:
            return np.array([scales(creepage_coefficients(float(r), nu)) for r in ratio]).T
        return self._interpolant.scales_of(ratio)

