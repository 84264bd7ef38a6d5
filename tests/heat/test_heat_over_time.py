"""Heat that builds up: closed forms of sources that start, the order in the step, and changes that must not matter."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import erf, erfc

from thermoroll_cli.physics.heat.frictional_heat import Heat
from thermoroll_cli.physics.heat.heat_over_time import End, HeatMemory
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatedBody, HeatResponse
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.tools.arrays import Array

K, KAPPA = 50.0, 1e-5
SIDE = 2e-3


def warmed(n: int, flux: Callable[[float], Array], times: Sequence[float], moved: Callable[[float], float] = lambda time: 0.0,
           *, jumps: bool = False, steady_speed: float | None = None) -> Array:
    """Temperature of the lower surface at the end of `times`, (n, n), by fluxes (n, n) into it alone; with `jumps` they begin
    at once, and with a `steady_speed` they have always been there."""
    grid = Grid.over((n, n), SIDE, SIDE)
    body = HeatedBody(K, 0.0, KAPPA, steady_speed or 0.0)
    memory = HeatMemory(grid, (body, body))
    slope = np.zeros((n, n))

    def end(time: float, *, constant: bool = False) -> End:
        return End(time, ((moved(time), 0.0), (moved(time), 0.0)), constant)

    memory.add(DividedHeat(flux(times[0]), 1.0, slope=slope), end(times[0]), (body, body) if steady_speed is not None else None)
    for i, time in enumerate(times[1:]):
        now = end(time, constant=jumps and i == 0)
        before, own = memory.step(now)
        heat = Heat(DividedHeat(flux(time), 1.0, slope=slope), own, before=before)
        memory.add(heat.into, now)
    return heat.temperatures()[0]


def test_a_disc_at_rest() -> None:
    """(2q/k) √(κt) [1/√π − ierfc(a/2√(κt))] at its centre (Carslaw and Jaeger, Sec. 10.5)."""
    n, a, q, last = 65, 0.8e-3, 1e6, 0.03
    fine = (np.arange(8 * n) + 0.5) / (8 * n) - 0.5
    inside = (fine[:, None] ** 2 + fine**2 < (a / SIDE) ** 2).astype(float)
    cover = inside.reshape(n, 8, n, 8).mean(axis=(1, 3))
    found = warmed(n, lambda time: q * cover, np.linspace(0.0, last, 7))[n // 2, n // 2]
    z = a / (2.0 * math.sqrt(KAPPA * last))
    exact = (
        2.0
        * q
        / K
        * math.sqrt(KAPPA * last)
        * (1.0 / math.sqrt(math.pi) - (math.exp(-z * z) / math.sqrt(math.pi) - z * erfc(z)))
    )
    assert found == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("speed", [0.05, 2.0])
def test_a_rectangle_that_starts_to_move(speed: float) -> None:
    """Uniform heat of elements that move from t = 0 on, at a speed that doubles on the way, against the integral over time."""
    n, q, last = 16, 1e6, 1e-3
    source = np.zeros((n, n))
    source[4:9, 6:10] = q
    h = SIDE / n

    def moved(time: float) -> float:
        return speed * time + speed * max(time - 0.5 * last, 0.0)

    found = warmed(n, lambda time: source, np.linspace(0.0, last, 9), moved)
    i, j = 10, 7
    x, y = (i - 6.0) * h, (j - 7.5) * h

    def rate(age: float) -> float:
        width, drift = 2.0 * math.sqrt(KAPPA * age), moved(last) - moved(last - age)
        along = 0.5 * (erf((x - drift + 2.5 * h) / width) - erf((x - drift - 2.5 * h) / width))
        return (
            float(along * 0.5 * (erf((y + 2.0 * h) / width) - erf((y - 2.0 * h) / width)))
            * q
            * math.sqrt(KAPPA / math.pi / age)
            / K
        )

    exact = quad(rate, 0.0, last, limit=400, points=[h * h / 90.0 / KAPPA, 0.5 * last])[0]
    assert found[i, j] == pytest.approx(exact, rel=2e-4)


@pytest.mark.slow
def test_the_order_of_the_step_is_two() -> None:
    shape = np.zeros((16, 16))
    shape[4:12, 4:12] = 1e6
    last = 2e-3

    def at(steps: int) -> Array:
        return warmed(16, lambda time: shape * math.sin(3.0 * time / last) ** 2, np.linspace(0.0, last, steps + 1),
                      lambda time: 0.5 * time)

    exact = at(80)
    errors = [np.abs(at(steps) - exact).max() for steps in (5, 10, 20)]
    assert errors[0] / errors[1] > 3.2 and errors[1] / errors[2] > 3.2 and errors[2] < 5e-3 * exact.max()


@pytest.mark.parametrize("speed", [0.0, 0.3])
def test_steady_heat_stays_and_is_approached(speed: float) -> None:
    shape = np.zeros((16, 16))
    shape[4:12, 4:12] = 1e6
    grid, body = Grid.over((16, 16), SIDE, SIDE), HeatedBody(K, 0.0, KAPPA, speed)
    steady = HeatResponse(grid, body, body).temperatures(DividedHeat(shape, 1.0, slope=np.zeros((16, 16))))[0]
    times = [0.0, 1e-4, 2.5e-4, 1e-3]
    stays = warmed(16, lambda time: shape, times, lambda time: speed * time, steady_speed=speed)
    assert np.abs(stays - steady).max() < 3e-4 * steady.max()
    long = warmed(16, lambda time: shape * (time > 0.0), [0.0, 1e-3, 1e-2, 1.0, 1e5], lambda time: speed * time, jumps=True)
    assert np.abs(long - steady).max() < 5e-3 * steady.max()
