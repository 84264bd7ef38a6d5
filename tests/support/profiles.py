"""Contacts of bodies with transverse profiles: those that CONTACT solved, and arcs that are ellipses in disguise."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from tests.support.scenes import elastic, reference, rolling
from thermoroll_cli.problem.geometry import Geometry, Profile
from thermoroll_cli.problem.problem import Problem

REFERENCES = reference("profiles")["cases"]


def points(
    height_mm: Callable[[np.ndarray], np.ndarray], low_mm: float, high_mm: float, count: int = 121, **options
) -> Profile:
    """Profile through `count` points of a height over y, both in mm."""
    y = np.linspace(low_mm, high_mm, count)
    return Profile(tuple((a / 1e3, b / 1e3) for a, b in zip(y.tolist(), height_mm(y).tolist(), strict=True)), **options)


def below(profile: Profile, radius_x: float) -> Geometry:
    """A flat body below one with `profile` (upper) and `radius_x` (m) along rolling."""
    return Geometry(math.inf, math.inf, radius_x, math.inf, upper_profile=profile)


def egg(y: np.ndarray) -> np.ndarray:
    return -(y**2 / 400.0 + 2e-4 * y**3)


def two_bumps(y: np.ndarray) -> np.ndarray:
    return -0.02 * (1.0 - (y / 5.0) ** 2) ** 2


CROWN = Profile(length=0.01, drop=1e-6)
GEOMETRIES = {
    "a1_crowned_roller_normal": below(CROWN, 0.01), "a3_crowned_roller_xi_0.0007": below(CROWN, 0.01),
    "b_asymmetric_c3_2e-4": below(points(egg, -6.0, 6.0), 0.3),
    "c_two_patches": below(points(two_bumps, -9.0, 9.0, 181), 0.3)}


def solved_by_contact(name: str, grid: int | tuple[int, int]) -> Problem:
    """One of the contacts of reference/profiles.json, which have no differential slip."""
    given = REFERENCES[name]["input"]
    return rolling(
        grid=grid, geometry=GEOMETRIES[name], body=elastic(0.3), load=given["normal_N"], friction=given["friction_coefficient"],
        creepage=(given["creepage_longitudinal"], given["creepage_lateral"]), spin=given["spin_rad_mm"] * 1e3)
