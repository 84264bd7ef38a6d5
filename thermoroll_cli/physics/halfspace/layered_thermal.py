"""Heat on half-spaces with bonded layers: temperature and thermal expansion of the surface, and temperature of interfaces.

Material of all layers moves at one velocity V, and a flux enters a surface that is insulated elsewhere. In wave numbers, with
s² = k² + i k·V/κ in each layer and ζ from its lower face, T = a e^{−sz} + b e^{−sζ}, where b follows from the reflection

    ρ = (λs − y)/(λs + y),   y = λs (1 − ρ e^{−2sh})/(1 + ρ e^{−2sh}) of each layer on those below it,   T(0) = 1/y

(λ conductivity, h thickness; Carslaw and Jaeger 1959, 3.7). The expansion follows from reciprocity (Maysel 1941):
u_z = ∫ α Θ T dz, with Θ = w₁ e^{−kz} + w₂ e^{−kζ} the trace of the stresses under unit pressure on the surface; w is 2G(1+ν)
times the second coefficient of `layered.layer_waves`. Its integrals (1 − e^{−(k+s)h})/(k+s) and (e^{−kh} − e^{−sh})/(s − k)
have no resonance.

Tables are Fourier integrals (`oscillations`) of the difference to the half-space of the top material, which decays like
e^{−kh}. Tables are good to 1e-8 of the largest coefficient;
with 1 % of lateral creepage, to 5e-6 (temperature) and 6e-3 (expansion of thick soft layers: its long wake lies aslant
to the nodes).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
import scipy

from thermoroll_cli.physics.halfspace.layered import DEEPEST, layer_waves
from thermoroll_cli.physics.halfspace.oscillations import Complex, oscillations, strip_response, up_to_a_constant
from thermoroll_cli.problem.problem import Layer, Material
from thermoroll_cli.tools.arrays import Array

LayeredQuantity = Literal["temperature", "interface", "expansion"]

ELASTIC_STEP, SHALLOW = 0.03, 1e-8
"""Step of ln k of the elastic coefficients, which are interpolated at fifth order; smallest k times the thickness: below it
they are constant."""


@dataclass(frozen=True)
class LayeredHeat:
    """A half-space of the material `body` under its layers, all with thermal constants (SI).

    `table` is the response around one dx × dy element (m) with a heat flux of 1 W/m², or with `slope` of ξ W/m², ξ = x'/dx from
    −½ to ½ within the element: (2nx−1, 2ny−1) in the layout of `thermal.temperature_table`. The material moves at `speed` (m/s
    along x and y)."""

    body: Material

    @lru_cache(maxsize=48)  # noqa: B019 - few bodies are kept
    def table(
        self, quantity: LayeredQuantity, shape: tuple[int, int], sizes: tuple[float, float], speed: tuple[float, float], *,
        slope: bool = False,
    ) -> Array:
        """"temperature" (K) and "expansion" (m, outward; without motion up to a constant) of the surface less those of a
        half-space of the top material, and the whole temperature of the "interface" below the uppermost layer. Under a
        strip (dy = inf) the expansion is known up to a constant."""
        largest = DEEPEST / self.body.layers[0].thickness
        symbol = {"temperature": self.temperature_symbol, "interface": self.interface_symbol,
                  "expansion": self.expansion_symbol}[quantity]
        if math.isinf(sizes[1]):
            strip = strip_response(lambda k: symbol(k, 0.0 * k, speed), shape[0], sizes[0], largest, moment=slope)
            return (up_to_a_constant(strip) if quantity == "expansion" else strip)[:, None]
        kx, along = oscillations(shape[0], sizes[0], largest, moment=slope)
        ky, across = oscillations(shape[1], sizes[1], largest)
        x, y = np.meshgrid(kx, ky, indexing="ij")
        scale = sizes[0] * sizes[1] / (2.0 * math.pi**2)
        onward = along @ symbol(x, y, speed)
        if speed[1] == 0.0:
            half = 2.0 * scale * onward.real @ across[shape[1] - 1 :].real.T
            return np.concatenate((half[:, :0:-1], half), axis=1)
        return np.asarray(scale * (onward @ across.T + (along @ symbol(x, -y, speed)) @ across.conj().T).real)

    @cached_property
    def _traces(self) -> scipy.interpolate.BSpline:
        """w₁ and w₂ of each layer, and w₁ of the substrate, over ln k."""
        body, layers = self.body, self.body.layers
        ends = SHALLOW / sum(layer.thickness for layer in layers), 2.0 * DEEPEST / layers[0].thickness
        log_k = np.arange(math.log(ends[0]), math.log(ends[1]) + ELASTIC_STEP, ELASTIC_STEP)
        waves, below = layer_waves(layers, (body.youngs_modulus, body.poisson_ratio), np.exp(log_k))
        traces = [layer.youngs_modulus * part[:, 1, 1] for layer, both in zip(layers, waves, strict=True) for part in both]
        traces.append(body.youngs_modulus * below[:, 1, 1])
        return scipy.interpolate.make_interp_spline(log_k, np.stack(traces, axis=1), 5)

    def temperature_symbol(self, kx: Array, ky: Array, speed: tuple[float, float]) -> Complex:
        """Difference of the temperature per flux in K m²/W at wave numbers of one shape, e^{i(kx x + ky y)}."""
        entering, echo, _ = self._heat_waves(np.hypot(kx, ky), _drift(kx, ky, speed))
        return np.asarray(2.0 * echo * entering)

    def interface_symbol(self, kx: Array, ky: Array, speed: tuple[float, float]) -> Complex:
        """Temperature below the uppermost layer per flux in K m²/W, likewise."""
        entering, _, waves = self._heat_waves(np.hypot(kx, ky), _drift(kx, ky, speed))
        _, decay, reflection = waves[0]
        return np.asarray((decay + reflection) * entering)

    def expansion_symbol(self, kx: Array, ky: Array, speed: tuple[float, float]) -> Complex:
        """Difference of the outward displacement per flux in m³/W, likewise."""
        k, drift = np.hypot(kx, ky), _drift(kx, ky, speed)
        down, _, waves = self._heat_waves(k, drift)
        knots = self._traces.t
        traces = np.moveaxis(self._traces(np.clip(np.log(k), knots[0], knots[-1])), -1, 0)
        top, root = self.body.layers[0], waves[0][0]
        conductivity, _, expansion = thermal_constants(top)
        # Less that of a half-space of the top material.
        total = -2.0 * (1.0 + top.poisson_ratio) * expansion / (conductivity * root * (k + root))
        for number, (layer, (root, decay, reflection)) in enumerate(zip(self.body.layers, waves, strict=True)):
            _, diffusivity, expansion = thermal_constants(layer)
            if number:
                down = down / (1.0 + reflection * decay)
            up, first, second = reflection * down, traces[2 * number], traces[2 * number + 1]
            elastic_decay = np.exp(-k * layer.thickness)
            alike = (1.0 - elastic_decay * decay) / (k + root)
            # (s − k)h without cancellation.
            phase = drift / diffusivity / (root + k) * layer.thickness
            small = np.abs(phase) < 1e-12
            opposite = layer.thickness * elastic_decay * np.where(small, 1.0, -np.expm1(-phase) / np.where(small, 1.0, phase))
            total += expansion * ((first * down + second * up) * alike + (first * up + second * down) * opposite)
            down = down * decay + up
        _, diffusivity, expansion = thermal_constants(self.body)
        return np.asarray(total + expansion * traces[-1] * down / (k + np.sqrt(k * k + drift / diffusivity)))

    def _heat_waves(self, k: Array, drift: Complex) -> tuple[Complex, Complex, list[tuple[Complex, Complex, Complex]]]:
        """Downward wave a per flux at the surface, its echo there (over a), and of each layer s, e^{−sh} and b/a."""
        conductivity, diffusivity, _ = thermal_constants(self.body)
        admittance: Complex = np.asarray(conductivity * np.sqrt(k * k + drift / diffusivity))
        stack: list[tuple[Complex, Complex, Complex]] = []
        for layer in reversed(self.body.layers):
            conductivity, diffusivity, _ = thermal_constants(layer)
            root: Complex = np.sqrt(k * k + drift / diffusivity)
            decay: Complex = np.exp(-root * layer.thickness)
            own = conductivity * root
            reflection: Complex = np.asarray((own - admittance) / (own + admittance) * decay)
            echo: Complex = np.asarray(reflection * decay)
            admittance = own * (1.0 - echo) / (1.0 + echo)
            stack.insert(0, (root, decay, reflection))
        return np.asarray(1.0 / (own * (1.0 - echo))), echo, stack


def thermal_constants(material: Material | Layer) -> tuple[float, float, float]:
    """Conductivity, diffusivity and expansion. Raises ValueError if one is missing."""
    if material.conductivity is None or material.diffusivity is None or material.expansion is None:
        raise ValueError("thermal constants are missing")
    return material.conductivity, material.diffusivity, material.expansion


def _drift(kx: Array, ky: Array, speed: tuple[float, float]) -> Complex:
    return np.asarray(1j * (kx * speed[0] + ky * speed[1]))
