"""Wheelsets on roller rigs: limits, symmetries, balances, and forces beside CONTACT's."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.sampling import sampled
from tests.support.wheelsets import ROOT
from thermoroll_cli import solve
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.plots.wheelset_figures import section_figure
from thermoroll_cli.problem.result import Result

MANCHESTER: dict[str, Any] = {
    "material": {"youngs_modulus_GPa": 209.92, "poisson_ratio": 0.28},
    "track": {"rail_profile": {"file": f"{ROOT}/cases/MBench_UIC60_v3.prr"}},
    "wheelset": {"wheel_profile": {"file": f"{ROOT}/cases/MBench_S1002_v3.prw"}, "nominal_radius_mm": 460.0,
                 "lateral_shift_mm": 4.0, "yaw_mrad": 9.6, "vertical_N": 20e3, "patches": "planar"},
    "load": {"friction_coefficient": 0.3}, "rolling": {"speed_m_s": 2.0}, "numerics": {"grid": 12},
}  # fmt: skip
Y = np.linspace(-50.0, 50.0, 201)
CIRCLE = np.sqrt(100.0**2 - Y**2) - 100.0


def outline(z: np.ndarray) -> dict[str, Any]:
    return {"points_mm": np.column_stack([Y, z]).tolist()}


def rig(rail: np.ndarray, wheel: np.ndarray, radii: tuple[float, float], speeds: tuple[float, float], **more: Any) -> Result:
    """A right wheel without a flange on a roller: radii in mm and angular velocities in rad/s of roller and wheel."""
    wheelset = {"wheel_profile": outline(wheel), "wheels": "right", "nominal_radius_mm": radii[1],
                "flange_back_distance_mm": 1500.0, "flange_back_mm": 0.0, "roll_mrad": 0.0,
                "angular_velocity_rad_s": speeds[1]}  # fmt: skip
    return solve({
        "material": {"youngs_modulus_GPa": 209.92, "poisson_ratio": 0.28},
        "track": {"rail_profile": outline(rail), "right": {"origin_mm": [750.0, 0.0]}, "roller_radius_mm": radii[0],
                  "roller_angular_velocity_rad_s": speeds[0]},
        "wheelset": wheelset | {"patches": "planar"} | more, "load": {"friction_coefficient": 0.3},
        "rolling": {"speed_m_s": 0.1}, "numerics": {"grid": 24},
    })  # fmt: skip


def force(result: Result) -> np.ndarray:
    return np.array([result.scalars[f"track_force_{axis}_N"] for axis in "xyz"])


def on_rollers(track: Mapping[str, Any] = {}, **wheelset: Any) -> Result:
    return solve({**MANCHESTER, "track": {**MANCHESTER["track"], **track}, "wheelset": {**MANCHESTER["wheelset"], **wheelset}})


@pytest.fixture(scope="module")
def small() -> Result:
    """On rollers that a wheelset feels."""
    return on_rollers({"roller_radius_mm": 500.0})


@pytest.mark.slow
@pytest.mark.parametrize("patches", sampled(["curved", "planar"]))
def test_large_rollers_are_straight_rails(patches: str) -> None:
    straight, rollers = on_rollers(patches=patches), on_rollers({"roller_radius_mm": 1e8}, patches=patches)
    for name in ("track_force_x_left_N", "track_force_y_left_N", "track_force_y_right_N", "height_mm", "Q_F_W", "roll_mrad"):
        assert rollers.scalars[name] == pytest.approx(straight.scalars[name], rel=1e-4)


@pytest.mark.slow
def test_small_rollers_are_felt_and_balanced(small: Result) -> None:
    """Contacts are shorter, and the wheelset finds the speed of the rollers."""
    straight, rollers = on_rollers(), small
    assert rollers.converged and rollers.scalars["power_balance_error"] < 1e-3
    assert rollers.scalars["angular_velocity_rad_s"] == pytest.approx(straight.scalars["angular_velocity_rad_s"], rel=5e-3)
    assert rollers.scalars["contact_area_mm2"] < 0.9 * straight.scalars["contact_area_mm2"]
    faster = on_rollers({"roller_radius_mm": 500.0, "roller_angular_velocity_rad_s": 8.0})
    ratio = faster.scalars["angular_velocity_rad_s"] / rollers.scalars["angular_velocity_rad_s"]
    assert ratio == pytest.approx(2.0, rel=1e-4)


@pytest.mark.slow
def test_the_mirror_image_has_mirrored_forces(small: Result) -> None:
    here, there = small, on_rollers({"roller_radius_mm": 500.0}, lateral_shift_mm=-4.0, yaw_mrad=-9.6)
    for axis, sign in zip("xyz", (1.0, -1.0, 1.0), strict=True):
        ours, theirs = here.scalars[f"track_force_{axis}_left_N"], there.scalars[f"track_force_{axis}_right_N"]
        assert ours == pytest.approx(sign * theirs, rel=1e-6)


@pytest.mark.slow
def test_wheel_and_roller_may_be_exchanged() -> None:
    """Upside down: the wheel of one is the roller of the other, with the opposite force. Both are inclined, and spin."""
    rail, wheel = 0.05 * Y + Y**2 / 600.0, 0.05 * Y - Y**2 / 400.0
    load = {"vertical_N": 60e3}
    one = rig(rail, wheel, (400.0, 150.0), (0.25, 0.6672), **load, lateral_velocity_mm_s=0.1)
    other = rig(-wheel, -rail, (150.0, 400.0), (0.6672, 0.25), **load, lateral_velocity_mm_s=-0.1)
    assert one.converged and other.converged
    np.testing.assert_allclose(force(other), force(one) * [-1.0, -1.0, 1.0], atol=5e-4 * 0.3 * 60e3)
    assert abs(force(one)[0]) > 300.0 and abs(force(one)[1]) > 1000.0


@pytest.mark.parametrize(("roll", "height", "turning", "theirs", "tolerance"), [
    pytest.param(0.0, -1.870, 0.24381, (-18.05, -5588.0, 98_910.0), 1e-3, marks=pytest.mark.slow),
    (266.667, -56.60956, 0.2451499, (1.806, -19_460.0, 95_490.0), 1e-3),
])  # fmt: skip
def test_forces_are_those_of_contact(
    roll: float, height: float, turning: float, theirs: tuple[float, float, float], tolerance: float
) -> None:
    """Its examples of an ellipsoid on a conical roller, tests 3a and 3c, on elements of 0.2 mm."""
    wheelset = {"roll_mrad": roll, "height_mm": height, "flange_back_distance_mm": 200.0, "flange_back_mm": -100.0}
    case = {
        "material": {"youngs_modulus_GPa": 209.92, "poisson_ratio": 0.28},
        "track": {"rail_profile": outline(math.tan(0.2) * Y), "right": {"origin_mm": [200.0, 0.0]}, "roller_radius_mm": 400.0,
                  "roller_angular_velocity_rad_s": turning},
        "wheelset": {"wheel_profile": outline(CIRCLE), "wheels": "right", "nominal_radius_mm": 133.33333,
                     "angular_velocity_rad_s": 0.75, "patches": "planar", **wheelset},
        "load": {"friction_coefficient": 0.3}, "rolling": {"speed_m_s": 0.0975}, "numerics": {"grid": 32},
    }  # fmt: skip
    np.testing.assert_allclose(force(solve(case)), theirs, atol=tolerance * theirs[2])


@pytest.mark.parametrize("more", [{"yaw_mrad": 20.0}, {"longitudinal_shift_mm": 4.0}])
def test_pressure_has_no_torque_about_the_roller(more: dict[str, float]) -> None:
    """The contact of a wheel that is yawed or shifted lies ahead of the axle, where the roller's surface is inclined."""
    result = solve({**MANCHESTER, "track": {**MANCHESTER["track"], "roller_radius_mm": 500.0},
                    "wheelset": {**MANCHESTER["wheelset"], "wheels": "right", "roll_mrad": 0.0, "lateral_shift_mm": 6.0, **more,
                                 "angular_velocity_rad_s": 4.35}, "load": {"friction_coefficient": 1e-6}})  # fmt: skip
    ahead = [-patch.record["normal_N"] * math.cos(1e-3 * patch.record["angle_mrad"]) * math.sin(patch.record["x_mm"] / 500.0)
             for patch in result.patches]  # fmt: skip
    total = force(result)[0]
    assert abs(total) > 20.0 and total == pytest.approx(sum(ahead), rel=0.03)


