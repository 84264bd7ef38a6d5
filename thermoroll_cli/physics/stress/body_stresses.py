"""Stresses of one body, depth by depth: the fields that are kept, their scalars, and the largest values between depths and
elements."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from operator import attrgetter
from typing import Any

import numpy as np

from thermoroll_cli.physics.numerics.convolution import unfolded
from thermoroll_cli.physics.stress.strength import StrengthCollector, depth_name, principal_and_shear, von_mises
from thermoroll_cli.physics.stress.superposition import ODD_IN_Y
from thermoroll_cli.problem.names import STRESSES, SUBSURFACE_SCALARS
from thermoroll_cli.problem.problem import KeptFields
from thermoroll_cli.problem.result import BodyStresses, Peak, within_layers
from thermoroll_cli.tools.arrays import AnyArray, Array

PRECISION = np.float32
by_value = attrgetter("value")
RANGE = "orthogonal_shear_range"
LARGEST = "von_mises", RANGE, "tensile_stress", "tresca_shear"
"""Stresses with a largest value over the body: von Mises, range of σ_xz, first principal stress, half of Tresca's."""


@dataclass
class EquivalentStresses:
    """Equivalent stresses, of total or of elastic stresses: (nz, nx, columns), and the ranges of σ_xz (nz, columns)."""

    von_mises: AnyArray
    principal: AnyArray
    tresca_shear: AnyArray
    shear_range: AnyArray

    @classmethod
    def empty(cls, shape: tuple[int, int, int]) -> EquivalentStresses:
        return cls(np.empty(shape, PRECISION), np.empty(shape, PRECISION), np.empty(shape, PRECISION),
                   np.empty((shape[0], shape[2])))

    def take(self, index: int, stress: AnyArray) -> None:
        """Keep the equivalent stresses of one depth, from stresses (6, nx, columns)."""
        self.von_mises[index] = von_mises(stress)
        self.principal[index], self.tresca_shear[index] = principal_and_shear(stress)
        self.shear_range[index] = _row_maxima(stress[4]) + _row_maxima(-stress[4])


