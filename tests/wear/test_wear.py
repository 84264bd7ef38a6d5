"""Wear per passage and the evolution of profiles: exact laws, conservation, resuming, and the command."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from itertools import islice
from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.support.command_line import call
from tests.support.scenes import reference
from thermoroll_cli import Case
from thermoroll_cli.exact.hertz import hertz_contact
from thermoroll_cli.files.case_source import Override
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.problem import Geometry, Heating, Material, Motion, Numerics, Problem, Wear, WornBody
from thermoroll_cli.refinement.plan import make_plan
from thermoroll_cli.refinement.scalars import sliding_work
from thermoroll_cli.refinement.solve import solve
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.wear import evolution as module
from thermoroll_cli.wear.evolution import BeyondProfile, evolution, half_width, line_load, remapped

REFERENCE = reference("life_wear")
STEEL = Material(210e9, 0.28)
RATE, LOAD, CREEPAGE = 1e-13, 1500.0, 1.0
TWIN_DISC = Problem(
    STEEL, STEEL, Geometry(23.5e-3, math.inf, 23.5e-3, 0.2), LOAD, Friction(0.4),
    Motion(3.0, CREEPAGE, differential_slip=False), Heating(heat=False), Numerics(grid=(32, 32)),
    wear=Wear(upper=WornBody(RATE, 1.0), depth=5.7013e-6))
CASE = Path(__file__).parents[2] / "cases" / "twin_disc_wear.toml"


def test_full_sliding_wears_in_proportion_to_pressure() -> None:
    """Area κWξ; depth κξ(π/2)p₀a(1 − y²/b²)."""
    result = solve(replace(TWIN_DISC, numerics=Numerics(grid=(64, 64))))
    scalars, first = result.coupled.scalars, REFERENCE["twin_disc_upper_wears_kappa_1e-13"]["first"]
    assert scalars["wear_area_upper_um2"] * 1e-12 == pytest.approx(RATE * LOAD * CREEPAGE, rel=1e-5)
    assert scalars["wear_rate_upper_mm3_m"] == pytest.approx(RATE * LOAD * CREEPAGE * 1e9, rel=1e-5)
    assert scalars["wear_depth_max_upper_nm"] * 1e-9 == pytest.approx(first["depth_per_pass_centre_m"], rel=2e-3)
    assert scalars["wear_area_lower_um2"] == 0.0
    hertz = result.hertz
    y = result.y
    exact = (0.5 * math.pi * CREEPAGE * hertz["hertz_p0_MPa"] * 1e6 * hertz["hertz_a_mm"] * 1e-3
             * np.maximum(1.0 - (y / (hertz["hertz_b_mm"] * 1e-3)) ** 2, 0.0))
    work = sliding_work(TWIN_DISC, result.coupled.fields, float(result.x[1] - result.x[0]))
    assert work == pytest.approx(exact, abs=5e-3 * exact.max())


def test_a_free_rolling_groove_wears_beside_its_neutral_lines() -> None:
    """Heathcote's groove: friction so low that nothing deforms tangentially."""
    problem = Problem(STEEL, STEEL, Geometry(0.022, -0.0066, 0.00635, 0.00635), 300.0, Friction(1e-5),
                      Motion(5.0, None, force_x=0.0), Heating(heat=False), Numerics(grid=(128, 128)))
    result = solve(problem)
    b = hertz_contact(problem.geometry.curvature_x, problem.geometry.curvature_y, problem.contact_modulus, 300.0).semi_axis_y
    slope = DerivedQuantities(problem).kinematics.differential_slip.slope(np.array([1e-4]))[0]
    unit = 300.0 * abs(slope) / 2e-4 * b
    work = sliding_work(problem, result.coupled.fields, float(result.x[1] - result.x[0]))
    wanted = REFERENCE["heathcote"]
    tolerance = REFERENCE["tolerance"]
    area = float(work.sum()) * float(result.y[1] - result.y[0])
    assert area / (unit * b) == pytest.approx(wanted["area"], rel=tolerance["heathcote_area"])
    found = np.interp(np.array(wanted["t"]) * b, result.y, work) / unit
    exact, largest = np.array(wanted["depth_per_pass_over"]), max(wanted["depth_per_pass_over"])
    neutral = exact < 1e-3 * largest
    assert found[~neutral] == pytest.approx(exact[~neutral], abs=tolerance["heathcote_profile_over_max"] * largest)
    # An element on a neutral line wears at both of its sides.
    assert found[neutral].max() < 0.03 * largest


