"""Rolling contacts whose bodies bring heat back: temperatures, shares, crown, friction, given forces, the plan."""

import math
from dataclasses import replace

import numpy as np
import pytest

from scripts.figures.figures_recirculation import CASES
from tests.support.sampling import sampled
from tests.support.scenes import rolling, solved, twin_disc, wheel_on_rail
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.one_contact.steady_state import heated_bodies
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.heated_bodies import turning_bodies
from thermoroll_cli.physics.heat.recirculation import Track
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Material, Motion, Numerics, Problem, ReturningTrack
from thermoroll_cli.python_api import solve


def test_wheel_on_rail():
    """Who turns is hot, and the rail takes most of the heat: near what a given flux of that heat makes (207 K, 79 %)."""
    s = solved(wheel_on_rail()).coupled.scalars
    alone = solved(wheel_on_rail(upper_track=None)).coupled.scalars
    assert 0.78 < s["partition_mean"] < 0.80
    assert 1.3 < s["temperature_rise_max_upper_K"] / alone["temperature_rise_max_upper_K"] < 1.4
    assert s["bulk_temperature_upper_K"] == pytest.approx(74.3, abs=1.0)
    assert s["entry_temperature_max_upper_K"] == pytest.approx(109.1, abs=1.0)
    assert s["heat_into_lower_W"] + s["heat_into_upper_W"] == pytest.approx(s["Q_F_W"], rel=1e-3)
    assert s["bulk_temperature_lower_K"] == s["entry_temperature_max_lower_K"] == 0.0
    assert s["flash_temperature_max_lower_K"] == s["temperature_rise_max_lower_K"]
    assert s["flash_temperature_max_upper_K"] < s["temperature_rise_max_upper_K"]
    assert math.isnan(s["warm_up_time_lower_s"]) and s["warm_up_time_upper_s"] > 3600.0
    assert 0.02 < s["thermal_crown_ratio"] < 0.025


@pytest.mark.parametrize("share, turns", [(0.99, True), (0.999, False)])
def test_a_body_that_a_force_stops_brings_no_heat_back(share: float, turns: bool) -> None:
    soft = Material(2e6, 0.49, conductivity=0.2, expansion=1e-4, diffusivity=1e-7)
    heating = Heating(deformation=False, upper_track=ReturningTrack(width=0.04, convection=10.0))
    motion = Motion(1e-3, None, force_x=40.0 * share)
    spheres, grid = Geometry(0.02, 0.02, 0.02, 0.02), Numerics(grid=(16, 16))
    problem = Problem(soft, soft, spheres, 20.0, Friction(2.0), motion, heating, grid)
    result = solve(problem)
    assert result.converged is turns and (result.coupled.scalars["creepage_longitudinal"] < 2.0) is turns
    assert turns or "the upper body hardly turns, or turns backwards, at a longitudinal creepage of 2.3" in result.reason


def test_surroundings_are_the_zero_of_each_body():
    cold, warm = (solved(wheel_on_rail(bulk_lower=t, bulk_upper=t)).coupled.scalars for t in (0.0, 40.0))
    for name in ("bulk_temperature_upper_K", "entry_temperature_max_upper_K", "surface_temperature_max_upper_K",
                 "bulk_temperature_lower_K"):
        assert warm[name] - cold[name] == pytest.approx(40.0, abs=1e-6)
    assert warm["temperature_rise_max_upper_K"] == pytest.approx(cold["temperature_rise_max_upper_K"], rel=1e-9)


@pytest.mark.slow
def test_equal_discs_share_evenly_and_the_cooler_one_takes_more():
    even, uneven = solved(twin_disc()), solved(twin_disc(resistance=(1.0, 0.5)))
    s, u = even.coupled.scalars, uneven.coupled.scalars
    assert s["partition_mean"] == pytest.approx(0.5, abs=0.01)  # their speeds differ by 2 %
    assert s["bulk_temperature_lower_K"] == pytest.approx(s["heat_into_lower_W"], rel=1e-9)
    assert u["partition_mean"] < s["partition_mean"] - 0.05
    assert u["bulk_temperature_upper_K"] == pytest.approx(0.5 * u["heat_into_upper_W"], rel=1e-9)
    assert u["temperature_rise_max_lower_K"] == pytest.approx(u["temperature_rise_max_upper_K"], rel=2e-3)
    assert uneven.work["partition"]["applications"] <= 15


def test_the_crown_acts_back_where_it_matters():
    """Polymer bodies: the thermal crown lifts the middle of the track, and the contact gets narrower across."""
    body = Material(4e9, 0.4, 0.25, 47e-6, 0.14e-6)
    tracks = {f"{b}_track": ReturningTrack(0.01, convection=50.0) for b in ("lower", "upper")}
    problem = rolling(grid=32, body=body, geometry=Geometry(0.02, 0.02, 0.02, math.inf), load=60.0, friction=0.3, speed=4.0,
                      creepage=(0.05, 0.0), heating=Heating(partition="matched", **tracks))
    plan = make_plan(problem)
    assert plan.runs("recirculation") and plan.runs("deformation") and "thermal crown" not in plan.skipped
    with_crown = solved(problem)
    assert with_crown.converged, with_crown.reason
    without = solved(replace(problem, heating=replace(problem.heating, lower_track=None, upper_track=None)))
    s, w = with_crown.coupled.scalars, without.coupled.scalars
    assert s["thermal_crown_ratio"] > 0.05
    assert s["gamma_p"] > w["gamma_p"] + 0.15 * s["thermal_crown_ratio"]
    wide = [np.count_nonzero((r.coupled.fields["state"] > 0).any(axis=0)) for r in (with_crown, without)]
    assert wide[0] < wide[1]


