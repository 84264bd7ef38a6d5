"""Both bodies of a contact, one of them coated at least: differences of their influence tables to homogeneous bodies.

Tables of homogeneous bodies are closed forms of the surfaces' materials (`elastic`). This module has the differences that
coatings make, summed over both bodies with the signs of `elastic`, the periodic symbols of the whole, and the half-spaces that
describe the bodies near borders. A wrapped-around table is no preconditioner for stiff layers, so periodic symbols come from
the compliance in wave numbers, summed over the nearest aliases.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from thermoroll_cli.physics.halfspace import layered
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance
from thermoroll_cli.problem.problem import Material
from thermoroll_cli.tools.arrays import Array

STEP = 0.02
"""Step of ln k at which the compliance is looked up for symbols."""
SHALLOW, DEEP = 1e-6, 30.0
"""Wave numbers over the inverse thickness: below the first the compliance is that of the substrate, above the second that of
the surface."""
UNCOUPLED = 1e-12
"""Difference of the bodies' coupling over the compliance, below which it is rounding."""
STEP_OF_WAVES, LARGEST_WAVES, DIRECTIONS = 0.1, 30.0, 32
"""Step and end of wave numbers over the inverse half-lengths, and directions, for `Coatings.shares`: their integrand falls like
the fourth power."""
THICK, RESOLVED = 4.0, 2.0
"""Thicknesses over the element's size: from the first the surface's material describes a border fully, below the second it
alone does not describe it at all."""
THIN, UNRESOLVED = 0.25, 0.5
"""Thicknesses times the ratio of moduli over the element's size: below the first the substrate describes a border fully, above
the second it alone does not describe it at all."""


