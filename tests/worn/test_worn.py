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
from tests.support.documents import cell
from tests.support.scenes import reference
from thermoroll_cli import Case, CaseError, wear
from thermoroll_cli.exact.hertz import hertz_contact
from thermoroll_cli.files.case_source import Override
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.scalars import worn_per_passage
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry, Profile
from thermoroll_cli.problem.problem import Heating, Material, Motion, Numerics, Problem, Wear, WornBody
from thermoroll_cli.python_api import solve
from thermoroll_cli.studies.worn import evolution as module
from thermoroll_cli.studies.worn.evolution import ContactState, evolution, half_width, line_load
from thermoroll_cli.studies.worn.rows import FixedRows

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
    for body, radius, speed in (("upper", TWIN_DISC.geometry.upper_radius_x, 1.0 - 0.5 * CREEPAGE),
                                ("lower", TWIN_DISC.geometry.lower_radius_x, 1.0 + 0.5 * CREEPAGE)):
        rolled = 2.0 * math.pi * radius / speed
        heat = TWIN_DISC.friction.coefficient * LOAD * CREEPAGE * rolled
        assert scalars[f"heat_per_revolution_{body}_J"] == pytest.approx(heat, rel=1e-5)
        worn = RATE * LOAD * CREEPAGE * rolled * 1e9 if body == "upper" else 0.0
        assert scalars[f"wear_per_revolution_{body}_mm3"] == pytest.approx(worn, rel=1e-5)
    assert scalars["wear_depth_max_upper_nm"] * 1e-9 == pytest.approx(first["depth_per_pass_centre_m"], rel=2e-3)
    assert scalars["wear_area_lower_um2"] == 0.0
    hertz = result.of_problem
    y = result.y
    exact = (0.5 * math.pi * CREEPAGE * hertz["hertz_p0_MPa"] * 1e6 * hertz["hertz_a_mm"] * 1e-3
             * np.maximum(1.0 - (y / (hertz["hertz_b_mm"] * 1e-3)) ** 2, 0.0))
    work = worn_per_passage(TWIN_DISC, WornBody(1.0), result.coupled.fields, float(result.x[1] - result.x[0]))
    assert work == pytest.approx(exact, abs=5e-3 * exact.max())


def test_a_free_rolling_groove_wears_beside_its_neutral_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    """Heathcote's groove of slip along rolling alone: friction so low that nothing deforms tangentially."""
    monkeypatch.setattr(Geometry, "lateral_slip", lambda _, shares, x, y: 0.0 * x * y)
    problem = Problem(STEEL, STEEL, Geometry(0.022, -0.0066, 0.00635, 0.00635), 300.0, Friction(1e-5),
                      Motion(5.0, None, force_x=0.0), Heating(heat=False), Numerics(grid=(128, 128)))
    result = solve(problem)
    b = hertz_contact(problem.geometry.curvature_x, problem.geometry.curvature_y, problem.contact_modulus, 300.0).semi_axis_y
    slope = DerivedQuantities(problem).kinematics.differential_slip.slope(np.array([1e-4]))[0]
    unit = 300.0 * abs(slope) / 2e-4 * b
    work = worn_per_passage(problem, WornBody(1.0), result.coupled.fields, float(result.x[1] - result.x[0]))
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


def test_other_rows_have_the_same_worn_area() -> None:
    """FixedRows twice as wide, of bodies that end and of those that do not; whole rows fill what both bodies have."""
    for facing in ((-math.inf, math.inf), (-2.3, 1.9)):
        rows = FixedRows.over(-1.0, 1.0, facing, 41)
        depth = np.maximum(1.0 - rows.y**2, 0.0)
        coarse = rows.coarser()
        assert coarse.size == pytest.approx(2.0 * rows.size, rel=0.05)
        assert coarse.averages(rows.edges, depth).sum() * coarse.size == pytest.approx(depth.sum() * rows.size, rel=1e-12)
    assert rows.covering(-9.0, 9.0).ends == pytest.approx((-2.3, 1.9), rel=1e-12)


