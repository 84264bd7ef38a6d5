"""Without friction the forces of a wheel on a rail are the gradient of one energy: F_y = ∂/∂y ∫ F_z dz."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy

from tests.support.documents import printed
from thermoroll_cli import Case, solve

CASE = Case.read(Path(__file__).parents[2] / "cases" / "manchester.toml").with_values({
    "wheelset.wheels": "right", "wheelset.yaw_mrad": 0.0, "wheelset.angular_velocity_rad_s": 4.34,
    "load.friction_coefficient": 0.0, "numerics.grid": 32, "thermal.heat": False,
})  # fmt: skip
SHIFT, STEP, DEPTH = 6.2, 4e-3, 0.08


def forces(patches: str, shift: float, **given: float) -> tuple[float, float, float]:
    """Height (mm), lateral and vertical force on the rail (N)."""
    keys = {f"wheelset.{key}": value for key, value in given.items()}
    summary = solve(CASE.with_values({"wheelset.lateral_shift_mm": shift, "wheelset.patches": patches, **keys})).summary()
    return summary["height_mm"], summary["track_force_y_right_N"], summary["track_force_z_right_N"]


@pytest.mark.slow
@pytest.mark.parametrize(("patches", "text"), [
    ("curved", "0.02 % of F_z"), pytest.param("planar", "0.33 %)", marks=pytest.mark.slow)])
def test_lateral_force_is_the_gradient_of_the_energy(patches: str, text: str) -> None:
    """At 23°: the curved patch meets it, the plane misses it by a third of a per cent of the load."""
    top, lateral, vertical = forces(patches, SHIFT, vertical_N=10e3)
    heights, energies = top - DEPTH * np.linspace(0.0, 1.0, 9), []
    for shift in (SHIFT - STEP, SHIFT + STEP):
        loads = np.array([forces(patches, shift, height_mm=float(height))[2] for height in heights])
        carried = loads > 50.0
        # F^⅔ is nearly a straight line of the height, down to first contact.
        line = np.polynomial.Polynomial.fit(heights[carried], loads[carried] ** (2.0 / 3.0), 3)
        fine = np.linspace(top - DEPTH, top, 20_001)
        energies.append(scipy.integrate.trapezoid(np.maximum(line(fine), 0.0) ** 1.5, fine))
    missed = abs((energies[1] - energies[0]) / (2.0 * STEP) - lateral) / vertical
    value, rounding = printed("verification", text)[0]
    assert 100.0 * missed == pytest.approx(value, abs=rounding)