@dataclass(frozen=True)
class Coatings:
    """The `lower` and the `upper` body, of which one is coated at least."""

    lower: Material
    upper: Material

    @classmethod
    def of(cls, lower: Material, upper: Material) -> Coatings | None:
        """The coatings of a contact; None if none has an elastic effect."""
        if not (lower.elastic_layers or upper.elastic_layers):
            return None
        return cls(*(Material(body.youngs_modulus, body.poisson_ratio, layers=body.elastic_layers) for body in (lower, upper)))

    @property
    def surface_modulus(self) -> float:
        """E* of the surfaces' materials in Pa."""
        return 1.0 / (1.0 / self.lower.surface.plane_strain_modulus + 1.0 / self.upper.surface.plane_strain_modulus)

    @property
    def _layered(self) -> list[tuple[float, layered.LayeredBody]]:
        """Sign of the coupling (`elastic.coupling_tables`), and body."""
        return [(sign, layered.LayeredBody.of(body)) for sign, body in ((-1.0, self.lower), (1.0, self.upper)) if body.layers]

    def normal_table(self, nx: int, ny: int, dx: float, dy: float) -> Array:
        """To be added to `elastic.normal_table`."""
        return self._tables("normal", nx, ny, dx, dy)[0]

    def shear_tables(self, nx: int, ny: int, dx: float, dy: float) -> tuple[Array, Array, Array]:
        """To be added to `elastic.shear_tables`."""
        xx, yy, xy = self._tables("shear", nx, ny, dx, dy)
        return xx, yy, xy

    def coupling_tables(self, nx: int, ny: int, dx: float, dy: float) -> tuple[Array, Array]:
        """To be added to K times `elastic.coupling_tables`."""
        x, y = self._tables("coupling", nx, ny, dx, dy)
        return x, y

    def _tables(self, kind: layered.TableKind, nx: int, ny: int, dx: float, dy: float) -> list[Array]:
        """Sums over both bodies."""
        of_bodies = ([table * (sign if kind == "coupling" else 1.0) for table in body.tables(kind, (nx, ny), dx, dy)]
                     for sign, body in self._layered)
        return [np.asarray(sum(tables)) for tables in zip(*of_bodies, strict=True)]

    # --- wave numbers --------------------------------------------------------------------------------------------

    @cached_property
    def _log_wave_numbers(self) -> Array:
        layers = self.lower.layers + self.upper.layers
        low, high = SHALLOW / max(body.thickness for _, body in self._layered), DEEP / min(layer.thickness for layer in layers)
        return np.arange(math.log(low), math.log(high) + STEP, STEP)

    @cached_property
    def _compliances(self) -> list[dict[str, Array]]:
        """k times the compliance of the lower and of the upper body, by the names of `SurfaceCompliance`."""
        k, compliances = np.exp(self._log_wave_numbers), []
        for body in (self.lower, self.upper):
            top = layered.halfspace_compliance(body.surface.youngs_modulus, body.surface.poisson_ratio)._asdict()
            own = body.youngs_modulus, body.poisson_ratio
            more = layered.difference_compliance(body.layers, own, k)._asdict() if body.layers else dict.fromkeys(top, 0.0 * k)
            compliances.append({name: part + more[name] for name, part in top.items()})
        return compliances

    def compliance(self, wave_numbers: Array) -> dict[str, Array]:
        """k times the compliance of both bodies together in 1/Pa: for pressure ("nn"), for shear along ("tt") and across ("ss")
        the wave vector."""
        lower, upper = self._compliances
        log = np.log(wave_numbers)
        return {name: np.interp(log, self._log_wave_numbers, lower[name] + upper[name]) for name in ("tt", "nn", "ss")}

    def shares(self, half_x: float, half_y: float) -> tuple[float, float]:
        """Shares of both bodies in the compliance of a contact with these half-lengths (m), with the sum 1: in the curvature
        across, by least squares over the contact, of the displacement under Hertz's pressure.

        With r² = (x/a)² + (y/b)² pressure and weight are √(1 − r²), whose transform is j₁(q)/q at q = (a kₓ, b k_y). The
        curvature is read by √(1 − r²)((y/b)² + (x/a)²/4 − 1/4), to which 1 and x² are orthogonal."""
        q = np.arange(0.5 * STEP_OF_WAVES, LARGEST_WAVES, STEP_OF_WAVES)
        nodes, widths = np.polynomial.legendre.leggauss(DIRECTIONS)
        angle = 0.25 * math.pi * (1.0 + nodes[:, None])
        j1, j2, j3 = (scipy.special.spherical_jn(n, q) / q**n for n in (1, 2, 3))
        read = 1.25 * j2 - 0.25 * j1 - q**2 * (np.sin(angle) ** 2 + 0.25 * np.cos(angle) ** 2) * j3
        over_q = np.hypot(np.cos(angle) / half_x, np.sin(angle) / half_y)  # |k|/q
        weight = widths[:, None] * j1 * read / over_q
        lower, upper = (float((weight * np.interp(np.log(q * over_q), self._log_wave_numbers, body["nn"])).sum())
                        for body in self._compliances)
        return lower / (lower + upper), upper / (lower + upper)

    @cached_property
    def coupling_constant(self) -> float:
        """K of `elastic.coupling_constant` (1/Pa) at the wave number where it is largest; 0 for bodies that do not couple."""
        lower, upper = self._compliances
        difference = lower["tn"] - upper["tn"]
        largest = float(difference[np.argmax(np.abs(difference))])
        return 0.0 if abs(largest) <= UNCOUPLED * float((lower["nn"] + upper["nn"]).max()) else largest / (2.0 * math.pi)

    def periodic_symbols(self, padded: tuple[int, int], dx: float, dy: float) -> tuple[Array, Array, Array, Array]:
        """Symbols (py//2+1, px) on a plane of `padded` elements: u_z under p, u_x under q_x, u_y under q_y, u_x under q_y."""
        px, py = padded
        theta_x, theta_y = 2.0 * np.pi * np.fft.fftfreq(px), 2.0 * np.pi * np.fft.rfftfreq(py)[:, None]
        strips = math.isinf(dy)  # on which nothing varies across
        smallest = np.pi / (px * dx if strips else max(px * dx, py * dy))
        sums = np.zeros((4, py // 2 + 1, px))
        for along in (-1, 0, 1):
            for across in (0,) if strips else (-1, 0, 1):
                phase_x, phase_y = theta_x + 2.0 * np.pi * along, (theta_y + 2.0 * np.pi * across) * (not strips)
                x, y = phase_x / dx, phase_y / dy
                k = np.maximum(np.hypot(x, y), smallest)
                # The mean has no direction but that of strips.
                cosine = np.where(k > smallest, (x / k) ** 2, 1.0 if strips else 0.5)
                c = self.compliance(k)
                weight = np.sinc(0.5 * phase_x / np.pi) * np.sinc(0.5 * phase_y / np.pi) / k
                sums += weight * np.stack([c["nn"], c["tt"] * cosine + c["ss"] * (1.0 - cosine),
                                           c["ss"] * cosine + c["tt"] * (1.0 - cosine), (c["tt"] - c["ss"]) * x * y / k**2])
        nn, xx, yy, xy = sums
        return nn, xx, yy, xy

    # --- borders -------------------------------------------------------------------------------------------------

    def near_border(self, dx: float, dy: float, interlayer: float = 0.0) -> ShearCompliance:
        """Half-spaces that describe the bodies within an element of dx × dy (m): of the surfaces' materials for thick layers,
        of the substrates' for thin ones. Between, neither is right, and their mean is a guess."""
        bodies, trusts = zip(*(_seen(body, min(dx, dy)) for body in (self.lower, self.upper)), strict=True)
        compliance = ShearCompliance.of(*((m.shear_modulus, m.poisson_ratio) for m in bodies), interlayer=interlayer)
        return replace(compliance, trust=min(trusts))


def _seen(body: Material, size: float) -> tuple[Material, float]:
    """The material that describes a body within `size` (m) of its surface, and how well, 0 to 1."""
    top, below = body.surface, Material(body.youngs_modulus, body.poisson_ratio)
    if not body.layers:
        return below, 1.0
    first = body.layers[0].thickness / size
    # A thin layer that is softer, or stiffer, acts like a layer of the material below that is thicker by the ratio of moduli.
    ratios = (layer.youngs_modulus / body.youngs_modulus for layer in body.layers)
    total = sum(layer.thickness * max(ratio, 1.0 / ratio) for layer, ratio in zip(body.layers, ratios, strict=True)) / size
    # For like materials this does not matter.
    contrast = min(1.0, abs(math.log(top.plane_strain_modulus / below.plane_strain_modulus))
                   + 2.0 * abs(top.poisson_ratio - below.poisson_ratio)) if len(body.layers) == 1 else 1.0
    if first >= RESOLVED:
        material, trust = top, math.log(first / RESOLVED) / math.log(THICK / RESOLVED)
    elif total <= UNRESOLVED:
        material, trust = below, math.log(UNRESOLVED / total) / math.log(UNRESOLVED / THIN)
    else:
        share = min(max(math.log(first / UNRESOLVED) / math.log(RESOLVED / UNRESOLVED), 0.0), 1.0)
        material = Material(top.youngs_modulus**share * below.youngs_modulus ** (1.0 - share),
                            share * top.poisson_ratio + (1.0 - share) * below.poisson_ratio)
        trust = 0.0
    return material, 1.0 - (1.0 - min(trust, 1.0)) * contrast
