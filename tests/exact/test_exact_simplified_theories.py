"""FASTSIM and Polach's formulas: linear theory for little creepage, the friction limit for much, closed forms between."""

from __future__ import annotations

import math

import numpy as np
import pytest

from thermoroll_cli.exact.kalker import creepage_coefficients, fastsim, fastsim_flexibilities, linear_creep_forces, polach

G, LIMIT = 82e9, 25e3
A, B = 6e-3, 4e-3
COEFFICIENTS = creepage_coefficients(A / B, 0.27)
CONTACT = (COEFFICIENTS, A, B, G, LIMIT)

SMALL = [(1e-7, 0.0, 0.0), (0.0, 1e-7, 0.0), (0.0, 0.0, 1e-5), (1e-7, -2e-7, 0.0)]


@pytest.mark.parametrize("theory", [fastsim, polach])
@pytest.mark.parametrize("creepage", SMALL)
def test_little_creepage_gives_the_linear_forces(theory, creepage):
    found, linear = theory(*CONTACT, *creepage), linear_creep_forces(COEFFICIENTS, A, B, G, *creepage)
    size = math.hypot(linear.force_x, linear.force_y)
    assert math.hypot(found.force_x, found.force_y) == pytest.approx(size, rel=0.01)
    # Polach's force of both creepages is along the creepage, whatever the difference of C11 and C22.
    direction = 0.06 if theory is polach and all(creepage[:2]) else 0.01
    assert found.force_x == pytest.approx(linear.force_x, abs=direction * size)
    assert found.force_y == pytest.approx(linear.force_y, abs=direction * size)


@pytest.mark.parametrize("theory", [fastsim, polach])
@pytest.mark.parametrize("angle", [0.0, 0.7, math.pi / 2, 2.5, -1.2])
def test_much_creepage_gives_the_friction_limit_along_it(theory, angle):
    found = theory(*CONTACT, 0.5 * math.cos(angle), 0.5 * math.sin(angle))
    assert math.hypot(found.force_x, found.force_y) == pytest.approx(LIMIT, rel=6e-3)
    # FASTSIM weighs both creepages by the flexibilities even where all slips.
    weights = (COEFFICIENTS.c11, COEFFICIENTS.c22) if theory is fastsim else (1.0, 1.0)
    expected = math.atan2(weights[1] * math.sin(angle), weights[0] * math.cos(angle))
    assert math.atan2(found.force_y, found.force_x) == pytest.approx(expected, abs=6e-3)


@pytest.mark.parametrize("share", [0.2, 0.5, 1.0, 2.0])
def test_fastsim_with_longitudinal_creepage_alone(share):
    """On a strip of half-length h stick ends at x = h − s a, s = ξ a π a b/(2 μW L): both parts of the force are integrals of
    polynomials."""
    flexibility = fastsim_flexibilities(COEFFICIENTS, A, B, G).longitudinal
    peak = 2.0 * LIMIT / (math.pi * A * B)
    creepage = share * peak * flexibility / A
    y = B * np.sin((np.arange(4000) + 0.5) / 4000 * math.pi - math.pi / 2)
    h = np.sqrt(1.0 - (y / B) ** 2)  # over a
    end = np.maximum(h - share, -h)
    stick = share * (end + h) ** 2 / 2.0
    slip = (h**2 * h - h**3 / 3.0) - (h**2 * end - end**3 / 3.0)
    exact = peak * A * float(((stick + slip) * math.pi / 4000 * B * np.sqrt(1.0 - (y / B) ** 2)).sum())
    assert fastsim(*CONTACT, creepage).force_x == pytest.approx(exact, abs=2e-3 * LIMIT)


def test_both_follow_the_complete_theory_between():
    """At half and at all of the saturation creepage of the linear law, within 15 % of Vermeulen and Johnson's curve."""
    full = 3.0 * LIMIT / (G * A * B * COEFFICIENTS.c11)
    for share in (1.0 / 3.0, 2.0 / 3.0):
        cubic = LIMIT * (1.0 - (1.0 - share) ** 3)
        for theory in (fastsim, polach):
            assert theory(*CONTACT, share * full).force_x == pytest.approx(cubic, rel=0.15)


@pytest.mark.parametrize("theory", [fastsim, polach])
def test_signs(theory):
    """Opposite creepages give opposite forces; spin acts against positive lateral creepage."""
    one, other = theory(*CONTACT, 1e-3, 2e-3, 0.3), theory(*CONTACT, -1e-3, -2e-3, -0.3)
    assert (one.force_x, one.force_y) == pytest.approx((-other.force_x, -other.force_y))
    assert theory(*CONTACT, 0.0, 0.0, 0.5).force_y < 0.0
    assert theory(*CONTACT, 0.0, 1e-3, 0.5).force_y < theory(*CONTACT, 0.0, 1e-3, 0.0).force_y


@pytest.mark.parametrize("theory", [fastsim, polach])
def test_without_friction_there_is_no_answer(theory):
    with pytest.raises(ValueError, match="limit must be positive"):
        theory(COEFFICIENTS, A, B, G, 0.0, 1e-3)
