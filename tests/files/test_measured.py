"""Measured creep forces beside the shipped cases (docs/verification.md): friction and interlayers are fitted to the creep
curves, the angles of attack are predicted."""

from __future__ import annotations

import numpy as np
import pytest

from scripts.measured import (
    FRICTION,
    INTERLAYER,
    RISING,
    SMOOTH,
    Array,
    at_angles,
    case,
    fitted,
    forces,
    roller_rig,
    roller_rig_angles,
    twin_disc,
)
from tests.support.scenes import reference
from thermoroll_cli import Case, solve

GRID = 16


def rms(model: Case, points: Array) -> float:
    """Root of the mean square of computed less measured force over load."""
    apart = forces(model, {"creepage.longitudinal": points[0].tolist()}) - points[1]
    return float(np.sqrt(np.mean(apart**2)))


@pytest.mark.slow
def test_the_values_of_a_roller_rig_are_inside_the_intervals_of_a_fit() -> None:
    rig, points = case("vt_fra_roller_rig", GRID), roller_rig()[:, ::6]
    found = fitted(rig.with_values({FRICTION: 0.5}), points, FRICTION, INTERLAYER)
    for key, one in found.parameters.items():
        assert abs(one.value - {FRICTION: 0.5135, INTERLAYER: 3.8}[key]) < one.uncertainty_95
    assert found.rms["force_x_over_load"] == pytest.approx(rms(found.case, points), rel=1e-3) and not found.warnings
    assert found.rms["force_x_over_load"] <= rms(rig, points)


@pytest.mark.slow
def test_creep_curve_of_a_roller_rig() -> None:
    """Every sixth of 40 points to 2 %: the values of the case leave a third of the scatter; smooth bodies are too stiff."""
    rig, points = case("vt_fra_roller_rig", GRID), roller_rig()[:, ::6]
    assert rms(rig, points) < 0.010
    smooth = rig.with_values({**SMOOTH, FRICTION: 0.48})
    assert 0.028 < rms(smooth, points) < 0.036
    creepage, force = (row[(points[0] > 1e-3) & (points[0] < 4e-3)] for row in points[:2])
    ratio = force / forces(smooth, {"creepage.longitudinal": creepage.tolist()})
    assert ((ratio > 0.6) & (ratio < 0.9)).all()


@pytest.mark.slow
def test_angles_of_attack_are_predicted() -> None:
    rig, (angles, force, _) = case("vt_fra_roller_rig", GRID), roller_rig_angles()
    for model, bound in ((rig, 0.016), (rig.with_values({**RISING, INTERLAYER: 2.85}), 0.0075)):
        assert np.sqrt(np.mean((at_angles(model, angles) - force) ** 2)) < bound


@pytest.mark.slow
def test_tractions_of_a_twin_disc() -> None:
    """Up to 3 % slip; beyond, the curve is the coefficient of friction."""
    disc, points = case("twin_disc_lewis", GRID), twin_disc()[:, :4]
    assert rms(disc, points) < 0.018
    assert 0.050 < rms(disc.with_values(SMOOTH), points) < 0.060


def test_an_interlayer_may_be_taken_from_the_slope() -> None:
    """Springs in series: L ≈ (8/3) a²b (1/k − 1/k₀)."""
    rig = case("vt_fra_roller_rig", GRID)
    slow = [solve(one.with_values({"creepage.longitudinal": 2e-5})) for one in (rig, rig.with_values(SMOOTH))]
    flexibility = [2e-5 / result["force_x_N"] for result in slow]
    a, b = (slow[0].of_problem[f"hertz_{axis}_mm"] * 1e-3 for axis in "ab")
    interlayer = 8.0 / 3.0 * a**2 * b * (flexibility[0] - flexibility[1])
    assert interlayer == pytest.approx(rig.problem.interlayer.compliance, rel=0.15)


@pytest.mark.slow
def test_measured_creep_forces_of_a_locomotive() -> None:
    """Parameters were fitted to these points by others: this checks the form of the model and the program, not a prediction."""
    measured = reference("friction_eurosprinter_measured")
    train = case("eurosprinter", 32)
    creepages = measured["ours"]["creepage"][::2]
    forces = [solve(train.with_values({"creepage.longitudinal": c})).coupled.scalars["force_x_N"] / 106700 for c in creepages]
    points = np.array(measured["points"])
    model = np.interp(points[:, 0], creepages, forces)
    assert np.sqrt(np.mean((points[:, 1] - model) ** 2)) <= 0.030
    assert forces == pytest.approx(measured["ours"]["Fx_over_W"][::2], abs=4e-4)