def test_a_crown_that_does_not_matter_is_skipped_and_said_so():
    plan = make_plan(twin_disc(motion=Motion(2.0, 1e-4)))
    assert "thermal crown" in plan.skipped and plan.runs("recirculation")
    assert plan.facts["thermal_crown_bound"] < 1e-3
    assert plan.facts["expected_bulk_temperature_lower_K"] > 0.0


@pytest.mark.parametrize(("problem", "word"), [
    (wheel_on_rail(partition=0.5), "fixed thermal.partition"),
    (twin_disc(lower_track=ReturningTrack(0.003, resistance=1.0)), "wider than the body"),
    (wheel_on_rail(upper_track=ReturningTrack(0.135, convection=1e4)), "Biot"),
])
def test_warnings(problem, word):
    assert any(word in warning for warning in make_plan(problem).warnings)


def test_a_fixed_partition_is_dangerous_here():
    half = solved(wheel_on_rail(partition=0.5)).coupled.scalars
    assert half["temperature_rise_max_upper_K"] > 1.8 * solved(wheel_on_rail()).coupled.scalars["temperature_rise_max_upper_K"]


def test_prescribed_force_finds_the_creepage_and_the_same_temperatures():
    motion = Motion(2.0, None, 0.0, force_x=150.0)
    forced = solve(twin_disc(motion=motion, deformation=False))
    assert forced.converged, forced.reason
    s = forced.coupled.scalars
    again = solve(twin_disc(motion=Motion(2.0, s["creepage_longitudinal"]), deformation=False)).coupled.scalars
    for name in ("temperature_rise_max_lower_K", "bulk_temperature_upper_K", "Q_F_W"):
        assert again[name] == pytest.approx(s[name], rel=6e-3)


def test_friction_feels_what_comes_back():
    """Bulk temperature lowers friction, and with it the heat."""
    turning = twin_disc(resistance=(10.0, 10.0), deformation=False)
    falling = replace(turning.friction, slope=2e-3)
    passing = replace(turning, heating=replace(turning.heating, lower_track=None, upper_track=None))
    once = solve(replace(passing, friction=falling)).coupled.scalars
    back = solve(replace(turning, friction=falling))
    assert back.converged, back.reason
    assert back.coupled.scalars["force_x_N"] < 0.97 * once["force_x_N"]


HOT = {"motion": Motion(5.0, 0.02)}


@pytest.mark.slow
@pytest.mark.parametrize("problem", sampled([
    twin_disc(64, (1.0, 0.2), **HOT), twin_disc(64, (1.0, 1.0), **HOT),
    *(replace(case, numerics=replace(case.numerics, grid=(64, 64)))
      for name, case in CASES.items() if name.startswith(("wheel", "PEEK")))]))
def test_cost(problem):
    """Transforms on all grids of a coupled solve at N = 64 with and without tracks, each as much as its elements: at most
    half more, also where bodies need hardly anything solved without them, and at most 15 applications where the heat must be
    divided."""
    passing = replace(problem, heating=replace(problem.heating, lower_track=None, upper_track=None))
    done = []
    for result in (solved(problem), solved(passing)):
        assert result.converged and result.work["levels"][-1]["coupling_iterations"] > 0
        assert result.work["partition"]["applications"] <= 15
        done.append(sum(level["transforms"] * math.prod(level["grid"]) for level in result.work["levels"]))
    assert done[0] < 1.5 * done[1]


def test_a_ring_brings_heat_back_through_its_bore():
    """A ball in a groove: the race is concave along rolling, takes a resistance and has no volume that is known."""
    in_a_race = Geometry(-0.05, 0.1, 0.02, 0.1)
    ring = replace(twin_disc(deformation=False), geometry=in_a_race)
    s = solved(ring).coupled.scalars
    assert s["bulk_temperature_lower_K"] == pytest.approx(s["heat_into_lower_W"], rel=1e-9)
    assert math.isnan(s["warm_up_time_lower_s"]) and s["warm_up_time_upper_s"] > 0.0
    cylinder = replace(ring, geometry=Geometry(0.05, 0.1, 1.0 / (1.0 / 0.02 - 2.0 / 0.05), 0.1))
    assert DerivedQuantities(cylinder).hertz == DerivedQuantities(ring).hertz
    around, alone = (turning_bodies(p, 0.02)[0] for p in (ring, cylinder))
    assert around == replace(alone, ring=True)
    grid = DerivedQuantities(ring).grid((8, 16), 2.2)
    flux = np.ones(grid.shape)
    # More body around a bore than inside a cylinder: its track is cooler, and bulges less.
    bore, rim = (Track(roller, grid) for roller in (around, alone))
    assert 0.99 < bore.entry_temperature(flux)[8] / rim.entry_temperature(flux)[8] < 0.9999
    assert np.ptp(bore.entry_bulge(flux)) < np.ptp(rim.entry_bulge(flux))
    with pytest.raises(ValueError, match="ring"):
        make_plan(replace(ring, heating=replace(ring.heating, lower_track=ReturningTrack(0.01, convection=30.0))))


def test_bodies_that_do_not_return_build_nothing_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(heated_bodies, "RecirculatingResponse")
    assert solve(wheel_on_rail(16, upper_track=None)).converged
    with pytest.raises(NameError):
        solve(wheel_on_rail(16))
