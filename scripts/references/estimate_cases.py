"""The cases on which the error estimates are tested for honesty: their inputs and fine references are kept in
tests/reference/estimate_references.json, written by scripts/references/estimate_references.py."""

from __future__ import annotations

from typing import Any

from scripts.problems import ellipse, on_grid
from thermoroll_cli.problem.problem import Heating, Material, Motion, Problem

SCALARS = ("Q_F_W", "force_x_N", "force_y_N", "gamma_c", "gamma_st", "gamma_p", "temperature_rise_max_lower_K",
           "temperature_rise_max_upper_K")
"""Scalars whose estimates are held against references."""


def problem_of(given: dict[str, Any], grid: int) -> Problem:
    """The problem of one entry's `input`: two equal bodies of E = 210 GPa, on a square grid."""
    heated = given["peclet"] is not None
    thermal = (50.2, given["expansion_1e6_K"] * 1e-6, 10e-6) if heated else (None, None, None)
    body = Material(210e9, given["poisson_ratio"], *thermal)
    motion = Motion(given["speed_m_s"], given["creepage_longitudinal"], given["creepage_lateral"], given["spin_rad_m"],
                    given["force_x_N"], given["force_y_N"], differential_slip=False)
    heating = Heating(peclet=given["peclet"], partition=given["partition"]) if heated else Heating(heat=False)
    geometry = ellipse(given["aspect_ratio"], given["radius_m"])
    return on_grid(Problem(body, body, geometry, given["normal_N"], given["friction"], motion, heating), grid)


def scale_of(name: str, reference: float, traction_limit: float) -> float:
    """What an error is relative to: the value, for forces μW at least; stick fractions are absolute."""
    if name.startswith("force"):
        return max(abs(reference), traction_limit)
    return 1.0 if name == "gamma_st" else abs(reference)


def has_error(name: str, given: dict[str, Any], reference: float | None) -> bool:
    """Whether there is an error to estimate: not in what is prescribed, vanishes by symmetry or is known in closed form."""
    if reference is None or given.get(name) is not None:
        return False
    if name.startswith("force"):
        return abs(reference) > 1e-6 * given["friction"] * given["normal_N"]
    if name in ("gamma_c", "gamma_p"):
        return given["peclet"] is not None  # without heat the contact is that of Hertz
    return reference != 0.0
