"""Equivalent stresses that strength criteria use."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.arrays import AnyArray


def von_mises(stress: AnyArray) -> AnyArray:
    """√(½[(σxx−σyy)² + (σyy−σzz)² + (σzz−σxx)²] + 3[σxy² + σxz² + σyz²]) of stresses (6, …), xx yy zz xy xz yz."""
    xx, yy, zz, xy, xz, yz = stress
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.asarray(np.sqrt(0.5 * normal + 3.0 * (xy * xy + xz * xz + yz * yz)))


def first_principal(stress: AnyArray) -> AnyArray:
    """The largest principal stress (tension positive) of stresses (6, …).

    The largest root of the characteristic polynomial by the cosine of its angle (Smith 1961), from the deviator."""
    xx, yy, zz, xy, xz, yz = stress
    mean = (xx + yy + zz) / 3.0
    a, b, c = xx - mean, yy - mean, zz - mean
    half_square = (a * a + b * b + c * c) / 6.0 + (xy * xy + xz * xz + yz * yz) / 3.0
    radius = np.sqrt(half_square)
    half_determinant = 0.5 * (a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz))
    cube = np.maximum(radius * half_square, np.finfo(radius.dtype).tiny)
    angle = np.arccos(np.clip(half_determinant / cube, -1.0, 1.0)) / 3.0
    return np.asarray(mean + 2.0 * radius * np.cos(angle))
