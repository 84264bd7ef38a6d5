"""Hertz contact of two elastic bodies: general elliptic contact, and the line contact of cylinders.

Hertz (1882); Johnson, Contact Mechanics (1985), Secs. 3.2, 3.5 and 4.2(c). The undeformed gap is
h_i = x² κ_x/2 + y² κ_y/2 with relative curvatures κ = 1/R', and the pressure
p = p0 sqrt(1 − x²/a0² − y²/b0²) moves the two surfaces together by (sum of both bodies)

    u_z(x, y) = p0 a0 b0/(2E*) ∫_λ^∞ [1 − x²/(a0² + s) − y²/(b0² + s)] ds / sqrt((a0² + s)(b0² + s) s),

λ = 0 inside the contact ellipse, and outside it the largest root of x²/(a0² + λ) + y²/(b0² + λ) = 1. The three
integrals are Carlson's symmetric R_F and R_D, which keep full precision for any aspect ratio (no eccentricity loses digits
near the circle or the line).

`element_averages` is the pressure averaged over the elements of a grid, with the part of each that the contact covers.

`shear_gradients` belongs to tangential tractions distributed like the pressure. A kernel whose Fourier transform is
g(θ)/k, θ being the direction of the wave vector k, turns the pressure
p = p0 sqrt(1 − x²/a0² − y²/b0²) into a paraboloid inside the ellipse. The transform of p depends on k m(θ) only,
m² = a0² cos²θ + b0² sin²θ, and the integral over k can be done:

    u(x, y) = p0 a0 b0/8 ∫_0^2π g(θ)/m [1 − (x cos θ + y sin θ)²/m²] dθ

(Vermeulen & Johnson 1964 in elliptic integrals; Cattaneo and Mindlin's formula for the circle, see `cattaneo_mindlin`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike
from scipy.special import elliprd, elliprf

from thermoroll_cli.physics.numerics.quadrature import gauss_points
from thermoroll_cli.tools.arrays import Array


@dataclass(frozen=True)
class HertzContact:
    """A solved Hertz contact (consistent units, SI in this program).

    Fields: `semi_axis_x`, `semi_axis_y` = a0, b0 of the contact ellipse (m); `peak_pressure` = p0 (Pa); `approach` = δ,
    by which the remote parts of the bodies come closer (m); and the inputs `curvature_x`, `curvature_y` (1/m),
    `contact_modulus` = E* (Pa), `normal_force` = W (N). Made by `hertz_contact`. Of cylinders (`curvature_y` = 0) b0 is inf, W
    is per length (N/m), and δ, which is not defined, is nan.
    """

    semi_axis_x: float
    semi_axis_y: float
    peak_pressure: float
    approach: float
    curvature_x: float
    curvature_y: float
    contact_modulus: float
    normal_force: float

    @property
    def area(self) -> float:
        """Contact area A_c0 = π a0 b0; of cylinders 2 a0 per length."""
        if math.isinf(self.semi_axis_y):
            return 2.0 * self.semi_axis_x
        return math.pi * self.semi_axis_x * self.semi_axis_y

    @property
    def mean_pressure(self) -> float:
        """Mean pressure W/(π a0 b0) = 2 p0/3."""
        return self.normal_force / self.area

    @property
    def aspect_ratio(self) -> float:
        """a0/b0: semi-axis along x (rolling) over semi-axis along y."""
        return self.semi_axis_x / self.semi_axis_y

    @property
    def mean_radius(self) -> float:
        """Radius sqrt(a0 b0) of the circle with the same area (Kalker's c)."""
        return math.sqrt(self.semi_axis_x * self.semi_axis_y)

    @property
    def stiffness(self) -> float:
        """Normal contact stiffness dW/dδ = 3W/(2δ), since δ ∝ W^(2/3)."""
        return 1.5 * self.normal_force / self.approach

    def undeformed_gap(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Gap h_i = x²/(2R'_x) + y²/(2R'_y) of the bodies touching at the origin; broadcasts x and y."""
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        return np.asarray(0.5 * self.curvature_x * x**2 + 0.5 * self.curvature_y * y**2)

    def pressure(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Pressure p0 sqrt(1 − x²/a0² − y²/b0²), zero outside the ellipse; broadcasts x and y."""
        return np.asarray(self.peak_pressure * np.sqrt(np.maximum(-self._excess(x, y), 0.0)))

    def displacement(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Elastic surface displacement u_z of both bodies together, anywhere on the surface.

        δ − h_i inside the contact ellipse, the integral of the module's docstring outside; it falls as
        W/(πE* r) far away. Broadcasts x and y.
        """
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        displacement = np.asarray(self.approach - self.undeformed_gap(x, y))
        excess = self._excess(x, y)
        outside = excess > 0.0
        if not outside.any():
            return displacement
        xx, yy = x[outside] ** 2, y[outside] ** 2
        aa, bb = self.semi_axis_x**2, self.semi_axis_y**2
        half_trace = 0.5 * (xx + yy - aa - bb)
        minus_det = aa * bb * excess[outside]
        root = np.sqrt(half_trace**2 + minus_det)
        # the textbook root half_trace + root cancels next to a slender ellipse; there use the product of the roots
        safe = np.where(half_trace < 0.0, root - half_trace, 1.0)
        lam = np.where(half_trace < 0.0, minus_det / safe, half_trace + root)
        integral = elliprf(lam, aa + lam, bb + lam)
        integral -= xx * elliprd(lam, bb + lam, aa + lam) / 3.0
        integral -= yy * elliprd(lam, aa + lam, bb + lam) / 3.0
        displacement[outside] = self.peak_pressure * (aa * bb) ** 0.5 / self.contact_modulus * integral
        return displacement

    def gap(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Gap h = h_i + u_z − δ between the deformed surfaces: zero in the contact, positive outside; beside cylinders
        ½ κ a² (ξ √(ξ² − 1) − arcosh ξ) with ξ = |x|/a, since dh/dx = κ √(x² − a²)."""
        if math.isinf(self.semi_axis_y):
            ratio = np.maximum(np.abs(np.asarray(x, dtype=float) / self.semi_axis_x), 1.0)
            return 0.5 * self.curvature_x * self.semi_axis_x**2 * (ratio * np.sqrt(ratio**2 - 1.0) - np.arccosh(ratio))
        gap = self.undeformed_gap(x, y) + self.displacement(x, y) - self.approach
        # differences of rounding size are meaningless in and next to the contact
        return np.where(self._excess(x, y) > 0.0, np.maximum(gap, 0.0), 0.0)

    def _excess(self, x: ArrayLike, y: ArrayLike) -> Array:
        """x²/a0² + y²/b0² − 1: negative inside the contact ellipse."""
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        return np.asarray((x / self.semi_axis_x) ** 2 + (y / self.semi_axis_y) ** 2 - 1.0)


def hertz_contact(curvature_x: float, curvature_y: float, contact_modulus: float, normal_force: float) -> HertzContact:
    """Solve the elliptic Hertz contact to rounding accuracy (relative error below 1e-12).

    Matching u_z = δ − h_i inside the ellipse gives, with a0 = c e^(t/2), b0 = c e^(−t/2),

        κ_x/κ_y = R_D(0, e^(−t), e^t) / R_D(0, e^t, e^(−t))                                 → t = ln(a0/b0)
        c³      = W [R_D(0, e^(−t), e^t) + R_D(0, e^t, e^(−t))] / (π E* (κ_x + κ_y))
        p0      = 3W/(2π a0 b0),     δ = p0 a0 b0 R_F(0, a0², b0²)/E*.

    Parameters: relative curvatures κ = 1/R' along x and y (1/m), the contact modulus E* with
    1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂ (Pa), and the normal force W (N).

    With κ_y = 0 the bodies are cylinders and W is per length (`line_contact`).

    Raises ValueError if any other of them is not positive and finite.
    """
    if curvature_y == 0.0:
        line = line_contact(curvature_x, contact_modulus, normal_force)
        return HertzContact(line.half_width, math.inf, line.peak_pressure, math.nan, line.curvature, 0.0, line.contact_modulus,
                            line.load_per_length)
    check_positive(curvature_x=curvature_x, curvature_y=curvature_y, contact_modulus=contact_modulus,
                   normal_force=normal_force)
    t = _log_aspect_ratio(math.log(curvature_x) - math.log(curvature_y))
    integrals = _curvature_integral(t) + _curvature_integral(-t)
    # cube roots factor by factor: the quotient itself may overflow for extreme units
    c = math.cbrt(normal_force / contact_modulus) * math.cbrt(integrals / (math.pi * (curvature_x + curvature_y)))
    semi_axis_x, semi_axis_y = c * math.exp(0.5 * t), c * math.exp(-0.5 * t)
    return HertzContact(
        semi_axis_x=semi_axis_x,
        semi_axis_y=semi_axis_y,
        peak_pressure=1.5 * normal_force / (math.pi * c * c),
        approach=float(1.5 * normal_force / (math.pi * contact_modulus * c) * elliprf(0.0, math.exp(t), math.exp(-t))),
        curvature_x=float(curvature_x),
        curvature_y=float(curvature_y),
        contact_modulus=float(contact_modulus),
        normal_force=float(normal_force),
    )


def check_positive(**values: float) -> None:
    """Raise ValueError naming the first value that is not positive and finite."""
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0.0):
            hint = " (the bodies must curve away from each other)" if name.startswith("curvature") else ""
            raise ValueError(f"{name} must be positive and finite{hint}, got {value!r}")


def _curvature_integral(t: float) -> float:
    """R_D(0, e^(−t), e^t), proportional to the curvature that the pressure flattens along the semi-axis e^(t/2)."""
    return float(elliprd(0.0, math.exp(-t), math.exp(t)))


def _log_aspect_ratio(log_curvature_ratio: float) -> float:
    """Solve for t = ln(a0/b0) given ln(κ_x/κ_y).

    The logarithm of the curvature ratio is an odd function of t with a slope between −3/2 at the circle and −2 for slender
    ellipses, which brackets the root.
    """
    if abs(log_curvature_ratio) < 1e-6:
        # A circle but for rounding, which would hide the change of sign between the brackets.
        return -log_curvature_ratio / 1.5

    def mismatch(t: float) -> float:
        return math.log(_curvature_integral(t)) - math.log(_curvature_integral(-t)) - log_curvature_ratio

    near, far = -0.45 * log_curvature_ratio, -0.7 * log_curvature_ratio
    return float(scipy.optimize.brentq(mismatch, near, far, xtol=1e-16 * abs(far), rtol=4.0 * np.finfo(float).eps))


@dataclass(frozen=True)
class LineContact:
    """A solved Hertz contact of parallel cylinders, per unit length along y.

    Fields: `half_width` = a (m), `peak_pressure` = p0 (Pa), and the inputs `curvature` = 1/R (1/m), `contact_modulus` =
    E* (Pa), `load_per_length` = N (N/m). Made by `line_contact`.
    """

    half_width: float
    peak_pressure: float
    curvature: float
    contact_modulus: float
    load_per_length: float

    def pressure(self, x: ArrayLike) -> Array:
        """Pressure p0 sqrt(1 − x²/a²), zero outside the contact; shape of x."""
        x = np.asarray(x, dtype=float) / self.half_width
        return np.asarray(self.peak_pressure * np.sqrt(np.maximum((1.0 - x) * (1.0 + x), 0.0)))


def line_contact(curvature: float, contact_modulus: float, load_per_length: float) -> LineContact:
    """Hertz contact of two parallel cylinders: a² = 4N/(πE*κ), p0 = E* a κ/2 = 2N/(πa) (Johnson 1985, Sec. 4.2(c)).

    Parameters: relative curvature κ = 1/R (1/m), contact modulus E* (Pa), load per length N (N/m). The approach of the
    two bodies is not defined in two dimensions.

    Raises ValueError if any of them is not positive and finite.
    """
    check_positive(curvature=curvature, contact_modulus=contact_modulus, load_per_length=load_per_length)
    half_width = math.sqrt(4.0 * load_per_length / (math.pi * contact_modulus * curvature))
    peak_pressure = 0.5 * contact_modulus * half_width * curvature
    return LineContact(half_width, peak_pressure, float(curvature), float(contact_modulus), float(load_per_length))


ROW_POINTS = 6
"""Gauss points across each row. The outermost row meets a square-root end point; six leave 1e-4 of that row's load."""


def element_averages(hertz: HertzContact, x_edges: Array, y_edges: Array) -> tuple[Array, Array]:
    """Element averages of p in Pa and covered fractions, both (nx, ny), for elements between the given edges (m).

    Both are integrated in closed form along x and by Gauss points across each row; cylinders have one row, without ends.
    """
    a, b = hertz.semi_axis_x, hertz.semi_axis_y
    nodes, weights = gauss_points(ROW_POINTS)
    if math.isinf(b):
        share, chord = np.ones(1), np.ones((1, ROW_POINTS))
    else:
        low = np.clip(y_edges[:-1], -b, b)
        high = np.clip(y_edges[1:], -b, b)
        share = (high - low) / np.diff(y_edges)  # part of each row's width inside the ellipse
        y = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * nodes
        chord = np.sqrt(np.maximum(1.0 - (y / b) ** 2, 0.0))  # half-chord over a, (ny, points)
    safe = np.where(chord > 0.0, chord, 1.0)
    ratio = np.clip(x_edges[:, None, None] / (a * safe), -1.0, 1.0)
    # Antiderivative of sqrt(c² − ξ²) in ξ = x/a.
    area = 0.5 * chord**2 * (ratio * np.sqrt(1.0 - ratio**2) + np.arcsin(ratio))
    mean = (np.diff(area, axis=0) @ (0.5 * weights)) * share
    pressure = hertz.peak_pressure * mean * (a / np.diff(x_edges))[:, None]
    inside = np.clip(x_edges[:, None, None] / a, -chord, chord)
    covered = (np.diff(inside, axis=0) @ (0.5 * weights)) * share * (a / np.diff(x_edges))[:, None]
    covered[covered > 1.0 - 1e-12] = 1.0
    return pressure, np.where(pressure > 0.0, covered, 0.0)


POINTS_PER_ASPECT = 24
"""The integrands are smooth and periodic, so equal steps converge exponentially, at a rate set by the ratio of the axes."""


def shear_gradients(hertz: HertzContact, isotropic: float, directional: float) -> tuple[float, float, float]:
    """Slopes c_xx, c_yy, c_xy in 1/m·(Pa/Pa) of ∂u/∂x inside the ellipse under the tractions (p, 0) and (0, p):

        ∂u_x/∂x = c_xx x,   ∂u_y/∂x = c_xy y   under (p, 0);      ∂u_x/∂x = c_xy y,   ∂u_y/∂x = c_yy x   under (0, p).

    `isotropic` and `directional` are Σ(1−ν)/(2πG) and Σν/(2πG) in 1/Pa (`ShearCompliance`). The kernels 1/r, x²/r³, y²/r³
    and xy/r³ of Cerruti's solution have g = 2π, 2π sin²θ, 2π cos²θ and −2π sin θ cos θ. Between cylinders c_xx, c_yy are
    −2π p0/a0 times `isotropic`, and times the sum of both.
    """
    a, b = hertz.semi_axis_x, hertz.semi_axis_y
    if math.isinf(b):
        along = -2.0 * math.pi * hertz.peak_pressure / a
        return along * isotropic, along * (isotropic + directional), 0.0
    points = POINTS_PER_ASPECT * math.ceil(4.0 + max(a / b, b / a))
    theta = 2.0 * math.pi / points * np.arange(points)
    cc, ss = np.cos(theta) ** 2, np.sin(theta) ** 2
    # −2 cos θ (x cos θ + y sin θ) of the derivative by x, with the 2π of all g.
    weight = -hertz.peak_pressure * a * b / 4.0 * (2.0 * math.pi / points) * 2.0 * math.pi / (a * a * cc + b * b * ss) ** 1.5
    along = float((weight * cc * (isotropic + directional * ss)).sum())
    across = float((weight * cc * (isotropic + directional * cc)).sum())
    mixed = float((weight * cc * ss).sum()) * -directional
    return along, across, mixed