@pytest.mark.parametrize("grid", [14, pytest.param(26, marks=pytest.mark.slow)])
def test_an_evolution_goes_on_with_another_grid(grid: int) -> None:
    """Worn depths of other rows have the same area, and no stairs that the pressure would show."""
    problem = replace(TWIN_DISC, numerics=Numerics((20, 20)))
    states = list(evolution(problem))
    middle = replace(states[len(states) // 2], result=None)
    *_, last = evolution(replace(problem, numerics=Numerics((grid, grid))), middle)
    assert last.result is not None and last.result.problem.numerics.grid[0] == grid  # type: ignore[index]
    assert last.distance == pytest.approx(states[-1].distance, rel=5e-3)
    assert last.worn_area("upper") == pytest.approx(RATE * LOAD * CREEPAGE * last.distance, rel=1e-4)
    assert last.result["pressure_max_MPa"] == pytest.approx(states[-1].result["pressure_max_MPa"], rel=1e-2)  # type: ignore[index]


@pytest.mark.slow
def test_a_symmetric_crown_stays_symmetric() -> None:
    """Half of the contact stands for all of it as long as the profiles are their own mirror images."""
    sliding_in_part = replace(TWIN_DISC, motion=replace(TWIN_DISC.motion, creepage_x=2e-3))
    state = list(islice(evolution(sliding_in_part), 6))[-1]
    assert state.result is not None and state.result.problem.geometry.symmetric
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
    would limit the steps. After two approaches the rigid law is 2 % off, by that solver, too."""
    wanted = REFERENCE["twin_disc_to_10"]["trajectory"][-3]
    depth = wanted["total_depth_um"] * 1e-6
    problem = replace(TWIN_DISC, numerics=Numerics(grid=(16, 16)), wear=replace(TWIN_DISC.wear, depth=depth))
    *_, last = evolution(problem)
    assert last.steps <= 33
    assert last.deepest == pytest.approx(depth, rel=1e-5)
    assert last.distance == pytest.approx(wanted["passes"], rel=REFERENCE["tolerance"]["passes_later"])
    assert last.worn_area("upper") == pytest.approx(RATE * LOAD * CREEPAGE * last.distance, rel=REFERENCE["tolerance"]["mass"])
    rigid = (1.5 * 0.2 * RATE * LOAD * CREEPAGE * last.distance) ** (2.0 / 3.0) / (2.0 * 0.2)
    (less,) = cell("verification", "worn depth after two approaches", "difference")
    assert 100.0 * (1.0 - last.deepest / rigid) == pytest.approx(less.value, abs=less.rounding)


@pytest.mark.slow
def test_steps_converge_at_first_order() -> None:
    def passes(fraction: float) -> float:
        wear = replace(TWIN_DISC.wear, step_fraction=fraction, depth=1e-6)
        problem = replace(TWIN_DISC, numerics=Numerics(grid=(16, 16)), wear=wear)
        return list(evolution(problem))[-1].distance

    coarse, middle, fine = (passes(fraction) for fraction in (0.08, 0.04, 0.02))
    assert 0.9 < math.log2((coarse - middle) / (middle - fine)) < 1.3


@pytest.mark.slow
def test_steps_beyond_the_limit_are_unstable(monkeypatch: pytest.MonkeyPatch) -> None:
    """A depth well beyond the stable one makes neighbouring rows wear in turn."""
    def roughness() -> float:
        *_, last = evolution(replace(TWIN_DISC, wear=replace(TWIN_DISC.wear, step_fraction=9.0, depth=25e-6)))
        loads = line_load(last.result)
        return float(np.abs(np.diff(loads, 2))[10:-10].max() / loads.max())

    calm = roughness()
    monkeypatch.setattr(module, "STABLE_SHARE", 2.5)
    assert calm < 0.02 and roughness() > 0.1


def test_a_contact_wears_up_to_the_end_of_a_profile() -> None:
    """A crown narrower than its contact: the worn area is that of full sliding, and pressures at the ends have no limit."""
    points = tuple((y, -(y**2) / 0.4) for y in np.linspace(-1e-3, 1e-3, 9).tolist())
    narrow = replace(TWIN_DISC, geometry=replace(TWIN_DISC.geometry, upper_radius_y=math.inf, upper_profile=Profile(points)),
                     wear=replace(TWIN_DISC.wear, depth=2e-6))
    *_, last = evolution(narrow)
    assert last.deepest == pytest.approx(2e-6, rel=1e-5) and last.domain.ends == pytest.approx((-1e-3, 1e-3))
    assert last.worn_area("upper") == pytest.approx(RATE * LOAD * CREEPAGE * last.distance, rel=1e-4)
    assert last.result is not None and "pressure_max_MPa" in last.result.unbounded


@pytest.mark.slow
def test_the_largest_pressure_of_a_worn_contact_is_that_of_its_middle_or_has_no_error() -> None:
    """The upper body wears far beyond the approach, while the contact becomes three times as wide: for a step or two after the
    contact has reached a row its border carries up to a sixth more, within an element, and a warning says where."""
    problem = Problem(STEEL, STEEL, Geometry(0.02, 0.02, 0.02, 0.03), 100.0, Friction(0.3), Motion(1.0, 0.02),
                      Heating(heat=False), Numerics(grid=(16, 16)), wear=Wear(upper=WornBody(1e-14, 0.125), distance=20e3))
    ratios = []
    for state in evolution(problem):
        assert state.result is not None
        pressure = state.result.coupled.fields["pressure"].max(axis=0)
        largest, known = state.result["pressure_max_MPa"] * 1e6, math.isfinite(state.result.uncertainty["pressure_max_MPa"])
        assert largest >= (1.0 - 1e-12) * pressure.max()
        ratios.append((largest / pressure[len(pressure) // 2], known))
        assert known or any("part within an element" in warning for warning in state.result.warnings)
    assert max(ratio for ratio, known in ratios if known) < 1.03 and max(ratios)[0] < 1.2
    assert sum(known for _, known in ratios) > len(ratios) // 2


@pytest.mark.slow
def test_errors_cover_finer_steps_and_grids() -> None:
    """The state after a distance, against one of more rows and three times as many steps."""
    def at_end(side: int, fraction: float) -> ContactState:
        wear = Wear(upper=WornBody(RATE, 1.0), distance=100.0, step_fraction=fraction)
        *_, last = evolution(replace(TWIN_DISC, numerics=Numerics(grid=(side, side)), wear=wear))
        return last

    coarse, fine = at_end(16, 0.1), at_end(32, 0.03)
    depth_error, area_error = coarse.errors("upper")
    assert abs(coarse.deepest - fine.deepest) < depth_error < 0.1 * fine.deepest
    assert abs(coarse.worn_area("upper") - fine.worn_area("upper")) <= area_error < 1e-3 * fine.worn_area("upper")


@pytest.mark.parametrize(("asked", "has"), [(3.0, 3.0), (1.5, 2.1)])
def test_a_worn_contact_has_the_domain_that_is_asked_for(asked: float, has: float) -> None:
    """Along rolling exactly, across it in whole rows, and no smaller than a contact needs, which is said."""
    first = next(iter(evolution(replace(TWIN_DISC, numerics=Numerics(grid=(16, 16), extent=asked)))))
    result, scales = first.result, DerivedQuantities(TWIN_DISC).scales
    assert result is not None and result.converged
    assert 16 * (result.x[1] - result.x[0]) == pytest.approx(has * scales.semi_axis_x, rel=1e-6)
    assert has * (1.0 - 1e-6) <= len(result.y) * (result.y[1] - result.y[0]) / scales.semi_axis_y < has * (1.0 + 2.0 / 16.0)
    assert any("smaller than the contact: grown to 2.1" in warning for warning in result.warnings) == (asked < has)


USFD = ((10.4, 5.3), (78.09, 55.0 / 78.09), (200.0, (61.9 * 200.0 - 4778.7) / 200.0))
"""USFD's wear function as a table: T_γ/A in N/mm², and µg/(m mm²) over it."""


def test_a_table_of_regimes_is_usfd_s_wear_function() -> None:
    body = WornBody(USFD)
    work = np.array([2.0, 10.0, 30.0, 60.0, 100.0, 150.0])
    rate, steepness = body.rate_at(work)
    assert rate * work == pytest.approx([10.6, 53.0, 55.0, 55.0, 1411.3, 4506.3], rel=5e-3)
    change = 1e-6
    above = body.rate_at(work * (1.0 + change))[0] * work * (1.0 + change)
    assert steepness == pytest.approx((above / (rate * work) - 1.0) / change, abs=1e-4)


def test_archard_and_t_gamma_wear_agree_in_one_regime() -> None:
    """κ = Kμ: the volume worn per distance is K T_γ/(track length), with partial slip, too; one regime is a constant rate."""
    sliding_in_part = replace(TWIN_DISC, motion=replace(TWIN_DISC.motion, creepage_x=1e-3),
                              wear=Wear(WornBody(RATE, 1.0), WornBody(((1e6, RATE),), 1.0)))
    scalars = solve(sliding_in_part).coupled.scalars
    assert scalars["wear_rate_lower_mm3_m"] == scalars["wear_rate_upper_mm3_m"]
    assert scalars["wear_rate_upper_mm3_m"] * 1e-9 == pytest.approx(RATE / 0.4 * scalars["T_gamma_N"], rel=1e-3)


def test_a_case_wears_in_regimes(tmp_path: Path) -> None:
    """Mild at the border, severe in the middle: the strip wears less unevenly than at one rate (as the square of T_γ/A);
    the picture has the regimes."""
    mild = "[[5, 1e-5], [100, 5e-7]]"
    done = call("wear", CASE, "-o", tmp_path, "--json", "--set", "numerics.grid=16", "--set", "wear.depth_um=1",
                "--set", f"wear.upper.specific_wear_rate_mm3_Nm={mild}", painted=True)
    assert done.returncode == 0 and (tmp_path / "twin_disc_wear_wear.png").exists()
    with h5py.File(tmp_path / "twin_disc_wear_wear.h5") as file:
        work = file["wear/T_gamma_per_area"][0] * 1e-6
        worn = (file["wear/profile_upper"][0] - file["wear/profile_upper"][1])
    deep = work > 0.8 * work.max()
    assert worn[deep].min() / worn.max() > 1.15 * (work[deep].min() / work.max()) ** 2
    for wrong in ("[[10, 1e-5], [5, 1e-6]]", "[[10, 0.0]]", "[]"):
        bad = call("validate", CASE, "--set", f"wear.upper.specific_wear_rate_mm3_Nm={wrong}")
        assert bad.returncode == 3 and "specific_wear_rate_mm3_Nm" in bad.stderr


RAIL = Path(__file__).parents[2] / "cases" / "worn_rail.toml"


@pytest.mark.slow
def test_an_off_centre_contact_wears_over_the_whole_profile(tmp_path: Path) -> None:
    """The contact lies at +13 mm of a shifted rail that reaches from −19 to 29 mm: its worn profile is written from end to end,
    a result file carries the worn case, and both give the pressure of the last step."""
    (tmp_path / "rail.toml").write_text(RAIL.read_text().replace("grid = 128", "grid = 16") + """
[wear]
depth_um = 10
[wear.lower]
track_length_m = 1000
specific_wear_rate_mm3_Nm = 1e-4
""")
    heatless = ("--set", "thermal.heat=false", "-q", "--json", "-o", tmp_path, "--no-plots")
    done = call("wear", tmp_path / "rail.toml", *heatless, "--set", "geometry.lower_profile.offset_mm=5")
    summary = json.loads(done.stdout)
    assert done.returncode == 0 and summary["depth_max_lower_um"] == pytest.approx(10.0, rel=1e-5)
    assert summary["uncertainty.T_gamma_N"] > 0.0 and summary["uncertainty.depth_max_lower_um"] > 0.0
    points = np.loadtxt(tmp_path / "rail_worn_lower.csv", delimiter=",")
    assert points[[0, -1], 0] == pytest.approx([-19.0, 29.0], abs=1e-6)
    head, rest = (tmp_path / "rail.toml").read_text().split("[geometry.lower_profile]")
    profile = '[geometry.lower_profile]\nfile = "rail_worn_lower.csv"\n'
    (tmp_path / "worn.toml").write_text(head + profile + rest[rest.index("[load]"):])
    for again in (("--from", tmp_path / "rail_wear.h5"), (tmp_path / "worn.toml",)):
        found = json.loads(call("run", *again, *heatless).stdout)
        assert found["pressure_max_MPa"] == pytest.approx(summary["pressure_max_MPa"], rel=0.03)
        assert found["T_gamma_N"] == pytest.approx(summary["T_gamma_N"], rel=0.03)


def test_the_command_resumes_as_if_undisturbed(tmp_path: Path) -> None:
    settings = ("--set", "numerics.grid=16", "--set", "wear.depth_um=6", "--set", "wear.step_fraction=0.1", "--no-plots",
                "-q")
    whole, torn = tmp_path / "whole", tmp_path / "torn"
    assert call("wear", CASE, "-o", whole, *settings).returncode == 0
    lines = (whole / "twin_disc_wear_wear.jsonl").read_text().splitlines(keepends=True)
    assert len(lines) > 6
    torn.mkdir()
    (torn / "twin_disc_wear_wear.jsonl").write_text("".join(lines[:6]) + lines[6][:100])
    assert call("wear", CASE, "-o", torn, "--resume", *settings).returncode == 0
    assert (torn / "twin_disc_wear_wear.csv").read_text() == (whole / "twin_disc_wear_wear.csv").read_text()
    other = call("wear", CASE, "-o", whole, *settings, "--set", "load.normal_N=500")
    assert other.returncode == 5 and "twin_disc_wear_wear.jsonl is of another wear" in other.stderr
    assert (torn / "twin_disc_wear_wear.csv").read_text() == (whole / "twin_disc_wear_wear.csv").read_text()
    rows = list(csv.DictReader((whole / "twin_disc_wear_wear.csv").read_text().splitlines()))
    assert float(rows[-1]["depth_max_upper_um"]) == pytest.approx(6.0, rel=1e-5)
    with h5py.File(whole / "twin_disc_wear_wear.h5") as file:
        assert file["wear/profile_upper"].shape == (len(file["wear/distance"]), len(file["wear/y"]))
        assert file["wear/steps/distance_km"].shape == (len(rows),)


def test_a_given_approach_keeps_the_distance_of_the_axles(tmp_path: Path) -> None:
    """What is worn off where the bodies touch is missing in the approach, so that the load falls. The worn case has the load of
    the last step, heights of a profile have no zero, and an evolution that asks for more than the approach ends."""
    text = CASE.read_text().replace("normal_N = 1500.0", "approach_um = 6.0").replace("grid = 64", "grid = 12")
    text = text.replace("depth_um = 20.0", "depth_um = 3.0\nstep_fraction = 0.5")
    crown = [[y, 3.0 - y**2 / 400.0] for y in np.linspace(-8.0, 8.0, 33).tolist()]
    profile = f"[geometry.upper_profile]\npoints_mm = {crown}\n[load]"
    found = {}
    lifted = text.replace("upper_radius_y_mm = 200.0", "").replace("[load]", profile)
    for name, of in {"radius": text, "lifted": lifted}.items():
        (tmp_path / f"{name}.toml").write_text(of)
        done = call("wear", tmp_path / f"{name}.toml", "-o", tmp_path, "--json", "--no-plots", "-q")
        assert done.returncode == 0, done.stderr
        rows = list(csv.DictReader((tmp_path / f"{name}_wear.csv").read_text().splitlines()))
        loads, approaches, depths = (np.array([float(row[column]) for row in rows])
                                     for column in ("normal_N", "approach_um", "depth_max_upper_um"))
        # Where they touch first less may be worn off than at the deepest place.
        assert (np.diff(loads) < 0.0).all() and approaches[0] == pytest.approx(6.0)
        np.testing.assert_allclose(approaches + depths, 6.0, atol=0.06)
        assert loads[-1] < 0.6 * loads[0] and float(rows[-1]["uncertainty.normal_N"]) > 0.0
        found[name] = json.loads(done.stdout)
    for quantity in ("normal_N", "distance_km", "pressure_max_MPa"):
        assert found["lifted"][quantity] == pytest.approx(found["radius"][quantity], rel=0.02)
    again = call("run", "--from", tmp_path / "radius_wear.h5", "-o", tmp_path, "--json", "--no-plots", "-q")
    assert json.loads(again.stdout)["normal_N"] == pytest.approx(found["radius"]["normal_N"], rel=0.02)
    apart = call("wear", tmp_path / "radius.toml", "-o", tmp_path, "--no-plots", "--force", "--set", "load.approach_um=0.5")
    assert apart.returncode == 4 and "the bodies wear apart at the given distance" in " ".join(apart.stdout.split())


def test_what_cannot_wear_is_an_invalid_case(tmp_path: Path) -> None:
    case, key, words = tmp_path / "conformal.toml", "geometry.conformal", "not computed for conformal contacts"
    case.write_text(CASE.read_text().replace("[load]", "conformal = true\n[load]"))
    done = call("wear", case, "-o", tmp_path, "--json")
    (error,) = json.loads(done.stdout)["errors"]
    assert done.returncode == 3 and error["key"] == key and words in error["message"] and f"error: {key}" in done.stderr
    with pytest.raises(CaseError, match=words):
        wear(case)


def test_nothing_wears_where_nothing_slips(tmp_path: Path) -> None:
    done = call("wear", CASE, "-o", tmp_path, "--set", "creepage.longitudinal=0", "--set", "numerics.grid=16", "--no-plots")
    assert done.returncode == 4 and "nothing slips" in done.stdout
    plan = make_plan(Case.read(CASE, [Override.parse("creepage.longitudinal=0")]).problem)
    assert plan.skipped["wear"] == "nothing slips" and any("nothing wears" in warning for warning in plan.warnings)
    assert make_plan(Case.read(CASE).problem).runs("wear")
