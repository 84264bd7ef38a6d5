"""Influence tables of a coated body whose upper layers relax: what their memory adds to the instantaneous tables.

With the compliance c(k, E)/k of a layered body in wave numbers (`layered`), memory adds c(k, E(ω)) − c(k, E₀), ω = kₓV. On
short waves this is the memory of a half-space of the top material, c₀ (Ĵ(ω) − 1), on long ones that of layers compressed and
sheared evenly, k Σ h m (Ĵ(ω) − 1) with m = (1+ν)(1−2ν)/((1−ν)E₀) or 1/G₀. Both parts have closed forms (`relaxing`), the first
one less an image at a depth z that cancels it on long waves, the second one at the same depth:

    1 − (1 + kz) e^{−kz}  and  k e^{−kz}.

What remains decays fast on short and on long waves, and so in space: its inverse Fourier transform is taken on a plane a few
times as large as the table. Waves with kₓ = 0 stand for all up to half a step of kₓ: memories longer than the plane are
averaged over these.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, Literal

import numpy as np
import scipy

from thermoroll_cli.physics.halfspace.layered import difference_compliance, halfspace_compliance
from thermoroll_cli.physics.numerics.convolution import even_length
from thermoroll_cli.problem.problem import Layer, Material
from thermoroll_cli.problem.relaxation import modulus_at
from thermoroll_cli.tools.arrays import AnyArray, Array

BOXES = 4.0
"""Sides of the plane of the remaining part over those of the table."""
DEEP, SHALLOW = 30.0, 1e-4
"""Wave numbers times the thinnest layer beyond which the surface's material is all, and times all layers below which the
substrate is."""
RELAXED = 1e-3
"""Frequency times the longest retardation time below which everything has relaxed."""
STEP_K, STEP_OMEGA = 0.1, 0.25
"""Steps of ln k and ln ω between which compliances are interpolated by cubics."""
_HALVINGS = 0.5 ** np.arange(25)
_GAUSS = 0.5 + 0.5 / math.sqrt(3.0), 0.5 - 0.5 / math.sqrt(3.0)
SLOW = np.concatenate([_HALVINGS * (1.0 - 0.5 * place) for place in _GAUSS])
SHARES = np.tile(0.25 * _HALVINGS, 2) / (1.0 - 0.5**25)
"""Places between 0 and 1, denser towards 0, and their weights in a mean."""
WIDE = 4.0
"""Width of the plane of slow waves over that of the others, across."""
SLOWEST_WAVES, NODES, FEW_NODES = 6.0, 20, 4
"""Width, over the step of the plane's wave numbers along x, of the Gaussian part around 0 that is integrated more finely, and
the nodes of Gauss's rule on its first panels and on the others."""
MOST_ALIASES = 3
"""Aliases on each side that are added for layers thinner than an element."""
Part = Literal["normal", "shear", "coupling"]
COMPLIANCES: dict[Part, tuple[str, ...]] = {"normal": ("nn",), "shear": ("tt", "ss"), "coupling": ("tn",)}
"""The compliances that each group of tables consists of."""


def added_by_memory(body: Material, speed: float, k: Array) -> dict[str, AnyArray]:
    """k times the compliance that memory adds to that of a `body` with or without layers, for waves `k` (1/m) along rolling,
    by the names of `SurfaceCompliance`."""
    top, frequency = body.surface, k * speed
    softer = 1.0 / modulus_at(top.relaxation, frequency) - 1.0
    own = halfspace_compliance(top.youngs_modulus, top.poisson_ratio)
    added = {name: part * softer for name, part in own._asdict().items()}
    if not body.layers:
        return added
    # The equations hold for complex moduli as they are.
    moduli: list[Any] = [layer.youngs_modulus * modulus_at(layer.relaxation, frequency) for layer in body.layers]
    relaxed = [replace(layer, youngs_modulus=modulus) for layer, modulus in zip(body.layers, moduli, strict=True)]
    at_once, later = (difference_compliance(layers, (body.youngs_modulus, body.poisson_ratio), k)._asdict()
                      for layers in (body.layers, relaxed))
    return {name: part + later[name] - at_once[name] for name, part in added.items()}


