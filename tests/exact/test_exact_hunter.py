"""A cylinder rolling on a half-plane that relaxes: against independent values, equilibrium, and its limits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.sampling import sampled
from tests.support.scenes import reference
from thermoroll_cli.exact.hunter import hunter


@pytest.mark.parametrize("row", sampled(reference("relaxing_hunter")["rows"], 3),
                         ids=lambda row: f"{row['relaxed_over_glassy']}-{row['length_over_a0']}")
def test_values_of_an_independent_solution(row: dict[str, float]) -> None:
    contact = hunter(row["relaxed_over_glassy"], row["length_over_a0"])
    assert contact.half_width == pytest.approx(row["half_width_over_a0"], rel=1e-9)
    assert contact.centre == pytest.approx(row["centre_over_a0"], rel=1e-9)
    # The reference integrates its pressure numerically.
    assert contact.moment == pytest.approx(row["moment_over_wa0"], rel=6e-3)
    assert contact.pressure(np.linspace(-1.0, 1.0, 2001)).max() == pytest.approx(row["pressure_max_over_elastic"], rel=8e-3)


@pytest.mark.parametrize(("ratio", "length"), [
    (10.0, 1.0), *(pytest.param(*row, marks=pytest.mark.slow) for row in ((1.2, 0.3), (3.0, 0.1), (30.0, 5.0)))])
def test_the_pressure_carries_load_and_moment(ratio: float, length: float) -> None:
    contact = hunter(ratio, length)
    t, weights = np.polynomial.legendre.leggauss(1000)
    per_length = 2.0 / math.pi * contact.half_width * contact.pressure(t) * weights
    assert per_length.sum() == pytest.approx(1.0, rel=1e-7)
    assert (per_length * (contact.centre + contact.half_width * t)).sum() == pytest.approx(contact.moment, rel=1e-7)
    assert contact.pressure(np.array([-1.0, 1.0])) == pytest.approx(0.0, abs=1e-9)


def test_fast_and_slow_rolling_are_elastic() -> None:
    slow, fast = hunter(4.0, 1e-4), hunter(4.0, 1e4)
    assert (slow.half_width, slow.centre) == pytest.approx((1.0, 0.0), abs=2e-4)
    assert (fast.half_width, fast.centre) == pytest.approx((0.5, 0.0), abs=1e-3)


def test_the_compliance_must_grow() -> None:
    with pytest.raises(ValueError, match="ratio_above_one"):
        hunter(1.0, 1.0)