def test_remapping_keeps_the_worn_area() -> None:
    centres = np.linspace(-1.0, 1.0, 41)
    depth = np.maximum(1.0 - centres**2, 0.0)
    y = np.linspace(-1.7, 1.7, 257)
    widths = np.diff(np.concatenate([y[:1], 0.5 * (y[1:] + y[:-1]), y[-1:]]))
    assert (remapped(y, centres, depth) * widths).sum() == pytest.approx(depth.sum() * 0.05, rel=1e-12)


def test_a_symmetric_crown_stays_symmetric() -> None:
    """Half of the contact stands for all of it as long as the profiles are their own mirror images."""
    sliding_in_part = replace(TWIN_DISC, motion=replace(TWIN_DISC.motion, creepage_x=2e-3))
    state = list(islice(evolution(sliding_in_part), 6))[-1]
    assert state.result is not None and DerivedQuantities(state.result.problem).symmetric
    worn = state.worn["upper"]
    assert worn == pytest.approx(worn[::-1], abs=1e-12 * worn.max())


def test_a_crown_wears_flat() -> None:
    """Against an independent wear solver; the worn area is that of full sliding at all times."""
    states = list(evolution(TWIN_DISC))
    wanted = REFERENCE["twin_disc_to_10"]["trajectory"][0]
    last = states[-1]
    assert last.deepest == pytest.approx(5.7013e-6, rel=1e-5)
    assert last.distance == pytest.approx(wanted["passes"], rel=REFERENCE["tolerance"]["passes_at_half"])
    assert last.worn_area("upper") == pytest.approx(RATE * LOAD * CREEPAGE * last.distance, rel=1e-4)
    assert half_width(last.result) == pytest.approx(wanted["half_width_mm"] * 1e-3, rel=0.03)
    centre = len(last.result.y) // 2
    assert line_load(last.result)[centre] * 1e-3 == pytest.approx(wanted["q_centre_N_mm"], rel=0.03)


def test_a_crown_worn_far_beyond_the_approach_is_rigid() -> None:
    """Depth w²/(2R) ∝ n^(2/3) of rigid wear, and the passes of an independent wear solver; ridges at the border of the contact
    would limit the steps. After five approaches the rigid law is 0.5 % off on fine grids, after ten 0.2 %."""
    wanted = REFERENCE["twin_disc_to_10"]["trajectory"][-2]
    depth = wanted["total_depth_um"] * 1e-6
    problem = replace(TWIN_DISC, numerics=Numerics(grid=(16, 16)), wear=replace(TWIN_DISC.wear, depth=depth))
    *_, last = evolution(problem)
    assert last.steps <= 110
    assert last.deepest == pytest.approx(depth, rel=1e-5)
    assert last.distance == pytest.approx(wanted["passes"], rel=REFERENCE["tolerance"]["passes_later"])
    assert last.worn_area("upper") == pytest.approx(RATE * LOAD * CREEPAGE * last.distance, rel=REFERENCE["tolerance"]["mass"])
    rigid = (1.5 * 0.2 * RATE * LOAD * CREEPAGE * last.distance) ** (2.0 / 3.0) / (2.0 * 0.2)
    assert last.deepest == pytest.approx(rigid, rel=8e-3)


def test_steps_converge_at_first_order() -> None:
    def passes(fraction: float) -> float:
        wear = replace(TWIN_DISC.wear, step_fraction=fraction, depth=2e-6)
        problem = replace(TWIN_DISC, numerics=Numerics(grid=(24, 24)), wear=wear)
        return list(evolution(problem))[-1].distance

    fine = passes(0.0025)
    errors = [abs(passes(fraction) - fine) for fraction in (0.04, 0.01)]
    assert math.log(errors[0] / errors[1]) / math.log(4.0) > 0.7


def test_grids_converge() -> None:
    def passes(side: int) -> float:
        wear = replace(TWIN_DISC.wear, step_fraction=0.02, depth=2.28e-6)
        return list(evolution(replace(TWIN_DISC, numerics=Numerics(grid=(side, side)), wear=wear)))[-1].distance

    fine = passes(64)
    errors = [abs(passes(side) - fine) for side in (16, 32)]
    assert math.log2(errors[0] / errors[1]) > 1.5 and errors[1] < 1e-3 * fine


