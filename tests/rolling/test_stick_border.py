"""Where stick ends inside an element: against Carter's contact, and under refinement in three dimensions."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.support.scenes import CASES, article_4_1, elastic, reference_problem, rolling, saturation, solved
from tests.support.strips import CYLINDERS, carter_row, carter_strip
from thermoroll_cli.exact.rolling_cylinders import carter, saturation_creepage
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance
from thermoroll_cli.physics.rolling.element_borders import stick_share

REFERENCES = json.loads((Path(__file__).parents[2] / "scripts" / "benchmark" / "references.json").read_text())["cases"]
G, NU, FRICTION = elastic(0.28).shear_modulus, 0.28, 0.3
COMPLIANCE = ShearCompliance.of((G, NU), (G, NU))


def strip_errors(n: int, share: float, lateral: bool) -> np.ndarray:
    """Length of the stick zone less Carter's, in elements, over places of the border inside its element: counted in whole
    elements, and with the surplus."""
    dx = 2.2 * CYLINDERS.half_width / n
    exact = carter(CYLINDERS, FRICTION, share * saturation_creepage(CYLINDERS, FRICTION)).stick_zone[1]
    errors = []
    for k in range(8):
        _, solution = carter_strip(n, k / 8, share, lateral)
        edges = (np.arange(n + 1) - 0.5 * n + k / 8) * dx
        bound = carter_row(n, k / 8, share, lateral)[1].traction_bound
        stick = solution.stick & (bound > 0.0)
        end = edges[np.flatnonzero(stick)[-1] + 1]
        sticking = stick_share(solution.traction, solution.slip, bound, stick, (bound > 0.0) * 1.0, dx, 1e9 * dx,
                               COMPLIANCE)
        surplus = sticking.sum() - stick.sum()
        errors.append([(end - exact) / dx, (end - exact) / dx + surplus])
    return np.array(errors)


@pytest.mark.parametrize("lateral", [False, True])
@pytest.mark.parametrize(("share", "most"), [(0.3, 0.02), (0.6, 0.03), (0.9, 0.2)])
@pytest.mark.parametrize("n", [64, pytest.param(128, marks=pytest.mark.slow)])
def test_stick_zone_ends_where_carters_does(n, share, most, lateral):
    """Wherever it ends in its element; close to saturation the law holds over few elements only."""
    whole, placed = strip_errors(n, share, lateral).T
    assert np.ptp(whole) > 0.8, "the border visits all places"
    assert np.abs(placed).max() < most


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("n", "bound"), [
    (32, 4e-3), *(pytest.param(*row, marks=pytest.mark.slow) for row in ((64, 1e-3), (128, 4e-4)))])
def test_stick_fraction_of_rolling_contacts(case, n, bound):
    found = solved(reference_problem(case, n)).isothermal.scalars["gamma_st"]
    assert found == pytest.approx(REFERENCES[case]["gamma_st"], abs=bound)


@pytest.mark.parametrize(("n", "bound"), [
    (32, 4e-3), *(pytest.param(*row, marks=pytest.mark.slow) for row in ((64, 1.2e-3), (128, 4e-4)))])
def test_stick_fraction_of_the_hot_contact(n, bound):
    found = solved(article_4_1(n)).coupled.scalars["gamma_st"]
    assert found == pytest.approx(REFERENCES["article_4_1"]["gamma_st"], abs=bound)


def test_full_stick_and_full_slip_have_no_border():
    base = rolling(grid=32)
    creep = saturation(base).creepage
    for factor, expected in ((1e-9, 1.0), (30.0, 0.0)):
        scalars = solved(rolling(grid=32, creepage=(factor * creep, 0.0))).coupled.scalars
        assert scalars["gamma_st"] == pytest.approx(expected, abs=1e-12 if expected == 0.0 else 1e-2)
        assert 0.0 <= scalars["gamma_st"] <= 1.0
