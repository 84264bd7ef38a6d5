"""Shakedown and fatigue: the yield stress that keeps a body elastic after the first passages, and where cracks start.

In steady rolling the residual stresses do not depend on x. By Melan's theorem a body shakes down if some residual stress
brings all stress states below yield. The family ρ_xx(z), ρ_yy(z), ρ_xy(z) is exact where every y is rolled over, and a safe
lower bound for a single track. With the deviator in the metric of von Mises,

    q = (σzz − ½(σxx + σyy), (√3/2)(σxx − σyy), √3 σxy, √3 σxz, √3 σyz),      |q| = von Mises stress,

the residual stresses shift the first three components, and the shear yield stress that a layer needs is k = R/√3 with the
smallest ball R² = min over c of max |q₁₋₃ − c|² + q₄² + q₅² around its states, the unloaded one included.

Alternating plasticity is excluded, whatever the residual stress, if k ≥ R₅/√3 with the smallest ball in all five components
along each line of rolling. Dang Van's criterion (Dang Van et al. 1989) takes the centre of that ball as the mesoscopic
residual stress: its stress is the largest of τ + a_DV σ_h along the line, with the Tresca shear stress τ of the deviator less
the centre and the hydrostatic stress σ_h.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from thermoroll_cli.arrays import AnyArray, Array
from thermoroll_cli.stress.smallest_ball import Balls, smallest_balls

SQRT3 = math.sqrt(3.0)


def deviator(stress: AnyArray) -> Array:
    """The five components q (…, 5) of stresses (6, …), xx yy zz xy xz yz; |q| is the von Mises stress."""
    xx, yy, zz, xy, xz, yz = np.asarray(stress, dtype=float)
    return np.stack([zz - 0.5 * (xx + yy), 0.5 * SQRT3 * (xx - yy), SQRT3 * xy, SQRT3 * xz, SQRT3 * yz], axis=-1)


@dataclass(frozen=True)
class LayerShakedown:
    """Shear yield stress `k` (Pa) that one layer needs, and the `residual` stresses xx, yy, xy (Pa) for which this suffices."""

    k: float
    residual: tuple[float, float, float]


def layer_shakedown(stress: AnyArray, *, mirrored: bool = False) -> LayerShakedown:
    """Shakedown of one layer with stresses (6, nx, ny) in Pa; a `mirrored` state, even in y, is given for y > 0 only.

    By symmetry ρ_xy = 0 in a mirrored state."""
    q = deviator(stress).reshape(-1, 5)
    free = 2 if mirrored else 3
    unloaded = np.zeros((1, free + 1))
    states = np.vstack([np.column_stack([q[:, :free], (q[:, free:] ** 2).sum(axis=1)]), unloaded])[None]
    ball = smallest_balls(states[..., :free], states[..., free])
    c1, c2, c3 = (*ball.centres[0], 0.0)[:3]
    residual = c1 - c2 / SQRT3, c1 + c2 / SQRT3, -c3 / SQRT3
    return LayerShakedown(math.sqrt(ball.squared_radii[0] / 3.0), residual)


@dataclass(frozen=True)
class LineFatigue:
    """Lines of rolling of one layer: `alternating_k` and `dang_van` (ny,) in Pa, and the `balls`, starting points for the next
    layer."""

    alternating_k: Array
    dang_van: Array
    balls: Balls


def line_fatigue(stress: AnyArray, dang_van_coefficient: float, start: Balls | None = None) -> LineFatigue:
    """Alternating plasticity and Dang Van's stress of every line of rolling of a layer with stresses (6, nx, ny) in Pa.

    `dang_van_coefficient` weighs the hydrostatic stress, positive in tension; `start` are the balls of a layer nearby."""
    history = deviator(stress).transpose(1, 0, 2)
    history = np.concatenate([history, np.zeros_like(history[:, :1])], axis=1)
    balls = smallest_balls(history, start=start)
    hydrostatic = np.zeros(history.shape[:2])
    hydrostatic[:, :-1] = np.asarray(stress[0] + stress[1] + stress[2], dtype=float).T / 3.0
    shear = tresca_shear(history - balls.centres[:, None])
    return LineFatigue(np.sqrt(balls.squared_radii / 3.0), (shear + dang_van_coefficient * hydrostatic).max(axis=1), balls)


def tresca_shear(q: Array) -> Array:
    """Half the difference of the largest and the smallest principal stress of deviators (…, 5).

    The principal deviators are (2/3)|q| cos(θ + 2πn/3) with cos 3θ = 27 det/(2|q|³) (Lode's angle)."""
    size = np.sqrt(np.einsum("...d,...d->...", q, q))
    zz = q[..., 0] * (2.0 / 3.0)
    half, difference = -q[..., 0] / 3.0, q[..., 1] / SQRT3
    xx, yy = half + difference, half - difference
    xy, xz, yz = (q[..., i] / SQRT3 for i in (2, 3, 4))
    determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    cosine = 13.5 * determinant / np.maximum(size**3, np.finfo(float).tiny)
    angle = np.arccos(np.clip(cosine, -1.0, 1.0)) / 3.0
    return np.asarray(size * np.sin(angle + math.pi / 3.0) / SQRT3)


def largest_over_depth(depths: Array, values: Array) -> tuple[float, float]:
    """Largest of `values` (nz,) below the surface and its depth, by the parabola through the highest layer and its neighbours.

    The surface is the first layer and serves only as a neighbour: with friction it converges more slowly and has a scalar of
    its own. Both are nan if the values fall from the surface downwards, so that there is no maximum below it."""
    top = int(np.argmax(values[1:])) + 1
    if values[top] <= values[top - 1]:
        return math.nan, math.nan
    if top == len(values) - 1:
        return float(values[top]), float(depths[top])
    z, v = depths[top - 1 : top + 2] - depths[top], values[top - 1 : top + 2]
    bend, slope, _ = np.polyfit(z, v, 2)
    if bend >= 0.0:
        return float(values[top]), float(depths[top])
    shift = min(max(-0.5 * slope / bend, z[0]), z[2])
    return float(v[1] + shift * (slope + bend * shift)), float(depths[top] + shift)
