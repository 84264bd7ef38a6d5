"""Stresses of one body, layer by layer: the fields that are kept, and their scalars."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from thermoroll_cli.arrays import AnyArray
from thermoroll_cli.numerics.convolution import unfolded
from thermoroll_cli.problem.names import STRESSES
from thermoroll_cli.problem.problem import KeptFields
from thermoroll_cli.problem.result import BodyStresses, Peak
from thermoroll_cli.stress.peaks import peak_of, row_ranges
from thermoroll_cli.stress.strength import StrengthCollector, first_principal, von_mises
from thermoroll_cli.stress.superposition import ODD_IN_Y

PRECISION = np.float32


@dataclass
class _Judged:
    """Equivalent stresses, of total or of elastic stresses: (nz, nx, columns), and the ranges of σ_xz (nz, columns)."""

    von_mises: AnyArray
    principal: AnyArray
    shear_range: AnyArray

    @classmethod
    def empty(cls, shape: tuple[int, int, int]) -> _Judged:
        return cls(np.empty(shape, PRECISION), np.empty(shape, PRECISION), np.empty((shape[0], shape[2])))

    def take(self, layer: int, stress: AnyArray) -> None:
        """Keep the equivalent stresses of a layer with stresses (6, nx, columns)."""
        self.von_mises[layer] = von_mises(stress)
        self.principal[layer] = first_principal(stress)
        self.shear_range[layer] = row_ranges(stress[4])


@dataclass
class Collector:
    """Collects the layers of one body from the surface down. `columns` along y hold y > 0 of a `mirrored` state."""

    depths: AnyArray
    x: AnyArray
    y: AnyArray
    mirrored: bool
    thermal: bool
    keep: KeptFields | None
    plane_column: int
    elastic: _Judged = field(init=False)
    total: _Judged = field(init=False)
    strength: StrengthCollector | None = None
    temperature: AnyArray | None = field(init=False)
    stresses: AnyArray | None = field(init=False)
    plane: AnyArray | None = field(init=False)

    def __post_init__(self) -> None:
        shape = (len(self.depths), len(self.x), len(self.y))
        self.elastic = _Judged.empty(shape)
        self.total = _Judged.empty(shape) if self.thermal else self.elastic
        self.temperature = np.empty(shape, PRECISION) if self.thermal else None
        self.stresses = np.empty((6, *shape), PRECISION) if self.keep == "full" else None
        self.plane = np.empty((6, *shape[:2]), PRECISION) if self.keep else None

    def take(self, layer: int, elastic: AnyArray, thermal: tuple[AnyArray, AnyArray] | None) -> None:
        """One layer: elastic stresses (6, nx, columns) in Pa, and thermal stresses with temperatures in K."""
        self.elastic.take(layer, elastic)
        stress = elastic
        if thermal is not None and self.temperature is not None:
            stress = elastic + thermal[0]
            self.temperature[layer] = thermal[1]
            self.total.take(layer, stress)
        if self.strength is not None:
            self.strength.take(layer, elastic, stress)
        if self.stresses is not None:
            self.stresses[:, layer] = stress
        if self.plane is not None:
            self.plane[:, layer] = stress[:, :, self.plane_column]

    def peaks(self, judged: _Judged, every: int = 1) -> tuple[Peak, Peak, Peak]:
        """Largest von Mises stress, range of σ_xz and first principal stress, of every layer or only every `every`-th one."""
        depths = self.depths[::every]
        ranges = peak_of(judged.shear_range[::every, None, :], depths, np.zeros(1), self.y, self.mirrored)
        found = [peak_of(values[::every], depths, self.x, self.y, self.mirrored)
                 for values in (judged.von_mises, judged.principal)]
        return found[0], ranges, found[1]

    def rivals(self, judged: _Judged) -> tuple[Peak, Peak]:
        """Largest von Mises stress at the surface, and below it."""
        found = [peak_of(judged.von_mises[part], self.depths[part], self.x, self.y, self.mirrored)
                 for part in (slice(0, 1), slice(1, None))]
        return found[0], found[1]

    def result(self, most_stressed: Peak) -> BodyStresses:
        """The kept fields, on both sides of a mirror."""
        fields = {"von_mises": self.total.von_mises}
        if self.temperature is not None:
            fields |= {"von_mises_elastic": self.elastic.von_mises, "temperature_rise": self.temperature}
        i, j = _nearest(self.x, most_stressed.x), _nearest(self.y, most_stressed.y)
        below_stressed = {name: values[:, i, j].copy() for name, values in fields.items()}
        hottest, below_heated = None, {}
        if self.temperature is not None:
            hottest = peak_of(self.temperature[:1], self.depths[:1], self.x, self.y, self.mirrored)
            i, j = _nearest(self.x, hottest.x), _nearest(self.y, hottest.y)
            below_heated = {name: values[:, i, j].copy() for name, values in fields.items()}
        plane = {name: np.ascontiguousarray(values[:, :, self.plane_column]) for name, values in fields.items()}
        assert self.plane is not None
        plane |= dict(zip(STRESSES, self.plane, strict=True))
        kept: dict[str, AnyArray] = {}
        if self.keep != "plane":
            kept |= {name: self._whole(values, 1) for name, values in fields.items()}
        if self.stresses is not None:
            kept |= {name: self._whole(values, -1 if odd else 1)
                     for name, values, odd in zip(STRESSES, self.stresses, ODD_IN_Y, strict=True)}
        return BodyStresses(self.depths, float(self.y[self.plane_column]), plane, most_stressed, hottest, below_stressed,
                            below_heated, fields=kept,
                            strength={} if self.strength is None else self.strength.fields())

    def _whole(self, values: AnyArray, parity: int) -> AnyArray:
        return unfolded(values, parity) if self.mirrored else values


def scalars_of(body: str, peaks: tuple[Peak, Peak, Peak], prefix: str = "") -> dict[str, float]:
    """Scalars of one body in the units of their names (`SUBSURFACE_SCALARS`)."""
    stress, shear, tension = peaks
    return {
        f"{prefix}von_mises_max_{body}_MPa": stress.value * 1e-6,
        f"{prefix}von_mises_depth_{body}_mm": stress.z * 1e3,
        f"{prefix}von_mises_x_{body}_mm": stress.x * 1e3,
        f"{prefix}von_mises_y_{body}_mm": stress.y * 1e3,
        f"{prefix}orthogonal_shear_range_max_{body}_MPa": shear.value * 1e-6,
        f"{prefix}orthogonal_shear_range_depth_{body}_mm": shear.z * 1e3,
        f"{prefix}tensile_stress_max_{body}_MPa": tension.value * 1e-6,
    }


def _nearest(axis: AnyArray, at: float) -> int:
    return int(np.argmin(np.abs(axis - at)))