@dataclass
class Collector:
    """Collects the depths of one `body` from the surface down. `columns` along y hold y > 0 of a `mirrored` state; `near` (m)
    is the depth down to which a place counts as the surface, and `shallow` (m) for ranges of σ_xz, which lack the edges of the
    contact there; `width` (m) is the smaller semi-axis of the contact; `interfaces` are the depths of those of a coating."""

    body: str
    depths: AnyArray
    x: AnyArray
    y: AnyArray
    mirrored: bool
    thermal: bool
    keep: KeptFields | None
    plane_column: int
    near: float
    shallow: float
    width: float
    interfaces: tuple[float, ...] = ()
    elastic: EquivalentStresses = field(init=False)
    total: EquivalentStresses = field(init=False)
    strength: StrengthCollector | None = None
    temperature: AnyArray | None = field(init=False)
    stresses: AnyArray | None = field(init=False)
    plane: AnyArray | None = field(init=False)
    at_interfaces: dict[int, tuple[AnyArray, AnyArray, AnyArray]] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        shape = (len(self.depths), len(self.x), len(self.y))
        self.elastic = EquivalentStresses.empty(shape)
        self.total = EquivalentStresses.empty(shape) if self.thermal else self.elastic
        self.temperature = np.empty(shape, PRECISION) if self.thermal else None
        self.stresses = np.empty((6, *shape), PRECISION) if self.keep == "full" else None
        self.plane = np.empty((6, *shape[:2]), PRECISION) if self.keep else None

    def take(
        self, index: int, elastic: AnyArray, thermal: tuple[AnyArray, AnyArray] | None, beyond: tuple[AnyArray, AnyArray] | None
    ) -> None:
        """One depth: elastic stresses (6, nx, columns) in Pa, and thermal stresses with temperatures in K; elastic and total
        stresses `beyond` the domain along x, if there is a strength."""
        self.elastic.take(index, elastic)
        stress = elastic
        if thermal is not None and self.temperature is not None:
            stress = elastic + thermal[0]
            self.temperature[index] = thermal[1]
            self.total.take(index, stress)
        if self.strength is not None and beyond is not None:
            self.strength.take(index, *(np.concatenate(parts, axis=1) for parts in zip((elastic, stress), beyond, strict=True)))
        if self.stresses is not None:
            self.stresses[:, index] = stress
        if self.plane is not None:
            self.plane[:, index] = stress[:, :, self.plane_column]
        if self.depths[index] in self.interfaces:
            self.take_interface(index, stress, self.x, self.y)

    def take_interface(self, index: int, stress: AnyArray, x: AnyArray, y: AnyArray) -> None:
        """An interface: stresses (6, len(x), len(y)) on a domain that may be wider than that of other depths."""
        self.at_interfaces[index] = np.stack([np.hypot(stress[4], stress[5]), stress[2]]), x, y

    def interfaces_cut_off(self) -> list[int]:
        """Layers that are interfaces whose shear stress grows up to the border of its domain."""
        indices = []
        for index, (_, x, y) in self.at_interfaces.items():
            peak = self._at_interface(index, 0)
            between = len(y) == 1 or ((self.mirrored or y[0] < peak.y) and peak.y < y[-1])
            if not (x[0] < peak.x < x[-1] and between):
                indices.append(index)
        return indices

    def _at_interface(self, index: int, number: int) -> Peak:
        """The largest shear stress (0) or σ_zz (1) of an interface."""
        values, x, y = self.at_interfaces[index]
        return peak_of(values[[number]], self.depths[index : index + 1], x, y, self.mirrored)

    def _largest(
        self, judged: EquivalentStresses, wanted: Sequence[str] = LARGEST, every: int = 1, part: slice = slice(None)
    ) -> dict[str, Peak]:
        """The largest of the `wanted` stresses of a `part` of the depths, all or only every `every`-th one."""
        fields = {"von_mises": (judged.von_mises, self.x), "tensile_stress": (judged.principal, self.x),
                  "tresca_shear": (judged.tresca_shear, self.x), RANGE: (judged.shear_range[:, None, :], np.zeros(1))}
        return {stress: peak_of(fields[stress][0][part], self.depths[part], fields[stress][1], self.y, self.mirrored, every)
                for stress in wanted}

    def profiles(self) -> dict[str, Array]:
        """Largest stresses (Pa) of each depth, (nz,), by the names of their peaks, where they may grow below the last."""
        profiles = {} if self.strength is None else self.strength.profiles()
        for prefix, judged in (("", self.total), ("elastic_", self.elastic)):
            profiles |= {f"{prefix}von_mises": judged.von_mises.max(axis=(1, 2)),
                         f"{prefix}orthogonal_shear_range": judged.shear_range.max(axis=1),
                         f"{prefix}tensile_stress": judged.principal.max(axis=(1, 2)),
                         f"{prefix}tresca_shear": judged.tresca_shear.max(axis=(1, 2))}
        if self.interfaces and self.depths[-1] <= self.interfaces[-1]:
            profiles["layer_tension"] = profiles["tensile_stress"]
        return profiles

    def bond_peaks(self, every: int = 1) -> dict[str, Peak]:
        """Largest shear stress and largest σ_zz of the interfaces of a coated body, no smaller than far away, and largest
        first principal stress in its coating; nan where no interface was computed."""
        if not self.interfaces:
            return {}
        shear, tension = ([self._at_interface(index, number) for index in self.at_interfaces] for number in (0, 1))
        far_away = [Peak(0.0, z=self.interfaces[0])] if tension else []
        bonded = self.depths <= self.interfaces[-1]
        return {
            "interface_shear": max(shear, key=by_value, default=Peak()),
            "interface_tension": max(tension + far_away, key=by_value, default=Peak()),
            "layer_tension": peak_of(self.total.principal[bonded], self.depths[bonded], self.x, self.y, self.mirrored, every),
        }

    @cached_property
    def peaks(self) -> dict[str, Peak]:
        """The largest stresses by name, "elastic_…" without thermal stresses."""
        return self._peaks(1)

    def _peaks(self, every: int) -> dict[str, Peak]:
        """The peaks over all depths (`every` = 1), or every second one (2)."""
        total = self._largest(self.total, every=every)
        elastic = self._largest(self.elastic, every=every) if self.thermal else total
        return {**self.bond_peaks(every), **total, **{f"elastic_{stress}": peak for stress, peak in elastic.items()}}

    def scalars(self, every: int = 1) -> dict[str, float]:
        """The scalars (`SUBSURFACE_SCALARS`) from all depths (`every` = 1), or every second one (2)."""
        scalars = {} if self.strength is None else self.strength.scalars(self.body, every)
        for stress, peak in (self.peaks if every == 1 else self._peaks(every)).items():
            scalars |= scalars_of(stress, self.body, peak)
        return scalars

    def parts(self) -> dict[str, dict[str, slice]]:
        """The depths "below" the surface and those at the "surface", each of which may hold the largest of a stress, by the
        beginning of the name of its scalar, but for strength (`rivals`). At z = 0 the range of σ_xz is the "traction". What
        grows on from the surface into the body is no peak of the surface."""
        parts = {}
        for name, values in self.profiles().items():
            if (stress := name.removeprefix("elastic_")) in LARGEST:
                first, near = (1, self.shallow) if stress == RANGE else (0, self.near)
                split = min(int(np.searchsorted(self.depths, near, side="right")), len(self.depths) - 1)
                while split > 1 and values[split - 1] < values[split]:
                    split -= 1
                named = {"below": slice(split, None), "surface": slice(first, split), "traction": slice(first)}
                parts[f"{name}_max"] = {word: part for word, part in named.items() if self.depths[part].size}
        return parts

    def rivals(self, parts: dict[str, dict[str, slice]]) -> dict[str, dict[str, Peak]]:
        """The largest stress of each of the `parts` of the depths, and what strength needs at the surface and below it."""
        peaks = {} if self.strength is None else self.strength.peaks()
        rivals = {name: {"below": below, "surface": surface} for name, (surface, below) in peaks.items()}
        for name, words in parts.items():
            judged, stress = self.total, name.removesuffix("_max")
            if stress.startswith("elastic_"):
                judged, stress = self.elastic, stress.removeprefix("elastic_")
            rivals[name] = {word: self._largest(judged, (stress,), part=part)[stress] for word, part in words.items()}
        return rivals

    def at_surface(self) -> set[str]:
        """Names of the scalars whose maximum lies at the surface."""
        names = set() if self.strength is None else self.strength.at_surface(self.body, self.near)
        return names.union(*(scalars_of(stress, self.body, peak) for stress, peak in self.peaks.items()
                             if peak.z <= (self.shallow if stress.endswith(RANGE) else self.near)))

    def of_traction(self) -> set[str]:
        """Names of the ranges of σ_xz that are largest at z = 0, where it is the traction along x and thermal stresses have
        none."""
        return set[str]().union(*(scalars_of(stress, self.body, peak) for stress, peak in self.peaks.items()
                                  if stress.endswith(RANGE) and peak.z == 0.0))

    @cached_property
    def cut_off(self) -> set[str]:
        """Names of the scalars whose maximum over depth may lie below the last depth.

        There are two cases: values that grow at the last depth and would exceed all others within twice that depth; and values
        without a peak below the surface, if the last depth is less than the `width` within which the peaks of Hertz's contacts
        lie."""
        names: set[str] = set()
        for quantity, values in self.profiles().items():
            slopes = np.diff(values) / np.diff(self.depths)
            peaked = (slopes[:-1] > 0.0) & (slopes[1:] <= 0.0) & (self.depths[1:-1] > self.near)
            unseen = self.depths[-1] < self.width and not peaked.any()
            reached = values[-1] + slopes[-1] * self.depths[-1] if slopes[-1] > 0.0 else -math.inf
            if unseen or reached >= values[1:].max():
                names |= {f"{quantity}_below_{self.body}_MPa"}
            if unseen or reached >= values.max():
                names |= {*scalars_of(quantity, self.body, Peak()), depth_name(quantity, self.body),
                          f"{quantity}_{self.body}_MPa"}
        return names.intersection(SUBSURFACE_SCALARS)

    def without_peak(self) -> set[str]:
        """Names of the scalars below the surface that have no maximum there: what falls from the surface on is largest at the
        first depth, wherever that is."""
        profiles = {} if self.strength is None else self.strength.profiles()
        return {f"{quantity}_below_{self.body}_MPa" for quantity, values in profiles.items()
                if values[0] > values[1:].max() == values[1]}

    def result(self) -> BodyStresses:
        """The kept fields, on both sides of a mirror."""
        fields, most_stressed = {"von_mises": self.total.von_mises}, self.peaks["von_mises"]
        if self.temperature is not None:
            fields |= {"von_mises_elastic": self.elastic.von_mises, "temperature_rise": self.temperature}

        def below(peak: Peak) -> dict[str, AnyArray]:
            i, j = (int(np.argmin(np.abs(axis - at))) for axis, at in ((self.x, peak.x), (self.y, peak.y)))
            return {name: values[:, i, j].copy() for name, values in fields.items()}

        hottest = None
        if self.temperature is not None:
            hottest = peak_of(self.temperature[:1], self.depths[:1], self.x, self.y, self.mirrored)
        plane = {name: np.ascontiguousarray(values[:, :, self.plane_column]) for name, values in fields.items()}
        assert self.plane is not None
        plane |= dict(zip(STRESSES, self.plane, strict=True))
        kept: dict[str, AnyArray] = {}
        if self.keep != "plane":
            kept |= {name: self._whole(values, 1) for name, values in fields.items()}
        if self.stresses is not None:
            kept |= {name: self._whole(values, -1 if odd else 1)
                     for name, values, odd in zip(STRESSES, self.stresses, ODD_IN_Y, strict=True)}
        return BodyStresses(self.depths, float(self.y[self.plane_column]), plane, most_stressed, hottest, below(most_stressed),
                            {} if hottest is None else below(hottest), fields=kept,
                            strength={} if self.strength is None else self.strength.fields())

    def _whole(self, values: AnyArray, parity: int) -> AnyArray:
        return unfolded(values, parity) if self.mirrored else values