@pytest.mark.slow
def test_the_edge_of_a_wheel_far_off_its_roller_is_a_reason() -> None:
    """Where the surface turns by 78 degrees in a patch, an approach closes hardly any of its gap."""
    right = {"shift_y_mm": -2.966279163583489, "shift_z_mm": 0.34092236539617016, "roll_mrad": 9.486913034411977}
    result = on_rollers({"roller_radius_mm": 946.2931056210161, "gauge_mm": 1435.6186357429085, "right": right}, wheels="right",
                        patches="curved", vertical_N=13.7e3, nominal_radius_mm=458.74811038947826, roll_mrad=0.0,
                        longitudinal_shift_mm=2.1, lateral_shift_mm=-95.39606189044072, yaw_mrad=18.62947076)  # fmt: skip
    assert not result.converged and "the profiles meet at sharp ends alone" in result.reason


@pytest.mark.slow
def test_files_and_pictures_know_the_roller(tmp_path: Path) -> None:
    on_rollers({"roller_radius_mm": 500.0}, wheels="right", roll_mrad=0.0).save(tmp_path / "rig.h5")
    found = read_result(tmp_path / "rig.h5")
    assert found.lines["axle_right"][1] == pytest.approx(0.5)
    legend = section_figure(found).legends[0]
    assert "roller, radius 500 mm" in [text.get_text() for text in legend.get_texts()]


@pytest.mark.slow
def test_a_sphere_touches_the_same_however_it_is_yawed() -> None:
    """A roller of 1e8 mm is a rail, and a wheel whose outline is a circle of its own radius is a sphere."""
    there = {"vertical_N": 1e3}
    straight = rig(0.0 * Y, CIRCLE, (1e8, 100.0), (1e-6, 1.0), **there)
    yawed = rig(0.0 * Y, CIRCLE, (1e8, 100.0), (1e-6, 1.0), yaw_mrad=450.0,
                lateral_shift_mm=750.0 * (1.0 - math.cos(0.45)), **there)
    assert straight.converged and yawed.converged
    for name in ("pressure_max_MPa", "approach_max_um", "contact_area_mm2"):
        assert yawed[name] == pytest.approx(straight[name], rel=1e-3), name
    assert abs(force(yawed)[1]) == pytest.approx(0.3e3 * math.cos(0.225), rel=0.1)
