"""Surfaces that roll through a contact: exact answers, symmetries, and the order of convergence."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.command_line import call
from thermoroll_cli import Case, Result, solve
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.files.table_file import read_table
from thermoroll_cli.many_contacts.history.steps import Steps
from thermoroll_cli.problem.surface import Dent, Flat, Heights, MeasuredHeights, SurfacesInContact, Wave

MODULUS = 210e9 / 2.0 / (1.0 - 0.3**2)
RADIUS = 10e-3


def over_time(grid: int, distance: float, steps: int, *, line: bool = False, **tables: Any) -> dict[str, Any]:
    """A steel cylinder or ball of 10 mm that rolls on a plane, 100 N/mm or 100 N, over a `distance` in mm."""
    load = "normal_N_mm" if line else "normal_N"
    case: dict[str, Any] = {
        "material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.3},
        "geometry": {"lower_radius_x_mm": np.inf, "lower_radius_y_mm": np.inf, "upper_radius_x_mm": 1e3 * RADIUS,
                     "upper_radius_y_mm": np.inf if line else 1e3 * RADIUS},
        "load": {load: 100.0, "friction_coefficient": 0.1}, "rolling": {"speed_m_s": 1.0},
        "creepage": {"longitudinal": 0.0008}, "thermal": {"heat": False}, "numerics": {"grid": grid},
        "history": {"distance_mm": [0.0, distance], "steps": steps, "values": {f"load.{load}": [100.0, 100.0]},
                    **({"length_mm": 10.0} if line else {})}}  # fmt: skip
    return case | tables


def rolled(case: dict[str, Any], lower: Heights | None = None, upper: Heights | None = None) -> Result:
    result: Result = solve(replace(Case.from_dict(case).task, surfaces=(lower, upper)))
    assert result.converged
    return result


def column(result: Result, name: str) -> np.ndarray:
    assert result.history is not None
    return np.array(result.history[name])


def ridges(amplitude: float, length: float, count: int = 64) -> MeasuredHeights:
    """A wave along rolling that is measured."""
    heights = amplitude * np.cos(2.0 * np.pi * np.arange(count) / count)[:, None]
    return MeasuredHeights(heights, (length / count, 1.0), repeats=(True, False))


@pytest.mark.parametrize("surface", [
    Wave(1e-6, 70e-6, 0.4, 11e-6, -7e-6), Dent(2e-6, 40e-6, 0.5e-6, 60e-6, 20e-6),
    Flat(120e-6, 2e-3, 30e-6, 70e-6, 400e-6), ridges(1e-6, 90e-6)])  # fmt: skip
def test_elements_see_the_mean_height(surface: Heights) -> None:
    """Means over elements are those of many small ones, and of neighbouring elements together."""
    along, across = np.array([-220e-6, -100e-6, 15e-6, 90e-6, 330e-6]), np.array([-50e-6, 10e-6, 90e-6])
    fine = surface.over(np.linspace(-220e-6, 330e-6, 1101), np.linspace(-50e-6, 90e-6, 281))
    means = np.array([[fine[int(a * 2e6 + 440.5) : int(b * 2e6 + 440.5), int(c * 2e6 + 100.5) : int(d * 2e6 + 100.5)].mean()
                       for c, d in pairwise(across)] for a, b in pairwise(along)])
    np.testing.assert_allclose(surface.over(along, across), means, rtol=0.0, atol=1e-6 * np.ptp(fine))


def test_shapes_are_those_that_they_are_called() -> None:
    """Crest, depth and shoulder of a dent, chord of a flat; points of a file are met, and come in their order."""
    places, small = np.array([0.0, 1e-9]), np.array([-1e-9, 1e-9])

    def at(surface: Heights, u: float, y: float = 0.0) -> float:
        return float(surface.over(u + small, y + small)[0, 0])

    assert at(Wave(1e-6, 50e-6, start=20e-6), 20e-6) == pytest.approx(1e-6)
    dent = Dent(2e-6, 40e-6, 0.5e-6)
    assert at(dent, 0.0) == pytest.approx(-2e-6, rel=1e-6)
    around = dent.over(np.linspace(0.0, 200e-6, 4001), places)
    assert around.max() == pytest.approx(0.5e-6, rel=1e-5)
    flat = Flat(0.4e-3, 10e-3, 0.0)
    assert flat.depth == pytest.approx(2e-6)
    assert [at(flat, u) for u in (0.0, 0.1e-3, 0.21e-3)] == pytest.approx([-2e-6, -1.5e-6, 0.0], abs=1e-12)
    heights = np.random.default_rng(1).normal(size=(30, 9))
    measured = MeasuredHeights(heights, (2e-6, 3e-6), 5e-6, -8e-6)
    assert at(measured, 5e-6 + 2e-6 * 7, -8e-6 + 3e-6 * 2) == pytest.approx(heights[7, 2], abs=1e-3)
    # What comes in first stands further ahead: u = 14 µm at x = s − 14 µm, and sideways by what the body has moved.
    standing = SurfacesInContact(((measured, (40e-6, 6e-6)),))
    assert at(standing, 40e-6 - 19e-6, -8e-6 + 6e-6 + 6e-6) == pytest.approx(heights[7, 2], abs=1e-3)


def test_wave_in_a_line_contact_is_westergaards() -> None:
    """Full contact with a wave: p − p₀ = π E* Δ/λ cos k(x − s), with the mean over each element."""
    amplitude, length, case = 0.05e-6, 60e-6, over_time(64, 0.12, 3, line=True)
    rough, smooth = rolled(case, lower=Wave(amplitude, length)), rolled(case)
    middle, width = np.abs(rough.x) < 60e-6, rough.x[1] - rough.x[0]
    moved = 0.12e-3 * (1.0 + 0.5 * 0.0008)
    wave = np.pi * MODULUS * amplitude / length * np.cos(2.0 * np.pi * (moved - rough.x) / length) * np.sinc(width / length)
    difference = (rough.fields["pressure"] - smooth.fields["pressure"])[middle]
    assert wave[middle] @ difference / (wave[middle] @ wave[middle]) == pytest.approx(1.0, abs=4e-3)


@pytest.mark.slow
def test_ridges_along_rolling_are_a_profile() -> None:
    """After some lengths of the contact they are in the steady state of a body with this lateral profile."""
    y = np.arange(-800, 801) * 1e-6
    heights = 0.1e-6 * np.cos(2.0 * np.pi * y / 120e-6)
    case = over_time(64, 0.6, 12)
    surface = MeasuredHeights(np.tile(heights, (4, 1)), (1e-3, 1e-6), side=-800e-6, repeats=(True, False))
    over = rolled(case, upper=surface)
    shape = {name: value for name, value in case["geometry"].items() if name != "upper_radius_y_mm"}
    points = np.stack([1e3 * y, 1e3 * (heights - y**2 / (2.0 * RADIUS))], axis=1)
    steady = solve({name: table for name, table in case.items() if name != "history"} | {
        "geometry": shape | {"upper_profile": {"points_mm": points.tolist()}}})
    for name, tolerance in {"pressure_max_MPa": 1e-3, "force_x_N": 5e-3, "Q_F_W": 0.015, "contact_area_mm2": 2e-3}.items():
        assert over[name] == pytest.approx(steady[name], rel=tolerance), name
    assert over["gamma_st"] == pytest.approx(steady["gamma_st"], abs=0.012)


def test_which_body_which_period_and_what_height_do_not_matter() -> None:
    """Without creepage both bodies move alike; periods are alike; constant heights are none, but for Hertz's closed form."""
    case = over_time(12, 0.3, 2, creepage={"longitudinal": 0.0})
    case["history"]["values"] = {"load.normal_N": [100.0, 120.0]}
    wave = ridges(0.1e-6, 150e-6)
    pressure = column(rolled(case, lower=wave), "pressure_max_MPa")
    np.testing.assert_array_equal(column(rolled(case, upper=wave), "pressure_max_MPa"), pressure)
    shifted = column(rolled(case, lower=replace(wave, start=150e-6)), "pressure_max_MPa")
    np.testing.assert_allclose(shifted, pressure, rtol=1e-12)
    level, case = MeasuredHeights(np.full((8, 1), 2e-6), (1e-4, 1.0), repeats=(True, False)), over_time(48, 0.1, 1)
    even, smooth = rolled(case, lower=level), rolled(case)
    np.testing.assert_allclose(column(even, "pressure_max_MPa"), column(smooth, "pressure_max_MPa"), rtol=6e-5)