def scalars_of(stress: str, body: str, peak: Peak) -> dict[str, float]:
    """The largest value of a stress and its place, as far as they are reported, in the units of their names
    (`SUBSURFACE_SCALARS`)."""
    values = {f"max_{body}_MPa": peak.value * 1e-6, f"depth_{body}_mm": peak.z * 1e3, f"x_{body}_mm": peak.x * 1e3,
              f"y_{body}_mm": peak.y * 1e3}
    return {name: value for ending, value in values.items() if (name := f"{stress}_{ending}") in SUBSURFACE_SCALARS}


LAYER_POINTS, ELEMENT_POINTS = 5, 3
"""Points of the interpolating polynomials: along the depth, where the depths are far apart, and along the surface."""
MOST_MOVES = 16
CONTENDER = 0.5
"""Share of the largest value that a layer or the surface needs to be searched: no polynomial rises to twice its points."""
ZOOMS, POINTS_PER_ZOOM = 7, 9
"""Each zoom samples so many points per axis and shrinks to a quarter."""


def peak_of(
    values: AnyArray, depths: AnyArray, x: AnyArray, y: AnyArray, mirrored: bool = False, every: int = 1
) -> Peak:
    """The largest of `values` (nz, nx, ny) on `depths` × `x` × `y`, between them by polynomials through the neighbours in the
    same layer of the coating, of all depths or only every `every`-th one.

    The surface alone is searched as well. A `mirrored` field, even in y, is given for y > 0 only. Positions are in the units of
    the arrays."""
    parts = [(values[part][::every], depths[part][::every]) for part in within_layers(depths)]
    if depths[0] == 0.0:
        parts.append((values[:1], depths[:1]))
    least = CONTENDER * max(float(part.max()) for part, _ in parts)
    return max((_followed(part, at, x, y, mirrored) for part, at in parts if part.max() >= least or least <= 0.0), key=by_value)


