"""The picture of docs/polymers.md: rolling resistance over the speed, with the share of each time, and the leading pressure."""

from __future__ import annotations

import pathlib
from dataclasses import dataclass, replace

import numpy as np

from scripts.figures.figures_drawing import (
    COUPLED,
    ISOTHERMAL,
    ROOT,
    THIRD,
    Array,
    Numbers,
    diagrams,
    letter,
    rounded,
    solve_problem,
    write,
)
from thermoroll_cli import Case
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.physics.contact.normal_contact import NormalSolver
from thermoroll_cli.physics.halfspace.bodies import RelaxingBodies
from thermoroll_cli.physics.halfspace.relaxing import Memory, Relaxing
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.plots.style import readable
from thermoroll_cli.problem.problem import Material, Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import Solver

SPEEDS = np.logspace(-3.0, 4.0, 22)
SHOWN = (1e-3, 0.5, 1e4)
"""Speeds (m/s) whose pressure is drawn: slow, near the largest resistance, fast."""
THICKNESSES = {"tread of 9.5 mm": 9.5e-3, "tread of 2 mm": 2e-3}


@dataclass(frozen=True)
class OneTime(Relaxing):
    """Bodies of which one of the retardation times alone is kept."""

    number: int = 0

    @property
    def memories(self) -> list[Memory]:
        return super().memories[self.number : self.number + 1]


def _freely_rolling() -> Problem:
    problem = Case.read(ROOT / "cases" / "polymer_roller.toml").problem
    motion = replace(problem.motion, creepage_x=0.0, force_x=None)
    return replace(problem, friction=replace(problem.friction, coefficient=0.0), motion=motion)


def _swept(problem: Problem, grid: int) -> list[Result]:
    solver = Solver()
    return [solve_problem(replace(problem, motion=replace(problem.motion, speed=float(speed)), numerics=Numerics((grid, grid))),
                          solver) for speed in SPEEDS]


def _shares(result: Result) -> list[float]:
    """Rolling resistance by each time in N."""
    problem, x, y = result.problem, result.x, result.y
    grid = Grid(x.size, y.size, float(x[1] - x[0]), float(y[1] - y[0]))
    pressure = result.coupled.fields["pressure"]
    count = len(problem.upper.retardation)
    bodies = DerivedQuantities(problem).bodies
    assert isinstance(bodies, RelaxingBodies)
    parts = (OneTime(problem.lower, problem.upper, problem.motion.speed, number) for number in range(count))
    return [NormalSolver(grid, replace(bodies, memory=part)).hysteresis(pressure) for part in parts]


def resistance(folder: pathlib.Path, grid: int) -> Numbers:
    """Resistance over the load of the case's wheel, with a thin tread and with a whole wheel of the tread's material."""
    problem, side = _freely_rolling(), min(grid, 48)
    layer = problem.upper.layers[0]
    solid = replace(problem, upper=Material(layer.youngs_modulus, layer.poisson_ratio, relaxation=layer.relaxation))
    whole = _swept(solid, side)
    curves = {"whole wheel": whole} | {
        name: _swept(replace(problem, upper=replace(problem.upper, layers=(replace(layer, thickness=h),))), side)
        for name, h in THICKNESSES.items()}
    figure, (left, right) = diagrams(1, 2, (3.6, 2.7))
    load = problem.normal_force
    shares: Array = np.array([_shares(result) for result in whole]).T / load
    times = [readable(f"{time:.2g} s") for _, time in solid.upper.retardation]
    shades = [str(shade) for shade in np.linspace(0.93, 0.62, len(times))]
    left.stackplot(SPEEDS, shares, colors=shades, labels=times)
    for (name, results), colour in zip(curves.items(), (COUPLED, ISOTHERMAL, THIRD), strict=True):
        values = [result.coupled.scalars["rolling_resistance_N"] / load for result in results]
        left.plot(SPEEDS, values, color=colour, label=name)
    left.set(xscale="log", xlabel="speed (m/s)", ylabel="rolling resistance / load", xlim=(SPEEDS[0], SPEEDS[-1]),
             ylim=(0.0, 1.45 * float(shares.sum(axis=0).max())))
    left.legend(fontsize=6.5, ncol=3, title="whole wheel: share of each retardation time", title_fontsize=6.5,
                loc="upper center")
    for speed, colour in zip(SHOWN, (ISOTHERMAL, COUPLED, THIRD), strict=True):
        result = whole[int(np.argmin(np.abs(np.log(SPEEDS / speed))))]
        middle = result.coupled.fields["pressure"][:, result.y.size // 2]
        right.plot(1e3 * result.x, 1e-6 * middle, color=colour, label=readable(f"{result.problem.motion.speed:.2g} m/s"))
    right.set(xlabel="x (mm), material flows to the right", ylabel="pressure of the whole wheel (MPa)", ylim=(0.0, None))
    right.axvline(0.0, color="0.7", linewidth=0.8)
    right.legend(fontsize=8)
    letter(left, "(a)", low=True)
    letter(right, "(b)")
    write(figure, folder, "polymer_roller")
    peaks = {name: max((result.coupled.scalars["rolling_resistance_N"] / load, speed) for result, speed in
                       zip(results, SPEEDS, strict=True)) for name, results in curves.items()}
    return {name: {"largest resistance over load": rounded(value, 3), "at m/s": rounded(speed, 2)}
            for name, (value, speed) in peaks.items()}


FIGURES = {"polymer roller": resistance}