def test_steps_beyond_the_limit_are_unstable(monkeypatch: pytest.MonkeyPatch) -> None:
    """A depth well beyond the stable one makes neighbouring rows wear in turn."""
    def roughness() -> float:
        *_, last = evolution(replace(TWIN_DISC, wear=replace(TWIN_DISC.wear, step_fraction=9.0, depth=25e-6)))
        loads = line_load(last.result)
        return float(np.abs(np.diff(loads, 2))[10:-10].max() / loads.max())

    calm = roughness()
    monkeypatch.setattr(module, "STABLE_SHARE", 2.0)
    assert calm < 0.02 and roughness() > 0.1


def test_a_contact_that_reaches_the_end_of_a_profile_stops() -> None:
    state = next(evolution(TWIN_DISC))
    short = replace(state, y=np.linspace(-1.5e-3, 1.5e-3, 81), worn={body: np.zeros(81) for body in ("lower", "upper")})
    with pytest.raises(BeyondProfile, match="end of a profile"):
        list(evolution(TWIN_DISC, short))


def test_the_command_resumes_as_if_undisturbed(tmp_path: Path) -> None:
    settings = ("--set", "numerics.grid=16", "--set", "wear.depth_um=12", "--set", "wear.step_fraction=0.05", "--no-plots",
                "-q")
    whole, torn = tmp_path / "whole", tmp_path / "torn"
    assert call("wear", CASE, "-o", whole, *settings).returncode == 0
    lines = (whole / "twin_disc_wear_wear.jsonl").read_text().splitlines(keepends=True)
    assert len(lines) > 24
    torn.mkdir()
    (torn / "twin_disc_wear_wear.jsonl").write_text("".join(lines[:24]) + lines[24][:100])
    assert call("wear", CASE, "-o", torn, "--resume", *settings).returncode == 0
    assert (torn / "twin_disc_wear_wear.csv").read_text() == (whole / "twin_disc_wear_wear.csv").read_text()
    rows = list(csv.DictReader((whole / "twin_disc_wear_wear.csv").read_text().splitlines()))
    assert float(rows[-1]["depth_max_upper_um"]) == pytest.approx(12.0, rel=1e-5)
    with h5py.File(whole / "twin_disc_wear_wear.h5") as file:
        assert file["wear/profile_upper"].shape == (len(file["wear/distance"]), len(file["wear/y"]))
        assert file["wear/steps/distance_km"].shape == (len(rows),)


def test_a_worn_profile_is_read_by_a_case(tmp_path: Path) -> None:
    settings = ("--set", "numerics.grid=16", "--set", "wear.depth_um=4", "-q")
    done = call("wear", CASE, "-o", tmp_path, "--json", *settings)
    summary = json.loads(done.stdout)
    assert summary["status"] == "converged" and (tmp_path / "twin_disc_wear_wear.png").exists()
    text = CASE.read_text().replace("upper_radius_y_mm = 200.0", "").split("[wear]")[0]
    text += '\n[numerics]\ngrid = 16\n[geometry.upper_profile]\nfile = "twin_disc_wear_worn_upper.csv"\n'
    (tmp_path / "worn.toml").write_text(text)
    again = call("run", tmp_path / "worn.toml", "-o", tmp_path, "--json", "--no-plots", "-q")
    assert json.loads(again.stdout)["pressure_max_MPa"] == pytest.approx(summary["pressure_max_MPa"], rel=2e-3)


@pytest.mark.parametrize(("old", "new", "words"), [
    ("1e-5 ", "-1e-5 ", "specific_wear_rate_mm3_Nm"),
    ("depth_um = 20.0", "depth_um = 20.0\ndistance_km = 3.0", "distance_km"),
    ("upper_radius_x_mm = 23.5", "upper_radius_x_mm = inf", "track_length_m"),
    ("[wear.upper]\nspecific_wear_rate_mm3_Nm = 1e-5 ", "# ", "no body wears"),
])
def test_what_does_not_fit_is_an_error(tmp_path: Path, old: str, new: str, words: str) -> None:
    (tmp_path / "case.toml").write_text(CASE.read_text().replace(old, new))
    done = call("wear", tmp_path / "case.toml", "-o", tmp_path)
    assert done.returncode == 3 and words in done.stderr


def test_nothing_wears_where_nothing_slips(tmp_path: Path) -> None:
    done = call("wear", CASE, "-o", tmp_path, "--set", "creepage.longitudinal=0", "--set", "numerics.grid=16", "--no-plots")
    assert done.returncode == 4 and "nothing slips" in done.stderr
    plan = make_plan(Case.read(CASE, [Override.parse("creepage.longitudinal=0")]).problem)
    assert plan.skipped["wear"] == "nothing slips" and any("nothing wears" in warning for warning in plan.warnings)
    assert make_plan(Case.read(CASE).problem).runs("wear")