@pytest.mark.slow
def test_long_wave_is_a_curvature() -> None:
    """Below a crest of a wave 4 mm long bodies have the curvature 1/R + k²Δ, in a trough 1/R − k²Δ."""
    for sign in (1.0, -1.0):
        found = rolled(over_time(48, 0.1, 1), lower=Wave(sign * 2e-6, 4e-3, start=0.1e-3))["pressure_max_MPa"]
        hertz = over_time(48, 1.0, 1)
        hertz["geometry"]["upper_radius_x_mm"] = 1e3 / (1.0 / RADIUS + sign * 2e-6 * (2.0 * np.pi / 4e-3) ** 2)
        del hertz["history"]
        assert found == pytest.approx(solve(hertz)["pressure_max_MPa"], rel=1e-4)


@pytest.mark.slow
def test_errors_fall_with_the_square_of_elements_and_steps() -> None:
    """Elements and steps are halved together; then steps alone, for the energy that is missing."""
    wave = Wave(0.5e-6, 1e-3, start=0.3e-3)
    coarse, middle, fine = (rolled(over_time(grid, 0.4, grid // 4), lower=wave) for grid in (12, 24, 48))
    for name in ("pressure_max_MPa", "force_x_N"):
        assert abs(fine[name] - middle[name]) < 0.35 * abs(middle[name] - coarse[name])
    missing = []
    for steps in (8, 32):
        over = rolled(over_time(12, 0.4, steps), lower=wave)
        work, heat, stored = (column(over, name) for name in ("work_J", "heat_J", "elastic_energy_J"))
        missing.append(abs(work - heat - stored + stored[0])[-1] / heat[-1])
    assert missing[1] < 0.1 * missing[0] < 2e-4


def test_exchange_mirror_and_units() -> None:
    """The same surface on the other body with −ξ, in the mirror, and in other units of length gives the same pressure."""
    rolling = {"speed_m_s": 1.0, "differential_slip": False}  # which the shapes do not exchange
    case, other = (over_time(14, 0.12, 2, creepage={"longitudinal": sign * 0.001, "lateral": 0.0005 * sign}, rolling=rolling)
                   for sign in (1.0, -1.0))
    surface = MeasuredHeights(1e-7 * np.random.default_rng(2).normal(size=(40, 25)), (20e-6, 20e-6), -100e-6, -240e-6)
    result = rolled(case, lower=surface)
    exchanged = rolled(other, upper=surface)
    np.testing.assert_allclose(exchanged.fields["pressure"], result.fields["pressure"], rtol=0.0, atol=1e-6 * 2e9)
    assert exchanged["force_x_N"] == pytest.approx(-result["force_x_N"], rel=1e-5)
    reflected = replace(surface, heights=surface.heights[:, ::-1])
    mirrored = rolled(case | {"creepage": {"longitudinal": 0.001, "lateral": -0.0005}}, lower=reflected)
    np.testing.assert_allclose(mirrored.fields["pressure"][:, ::-1], result.fields["pressure"], rtol=0.0, atol=1e-6 * 2e9)
    assert mirrored["force_y_N"] == pytest.approx(-result["force_y_N"], rel=1e-5)
    large = over_time(14, 12.0, 2, creepage=case["creepage"], rolling=rolling)
    large["geometry"] = {name: 100.0 * value for name, value in case["geometry"].items()}
    large["load"]["normal_N"] = 1e6
    large["history"]["values"] = {"load.normal_N": [1e6, 1e6]}
    scaled = rolled(large, lower=MeasuredHeights(100.0 * surface.heights, (2e-3, 2e-3), -10e-3, -24e-3))
    np.testing.assert_allclose(scaled.fields["pressure"], result.fields["pressure"], rtol=0.0, atol=1e-6 * 2e9)


def test_split_in_two_and_what_a_run_writes(tmp_path: Path) -> None:
    """A history in two parts: the second goes on where the surfaces of the first stand. Columns, fields and pictures."""
    case = over_time(12, 0.3, 4)
    case["history"] |= {"fields_every": 1}
    case["surface"] = {"lower": {"kind": "dent", "depth_um": 0.4, "radius_mm": 0.05, "start_mm": 0.25}}
    whole = solve(Case.from_dict(case))
    case["history"] |= {"distance_mm": [0.0, 0.15], "steps": 2}
    (tmp_path / "one.toml").write_text(Case.from_dict(case).to_toml())
    assert call("run", tmp_path / "one.toml", "-o", tmp_path / "results").returncode == 0
    names = {path.name for path in (tmp_path / "results").iterdir()}
    assert {"one_surface.png", "one_surface_height.png", "one_history.h5"} <= names
    (tmp_path / "results" / "one_surface.png").unlink()
    assert call("plot", tmp_path / "results" / "one.h5", "--fields", "surface").returncode == 0
    assert (tmp_path / "results" / "one_surface.png").exists()
    (name, kept), = read_result(tmp_path / "results" / "one.h5").surfaces.items()
    assert name == "lower" and kept.path == pytest.approx((0.0, 0.15e-3))
    middle = np.abs(kept.along[:-1] + 0.5 * np.diff(kept.along) - 0.25e-3).argmin()
    assert kept.heights[middle].min() == pytest.approx(-0.4e-6, rel=1e-2), "its dent"
    table = read_table(tmp_path / "results" / "one_history.h5", with_fields=True)
    assert "surface_height" in table.states[2].fields
    del case["history"]["distance_mm"]
    case["history"] |= {"time_s": [0.0, 0.15e-3], "steps": 2, "begin": str(tmp_path / "results" / "one.h5")}
    case["surface"]["lower"]["start_mm"] = 0.25
    second = solve(Case.from_dict(case))
    assert second.history is not None and whole.history is not None
    for name in ("pressure_max_MPa", "contact_area_mm2", "surface_lower_x_mm"):
        np.testing.assert_allclose(column(second, name), column(whole, name)[2:], rtol=1e-6)
    assert column(second, "contact_spots").min() >= 1.0
    np.testing.assert_allclose(column(second, "pressure_max_smooth_MPa"), 1370.9, rtol=1e-3)


def test_a_surface_of_small_waves_is_not_called_known() -> None:
    """The largest pressure may be larger by what elements do not see: waves shorter than they are."""
    case = over_time(16, 0.05, 4)
    fine = rolled(case, lower=Wave(0.02e-6, 8e-6, 0.3))
    assert fine.uncertainty["pressure_max_MPa"] > 0.3e-6 * 0.5 * MODULUS * 0.02e-6 * 2.0 * np.pi / 8e-6


@pytest.mark.slow
def test_errors_know_that_steps_pass_over_waves() -> None:
    """Steps longer than a wave hardly change the forces, but the heat at their ends."""
    wave = Wave(0.5e-6, 0.25e-3, start=0.1e-3)
    coarse, fine = (rolled(over_time(16, 0.9, steps, creepage={"longitudinal": 0.0004}), lower=wave) for steps in (3, 24))
    error = np.abs(column(coarse, "Q_F_W") - column(fine, "Q_F_W")[::8])
    assert (error[1:] < 2.5 * column(coarse, "uncertainty.Q_F_W")[1:]).all()
    assert error.max() > 0.25 * column(fine, "Q_F_W").max()


def test_errors_know_what_sticks_and_what_slips_between_elements() -> None:
    """About the place where spin and creepage cancel 0.055 % of a sliding contact stick (48 elements a side), and no element of
    16 does. Where all but a rim sticks, its flux and temperature are those of a rim as wide as elements allow."""
    sliding = rolled(over_time(16, 0.05, 2, creepage={"longitudinal": 0.01, "spin_rad_mm": -0.1}))
    assert column(sliding, "gamma_st")[-1] == 0.0 and 5.5e-4 < column(sliding, "uncertainty.gamma_st")[-1] < 0.05
    case = over_time(16, 0.1, 4, creepage={"longitudinal": 2e-5}, thermal={"heat": True, "deformation": False})
    case["material"] |= {"conductivity_W_mK": 50.0, "diffusivity_mm2_s": 13.0, "expansion_um_mK": 12.0}
    stuck = rolled(case)
    assert column(stuck, "gamma_st")[-1] > 0.96
    for name, least in (("heat_flux_max_W_mm2", 1.0), ("temperature_rise_max_lower_K", 0.4)):
        assert column(stuck, f"uncertainty.{name}")[-1] > least * column(stuck, name)[-1]


@pytest.mark.slow
def test_a_rough_step_takes_few_applications() -> None:
    """Spots stick and slip anew with every step; near full sliding, and with a part of the friction used."""
    for creepage, most in ((0.0015, 1.6), (0.0004, 1.6)):
        case = over_time(32, 0.05, 5, creepage={"longitudinal": creepage})
        case["history"]["begin"] = "pressed"
        rough = case | {"surface": {"upper": {"kind": "rough", "rms_um": 0.1, "shortest_mm": 0.024, "longest_mm": 0.3}}}
        work = []
        for each in (case, rough):
            task = Case.from_dict(each).task
            moments = list(Steps(task, (32, 32), extent=2.75).moments(task.course.rows))[1:]
            assert all(moment.converged for moment in moments)
            work.append(sum(moment.applications for moment in moments))
        assert work[1] < most * work[0]


@pytest.mark.slow
def test_stresses_below_rows_with_fields(tmp_path: Path) -> None:
    """Before a dent comes they are those of the steady state; the result has the largest of all rows, also from its file."""
    case = over_time(16, 0.3, 6, subsurface={"bodies": ["lower"], "layers": 8})
    del case["history"]["distance_mm"]
    case["history"] |= {"distance_mm": [-0.3, 0.0], "fields_every": 3}
    steady = solve({name: table for name, table in case.items() if name != "history"})
    dented = case | {"surface": {"lower": {"kind": "dent", "depth_um": 1.0, "radius_mm": 0.04}}}
    result = solve(Case.from_dict(dented))
    assert result.history is not None
    stresses = column(result, "von_mises_max_lower_MPa")
    assert [np.isnan(value) for value in stresses] == [False, True, True, False, True, True, False]
    assert stresses[0] == pytest.approx(steady["von_mises_max_lower_MPa"], rel=0.01)
    assert result["von_mises_max_lower_MPa"] == np.nanmax(stresses) > 1.02 * stresses[0]
    assert result.uncertainty["von_mises_max_lower_MPa"] > 0.0
    result.save(tmp_path / "dented.h5")
    assert read_result(tmp_path / "dented.h5")["von_mises_max_lower_MPa"] == np.nanmax(stresses)