def _followed(values: AnyArray, depths: AnyArray, x: AnyArray, y: AnyArray, mirrored: bool) -> Peak:
    """The maximum near the largest of `values`, searched again around each place found: on an inclined ridge it may lie between
    two depths, several elements away from the largest value at one depth."""
    place: tuple[int, ...] = tuple(int(i) for i in np.unravel_index(int(np.argmax(values)), values.shape))
    if depths[0] == 0.0 and place[0] == 0:
        # No polynomial knows how stresses fall from the surface to the first depth, far above the next ones.
        values, depths = values[:1], depths[:1]
    best = _refined(values, place, depths, x, y, mirrored)
    for _ in range(MOST_MOVES):
        moved = tuple(int(np.argmin(np.abs(axis - at))) for axis, at in ((depths, best.z), (x, best.x), (y, best.y)))
        if moved == place:
            break
        place = moved
        refined = _refined(values, moved, depths, x, y, mirrored)
        if not refined.value > best.value:
            break
        best = refined
    return best


def _row_maxima(values: AnyArray) -> AnyArray:
    """Largest of `values` (nx, ny) along x, between elements by parabolas; (ny,)."""
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
        interpolated = bases[1] @ np.tensordot(bases[0], cube, axes=1) @ bases[2].T
        top = np.unravel_index(int(np.argmax(interpolated)), interpolated.shape)
        centre = [float(sample[i]) for sample, i in zip(samples, top, strict=True)]
        if interpolated[top] > best.value:
            best = Peak(float(interpolated[top]), centre[1], centre[2], centre[0])
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
