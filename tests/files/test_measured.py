"""Measured creep forces beside the shipped cases (docs/measured.md): friction and interlayers are fitted to the creep curves,
the angles of attack are predicted."""

from __future__ import annotations

from dataclasses import replace

import pytest

from scripts.measured import DISC_SMOOTH, RIG_SMOOTH, model, rising, roller_rig, roller_rig_angles, smooth, twin_disc
from thermoroll_cli import solve
from thermoroll_cli.problem.problem import Problem

GRID = 16


@pytest.fixture(scope="module")
def rig() -> Problem:
    return model("vt_fra_roller_rig", GRID)


def test_creep_curve_of_a_roller_rig(rig: Problem) -> None:
    """40 points to 2 %: within a third of their scatter with two numbers fitted; smooth bodies are too stiff."""
    assert roller_rig(rig).rms < 0.010
    assert roller_rig(rising(rig)).rms < 0.0087
    bare = roller_rig(smooth(rig, RIG_SMOOTH))
    assert 0.030 < bare.rms < 0.034
    low = bare.points[(bare.points[:, 0] > 1e-3) & (bare.points[:, 0] < 3e-3)]
    assert ((low[:, 1] / bare.between(low[:, 0]) > 0.6) & (low[:, 1] / bare.between(low[:, 0]) < 0.9)).all()


def test_angles_of_attack_are_predicted(rig: Problem) -> None:
    assert roller_rig_angles(rig).rms < 0.016
    assert roller_rig_angles(rising(rig)).rms < 0.0075


def test_tractions_of_a_twin_disc() -> None:
    disc = model("twin_disc_lewis", GRID)
    assert twin_disc(disc).rms < 0.018
    assert 0.050 < twin_disc(smooth(disc, DISC_SMOOTH)).rms < 0.060


def test_an_interlayer_may_be_taken_from_the_slope(rig: Problem) -> None:
    """Springs in series: L ≈ (8/3) a²b (1/k − 1/k₀)."""
    slopes = []
    for problem in (rig, smooth(rig, RIG_SMOOTH)):
        result = solve(replace(problem, motion=replace(problem.motion, creepage_x=2e-5)))
        slopes.append(result.coupled.scalars["force_x_N"] / 2e-5)
    a, b = (result.of_problem[f"hertz_{axis}_mm"] * 1e-3 for axis in "ab")
    assert 8.0 / 3.0 * a**2 * b * (1.0 / slopes[0] - 1.0 / slopes[1]) == pytest.approx(rig.interlayer.compliance, rel=0.15)
