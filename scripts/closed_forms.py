"""The program beside closed forms, to be run again by anybody.

    python -m scripts.closed_forms [--grid N]

prints for each quantity the value that the solvers compute on N × N elements (default 64), the exact one and the difference."""

from __future__ import annotations

import argparse
import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from tests.support.problems import STEEL, elastic, ellipse, rolling
from thermoroll_cli.exact.heated_sphere import heated_sphere
from thermoroll_cli.exact.hertz import hertz_contact, line_contact
from thermoroll_cli.exact.kalker import creepage_coefficients
from thermoroll_cli.exact.moving_sources import effusivity, ellipse_maximum, tian_kennedy_maximum
from thermoroll_cli.exact.rolling_cylinders import carter, saturation_creepage
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.physics.contact.normal_contact import NormalSolver
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.physics.rolling.newton import TangentialProblem
from thermoroll_cli.physics.rolling.rolling_gradient import RollingGradient
from thermoroll_cli.physics.rolling.rolling_solver import RollingSolver
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Problem, SubsurfaceRequest
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve
from thermoroll_cli.tools.arrays import Array

HEADER = ("check", "quantity", "computed", "exact", "difference")
BEARING = Geometry(0.022, -0.0066, 0.00635, 0.00635)
"""A ball in a groove."""


@dataclass(frozen=True)
class Check:
    """One quantity beside its closed form; the difference is relative."""

    name: str
    quantity: str
    computed: float
    exact: float

    @property
    def row(self) -> tuple[str, ...]:
        numbers = (f"{value:.5g}" for value in (self.computed, self.exact))
        return (self.name, self.quantity, *numbers, f"{self.computed / self.exact - 1.0:+.0e}")


def checks(grid: int) -> Iterator[Check]:
    """All of them, on `grid` elements per side."""
    for group in (hertz, carter_strip, kalker, slender, moving_source, below_the_surface, groove, shares, hot_sphere):
        yield from group(grid)


def hertz(grid: int) -> Iterator[Check]:
    """The numerical normal solver, from one element, on an elliptic contact (Johnson, Sec. 4.2c)."""
    modulus, load = 210e9 / (2.0 * (1.0 - 0.28**2)), 65.0
    exact = hertz_contact(1.0 / 0.015, 1.0 / 0.06, modulus, load)
    mesh = Grid.over((grid, grid), 2.2 * exact.semi_axis_x, 2.2 * exact.semi_axis_y)
    gap = exact.undeformed_gap(mesh.x[:, None], mesh.y[None, :])
    solver = NormalSolver(mesh, Bodies(modulus))
    solution = solver.solve(gap, load, np.zeros(mesh.shape))
    refined = solver.refine(solution, gap, load)
    name = f"Hertz, a/b = {exact.semi_axis_x / exact.semi_axis_y:.2f}"
    yield Check(name, "largest pressure (MPa)", float(solution.pressure.max()) / 1e6, exact.peak_pressure / 1e6)
    yield Check(name, "approach (μm)", 1e6 * solution.approach, 1e6 * exact.approach)
    yield Check(name, "area (mm²)", 1e6 * float(refined.covered.sum()) * mesh.element_area, 1e6 * exact.area)


def carter_strip(grid: int) -> Iterator[Check]:
    """One row of elements across two cylinders, at half the creepage of full sliding (Carter 1926)."""
    cylinders, friction, shear = line_contact(20.0, 210e9 / (2.0 * (1.0 - 0.28**2)), 3e5), 0.3, 210e9 / 2.56
    exact = carter(cylinders, friction, 0.5 * saturation_creepage(cylinders, friction))
    dx, length = 2.2 * cylinders.half_width / grid, 1e4 * cylinders.half_width
    edges = (np.arange(grid + 1) - 0.5 * grid) * dx / cylinders.half_width
    t = np.clip(edges, -1.0, 1.0)
    pressure = np.diff(t * np.sqrt(1.0 - t * t) + np.arcsin(t)) / np.diff(edges) * 0.5 * cylinders.peak_pressure
    rigid = np.zeros((2, grid, 1))
    rigid[0] = exact.creepage
    covered = np.minimum(np.diff(t) / np.diff(edges), 1.0)
    strip = TangentialProblem(friction * pressure[:, None], covered[:, None], rigid, dx * length)
    gradient = RollingGradient((grid, 1), dx, length, Bodies.of_shear(ShearCompliance.of((shear, 0.28), (shear, 0.28))))
    found = float(RollingSolver(gradient).solve(strip, [], 1e-8).traction[0].sum()) * dx
    limit = friction * cylinders.load_per_length
    yield Check("Carter", "force over μW", found / limit, exact.force / limit)


