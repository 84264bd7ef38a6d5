"""Cases whose errors were once ten to a thousand times their estimates, and one that missed the accuracy it asked for."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from scripts.stress.coverage import pairs_of, shortfall
from scripts.stress.populations import POPULATIONS
from tests.support.errors import relative
from tests.support.sampling import sampled
from tests.support.scenes import MECHANICAL, rolling
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Material, Numerics
from thermoroll_cli.python_api import solve

OUTLIERS = (
    ("coverage of contacts", 7362, 32, 26.0),  # the largest traction at the border of the patch of stick about the pole of spin
    ("coverage of random contacts", 41033, 32, 31.0),  # a patch of stick a hundredth of the contact wide
    ("coverage of contacts", 41020, 32, 227.0),  # a patch of stick where a found creepage still falls with every grid
    ("coverage of profiles", 71022, 32, 4.8),  # two patches of one and two elements, which share the load as elements give way
)
"""Population, seed, elements, and error over estimate before."""
SLOW_OUTLIERS = (
    ("coverage of falling friction", 41000, 32, 4.8),  # mean friction of a zone of stick whose size is not known
    ("coverage of contacts", 6037, 64, 20.0),  # heat into a body that turns, which one with another temperature gives it
    ("coverage of random contacts", 5081, 32, 24.0),  # two peaks of pressure between unlike bodies that agreed by accident
    ("coverage of contacts", 4223, 64, 13.0),  # a small spin moment under strong heat
)


@pytest.mark.parametrize("seed", sampled([362, 489, 491, 378], 4))
def test_estimates_cover_what_they_once_missed(seed: int) -> None:
    """Slip zones narrower than an element, forces close to μW: of the stress generator, N = 32. (Seed 334 is another, whose
    reference alone takes half a minute: `make test-all` has it.)"""
    pairs = list(pairs_of(POPULATIONS["coverage of contacts"].draw(seed).problem, 32))
    assert len(pairs) >= 8
    # Seed 491 is short by 2.7 times in a heat flux, seed 362 by 2.1 times: zones narrower than half an element.
    assert not [p for p in pairs if shortfall(p) > 3.0]


@pytest.mark.parametrize(("population", "seed", "grid", "once"), [
    *OUTLIERS, *(pytest.param(*row, marks=pytest.mark.slow) for row in SLOW_OUTLIERS)])
def test_no_estimate_is_ten_times_too_small(population: str, seed: int, grid: int, once: float) -> None:
    """As these were `once`; now they are at most half as far off."""
    drawn = POPULATIONS[population].draw(seed)
    problem = getattr(drawn, "problem", drawn)
    pairs = pairs_of(problem, grid, reference=(3 if problem.subsurface is None else 2) * grid)
    assert max(map(shortfall, pairs)) < 0.5 * once


@pytest.mark.slow
def test_an_accuracy_that_was_missed_is_kept() -> None:
    """γ_st was 2.4e-3 off with `accuracy = 1e-3`: a small patch of stick in a contact that slides."""
    steel = Material(70e9, 0.33)
    geometry = Geometry(0.05, 0.012, 0.05, 0.012)
    problem = rolling(geometry=geometry, body=steel, load=500.0, friction=0.05, creepage=(0.00157194, 0.00094316), speed=30.0,
                      heating=MECHANICAL)
    result = solve(replace(problem, numerics=Numerics(accuracy=1e-3, accuracy_of=("all",))))
    fine = solve(replace(problem, numerics=Numerics((256, 256))))
    assert result.converged, result.reason
    for name in ("gamma_st", "Q_F_W"):
        scale = 1.0 if name == "gamma_st" else fine.coupled.scalars[name]
        off = abs(result.coupled.scalars[name] - fine.coupled.scalars[name]) / scale
        assert off < 1e-3 and not math.isnan(relative(result)[name]), name
