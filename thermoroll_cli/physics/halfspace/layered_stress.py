"""Stresses inside a layered half-space under one uniformly loaded rectangular element.

In wave numbers, along k and across it (c), with V, T and S of `layered` at a depth and per unit traction on the surface,

    σ_zz = S,   σ_kz = iT,   σ_kk = ν/(1−ν) S − 2G kV/(1−ν),   σ_cc = ν (σ_kk + S);

across k, u = (A e^{−kz} + B e^{−kζ})/Gk, σ_kc = i(A e^{−kz} + B e^{−kζ}) and σ_cz = B e^{−kζ} − A e^{−kz}, B = ρ e^{−kh} A with
the reflection ρ = (G − g)/(G + g) at the layers below, of impedance g. With M = ½(σ_kk + σ_cc), D = ½(σ_kk − σ_cc), Q = σ_kc/i
and Hm[f] = ∫ f J_m(kr) k dk/2π, a point load gives

    pressure:  σ_xx, σ_yy = H0[M] ∓ cos 2θ H2[D]      σ_xy = −sin 2θ H2[D]      σ_xz = −cos θ H1[T]
    t_x:       σ_xx, σ_yy = −cos θ H1[M ± ½(D+Q)] ± cos 3θ H3[½(D−Q)]           σ_xz = H0[½(Z−T)] + cos 2θ H2[½(Z+T)]
               σ_xy = −sin θ H1[½(D+Q)] + sin 3θ H3[½(D−Q)]                     σ_yz = sin 2θ H2[½(Z+T)],   Z = σ_cz.

and t_y by x ↔ y, θ ↔ π/2 − θ. In the uppermost layer these are differences to the half-space of its material, whose closed
forms (`subsurface_elastic`) are added. In that layer the symbols decay like e^{−k(2h−z)}, below it like e^{−kz}.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from thermoroll_cli.physics.halfspace.layered import (
    DEEPEST,
    FIRST_WAVE_NUMBER,
    MIRROR,
    Constants,
    LayeredBody,
    RadialFunctions,
    element_integrals,
    layer_waves,
)
from thermoroll_cli.physics.halfspace.oscillations import strip_response
from thermoroll_cli.physics.halfspace.subsurface_elastic import pressure_stress, traction_x_stress, traction_y_stress
from thermoroll_cli.tools.arrays import AnyArray, Array

PRESSURE = (("p mean", "even"), ("p difference", "cos2"), ("p difference", "sin2"), ("p zz", "even"), ("p kz", "cos"),
            ("p kz", "sin"))
TRACTION = (("t mean", "cos"), ("t mean", "sin"), ("t zz", "cos"), ("t zz", "sin"), ("t single", "cos"), ("t single", "sin"),
            ("t triple", "cos3"), ("t triple", "sin3"), ("t even", "even"), ("t double", "cos2"), ("t double", "sin2"))
"""Functions and angular factors of the stresses under both kinds of load."""


def element_stresses(
    body: LayeredBody, shape: tuple[int, int], dx: float, dy: float, depth: float, *, traction: bool = True
) -> list[Array]:
    """Stresses xx yy zz xy xz yz at `depth` (m) under a dx × dy element (m) that carries unit pressure, and with `traction`
    under unit traction along x and along y on the body.

    (6, nx, ny) each, at offsets (i dx, j dy), i < nx, j < ny, signs as in `subsurface_elastic`. The depth of an interface is
    its upper side, the next larger number its lower side."""
    if math.isinf(dy):
        loads = _strip_stresses(body, shape, dx, depth)[: 3 if traction else 1]
    else:
        loads = _rectangle_stresses(body, shape, dx, dy, depth, traction=traction)
    if depth <= body.layers[0].thickness:
        across = np.arange(float(shape[1])) * (dy / dx) if shape[1] > 1 else np.zeros(1)
        at = np.arange(float(shape[0])), across, depth / dx, dy / dx
        for load, closed_form in zip(loads, (pressure_stress, traction_x_stress, traction_y_stress), strict=False):
            load += closed_form(*at, body.layers[0].poisson_ratio)
    return loads


def _strip_stresses(body: LayeredBody, shape: tuple[int, int], dx: float, depth: float) -> list[Array]:
    """`element_stresses` of a strip without ends, where nothing varies across; in the uppermost layer the difference."""

    def symbols(k: Array) -> AnyArray:
        waves = np.maximum(k, FIRST_WAVE_NUMBER / max(body.thickness, depth))
        mean, difference, zz, kz = waves_along(body, waves, depth)
        xy, yz = waves_across(body, waves, depth)
        even = np.stack([mean + difference, mean - difference, zz, kz], axis=2)
        pressure, traction = even[:, 1] * [-1, -1, -1, -1j], even[:, 0] * [1j, 1j, 1j, -1]
        return np.concatenate([pressure, traction, xy[:, None] * 1j, yz[:, None]], axis=1)

    largest = DEEPEST / max(body.layers[0].thickness, depth)
    found = strip_response(symbols, shape[0], dx, largest)[shape[0] - 1 :].T
    loads = np.zeros((3, 6, shape[0]))
    for load, components in zip(loads, ((0, 1, 2, 4), (0, 1, 2, 4), (3, 5)), strict=True):
        load[list(components)], found = found[: len(components)], found[len(components) :]
    return list(loads[..., None])


def _rectangle_stresses(
    body: LayeredBody, shape: tuple[int, int], dx: float, dy: float, depth: float, *, traction: bool
) -> list[Array]:
    """`element_stresses`, in the uppermost layer the difference."""
    integrals = element_integrals(_point_stresses(body, depth), PRESSURE + TRACTION if traction else PRESSURE, shape, dx, dy)
    mean, turned, xy, zz, xz, yz = integrals[:6]
    loads = [np.stack([mean - turned, mean + turned, zz, -xy, -xz, -yz])]
    if traction:
        mean, mean_y, zz, zz_y, single, single_y, triple, triple_y, even, double, yz = integrals[6:]
        loads += [np.stack([triple - mean - single, single - mean - triple, -zz, triple_y - single_y, even + double, yz]),
                  np.stack([single_y - mean_y + triple_y, -mean_y - single_y - triple_y, -zz_y, -single - triple, yz,
                            even - double])]
    return loads


@lru_cache(maxsize=128)
def _point_stresses(body: LayeredBody, depth: float) -> RadialFunctions:
    """The functions Hm of a pressure (p) and of a traction (t): the grids of the error estimates share them."""
    k = body.wave_numbers(depth)
    mean, difference, zz, kz = waves_along(body, k, depth)
    kc, cz = waves_across(body, k, depth)
    symbols = {
        "p mean": (0, -mean[:, 1]), "p difference": (2, -difference[:, 1]), "p zz": (0, -zz[:, 1]), "p kz": (1, -kz[:, 1]),
        "t mean": (1, mean[:, 0]), "t zz": (1, zz[:, 0]), "t single": (1, 0.5 * (difference[:, 0] + kc)),
        "t triple": (3, 0.5 * (difference[:, 0] - kc)), "t even": (0, 0.5 * (cz - kz[:, 0])),
        "t double": (2, 0.5 * (cz + kz[:, 0])),
    }
    return RadialFunctions.of({name: (order, k * symbol) for name, (order, symbol) in symbols.items()}, k, body.thickness)


def waves_along(body: LayeredBody, k: Array, depth: float) -> tuple[Array, Array, Array, Array]:
    """M, D, S and T in the plane of wave vectors of length `k` (n,), (n, 2): for T = 1 and for S = 1 on the surface."""
    number, z = _place(body, depth)
    waves, below = layer_waves(body.layers, body.substrate, k)
    if number == len(body.layers):
        own, ratio, down, up = Constants.of(*body.substrate), body.substrate[1], below, 0.0 * below
    else:
        layer, (down, up) = body.layers[number], waves[number]
        own, ratio = Constants.of(layer.youngs_modulus, layer.poisson_ratio), layer.poisson_ratio
        if number == 0:
            # This makes up for the stresses of upward waves on the surface: the rest is the half-space's.
            down = np.asarray(np.linalg.solve(own.stress, MIRROR @ own.stress @ _moved(up, k * layer.thickness)))
        up = _moved(up, k * (layer.thickness - z))
    down = _moved(down, k * z)
    displacement = own.displacement @ down + MIRROR @ own.displacement @ up
    stress = own.stress @ down - MIRROR @ own.stress @ up
    zz, kz = stress[:, 1], stress[:, 0]
    kk = (ratio * zz - own.shear_modulus * displacement[:, 0]) / (1.0 - ratio)
    cc = ratio * (kk + zz)
    return 0.5 * (kk + cc), 0.5 * (kk - cc), zz, kz


def waves_across(body: LayeredBody, k: Array, depth: float) -> tuple[Array, Array]:
    """Q and Z across the wave vector, (n,), for unit traction on the surface."""
    number, z = _place(body, depth)
    moduli = [0.5 * layer.youngs_modulus / (1.0 + layer.poisson_ratio) for layer in body.layers]
    moduli.append(0.5 * body.substrate[0] / (1.0 + body.substrate[1]))
    below, reflections = np.full(k.size, moduli[-1]), [np.zeros(k.size)]
    decays = [np.exp(-k * layer.thickness) for layer in body.layers]
    for modulus, decay in zip(moduli[-2::-1], decays[::-1], strict=True):
        reflections.insert(0, (modulus - below) / (modulus + below) * decay)
        below = modulus * (1.0 - reflections[0] * decay) / (1.0 + reflections[0] * decay)
    down = 1.0 / (1.0 - reflections[0] * decays[0])
    for upper in range(number):
        face = down * (decays[upper] + reflections[upper]) * moduli[upper + 1] / moduli[upper]
        down = face / (1.0 + reflections[upper + 1] * (decays[upper + 1] if upper + 1 < len(decays) else 0.0))
    up = np.zeros(k.size)
    if number < len(body.layers):
        up = down * reflections[number] * np.exp(-k * (body.layers[number].thickness - z))
    if number == 0:
        down = down * reflections[0] * decays[0]
    down = down * np.exp(-k * z)
    return down + up, up - down


def _place(body: LayeredBody, depth: float) -> tuple[int, float]:
    """Number of the layer at a depth, that of the substrate after the last one, and the depth in it."""
    for number, face in enumerate(body.interfaces):
        if depth <= face:
            return number, depth - (body.interfaces[number - 1] if number else 0.0)
    return len(body.layers), depth - body.interfaces[-1]


def _moved(coefficients: Array, phase: Array) -> Array:
    """N(t) c e^{−t} of coefficients c (n, 2, 2)."""
    moved = coefficients * np.exp(-phase)[:, None, None]
    moved[:, 0] += phase[:, None] * moved[:, 1]
    return moved