def kalker(grid: int) -> Iterator[Check]:
    """Forces at vanishing creepage and spin over G ab ξ, against Kalker's printed three digits."""
    exact = creepage_coefficients(1.0, 0.25)
    yield Check("Kalker, circle, ν = 0.25", "C11", coefficient(1.0, 0.25, grid, "x"), exact.c11)
    yield Check("Kalker, circle, ν = 0.25", "C22", coefficient(1.0, 0.25, grid, "y"), exact.c22)
    yield Check("Kalker, circle, ν = 0.25", "C23", coefficient(1.0, 0.25, grid, "spin"), exact.c23)


def slender(grid: int) -> Iterator[Check]:
    """Long contacts, where the coefficients that the program reports come from asymptotes joined to the printed table."""
    for ratio in (6.9, 27.0):
        reported = creepage_coefficients(ratio, 0.28)
        yield Check(f"Kalker, a/b = {ratio:g}, interpolated", "C11", coefficient(ratio, 0.28, grid, "x"), reported.c11)


def coefficient(ratio: float, poisson_ratio: float, grid: int, direction: str) -> float:
    """Creepage coefficient of the ellipse a/b = `ratio` from a solve with a friction that nothing reaches."""
    body, tiny = elastic(poisson_ratio), 1e-7
    creepage = {"x": (tiny, 0.0), "y": (0.0, tiny), "spin": (0.0, 0.0)}[direction]
    problem = rolling(grid=grid, geometry=ellipse(ratio), body=body, friction=1.0, creepage=creepage)
    if direction == "spin":
        problem = dataclasses.replace(problem, motion=dataclasses.replace(problem.motion, spin=1e-4))
    result = solved(problem)
    area = 1e-6 * result.of_problem["hertz_a_mm"] * result.of_problem["hertz_b_mm"]
    force = result.coupled.scalars["force_x_N" if direction == "x" else "force_y_N"]
    unit = body.shear_modulus * area * (-math.sqrt(area) * 1e-4 if direction == "spin" else tiny)
    return force / unit


def moving_source(grid: int) -> Iterator[Check]:
    """A sliding sphere, with heat in the shape of Hertz's pressure: the integral of point sources; Tian and Kennedy's fit."""
    problem = rolling(grid=grid, friction=0.01, creepage=(0.02, 0.0), speed=1.0, heating=Heating(deformation=False))
    result, body = solved(problem), problem.lower
    speed, radius = problem.motion.speed * 1.01, 1e-3 * result.of_problem["hertz_a_mm"]
    flux = 0.5 * problem.friction.coefficient * 1e6 * result.of_problem["hertz_p0_MPa"] * problem.motion.speed * 0.02
    thermal = (body.conductivity or 0.0, body.diffusivity or 0.0, speed)
    found = result.coupled.scalars["temperature_rise_max_lower_K"]
    name = f"moving Hertz source, Pe = {speed * radius / thermal[1]:.3g}"
    yield Check(name, "largest rise (K), integral", found, ellipse_maximum(radius, radius, flux, *thermal, "hertz").temperature)
    yield Check(name, "the same, Tian and Kennedy", found, tian_kennedy_maximum(radius, flux / 1.5, *thermal, "hertz"))


def below_the_surface(grid: int) -> Iterator[Check]:
    """Largest von Mises stress: a sphere without friction (Johnson, Eq. 3.45), and sliding with μ = 0.25."""
    for friction, creepage, exact in ((0.0, 0.0, 0.620041), (0.25, 5.0, 0.647593)):
        problem = rolling(grid=grid, body=elastic(0.3), friction=friction, creepage=(creepage, 0.0))
        result = solved(dataclasses.replace(problem, subsurface=SubsurfaceRequest()))
        assert result.subsurface is not None
        found = result.subsurface.scalars["von_mises_max_lower_MPa"] / result.of_problem["hertz_p0_MPa"]
        yield Check(f"von Mises below a sphere, μ = {friction:g}", "maximum over p₀", found, exact)


def heathcote(aspect: float, across: int = 2000, along: int = 400) -> tuple[float, float]:
    """−ξ_x/(c b²) and Q_F/(μWV c b²) of an ellipse of a/b = `aspect` that slides as a whole and rolls freely, by midpoint sums.

    The slip over c b² V is (Y² − ζ, −2 aspect X Y) at X = x/a, Y = y/b. A slender contact has ζ = 4 sin² 10° and 0.161142."""
    y = (np.arange(across) + 0.5) / across
    angle = (np.arange(along) + 0.5) * 0.5 * np.pi / along
    x = np.sin(angle)[:, None] * np.sqrt(1.0 - y**2)
    load = np.cos(angle)[:, None] ** 2 * (1.0 - y**2)
    load /= load.sum()

    def size(zeta: float) -> Array:
        return np.hypot(y**2 - zeta, 2.0 * aspect * x * y)

    zeta = float(scipy.optimize.brentq(lambda z: float((load * (y**2 - z) / size(z)).sum()), 1e-3, 0.5))
    return zeta, float((load * size(zeta)).sum())