@dataclass(frozen=True)
class RelaxingLayers:
    """A `body` whose upper layers relax, rolling at `speed` (m/s). `RelaxingLayers.of` keeps the last ones, which know what
    took time."""

    body: Material
    speed: float

    @staticmethod
    @lru_cache(maxsize=4)
    def of(body: Material, speed: float) -> RelaxingLayers:
        return RelaxingLayers(body, speed)

    @property
    def top(self) -> Layer:
        return self.body.layers[0]

    @cached_property
    def surface(self) -> dict[str, float]:
        """c₀ of the top material, by name."""
        return {name: float(part) for name, part in
                halfspace_compliance(self.top.youngs_modulus, self.top.poisson_ratio)._asdict().items()}

    def even(self, layer: Layer) -> dict[str, float]:
        """h m of a layer, in m/Pa, by name."""
        nu, h = layer.poisson_ratio, layer.thickness
        shear = 2.0 * (1.0 + nu) * h / layer.youngs_modulus
        pressed = (1.0 + nu) * (1.0 - 2.0 * nu) / (1.0 - nu) * h / layer.youngs_modulus
        return {"nn": pressed, "tt": shear, "ss": shear, "tn": 0.0}

    def depth(self, dx: float, dy: float) -> float:
        """z of the image in m: grids resolve its waves."""
        return max(self.top.thickness, 4.0 * dx, 4.0 * dy)

    def memory(self, layer: Layer, x: Array, step: float) -> AnyArray:
        """Ĵ(ω) − 1 of a layer at the wave numbers `x` along x (1/m), at 0 its mean up to half a `step`."""
        total = np.zeros(x.shape, dtype=np.complex128)
        for c, time in layer.retardation:
            half = 0.5 * step * time * self.speed
            total += np.where(x == 0.0, c * math.atan(half) / half, c / (1.0 + 1j * x * time * self.speed))
        return total

    def whole(self, x: Array, y: Array) -> AnyArray:
        """k times the normal compliance that memory adds, on the plane of wave numbers (1/m)."""
        step = float(np.abs(x[x != 0.0]).min())
        return np.asarray(self._added("nn", x, y, step) + self.surface["nn"] * self.memory(self.top, x, step))

    @lru_cache(maxsize=16)  # noqa: B019 - few bodies are kept
    def remaining_tables(self, part: Part, rows: int, columns: int, dx: float, dy: float) -> dict[str, Array]:
        """The part without a closed form, in m/Pa, at offsets −(rows − 1) … rows − 1 by 0 … columns − 1: "nn"; "xx", "yy" and
        "xy"; or "x" and "y", (2 rows − 1, columns)."""
        px, py = (even_length(round(BOXES * (2 * n - 1))) for n in (rows, columns))
        theta_x, theta_y = (np.asarray(2.0 * np.pi * theta, dtype=np.float64) for theta in
                            (np.fft.fftfreq(px)[:, None], np.fft.rfftfreq(py)[None, :]))
        thinnest, step = min(layer.thickness for layer in self.body.layers), 2.0 * math.pi / (px * dx)
        aliases = [min(MOST_ALIASES, math.floor(6.0 * d / (math.pi * thinnest))) for d in (dx, dy)]
        sums: dict[str, AnyArray] = {}
        for along in range(-aliases[0], aliases[0] + 1):
            for across in range(-aliases[1], aliases[1] + 1):
                x, y = (theta_x + 2.0 * np.pi * along) / dx, (theta_y + 2.0 * np.pi * across) / dy
                for name, symbol in self._remaining(part, x, y, step, dx, dy).items():
                    if along == 0:
                        symbol = symbol * -np.expm1(-0.5 * (x / (SLOWEST_WAVES * step)) ** 2)
                    sums[name] = sums.get(name, 0.0) + symbol
        place = np.arange(-(rows - 1), rows)
        tables = {name: np.fft.irfft2(symbol, (px, py))[place, :columns] / (dx * dy) for name, symbol in sums.items()}
        wide = even_length(round(WIDE * py))
        theta_wide = np.asarray(2.0 * np.pi * np.fft.rfftfreq(wide)[None, :], dtype=np.float64)
        for name, slow in self._slow(part, np.asarray(place * dx), theta_wide, step, aliases[1], dx, dy).items():
            tables[name] = tables[name] + np.fft.irfft(slow, wide, axis=1)[:, :columns] / dy
        return tables

    def _slow(
        self, part: Part, place: Array, theta_y: Array, step: float, aliases: int, dx: float, dy: float
    ) -> dict[str, AnyArray]:
        """The part of waves so long that the plane has few or none of them, at `place` along x and the wave numbers across: a
        memory trails far behind the plane. By Gauss's rule on panels that halve towards kₓ = 0."""
        most = 6.0 * SLOWEST_WAVES * step
        times = [time for layer in self.body.layers for _, time in layer.retardation]
        least = min(1e-2 / (self.speed * max(times)), 0.1 * step)
        halvings = math.ceil(math.log2(most / least))
        edges = np.concatenate(([0.0], most * 2.0 ** np.arange(-halvings, 1.0)))
        panels = [(low, high, NODES if high > 0.2 * most else FEW_NODES) for low, high in itertools.pairwise(edges.tolist())]
        rules = [(low, high, *np.polynomial.legendre.leggauss(number)) for low, high, number in panels]
        k = np.concatenate([low + 0.5 * (high - low) * (1.0 + nodes) for low, high, nodes, _ in rules])
        w = np.concatenate([0.5 * (high - low) * weights for low, high, _, weights in rules])
        k, w = np.concatenate((k, -k)), np.concatenate((w, w))
        w = w * np.exp(-0.5 * (k / (SLOWEST_WAVES * step)) ** 2) / (2.0 * np.pi)
        wave = np.exp(1j * np.outer(place, k)) * w
        sums: dict[str, AnyArray] = {}
        for across in range(-aliases, aliases + 1):
            for name, symbol in self._remaining(part, k[:, None], (theta_y + 2.0 * np.pi * across) / dy, step, dx, dy).items():
                sums[name] = sums.get(name, 0.0) + wave @ symbol
        return sums

    def _remaining(self, part: Part, x: Array, y: Array, step: float, dx: float, dy: float) -> dict[str, AnyArray]:
        """What remains of the symbols of `remaining_tables` at wave numbers along and across, times the area of an element."""
        k, z = np.hypot(x, y), self.depth(dx, dy)
        longest = 10.0 * SHALLOW / sum(layer.thickness for layer in self.body.layers)
        safe = np.where(k > 0.0, k, 1.0)
        sinc = np.sinc(0.5 * x * dx / np.pi) * np.sinc(0.5 * y * dy / np.pi) * dx * dy
        decay = np.exp(-k * z) * dx * dy
        parts: dict[str, AnyArray] = {}
        for name in COMPLIANCES[part]:
            symbol = self._added(name, x, y, step) * sinc
            symbol += self.surface[name] * self.memory(self.top, x, step) * (1.0 + k * z) * decay
            for layer in self.body.layers:
                symbol -= self.even(layer)[name] * k * decay * self.memory(layer, x, step)
            # On longer waves it falls with their number, and is less than the error of the interpolation.
            parts[name] = np.where(k > longest, symbol / safe, 0.0)
        cosine, sine = x / safe, y / safe
        if part == "normal":
            return parts
        if part == "coupling":
            return {"x": -1j * parts["tn"] * cosine, "y": -1j * parts["tn"] * sine}
        tt, ss = parts["tt"], parts["ss"]
        return {"xx": tt * cosine**2 + ss * sine**2, "yy": tt * sine**2 + ss * cosine**2, "xy": (tt - ss) * cosine * sine}

    def _added(self, name: str, x: Array, y: Array, step: float) -> AnyArray:
        """k times the compliance that memory adds, less that of the surface as a half-space; where x = 0 its mean up to half a
        `step`."""
        k, along = np.hypot(x, y), np.broadcast_to(x, np.broadcast_shapes(x.shape, y.shape))
        result = np.zeros(k.shape, dtype=np.complex128)
        log_k, log_x, coefficients = self._table
        inside = (k > 0.0) & (k < math.exp(log_k[-1]))
        moves, rest = inside & (along != 0.0), inside & (along == 0.0)

        def interpolated(part: int, ahead: Array, numbers: Array) -> Array:
            places = np.broadcast_arrays((np.log(ahead) - log_x[0]) / STEP_OMEGA, (np.log(numbers) - log_k[0]) / STEP_K)
            return np.asarray(scipy.ndimage.map_coordinates(coefficients[name][part], np.stack(places), order=3,
                                                            mode="nearest", prefilter=False))

        ahead = np.abs(along[moves])
        result[moves] = (interpolated(0, ahead, k[moves])
                         + 1j * np.sign(along[moves]) * self._lagging(ahead) * interpolated(1, ahead, k[moves]))
        result[rest] = SHARES @ interpolated(0, 0.5 * step * SLOW[:, None], k[rest])
        return result

    def _lagging(self, x: Array) -> Array:
        """Share of the longest memory that lags behind, at wave numbers `x` along x (1/m)."""
        lag = x * self.speed * max(time for layer in self.body.layers for _, time in layer.retardation)
        return np.asarray(lag / (1.0 + lag**2))

    @cached_property
    def _table(self) -> tuple[Array, Array, dict[str, tuple[Array, Array]]]:
        """ln k, ln kₓ, and the coefficients of splines of the real and of the imaginary part of `_added` by name."""
        layers, substrate = self.body.layers, (self.body.youngs_modulus, self.body.poisson_ratio)
        thick, thin = sum(layer.thickness for layer in layers), min(layer.thickness for layer in layers)
        slowest = RELAXED / (self.speed * max(time for layer in layers for _, time in layer.retardation))
        log_k = np.arange(math.log(SHALLOW / thick), math.log(DEEP / thin) + STEP_K, STEP_K)
        # Below any wave number on a grid memory is that of layers that have relaxed, or have not begun to.
        first = max(math.log(slowest), log_k[0] - 7.0)
        log_x = np.arange(first, max(log_k[-1], first + 1.0) + STEP_OMEGA, STEP_OMEGA)
        at_once, rows = difference_compliance(layers, substrate, np.exp(log_k)), []
        for x in np.exp(log_x):
            # The equations hold for complex moduli as they are.
            moduli: list[Any] = [layer.youngs_modulus * modulus_at(layer.relaxation, x * self.speed) for layer in layers]
            softer = [replace(layer, youngs_modulus=modulus) for layer, modulus in zip(layers, moduli, strict=True)]
            rows.append(difference_compliance(softer, substrate, np.exp(log_k)))
        coefficients = {}
        for name in self.surface:
            added = np.stack([getattr(row, name) - getattr(at_once, name) for row in rows])
            # Over what one memory has, so that it is constant on waves so long that everything has relaxed.
            lagging = added.imag / self._lagging(np.exp(log_x))[:, None]
            real, imaginary = (np.asarray(scipy.ndimage.spline_filter(part, order=3, mode="nearest"))
                               for part in (added.real, lagging))
            coefficients[name] = real, imaginary
        return log_k, log_x, coefficients
