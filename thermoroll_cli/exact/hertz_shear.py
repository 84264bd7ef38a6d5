"""Displacements of a half-space under tangential tractions distributed like a Hertz pressure over the contact ellipse.

A kernel whose Fourier transform is g(θ)/k, θ being the direction of the wave vector k, turns the pressure
p = p0 sqrt(1 − x²/a0² − y²/b0²) into a paraboloid inside the ellipse. The transform of p depends on k m(θ) only,
m² = a0² cos²θ + b0² sin²θ, and the integral over k can be done:

    u(x, y) = p0 a0 b0/8 ∫_0^2π g(θ)/m [1 − (x cos θ + y sin θ)²/m²] dθ

(Vermeulen & Johnson 1964 in elliptic integrals; Cattaneo and Mindlin's formula for the circle, see `cattaneo_mindlin`).
"""

from __future__ import annotations

import math

import numpy as np

from thermoroll_cli.exact.hertz import HertzContact

POINTS_PER_ASPECT = 24
"""The integrands are smooth and periodic, so equal steps converge exponentially, at a rate set by the ratio of the axes."""


def shear_gradients(hertz: HertzContact, isotropic: float, directional: float) -> tuple[float, float, float]:
    """Slopes c_xx, c_yy, c_xy in 1/m·(Pa/Pa) of ∂u/∂x inside the ellipse under the tractions (p, 0) and (0, p):

        ∂u_x/∂x = c_xx x,   ∂u_y/∂x = c_xy y   under (p, 0);      ∂u_x/∂x = c_xy y,   ∂u_y/∂x = c_yy x   under (0, p).

    `isotropic` and `directional` are Σ(1−ν)/(2πG) and Σν/(2πG) in 1/Pa (`kernels.elastic.ShearCompliance`). The kernels 1/r,
    x²/r³, y²/r³ and xy/r³ of Cerruti's solution have g = 2π, 2π sin²θ, 2π cos²θ and −2π sin θ cos θ.
    """
    a, b = hertz.semi_axis_x, hertz.semi_axis_y
    points = POINTS_PER_ASPECT * math.ceil(4.0 + max(a / b, b / a))
    theta = 2.0 * math.pi / points * np.arange(points)
    cc, ss = np.cos(theta) ** 2, np.sin(theta) ** 2
    # −2 cos θ (x cos θ + y sin θ) of the derivative by x, with the 2π of all g.
    weight = -hertz.peak_pressure * a * b / 4.0 * (2.0 * math.pi / points) * 2.0 * math.pi / (a * a * cc + b * b * ss) ** 1.5
    along = float((weight * cc * (isotropic + directional * ss)).sum())
    across = float((weight * cc * (isotropic + directional * cc)).sum())
    mixed = float((weight * cc * ss).sum()) * -directional
    return along, across, mixed