def groove(grid: int) -> Iterator[Check]:
    """A ball in a groove that slides as a whole and rolls freely, with Heathcote's slip along and across (`heathcote`)."""
    problem = rolling(grid=grid, geometry=BEARING, friction=1e-6, creepage=(None, 0.0), force=(0.0, None),
                      differential_slip=True)
    result = solved(problem)
    slip = DerivedQuantities(problem).kinematics.differential_slip
    at_the_end = float(slip(np.array([1e-3 * result.of_problem["hertz_b_mm"]]))[0])
    s, exact = result.coupled.scalars, heathcote(result.of_problem["hertz_a_mm"] / result.of_problem["hertz_b_mm"])
    heat = s["Q_F_W"] / (problem.traction_limit * problem.motion.speed * at_the_end)
    yield Check("free rolling in a groove, μ → 0", "−ξ_x/(c b²)", -s["creepage_longitudinal"] / at_the_end, exact[0])
    yield Check("free rolling in a groove, μ → 0", "Q_F/(μWV c b²)", heat, exact[1])


def shares(grid: int) -> Iterator[Check]:
    """Matched partition of fast bodies (effusivities), and steady conduction between bodies at rest of unequal temperature."""
    other = dataclasses.replace(STEEL, conductivity=20.0, diffusivity=8e-6)
    problem = rolling(grid=grid, friction=0.3, creepage=(0.003, 0.0), speed=1000.0,
                      heating=Heating(partition="matched", deformation=False))
    share = solved(dataclasses.replace(problem, upper=other)).coupled.scalars["partition_mean"]
    lower, upper = (effusivity(b.conductivity or 0.0, b.diffusivity or 0.0) for b in (STEEL, other))
    lower *= math.sqrt(1.003)
    yield Check("matched share, two fast bodies", "share of the lower body", share, lower / (lower + upper))
    heating = Heating(peclet="stationary", partition="matched", deformation=False, bulk_upper=30.0)
    result = solved(dataclasses.replace(rolling(grid=grid, friction=0.0, heating=heating), upper=other))
    area = (result.x[1] - result.x[0]) * (result.y[1] - result.y[0])
    through = float(result.coupled.fields["heat_flux_lower"].sum()) * area
    exact = 4e-3 * result.of_problem["hertz_a_mm"] * 30.0 / (1.0 / (STEEL.conductivity or 0.0) + 1.0 / 20.0)
    yield Check("conduction through a circle, ΔT = 30 K", "heat (W)", through, exact)


def hot_sphere(grid: int) -> Iterator[Check]:
    """The coupled state of a sliding sphere with sources at rest."""
    friction, speed = 1e-4, 11.28 / 65.0 / 1e-4
    heating = Heating(peclet="stationary")
    result = solved(rolling(grid=grid, friction=friction, creepage=(1.0, 0.0), speed=speed, heating=heating))
    expansion = (1.0 + STEEL.poisson_ratio) * (STEEL.expansion or 0.0) / (STEEL.conductivity or 1.0)
    modulus = 210e9 / (2.0 * (1.0 - 0.28**2))
    exact = heated_sphere(modulus, 1.0 / 0.015, 65.0, expansion * friction * speed)
    s, name = result.coupled.scalars, "sliding sphere deformed by its heat"
    yield Check(name, "γ_p", s["gamma_p"], exact.peak_ratio)
    yield Check(name, "γ_c", s["gamma_c"], exact.area_ratio)
    yield Check(name, "largest rise (K)", s["temperature_rise_max_lower_K"],
                exact.centre_temperature(0.5 * friction * speed * 65.0, STEEL.conductivity or 0.0))


def solved(problem: Problem) -> Result:
    """Raises RuntimeError if it does not converge."""
    result = solve(problem)
    if not result.converged:
        raise RuntimeError(result.reason)
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grid", type=int, default=64, help="elements per side (default 64)")
    options = parser.parse_args()
    print("{:40} {:28} {:>10} {:>10} {:>11}".format(*HEADER))
    for check in checks(options.grid):
        print("{:40} {:28} {:>10} {:>10} {:>11}".format(*check.row))


if __name__ == "__main__":
    main()
