"""Half the contact where the other half is its mirror image: the same answers for half the work."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.sampling import sampled
from tests.support.scenes import STEEL, article_4_1, ellipse, rolling, saturation
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities, Kinematics
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance
from thermoroll_cli.physics.numerics.convolution import counted, unfolded
from thermoroll_cli.physics.rolling.rolling_gradient import RollingGradient
from thermoroll_cli.physics.rolling.stick_inverse import StickInverse, run_starts
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.problem import Heating, Material
from thermoroll_cli.python_api import solve

PARITIES = [(1, -1), (-1, 1)]
COMPLIANCE = ShearCompliance.of((1.0, 0.28), (2.0, 0.4))
BASE = rolling()
CREEPAGE, SPIN = saturation(BASE).creepage, saturation(BASE).spin
SOFT = Material(70e9, 0.33, 150.0, 23e-6, 60e-6)

MIRRORED = {
    "longitudinal": rolling(creepage=(0.5 * CREEPAGE, 0.0)),
    "lateral": rolling(creepage=(0.0, 0.5 * CREEPAGE)),
    "spin": rolling(spin=SPIN),
    "lateral and spin": rolling(creepage=(0.0, 0.3 * CREEPAGE), spin=0.5 * SPIN),
    "ellipse": rolling(geometry=ellipse(0.4), spin=0.5 * SPIN, grid=(48, 72)),
    "longitudinal force": rolling(force=(0.5 * BASE.traction_limit, None), creepage=(None, 0.0)),
    "lateral force and spin": rolling(force=(None, 0.4 * BASE.traction_limit), creepage=(0.0, None), spin=0.5 * SPIN),
    "hot": article_4_1(40),
    "hot spin": rolling(spin=2.0 * SPIN, speed=100.0, heating=Heating(), grid=40),
    "dissimilar": replace(rolling(creepage=(0.5 * CREEPAGE, 0.0)), upper=SOFT),
    "warm friction": replace(article_4_1(40), friction=Friction(0.3, slope=1e-3)),
    "isothermal lateral, then hot": rolling(creepage=(0.0, CREEPAGE), speed=100.0, heating=Heating(), grid=40),
}  # fmt: skip
WHOLE = {
    "both creepages": rolling(creepage=(0.3 * CREEPAGE, 0.3 * CREEPAGE)),
    "longitudinal and spin": rolling(creepage=(0.3 * CREEPAGE, 0.0), spin=0.3 * SPIN),
    "dissimilar spin": replace(rolling(spin=SPIN), upper=SOFT),
    "free lateral creepage": rolling(creepage=(0.3 * CREEPAGE, None), force=(None, 1.0)),
    "odd number of columns": rolling(creepage=(0.5 * CREEPAGE, 0.0), grid=(32, 33)),
}


def both_sides(half, mirror):
    return np.stack([unfolded(component, parity) for component, parity in zip(half, mirror, strict=True)])


@pytest.mark.parametrize("mirror", PARITIES)
@pytest.mark.parametrize(("n", "m"), [(7, 4), (12, 5), (1, 1), (30, 16)])
@pytest.mark.parametrize("compliance", [COMPLIANCE, ShearCompliance(1.0, 0.0)])
def test_operator_on_half_is_the_one_on_the_whole(n, m, mirror, compliance):
    half = RollingGradient((n, m), 0.1, 0.07, Bodies.of_shear(compliance), mirror=mirror)
    whole = RollingGradient((n, 2 * m), 0.1, 0.07, Bodies.of_shear(compliance))
    traction = np.random.default_rng(n).normal(size=(2, n, m))
    before = counted.transforms
    expected = whole(both_sides(traction, mirror))[:, :, m:]
    for_whole = counted.transforms - before
    np.testing.assert_allclose(half(traction), expected, atol=1e-13 * np.abs(expected).max())
    assert counted.transforms - before - for_whole == 0.5 * for_whole > 0


@pytest.mark.parametrize("mirror", PARITIES)
def test_preconditioner_on_half_is_the_one_on_the_whole(mirror):
    random = np.random.default_rng(3)
    n, m = 21, 9
    stick = random.random((n, m)) > 0.3
    gradient = random.normal(size=(2, n, m)) * stick
    half = StickInverse((n, m), 0.1, 0.07, Bodies.of_shear(COMPLIANCE), mirror)
    whole = StickInverse((n, 2 * m), 0.1, 0.07, Bodies.of_shear(COMPLIANCE))
    full = unfolded(stick, 1)
    expected = whole(both_sides(gradient, mirror), full, run_starts(full))[:, :, m:]
    np.testing.assert_allclose(half(gradient, stick, run_starts(stick)), expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("name", sampled(MIRRORED, 12))
def test_half_the_contact_gives_the_same_answer(name, monkeypatch, record_property):
    problem = MIRRORED[name]
    half = solve(problem)
    assert half.converged and "tangential, y < 0" in make_plan(problem).skipped
    monkeypatch.setattr(Kinematics, "mirror", None)
    problem = replace(problem, title="whole")  # another one, of which nothing is known yet
    whole = solve(problem)
    assert "tangential, y < 0" not in make_plan(problem).skipped
    limit = problem.traction_limit
    for key, scale in (("force_x_N", limit), ("force_y_N", limit), ("Q_F_W", whole.coupled.scalars["Q_F_W"]),
                       ("spin_moment_Nmm", limit), ("gamma_c", 1.0), ("gamma_st", 1.0), ("gamma_p", 1.0)):  # fmt: skip
        tolerance = 2e-3 if key == "gamma_st" else 3e-4 if "hot" in name or "warm" in name else 3e-5
        assert half.coupled.scalars[key] == pytest.approx(whole.coupled.scalars[key], abs=tolerance * abs(scale)), key
    shear = np.stack([half.coupled.fields["shear_x"], half.coupled.fields["shear_y"]])
    expected = np.stack([whole.coupled.fields["shear_x"], whole.coupled.fields["shear_y"]])
    assert np.linalg.norm(shear - expected) < 2e-3 * np.linalg.norm(expected)
    saved = half.work["levels"][-1]["transforms"] / whole.work["levels"][-1]["transforms"]
    record_property("share_of_transforms", saved)
    assert saved < 0.95


@pytest.mark.parametrize("name", sampled(WHOLE, 4))
def test_contact_without_mirror_image_is_solved_whole(name):
    assert "tangential, y < 0" not in make_plan(WHOLE[name]).skipped
    assert solve(WHOLE[name]).converged


def test_mirror_is_exact():
    """Both halves carry the same numbers, with and without sign."""
    fields = solve(MIRRORED["hot spin"]).coupled.fields
    for name, parity in (("shear_x", -1), ("shear_y", 1), ("pressure", 1), ("state", 1), ("heat_flux", 1)):
        np.testing.assert_array_equal(fields[name], parity * fields[name][:, ::-1])


def test_sideways_motion_is_felt_by_the_heat():
    """With lateral creepage material drifts sideways: the warmer half lies downstream, and no half tells the other."""
    problem = rolling(creepage=(0.0, 0.3), speed=0.05, heating=Heating(), body=STEEL)
    assert DerivedQuantities(problem).kinematics.mirror is not None and not DerivedQuantities(problem).kinematics.heat_mirrors
    temperature = solve(problem).coupled.fields["temperature_rise_lower"]
    assert np.abs(temperature - temperature[:, ::-1]).max() > 1e-3 * temperature.max()
